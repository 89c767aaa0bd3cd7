"""The simulation's machine code has no floating-point arithmetic.

Moves and bit operations on vector registers are integer instructions, and are allowed. The estimate of a root may use the
processor's double: exact integer arithmetic decides the result of the root.
"""
import re
import shutil
import subprocess

from layers import LINKS

MAY_USE_FLOATS = ("estimate.cpp.o",)

X86 = re.compile(
    r"^(v?(add|sub|mul|div|sqrt|min|max|cmp\w*|comi|ucomi|hadd|hsub|addsub|round|rndscale|rcp|rcp14|rcp28|rsqrt|rsqrt14|rsqrt28|fixupimm|dp|range|reduce|scalef|getexp|getmant)"
    r"(ss|sd|ps|pd|sh|ph)|vf(n?)m(add|sub|addsub|subadd)\w+|v?cvt\w+"
    r"|f(i?add|i?sub|i?mul|i?div|sqrt|i?ld|i?st|com|ucom|chs|abs|rndint|scale|prem|sin|cos|ptan|patan|yl2x|2xm1|xch|nst|nclex|in?it)\w*)$")
ARM64 = re.compile(r"^(f(add|sub|mul|mla|mls|div|sqrt|cm(eq|ge|gt|le|lt)|ac(ge|gt)|madd|msub|nmadd|nmsub|nmul|max|min|cmp|ccmp|cvt|rint|abd|recp|rsqrt|abs|neg)\w*|[su]cvtf)$")
ARITHMETIC = {"x86-64": X86, "aarch64": ARM64}


def architecture(objdump_text):
    found = re.search(r"file format (\S+)", objdump_text)
    return next((name for name in ARITHMETIC if found and name in found.group(1)), None)


def complaints_of(library, text):
    """`text` is the output of objdump -d for an archive: for each member and each function, instructions with tabs between their fields."""
    pattern = ARITHMETIC.get(architecture(text))
    if pattern is None:
        return [f"{library}:1: is for a machine whose floating-point instructions this check does not know; it knows {', '.join(ARITHMETIC)}"]
    member = function = "?"
    complaints = []
    for line in text.split("\n"):
        if "file format" in line:
            member = line.split(":")[0]
        elif line.endswith(">:"):
            function = line[line.index("<") + 1:-2]
        elif line.startswith(" ") and member not in MAY_USE_FLOATS:
            fields = line.split("\t")
            words = fields[2].split() if len(fields) > 2 else []
            if words and pattern.match(words[0]):
                complaints.append(f"{library}:{member}: {words[0]} in {function}")
    return complaints


def check(tree):
    if shutil.which("objdump") is None:
        return ["objdump:1: is not installed (package binutils)"]
    libraries = [tree.build / f"liblockstone_{layer}.a" for layer in LINKS]
    libraries += sorted(tree.build.glob("planted/*.cpp"))
    complaints = []
    for library in libraries:
        if not library.exists():
            continue
        objects = compiled(tree, library) if library.suffix == ".cpp" else library
        text = subprocess.run(["objdump", "-d", "-C", "--no-show-raw-insn", str(objects)], capture_output=True, text=True, check=True)
        # Without raw bytes the mnemonic is in the second field; complaints_of() reads the third.
        complaints += complaints_of(library.name, re.sub(r"^( +[0-9a-f]+:)\t", r"\1\t\t", text.stdout, flags=re.MULTILINE))
    if not any(library.exists() for library in libraries):
        return [f"{tree.build}:1: holds no libraries of the layers"]
    return complaints


def compiled(tree, source):
    out = source.with_suffix(".o")
    subprocess.run([tree.cxx, "-std=c++20", "-O2", "-c", str(source), "-o", str(out)], check=True)
    return out


PLANTED = [
    ("a sum of doubles", {"build/planted/a.cpp": "double f(double a, double b) { return a * b + 1; }\n"}),
    ("a float compared", {"build/planted/a.cpp": "bool f(float a, float b) { return a < b; }\n"}),
    ("an integer made a double", {"build/planted/a.cpp": "double f(long a) { return static_cast<double>(a); }\n"}),
    ("no library at all", {"README.md": ""}),
]
GOOD = [
    ("integer arithmetic, vectorised", {"build/planted/a.cpp": "void f(int* a, const int* b) { for (int i = 0; i < 64; ++i) a[i] += b[i] * 3; }\n"}),
    ("a struct copied through vector registers", {"build/planted/a.cpp": "struct S { long a[8]; };\nvoid f(S* a, const S* b) { *a = *b; }\n"}),
]
