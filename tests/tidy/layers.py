"""Compares the table of layers with every include and with CMakeLists.txt: a file may include its own layer, and the layers that it links."""
import re

from tree import numbered, without_comments

# The layers that each layer links, as in CMakeLists.txt. A layer may also include the layers that those link.
LINKS = {
    "base": [],
    "math": ["base"],
    "state": ["base", "math"],
    "shapes": ["base", "math"],
    "collide": ["shapes", "state"],
    "solve": ["collide"],
    "model": ["solve"],
    "scene": ["model"],
    "play": ["scene"],
    "tick": ["play"],
    "world": ["tick"],
    "prove": ["world"],
    "session": ["prove"],
    "net": ["session"],
    "replay": ["world"],
}
# The layer that implements each public header.
PUBLIC = {
    "compiler.h": "base", "result.h": "base", "tasks.h": "base",
    "simd.h": "solve", "wide.h": "math", "fixed.h": "math", "formats.h": "math", "vec.h": "math", "math.h": "math", "random.h": "math",
    "decimal.h": "math", "row.h": "state", "state.h": "state", "shape.h": "shapes", "asset.h": "shapes",
    "ids.h": "collide", "field.h": "collide", "character.h": "collide", "joint.h": "collide", "vehicle.h": "collide", "ragdoll.h": "world",
    "journal.h": "collide", "world_def.h": "model",
    "command.h": "collide", "event.h": "collide", "query.h": "collide",  # definitions and ids that rows of the state contain
    "world.h": "world", "assemble.h": "world", "game.h": "world", "input.h": "world",
    "transport.h": "session", "session.h": "session", "spectator.h": "session", "spectator_relay.h": "session", "join.h": "session", "input_delay.h": "session", "prove.h": "prove", "testing.h": "prove", "forgetful.h": "session",
    "net.h": "net",
    "convert.h": "outside",
}
# Headers of other projects, and the only places that may include them.
FOREIGN = [
    (r"xxhash\.h", ["src/base/hash.cpp"]),
    (r"hwy/", ["src/base/", "src/solve/"]),
    (r"(fcl|ccd)/", ["tests/oracle/", "tests/reference/", "tools/cook/", "tools/reference/"]),
    (r"(mpfr|gmp)\.h", ["tests/"]),
    (r"(glm|GLFW|epoxy|assimp)/", ["demo/", "tools/"]),
    (r"doctest/", ["tests/"]),
    # The headers of these two take longer to compile than a command, so only these sources include them.
    (r"CLI/", ["tools/cli/command_line.cpp", "demo/options.cpp"]),
    (r"nlohmann/", ["tools/json/json.cpp"]),
    (r"enet/", ["tests/net/enet/"]),
    (r"sodium\.h", ["src/net/", "tests/"]),
    (r"(sys/socket|netinet/\w+|arpa/inet|netdb|poll)\.h", ["src/net/", "tests/"]),
]
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')


def closure(layer):
    allowed = {layer}
    for below in LINKS.get(layer, []):
        allowed |= closure(below)
    return allowed


def layer_of(name):
    """Returns the layer of a file, or None for a file outside of the layers (tools, demo, tests)."""
    parts = name.split("/")
    if name.startswith("include/lockstone/"):
        return PUBLIC.get(parts[-1])
    if parts[0] == "src":
        return parts[1]
    return "replay" if parts[0] == "replay" else None


def target_of(include):
    """Returns the layer of a header of this project, "unlisted" for a public header without one, or None for other headers."""
    if include.startswith("lockstone/"):
        return PUBLIC.get(include.split("/")[-1], "unlisted")
    first = include.split("/")[0]
    return first if "/" in include and first in LINKS else None


