"""clang-format 14 changes no source, with the .clang-format of the repository."""
import pathlib
import re
import shutil
import subprocess

STYLE = pathlib.Path(__file__).resolve().parents[2] / ".clang-format"
# A declaration that clang-format broke, because the comment at its end makes the line too long.
SCAR = re.compile(r"^\s+(?!return\b|case\b|throw\b)[\w:<>,*& ]+\n\s{8,}[\w\[\]{}(), ]+;\s*///<", re.MULTILINE)


def formatter():
    for name in ("clang-format-14", "clang-format"):
        path = shutil.which(name)
        if path and " 14." in subprocess.run([path, "--version"], capture_output=True, text=True).stdout:
            return path
    return None


def check(tree):
    program = formatter()
    if program is None:
        return ["clang-format:1: version 14 is not installed (package clang-format-14)"]
    files = tree.files()
    command = [program, f"--style=file:{STYLE}", "--dry-run", "--ferror-limit=1", *map(str, files)]
    told = subprocess.run(command, capture_output=True, text=True).stderr
    complaints = []
    for path, line in dict(re.findall(r"^(\S+?):(\d+):\d+: \w+: code should be clang-formatted", told, re.MULTILINE)[::-1]).items():
        complaints.append(f"{tree.name(pathlib.Path(path))}:{line}: is not as clang-format writes it")
    for path in files:
        text = path.read_text()
        for scar in SCAR.finditer(text):
            complaints.append(f"{tree.name(path)}:{text.count(chr(10), 0, scar.start()) + 1}: a declaration is broken for its comment: put that above it")
    return complaints


PLANTED = [
    ("a brace on a line of its own", {"src/math/x.cpp": "int f()\n{\n    return 1;\n}\n"}),
    ("includes out of order", {"src/math/x.cpp": '#include "math/b.h"\n#include "math/a.h"\n'}),
    ("a declaration that is broken for its comment",
     {"src/math/x.h": "struct S {\n    std::uint32_t\n        source; ///< triangle of a mesh, cell of a height field, part of a compound, and of all others none, that is 0\n};\n"}),
]
GOOD = [("what it wrote", {"src/math/x.cpp": "int f() { return 1; }\n"})]
