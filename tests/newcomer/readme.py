#!/usr/bin/env python3
"""Every block of C++ in README.md and tools/guides/game.md is a complete program. The script compiles each with each compiler, with -Wall
-Wextra -Werror, with and without NDEBUG, links it and runs it: it has to end with status 0. The script also compiles all public headers without exceptions and
run-time types.

  readme.py --libraries BUILD [--cxx CXX]...     checks the pages and the headers
  readme.py --planted --libraries BUILD          checks that the script notices small programs with one fault each
  readme.py --extract LANGUAGE NUMBER            prints one block; the first one has the number 0"""
import argparse
import pathlib
import re
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
GAME = "tools/guides/game.md"
PAGES = ("README.md", GAME)
GAME_LINES_MAX = 90  # of the program in GAME, without empty lines
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
# From the highest layer down: the linker needs a library before those that it uses.
LAYERS = ("session", "replay", "prove", "world", "tick", "play", "scene", "model", "solve", "collide", "shapes", "state", "math", "base")
WARNINGS = ["-std=c++20", "-Wall", "-Wextra", "-Werror", f"-I{ROOT}/include"]
FLAGS = (("-O1",), ("-O1", "-DNDEBUG"))
HEADERS = ("-fno-exceptions", "-fno-rtti")


def blocks(text, language):
    """Returns (line, text) of each block in this language."""
    return [(text.count("\n", 0, m.start()) + 1, m.group(2)) for m in BLOCK.finditer(text) if m.group(1) == language]


def libraries(build):
    """Returns the linker arguments for the archives of all layers in the build, also of layers that LAYERS lacks."""
    named = [build / f"liblockstone_{layer}.a" for layer in LAYERS]
    others = sorted(set(build.glob("liblockstone_*.a")) - set(named))
    sodium = ["-lsodium"] if (build / "liblockstone_net.a") in others else []
    return ["-Wl,--start-group", *map(str, others), *[str(p) for p in named if p.exists()], "-Wl,--end-group", "-lxxhash", *sodium, "-pthread"]


def compile_fault(source, out, cxx, flags, build):
    """Compiles and links the file. Returns an empty text, or the first error."""
    compiled = subprocess.run([cxx, *WARNINGS, *flags, str(source), "-o", str(out), *libraries(build)], capture_output=True, text=True)
    if compiled.returncode == 0:
        return ""
    return next((l for l in compiled.stderr.splitlines() if "error" in l or "undefined" in l), compiled.stderr[-300:])


def fault_of(program, cxx, flags, build, folder):
    """Builds and runs the program. Returns an empty text, or its fault."""
    source, out = folder / "main.cpp", folder / "main"
    source.write_text(program)
    if fault := compile_fault(source, out, cxx, flags, build):
        return fault
    ran = subprocess.run([str(out)], capture_output=True, text=True, cwd=folder, timeout=120)
    return f"ends with status {ran.returncode}: {(ran.stdout + ran.stderr)[-3000:]}" if ran.returncode != 0 else ""


def check(page, text, compilers, build):
    complaints, programs = [], blocks(text, "cpp")
    with tempfile.TemporaryDirectory(prefix="lockstone-readme-") as folder:
        for line, program in programs:
            for cxx in compilers:
                for flags in FLAGS:
                    if fault := fault_of(program, cxx, flags, build, pathlib.Path(folder)):
                        complaints.append(f"{page}:{line}: by {cxx} {' '.join(flags)}: {fault}")
    return complaints or ([] if programs else [f"{page}:1: holds no C++"])


def shown_faults(text, build):
    """Runs the commands of README.md that lead to `lockstone diff`, and compares the shown lines with the printed ones. No complaints if the
    build has no command line."""
    program, printed = build.resolve() / "bin/lockstone", ""
    if not program.exists():
        return []
    commands = [line for _, block in blocks(text, "sh") for line in block.splitlines() if re.match(r"\$bin (run|branch|diff) ", line)]
    with tempfile.TemporaryDirectory(prefix="lockstone-readme-") as folder:
        for command in commands:
            words = command.split("#")[0].split()[1:]
            printed = subprocess.run([program, *words], capture_output=True, text=True, cwd=folder).stdout
    shown = [line for _, block in blocks(text, "text") for line in block.splitlines()]
    return [f"README.md shows {line.strip()!r}, but {commands[-1].split('#')[0].strip()} prints {printed}"
            for line in shown if line not in printed.splitlines()]