def complaints_of_include(name, number, include):
    for pattern, places in FOREIGN:
        if re.match(pattern, include) and not name.startswith(tuple(places)):
            yield f"{name}:{number}: only {', '.join(places)} may include {include}"
    layer, target = layer_of(name), target_of(include)
    if target is None:
        return
    if target == "unlisted":
        yield f"{name}:{number}: {include} has no layer in tests/tidy/layers.py"
    elif layer is None:  # tools and demo may include public headers and replay, tests may include all headers
        if not include.startswith(("lockstone/", "replay/")) and not name.startswith("tests/"):
            yield f"{name}:{number}: {include} is inside the engine; use what include/lockstone offers"
    elif layer != "outside" and target not in closure(layer):
        yield f"{name}:{number}: layer {layer} includes {include} of layer {target}, which it does not link"


def complaints_of_cmake(tree):
    path = tree.root / "CMakeLists.txt"
    if not path.exists():
        return
    text, told = path.read_text(), set()
    for number, line in numbered(text):
        found = re.match(r"\s*lockstone_layer\((\w+)(?: FOLDERS [\w/ ]+?)?(?: LINKS ([\w ]+))?\)", line)
        if found and LINKS.get(found.group(1)) != (found.group(2) or "").split():
            yield f"CMakeLists.txt:{number}: layer {found.group(1)} is not as in tests/tidy/layers.py"
        told |= {found.group(1)} if found else set()
    for layer in sorted(set(LINKS) - told) if "project(lockstone" in text else []:
        yield f"CMakeLists.txt:1: layer {layer} of tests/tidy/layers.py is not there"


def check(tree):
    complaints = list(complaints_of_cmake(tree))
    for path in tree.files():
        name = tree.name(path)
        if name.startswith("include/lockstone/") and path.name not in PUBLIC:
            complaints.append(f"{name}:1: has no layer in tests/tidy/layers.py")
        if name.startswith("src/") and name.split("/")[1] not in LINKS:
            complaints.append(f"{name}:1: src/{name.split('/')[1]} is not a layer")
        for number, line in numbered(without_comments(path.read_text(), keep_strings=True)):
            if found := INCLUDE.match(line):
                complaints += complaints_of_include(name, number, found.group(2))
    return complaints


PLANTED = [
    ("math includes state", {"src/math/x.cpp": '#include "state/x.h"\n'}),
    ("collide sees the world", {"src/collide/x.cpp": '#include "lockstone/world.h"\n'}),
    ("session knows replay", {"src/session/x.cpp": '#include "replay/format/format.h"\n'}),
    ("replay knows session", {"replay/x.cpp": '#include "lockstone/session.h"\n'}),
    ("the simulation converts to floats", {"src/world/x.cpp": '#include "lockstone/math/convert.h"\n'}),
    ("a tool reaches inside", {"tools/cli/x.cpp": '#include "state/x.h"\n'}),
    ("a socket outside net", {"src/session/x.cpp": "#include <sys/socket.h>\n"}),
    ("the library for JSON in a command", {"tools/cli/x.cpp": "#include <nlohmann/json.hpp>\n"}),
    ("the library for arguments in a command", {"tools/cli/x.h": "#include <CLI/CLI.hpp>\n"}),
    ("FCL in the engine", {"src/collide/x.cpp": "#include <fcl/fcl.h>\n"}),
    ("a public header without a layer", {"include/lockstone/brand_new.h": "#pragma once\n"}),
    ("a layer that links upwards", {"CMakeLists.txt": "lockstone_layer(math LINKS base world)\n"}),
    ("a layer within a condition", {"CMakeLists.txt": "if(X)\n    lockstone_layer(net LINKS replay)\nendif()\n"}),
    ("layers that are gone", {"CMakeLists.txt": "project(lockstone)\nlockstone_layer(base)\n"}),
]
GOOD = [
    ("includes downwards", {"src/world/x.cpp": '#include "solve/x.h"\n#include "base/x.h"\n#include "lockstone/math/vec.h"\n'}),
    ("an include in a comment", {"src/math/x.cpp": '// #include "world/x.h"\n'}),
    ("tests that look inside", {"tests/law/x.cpp": '#include "state/x.h"\n#include "lockstone/math/convert.h"\n'}),
]
