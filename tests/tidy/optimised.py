"""The release build optimises the engine fully: the last -O of every command that compiles it is -O3, without assertions."""
import json
import pathlib

ENGINE = ("src/", "replay/")


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
        path = pathlib.Path(entry["file"])
        name = tree.name(path) if path.is_relative_to(tree.root) else ""
        if name.startswith(ENGINE):
            seen += 1
            if complaint := complaint_of(name, entry["command"].split()):
                complaints.append(complaint)
    return complaints or ([] if seen else [f"{commands}:1: compiles nothing of {' and '.join(ENGINE)}"])


def commands_with(flags, name="src/base/x.cpp"):
    # Paths are those of the tree, whose place the planted trees do not know.
    return {"build/compile_commands.json": json.dumps([{"file": "ROOT/" + name, "command": f"c++ {flags} -c x.cpp"}])}


PLANTED = [
    ("no optimisation at all", commands_with("-DNDEBUG")),
    ("a level that comes last and is lower", commands_with("-O3 -DNDEBUG -O1")),
    ("assertions", commands_with("-O3")),
    ("commands of something else only", commands_with("-O3 -DNDEBUG", "tests/x.cpp")),
    ("no commands", {"README.md": ""}),
]
GOOD = [
    ("what the release preset gives", commands_with("-O3 -DNDEBUG -std=c++20")),
]