def line_faults(text):
    """Returns a complaint if a program of the page GAME has too many lines."""
    counts = [sum(bool(line.strip()) for line in program.splitlines()) for _, program in blocks(text, "cpp")]
    return [f"{GAME}: a program of {count} lines, and at most {GAME_LINES_MAX} are allowed" for count in counts if count > GAME_LINES_MAX]


def events_before_tick(text):
    """Returns the page GAME with a fault: its game reads the events before the tick."""
    tick = next(line for line in text.splitlines(keepends=True) if line.lstrip().startswith("world.tick();"))
    last = "        return world.write(score, now);\n"
    assert text.count(tick) == 1 and text.count(last) == 1
    return text.replace(tick, "").replace(last, "        const Status done = world.write(score, now);\n        world.tick();\n        return done;\n")


def headers_alone(compilers):
    """Checks that games without exceptions and run-time types can include every public header."""
    complaints = []
    text = "".join(f"#include <{h.relative_to(ROOT / 'include')}>\n" for h in sorted((ROOT / "include/lockstone").rglob("*.h")))
    for cxx in compilers:
        done = subprocess.run([cxx, *WARNINGS, *HEADERS, "-fsyntax-only", "-x", "c++", "-"], input=text, capture_output=True, text=True)
        if done.returncode != 0:
            complaints.append(f"{cxx} {' '.join(HEADERS)}: {next((l for l in done.stderr.splitlines() if 'error' in l), '?')}")
    return complaints


PLANTED = [
    ("a result that nobody looks at", "```cpp\n#include <lockstone/world.h>\nint main() { lockstone::World::create({}); }\n```\n"),
    ("a variable that only an assertion uses",
     "```cpp\n#include <cassert>\nint main() { int x = 1; assert(x == 1); }\n```\n"),
    ("statements outside of a function", "```cpp\n#include <lockstone/world.h>\nusing namespace lockstone;\nreturn 0;\n```\n"),
    ("a program that fails", "```cpp\nint main() { return 3; }\n```\n"),
    ("no program at all", "```sh\ntrue\n```\n"),
]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--libraries", type=pathlib.Path)
    parser.add_argument("--cxx", action="append")
    parser.add_argument("--planted", action="store_true")
    parser.add_argument("--extract", nargs=2, metavar=("LANGUAGE", "NUMBER"))
    arguments = parser.parse_args()
    readme = (ROOT / "README.md").read_text()
    if arguments.extract:
        print(blocks(readme, arguments.extract[0])[int(arguments.extract[1])][1], end="")
        return 0
    compilers = arguments.cxx or ["g++"]
    if arguments.planted:
        missed = [name for name, text in PLANTED if not check("planted", text, compilers[:1], arguments.libraries)]
        game = (ROOT / GAME).read_text()
        if not line_faults(game.replace("```cpp\n", "```cpp\n" + "// a line\n" * GAME_LINES_MAX)):
            missed.append("a program with too many lines")
        if (arguments.libraries / "bin/lockstone").exists() and not shown_faults(readme.replace("row 1, position", "row 2, position"), arguments.libraries):
            missed.append("a line that the command line does not print")
        noticed = check(GAME, events_before_tick(game), compilers[:1], arguments.libraries)
        shown = [line for _, block in blocks(game, "text") for line in block.splitlines()]
        if not noticed or not all(line in each for line in ["ends with status 1", *shown] for each in noticed):
            missed.append(f"a game that reads the events before the tick, as {GAME} shows it: {noticed}")
        print("\n".join(f"missed a planted fault: {name}" for name in missed))
        return 1 if missed else 0
    texts = {page: (ROOT / page).read_text() for page in PAGES}
    complaints = [each for page, text in texts.items() for each in check(page, text, compilers, arguments.libraries)]
    complaints += line_faults(texts[GAME]) + shown_faults(readme, arguments.libraries) + headers_alone(compilers)
    count = sum(len(blocks(text, "cpp")) for text in texts.values())
    print("\n".join(complaints) or f"{count} programs, {len(compilers)} compilers, {len(FLAGS)} builds each")
    return 1 if complaints else 0


if __name__ == "__main__":
    sys.exit(main())
