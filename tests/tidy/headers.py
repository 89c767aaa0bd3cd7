"""Every header compiles alone: the public ones, the layers' and the replay's. Where a source of the same name begins with it, the
release build has shown so: its layers are compiled without precompiled headers."""
import concurrent.futures
import os
import re
import subprocess

INCLUDE = re.compile(r'^\s*#include\s+["<]([^">]+)[">]', re.MULTILINE)


def begins_a_source(tree, header):
    name, source = tree.name(header), header.with_suffix(".cpp")
    if not name.startswith(("src/", "replay/")) or not source.exists():
        return False
    first = INCLUDE.search(source.read_text())
    return first is not None and first.group(1) in (name, name.removeprefix("src/"))


def compile_alone(tree, header):
    command = [tree.cxx, "-std=c++20", "-x", "c++-header", "-fsyntax-only", "-w", f"-I{tree.root}/include", f"-I{tree.root}/src",
               f"-I{tree.root}", f"-I{tree.root}/tools", str(header)]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode == 0:
        return None
    errors = [line for line in run.stderr.splitlines() if "error" in line] or run.stderr.splitlines() or ["?"]
    return f"{tree.name(header)}:1: does not compile alone: {errors[0]}"


def check(tree):
    headers = [h for h in tree.files(("include", "src", "replay", "tools/scenes"), (".h",)) if not begins_a_source(tree, h)]
    with concurrent.futures.ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        return [c for c in pool.map(lambda h: compile_alone(tree, h), headers) if c]


NEEDY = "#pragma once\nstd::uint32_t f();\n"
PLANTED = [
    ("a header that needs another before it", {"include/lockstone/x.h": NEEDY}),
    ("one of which its source is not the first to tell", {"src/base/x.h": NEEDY, "src/base/x.cpp": '#include <cstdint>\n#include "base/x.h"\n'}),
]
GOOD = [
    ("a header that its source begins with", {"src/base/x.h": NEEDY, "src/base/x.cpp": '#include "base/x.h"\n'}),
    ("a header that includes what it uses", {"include/lockstone/x.h": "#pragma once\n#include <cstdint>\nstd::uint32_t f();\n"}),
]
