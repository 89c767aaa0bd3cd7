"""The release build optimises the engine fully: in every command that compiles it the last -O is -O3, and -DNDEBUG turns assertions off."""
import json
import pathlib
import re

from layers import LINKS

ENGINE = ("src/", "replay/")
UNITY = re.compile(r"/lockstone_(\w+)\.dir/Unity/(\w+)")  # a file that includes several sources of a layer


def name_of(tree, path):
    """Returns the name of the file for complaints, or None if the file is not part of the engine."""
    unity = UNITY.search(path.as_posix())
    if unity:
        return f"{unity[1]}/{unity[2]}" if unity[1] in LINKS else None
    name = tree.name(path) if path.is_relative_to(tree.root) else ""
    return name if name.startswith(ENGINE) else None


def complaint_of(name, words):
    level = [w for w in words if w.startswith("-O")][-1:]
    if level != ["-O3"]:
        return f"{name}:1: is compiled with {level[0] if level else 'no -O'}, the release build has -O3"
    if "-DNDEBUG" not in words:
        return f"{name}:1: is compiled without -DNDEBUG"
    return None


def check(tree):
    commands = tree.build / "compile_commands.json"
    if not commands.exists():
        return [f"{commands}:1: is missing"]
    complaints, seen = [], 0
    for entry in json.loads(commands.read_text()):
        name = name_of(tree, pathlib.Path(entry["file"]))
        if name is not None:
            seen += 1
            if complaint := complaint_of(name, entry["command"].split()):
                complaints.append(complaint)
    return complaints or ([] if seen else [f"{commands}:1: compiles nothing of {' and '.join(ENGINE)}"])


def commands_with(flags, name="src/base/x.cpp"):
    # tidy.py replaces ROOT/ with the folder of the planted tree.
    return {"build/compile_commands.json": json.dumps([{"file": "ROOT/" + name, "command": f"c++ {flags} -c x.cpp"}])}


PLANTED = [
    ("no optimisation at all", commands_with("-DNDEBUG")),
    ("a level that comes last and is lower", commands_with("-O3 -DNDEBUG -O1")),
    ("assertions", commands_with("-O3")),
    ("sources of a layer in one, with a level that is lower", commands_with("-O2 -DNDEBUG", "build/CMakeFiles/lockstone_world.dir/Unity/unity_0_cxx.cxx")),
    ("commands of something else only", commands_with("-O3 -DNDEBUG", "tests/x.cpp")),
    ("sources of another library in one", commands_with("-O3 -DNDEBUG", "build/tools/CMakeFiles/lockstone_cook.dir/Unity/unity_0_cxx.cxx")),
    ("no commands", {"README.md": ""}),
]
GOOD = [
    ("what the release preset gives", commands_with("-O3 -DNDEBUG -std=c++20")),
    ("sources of a layer in one", commands_with("-O3 -DNDEBUG", "build/CMakeFiles/lockstone_world.dir/Unity/unity_0_cxx.cxx")),
]
