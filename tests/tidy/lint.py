"""clang-tidy finds nothing in the engine's sources. `.clang-tidy` lists its checks and the purpose of each.

clang-tidy takes seconds for each source, so the check runs on a sample: the longest source of each folder. With
LOCKSTONE_LONG=1 it runs on all sources.
"""
import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess

ENGINE = ("src", "replay")
CONFIG = pathlib.Path(__file__).resolve().parents[2] / ".clang-tidy"
# Flags of these sources, as in CMakeLists.txt.
KERNELS = {"kernel_sse41.cpp": ["-msse4.1"], "kernel_avx2.cpp": ["-mavx2"], "kernel_avx512.cpp": ["-mavx512f", "-mavx512dq", "-mavx512vl"]}
NAMES = ("clang-tidy-14", "clang-tidy")  # later versions have other checks


def sample(paths):
    longest = {}
    for path in paths:
        if path.parent not in longest or path.stat().st_size > longest[path.parent].stat().st_size:
            longest[path.parent] = path
    return list(longest.values())


def checks_of(config):
    text = "".join(line for line in config.read_text().splitlines(True) if not line.startswith("#"))
    return set(re.findall(r"^ +([a-z]+-[a-z-]+)", text, re.MULTILINE))


def complaints_of(program, tree, path):
    flags = ["-std=c++20", *[f"-I{tree.root / folder}" for folder in ("include", "src", "")], *KERNELS.get(path.name, [])]
    done = subprocess.run([program, "--quiet", f"--config-file={CONFIG}", str(path), "--", *flags], capture_output=True, text=True)
    found = re.findall(r"^(?:\./)?(\S+?):(\d+):\d+: (?:warning|error): (.*)$", done.stdout, re.MULTILINE)
    if not found and done.returncode != 0:
        return [f"{tree.name(path)}:1: clang-tidy ends with status {done.returncode}: {done.stderr.strip()[-500:]}"]
    return [f"{os.path.relpath(os.path.join(tree.root, name), tree.root)}:{line}: {what}" for name, line, what in found]


def check(tree):
    program = next(filter(shutil.which, NAMES), None)
    if program is None:
        return ["clang-tidy:1: is not installed (package clang-tidy)"]
    paths = tree.files(ENGINE, (".cpp",))
    if not os.environ.get("LOCKSTONE_LONG"):
        paths = sample(paths)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        found = pool.map(lambda path: complaints_of(program, tree, path), sorted(paths, key=lambda p: -p.stat().st_size))
    complaints = sorted({complaint for of_path in found for complaint in of_path})  # several sources include a header
    untried = checks_of(CONFIG) ^ set(FAULTS)
    return complaints + [f".clang-tidy:1: {name} is not both asked for and planted" for name in sorted(untried)]


def source(text):
    return {"src/base/x.cpp": text}


SAYS_WHICH = True
# For each check: a source in which it has to find a fault.
FAULTS = {
    "bugprone-too-small-loop-variable": "int f(int n) { int s = 0; for (short i = 0; i < n; ++i) s += i; return s; }\n",
    "bugprone-infinite-loop": "void g(); void f() { int i = 0; while (i < 10) g(); }\n",
    "bugprone-signed-char-misuse": "int f(signed char c) { int n = c; unsigned char u = 200; return c == u ? n : 0; }\n",
    "bugprone-undefined-memory-manipulation": "#include <cstring>\n#include <string>\nvoid f(std::string* s) { std::memset(s, 0, sizeof *s); }\n",
    "bugprone-suspicious-memset-usage": "#include <cstring>\nvoid f(int* p) { std::memset(p, '0', 4); }\n",
    "bugprone-use-after-move": "#include <utility>\n#include <vector>\nunsigned long f(std::vector<int> v) { std::vector<int> w = std::move(v); return w.size() + v.size(); }\n",
    "bugprone-inaccurate-erase": "#include <algorithm>\n#include <vector>\nvoid f(std::vector<int>& v) { v.erase(std::remove(v.begin(), v.end(), 1)); }\n",
    "bugprone-unused-raii": "struct Guard { Guard(int); ~Guard(); };\nint f(int x) { Guard(7); return x; }\n",
    "bugprone-unused-return-value": "#include <algorithm>\n#include <vector>\nvoid f(std::vector<int>& v) { std::unique(v.begin(), v.end()); v.clear(); }\n",
    "bugprone-undelegated-constructor": "struct S { int x; S(int n) : x(n) {} S() { S(1); } };\n",
    "bugprone-branch-clone": "int f(int x) { int y; if (x > 3) { y = x + 1; } else { y = x + 1; } return y; }\n",
    "bugprone-suspicious-semicolon": "void g(); void f(int x) {\n    if (x > 3);\n    g();\n}\n",
    "performance-for-range-copy": "#include <string>\n#include <vector>\nunsigned long f(const std::vector<std::string>& v) { unsigned long n = 0; for (const std::string s : v) n += s.size(); return n; }\n",
    "performance-unnecessary-copy-initialization": "#include <vector>\nconst std::vector<int>& g();\nint f() { const std::vector<int> v = g(); return v[0]; }\n",
    "performance-unnecessary-value-param": "#include <vector>\nint f(const std::vector<int> v) { return v[0]; }\n",
    "performance-inefficient-vector-operation": "#include <vector>\nstd::vector<int> f(int n) { std::vector<int> v; for (int i = 0; i < n; ++i) v.push_back(i); return v; }\n",
    "performance-noexcept-move-constructor": "struct S { S(S&&); S& operator=(S&&); };\n",
    "readability-misleading-indentation": "void g(); void f(int x) {\n    if (x > 3)\n        g();\n        g();\n}\n",
    "readability-misplaced-array-index": "int f(int* x) { return 5[x]; }\n",
}
PLANTED = [(name, source(text)) for name, text in FAULTS.items()]
PLANTED += [
    ("bugprone-suspicious-semicolon, in a header", {"src/base/x.h": "#pragma once\nvoid g(); inline void f(int x) {\n    if (x > 3);\n    g();\n}\n", "src/base/x.cpp": '#include "base/x.h"\n'}),
    ("clang-diagnostic-error, a source that does not compile", source("int f( { return 1; }\n")),
]
GOOD = [
    ("what is asked for done right", source("#include <algorithm>\n#include <vector>\nvoid f(std::vector<int>& v) { v.erase(std::remove(v.begin(), v.end(), 1), v.end()); }\n")),
    ("another folder", {"tools/x.cpp": "int f(int* x) { return 5[x]; }\n"}),
]
