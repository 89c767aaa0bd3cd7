"""Code that computes results has no floating point, no order by address or by hash, no clocks and no random numbers. Tests have no loose
tolerances, and no file has a path of one machine."""
import re

from tree import numbered, without_comments

SIMULATION = ("include", "src", "replay", "tools/scenes")
# convert.h converts between the engine's numbers and floats. The estimate is the start of an exact integer root and cannot change its result.
MAY_USE_FLOATS = ("include/lockstone/math/convert.h", "src/math/estimate.h", "src/math/estimate.cpp")
MAY_USE_CLOCKS = ("src/net/",)

FLOATS = [
    (r"\b(float|double|_Float16|__float128)\b", "floating point"),
    (r"#\s*include\s*<(cmath|math\.h|cfloat|float\.h|cfenv|fenv\.h|complex|valarray)>", "floating point"),
    (r"\b(std::)?(sqrtf?|cbrt|sinf?|cosf?|powf?|fabsf?|floorf?|lround|ldexp|frexp)\s*\(\s*\d+\.\d", "floating point"),
    (r"(?<![\w.\"'])\d[\d']*\.\d+([eE][-+]?\d+)?[fFlL]?(?![\w.])", "a floating-point literal (write 0.5_r)"),
]
ORDER = [
    (r"\b(std::)?unordered_(multi)?(map|set)\b", "order by hash"),
    (r"\bstd::hash\s*<", "order by hash"),
    (r"\b(std::)?(multi)?(map|set)\s*<\s*(const\s+)?[\w:]+(\s+const)?\s*\*", "order by address"),
    (r"\breinterpret_cast\s*<\s*(std::)?u?intptr_t\s*>", "an address as a number"),
]
CLOCKS = [
    (r"#\s*include\s*<(chrono|ctime|time\.h|sys/time\.h)>", "a clock"),
    (r"\bstd::chrono\b|\b(clock_gettime|gettimeofday)\b|(?<![\w.:>])(time|clock)\s*\(\s*(NULL|nullptr|0)?\s*\)(?!\s*(const|override|=|\{))", "a clock"),
    (r"#\s*include\s*<random>|\bstd::(random_device|mt19937\w*)|(?<![\w.:>])s?rand\s*\(", "chance"),
    (r"\bthread_local\b", "state outside the world"),
]
LOOSE = [
    (r"\bdoctest::Approx\b", "a tolerance that adds its epsilon times 1 (use test::about)"),
]
EVERYWHERE = [
    (r"(?<![\w/.])/(home|root|work|Users)/\w", "a path of one machine"),
]


def complaints_of(name, text, rules):
    for number, line in numbered(text):
        for pattern, meaning in rules:
            if found := re.search(pattern, line):
                yield f"{name}:{number}: {meaning}: '{found.group(0).strip()}'"


def check(tree):
    complaints = []
    for path in tree.files(SIMULATION):
        name, text = tree.name(path), without_comments(path.read_text())
        # Strings are blank here, so a decimal in a string is not a literal. Names of headers in <> stay.
        if name not in MAY_USE_FLOATS:
            complaints += complaints_of(name, text, FLOATS)
        complaints += complaints_of(name, text, ORDER)
        if not name.startswith(MAY_USE_CLOCKS):
            complaints += complaints_of(name, text, CLOCKS)
    for path in tree.files(("tests",)):
        if path.name != "about.h":
            complaints += complaints_of(tree.name(path), without_comments(path.read_text()), LOOSE)
    for path in tree.files(endings=(".h", ".cpp", ".md", ".txt", ".sh")):
        complaints += complaints_of(tree.name(path), path.read_text(), EVERYWHERE)
    return complaints


PLANTED = [
    ("a double in a source", {"src/sim/x.cpp": "int f() { double d{}; return d > 1; }\n"}),
    ("a float in a public header", {"include/lockstone/x.h": "struct S { float x; };\n"}),
    ("a float after a comment", {"src/sim/x.cpp": "/* no */ float f;\n"}),
    ("a float in a scene", {"tools/scenes/x.cpp": "float f;\n"}),
    ("a bare decimal", {"src/sim/x.cpp": "auto x = 0.5;\n"}),
    ("<cmath>", {"replay/x.cpp": "#include <cmath>\n"}),
    ("a hash map", {"src/collide/x.cpp": "std::unordered_map<int, int> m;\n"}),
    ("a map by address", {"src/collide/x.cpp": "std::map<const Body*, int> m;\n"}),
    ("an address as a number", {"src/base/x.cpp": "auto a = reinterpret_cast<std::uintptr_t>(p);\n"}),
    ("a clock", {"src/session/x.cpp": "#include <chrono>\n"}),
    ("the time", {"src/session/x.cpp": "auto seed = time(nullptr);\n"}),
    ("rand", {"src/session/x.cpp": "int r = rand();\n"}),
    ("a loose tolerance", {"tests/x.cpp": "CHECK(x == doctest::Approx(0.001).epsilon(0.1));\n"}),
    ("a path of one machine", {"tests/x.cpp": "// see /home" + "/me/notes\n"}),
]
GOOD = [
    ("floats in comments and strings", {"src/sim/x.cpp": '// double trouble, 0.5\nauto s = "float 0.5";\n'}),
    ("exact decimals", {"src/sim/x.cpp": "auto x = 0.5_r, y = 1'000.25_r;\n"}),
    ("convert.h", {"include/lockstone/math/convert.h": "double to_double(int);\n"}),
    ("the demo", {"demo/x.cpp": "float f = 0.5f;\n"}),
    ("integer maps", {"replay/x.cpp": "std::map<std::uint64_t, Row*> m; int floating_points;\n"}),
]
