"""The tables of replay/FORMAT.md are equal to the tables of the descriptions in the sources. tools/refresh rewrites them."""
import concurrent.futures
import os
import re
import subprocess

PAGE = "replay/FORMAT.md"
PART = re.compile(r"<!-- (?P<name>\w+) -->\n.*?<!-- end of (?P=name) -->\n", re.DOTALL)


def parts_of(text):
    """Returns {name: table with its marks}."""
    return {match["name"]: match.group(0) for match in PART.finditer(text)}


# A program of these sources prints the tables. The whole command line would take minutes to compile.
SOURCES = ("tools/cli/recordings/format_tables.cpp", "tools/cli/recordings/state_columns.cpp", "src/model/command_names.cpp", "src/model/manifest.cpp",
           "src/math/decimal.cpp", "src/state/layout.cpp", "src/base/assert.cpp", "src/base/hash.cpp", "src/base/result.cpp")
MAIN = '''#include "cli/recordings/format_tables.h"
#include <cstdio>
int main() { std::fputs(lockstone::cli::format_tables().c_str(), stdout); }
'''


def made(tree):
    """Compiles the program in a separate folder. Returns its path, or None if a source is missing."""
    if not all((tree.root / name).exists() for name in SOURCES):
        return None
    folder = tree.build.parent / "tables"
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "main.cpp").write_text(MAIN)
    objects = []
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count() or 1) as pool:
        def compile_one(source):
            out = folder / (source.name + ".o")
            subprocess.run([tree.cxx, "-std=c++20", "-O0", *(f"-I{tree.root / p}" for p in ("include", "src", "tools")), "-c", source, "-o", out], check=True)
            return out
        objects = list(pool.map(compile_one, [folder / "main.cpp", *(tree.root / name for name in SOURCES)]))
    program = folder / "format_tables"
    subprocess.run([tree.cxx, *objects, "-lxxhash", "-o", program], check=True)
    return program


def printed(tree):
    program = made(tree) or tree.build / "bin/lockstone"
    if not program.exists():
        return {}
    return parts_of(subprocess.run([program, "format"], capture_output=True, text=True, check=True).stdout)


def check(tree):
    parts = printed(tree)
    if not parts:
        return [f"{SOURCES[0]}:1: is missing or prints no table"]
    page = tree.root / PAGE
    there = parts_of(page.read_text()) if page.exists() else {}
    complaints = [f"{PAGE}:1: has no table <!-- {name} -->" for name in parts if name not in there]
    complaints += [f"{PAGE}:1: nothing prints the table <!-- {name} -->" for name in there if name not in parts]
    return complaints + [f"{PAGE}:1: the table <!-- {name} --> is not that of the descriptions; tools/refresh rewrites it"
                         for name in parts if there.get(name, parts[name]) != parts[name]]


def refresh(tree):
    """Writes the tables into the page. Returns true if the page changed."""
    page = tree.root / PAGE
    before, parts = page.read_text(), printed(tree)
    after = PART.sub(lambda match: parts.get(match["name"], match.group(0)), before)
    page.write_text(after)
    return after != before


def table(name, row):
    return f"<!-- {name} -->\n| field |\n|---|\n| {row} |\n<!-- end of {name} -->\n"


PROGRAM = {"build/bin/lockstone": "#!/bin/sh\ncat <<'END'\n" + table("world", "seed") + table("commands", "wake_body") + "END\n"}
TRUE = "# The file\n\n" + table("world", "seed") + "\nText.\n\n" + table("commands", "wake_body")
PLANTED = [
    ("not that of the descriptions, a field that was renamed", {**PROGRAM, PAGE: TRUE.replace("seed", "seeds")}),
    ("not that of the descriptions, a row more", {**PROGRAM, PAGE: TRUE.replace("| wake_body |", "| wake_body |\n| rest_body |")}),
    ("no table, one that was left out", {**PROGRAM, PAGE: "# The file\n\n" + table("world", "seed")}),
    ("nothing prints, a table that is kept by hand", {**PROGRAM, PAGE: TRUE + table("ticks", "count")}),
    ("is missing, no program", {PAGE: TRUE}),
    ("prints no table, another program", {"build/bin/lockstone": "#!/bin/sh\n", PAGE: TRUE}),
]
SAYS_WHICH = True
GOOD = [("a page that is true", {**PROGRAM, PAGE: TRUE})]
