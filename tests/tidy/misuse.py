"""tests/fault/misuse_*.cpp or api_extremes.cpp call every function of the headers below that takes an argument, with wrong arguments.
The check compares names only. A reviewer has to check that the arguments are wrong."""
import re

from tree import without_comments

HEADERS = ("include/lockstone/assemble.h", "include/lockstone/asset.h", "include/lockstone/prove.h", "include/lockstone/play/ragdoll.h",
           "include/lockstone/session.h", "include/lockstone/shape.h", "include/lockstone/simd.h", "include/lockstone/tasks.h",
           "include/lockstone/session/transport.h", "include/lockstone/play/vehicle.h", "include/lockstone/world.h", "replay/branch.h", "replay/diff.h",
           "replay/player.h", "replay/recorder.h", "replay/recording.h", "replay/sink.h", "replay/verifier.h")
# Functions that a game implements and the library calls, and functions for which every argument is valid.
WITHOUT = {"keep", "flip", "difference", "predict", "run", "on_command", "on_restore", "on_phase", "on_confirmed", "keep_states", "segment_count"}
DECLARED = re.compile(r"(?<![.>])\b([a-z]\w*)\(([^()]*(?:\([^()]*\)[^()]*)*)\)\s*(?:const\b|noexcept\b|override\b|&&|= 0|\s)*[;{]")
# The text in front of a declared name: a type.
TYPE = re.compile(r"(?:[\w:<>,*&\s]*[\w>][*&]?\s+[*&]?)$")
NO_TYPE = re.compile(r"\b(return|new|else|case|throw|co_return|explicit|using|typedef|friend)\b")


def public_part(text):
    """Returns the text with blank lines for private members. A class ends at a line `};` with less indentation than its `private:`."""
    out, hidden = [], None
    for line in text.split("\n"):
        indent = len(line) - len(line.lstrip())
        if hidden is None and line.strip() == "private:":
            hidden = indent
        elif hidden is not None and line.strip().startswith("};") and indent < hidden:
            hidden = None
        elif hidden is not None and line.strip() in ("public:", "protected:") and indent == hidden:
            hidden = None
        out.append("" if hidden is not None else line)
    return "\n".join(out)


def declarations(text):
    """Yields (line, name) of each function with parameters."""
    text = public_part(without_comments(text))
    for found in DECLARED.finditer(text):
        before = re.split(r"[;{}]", text[:found.start()])[-1]
        if not found.group(2).strip() or not TYPE.search(before) or NO_TYPE.search(before) or "(" in before.replace("()", ""):
            continue
        if before.strip() in ("", "public:", "private:"):
            continue
        yield text.count("\n", 0, found.start(1)) + 1, found.group(1)


def check(tree):
    tests = sorted((tree.root / "tests/fault").rglob("misuse_*.cpp")) + [tree.root / "tests/fault/api_extremes.cpp"]
    tried = set()
    for path in tests:
        if path.exists():
            tried |= set(re.findall(r"\b([a-z]\w*)(?:<[\w:]+>)?\(", without_comments(path.read_text())))
    complaints, functions = [], 0
    for name in HEADERS:
        path = tree.root / name
        if not path.exists():
            continue
        for line, function in declarations(path.read_text()):
            functions += 1
            if function not in WITHOUT and function not in tried:
                complaints.append(f"{name}:{line}: nobody tries {function} with wrong arguments")
    return complaints or ([] if functions else [f"{HEADERS[0]}:1: no function is found"])


HEADER = "include/lockstone/world.h"
WORLD = "#pragma once\nclass World {\n  public:\n    Status destroy(BodyId body);\n%s  private:\n    void hidden(int row);\n};\n"
TEST = "void test() { w.destroy({}); }\n"
PLANTED = [
    ("a function that no test calls", {HEADER: WORLD % "    Real mass(BodyId body) const;\n", "tests/fault/misuse_world.cpp": TEST}),
    ("one that stands only in a comment", {HEADER: WORLD % "    Real mass(BodyId body) const;\n",
                                          "tests/fault/misuse_world.cpp": TEST + "// mass(dead)\n"}),
    ("a free function over two lines", {HEADER: WORLD % "" + "Result<Doll> make_doll(World& world,\n                       const DollDef& def);\n",
                                       "tests/fault/misuse_world.cpp": TEST}),
    ("one with a body", {HEADER: WORLD % "    bool has(BodyId body) const { return find(body) != 0; }\n", "tests/fault/misuse_world.cpp": TEST}),
    ("one with a default argument that is a call", {HEADER: WORLD % "    void go(Vec3 to = origin());\n", "tests/fault/misuse_world.cpp": TEST}),
    ("tests that are gone", {HEADER: WORLD % ""}),
    ("headers that are gone", {"tests/fault/misuse_world.cpp": TEST}),
]
GOOD = [
    ("functions that are tried, and private ones", {HEADER: WORLD % "", "tests/fault/misuse_world.cpp": TEST}),
    ("what takes nothing", {HEADER: WORLD % "    int count() const;\n", "tests/fault/misuse_world.cpp": TEST}),
]
