"""Every header compiles alone: the public ones, the layers' and the replay's."""
import concurrent.futures
import os
import subprocess


def compile_alone(tree, header):
    command = [tree.cxx, "-std=c++20", "-x", "c++-header", "-fsyntax-only", "-w", f"-I{tree.root}/include", f"-I{tree.root}/src",
               f"-I{tree.root}", f"-I{tree.root}/tools", str(header)]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode == 0:
        return None
    errors = [line for line in run.stderr.splitlines() if "error" in line] or run.stderr.splitlines() or ["?"]
    return f"{tree.name(header)}:1: does not compile alone: {errors[0]}"


def check(tree):
    headers = tree.files(("include", "src", "replay", "tools/scenes"), (".h",))
    with concurrent.futures.ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        return [c for c in pool.map(lambda h: compile_alone(tree, h), headers) if c]


PLANTED = [
    ("a header that needs another before it", {"include/lockstone/x.h": "#pragma once\nstd::uint32_t f();\n"}),
]
GOOD = [
    ("a header that includes what it uses", {"include/lockstone/x.h": "#pragma once\n#include <cstdint>\nstd::uint32_t f();\n"}),
]
