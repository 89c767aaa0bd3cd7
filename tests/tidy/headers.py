"""Every header of include, src, replay and tools/scenes compiles alone; with LOCKSTONE_LONG=1 every source of src and replay, too. The release build
does not show such errors, because it compiles several sources as one. All standard headers are precompiled and included in each file; the check
`includes` finds standard headers that a file does not include."""
import concurrent.futures
import functools
import os
import pathlib
import subprocess
import tempfile

from includes import HOMES
from lint import KERNELS

KEPT = []  # temporary folders, kept until the program ends


@functools.cache
def standard_headers(cxx):
    """Returns a header that includes all standard headers. Its precompiled form is in the same folder."""
    KEPT.append(tempfile.TemporaryDirectory(prefix="lockstone-headers-"))
    header = pathlib.Path(KEPT[-1].name) / "standard.h"
    header.write_text("".join(f"#include <{name}>\n" for name in sorted({name for homes, _ in HOMES for name in homes.split()})))
    made = f"{header}.pch" if "clang" in cxx else f"{header}.gch"
    subprocess.run([cxx, "-std=c++20", "-x", "c++-header", str(header), "-o", made], check=True)
    return header


def compile_alone(tree, path):
    language = "c++-header" if path.suffix == ".h" else "c++"
    command = [tree.cxx, "-std=c++20", "-fsyntax-only", "-w", *[f"-I{tree.root / folder}" for folder in ("include", "src", "", "tools")],
               *KERNELS.get(path.name, []), "-include", str(standard_headers(tree.cxx)), "-x", language, str(path)]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode == 0:
        return None
    errors = [line for line in run.stderr.splitlines() if "error" in line] or run.stderr.splitlines() or ["?"]
    return f"{tree.name(path)}:1: does not compile alone: {errors[0]}"


def check(tree):
    paths = tree.files(("include", "src", "replay", "tools/scenes"), (".h",))
    if os.environ.get("LOCKSTONE_LONG"):
        paths += tree.files(("src", "replay"), (".cpp",))
    standard_headers(tree.cxx)
    with concurrent.futures.ThreadPoolExecutor(min(2, os.cpu_count() or 1)) as pool:
        return [c for c in pool.map(lambda path: compile_alone(tree, path), paths) if c]


OTHER = {"include/lockstone/other.h": "#pragma once\nstruct Other {};\n"}
NEEDY = "#pragma once\nOther f();\n"
PLANTED = [
    ("a header that needs another before it", {**OTHER, "include/lockstone/x.h": NEEDY}),
    ("one whose source helps it", {**OTHER, "src/base/x.h": NEEDY, "src/base/x.cpp": '#include "lockstone/other.h"\n#include "base/x.h"\n'}),
]
GOOD = [("a header that includes what it uses",
         {**OTHER, "include/lockstone/x.h": '#pragma once\n#include "lockstone/other.h"\nOther f();\nstd::uint32_t g();\n'})]
