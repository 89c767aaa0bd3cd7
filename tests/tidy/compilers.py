"""The engine is C++20. Code that only g++ and clang accept, or only one kind of processor, is inside a condition on a macro of lockstone/compiler.h,
beside a form for other compilers: MSVC's cl must compile the engine, too. With LOCKSTONE_PLAIN_CPLUSPLUS=1 g++ and clang compile that form, in cells
of tests/matrix.

Attributes such as [[gnu::cold]] are allowed: a compiler ignores unknown attributes. -Wpedantic finds extensions of the language's grammar."""
import re

from tree import numbered, without_comments

ENGINE = ("include", "src", "replay")
# Lanes of one instruction set. Other files include them inside such a condition.
LANES = ("src/solve/lanes/sse41.h", "src/solve/lanes/avx2.h", "src/solve/lanes/avx512.h")

WORDS = [
    (r"\b__builtin_\w+", "a builtin function"),
    (r"\b(__attribute__|__extension__|__typeof__|typeof|__label__|__PRETTY_FUNCTION__)\b", "an extension"),
    (r"\b__int128(_t)?\b", "a 128-bit integer"),
    (r"\b(asm|__asm|__asm__)\b", "inline assembly"),
    (r"\b__(sync|atomic)_\w+", "a builtin function"),
    (r"^\s*#\s*pragma\s+(GCC|clang|STDC)\b.*", "a pragma of one compiler"),
    (r"\b_Pragma\b", "a pragma of one compiler"),
    (r"\b(__forceinline|__declspec|__assume)\b", "an extension"),
    (r"^\s*#\s*include\s*<(\w*intrin|cpuid|arm_neon|arm_acle|wasm_simd128)\.h>", "a header of one kind of processor"),
    (r"\b_mm\d*_\w+", "an instruction of one kind of processor"),
]
ASKS = re.compile(r"(?<![!\w])LOCKSTONE_(GNU|HAS_\w+)\b")


def guards(condition):
    """Returns true if the condition holds only for compilers or processors that support the code."""
    return ASKS.search(condition) is not None and "||" not in condition


def unguarded(text):
    """Yields the numbered lines outside of such conditions."""
    nest = []
    for number, line in numbered(text):
        directive = re.match(r"\s*#\s*(ifdef|ifndef|if|elif|else|endif)\b(.*)", line)
        if directive is None:
            if not any(nest):
                yield number, line
        elif directive[1].startswith("if"):
            nest.append(directive[1] == "if" and guards(directive[2]))
        elif nest and directive[1] == "endif":
            nest.pop()
        elif nest:
            nest[-1] = directive[1] == "elif" and guards(directive[2])


def check(tree):
    complaints = []
    for path in tree.files(ENGINE):
        name = tree.name(path)
        if name in LANES:
            continue
        for number, line in unguarded(without_comments(path.read_text())):
            for pattern, meaning in WORDS:
                if found := re.search(pattern, line):
                    complaints.append(f"{name}:{number}: {meaning} where lockstone/compiler.h is not asked: '{found.group(0).strip()}'")
    return complaints


def source(text):
    return {"src/base/x.cpp": text}


PLANTED = [
    ("a builtin function", source("int f(unsigned x) { return __builtin_clz(x); }\n")),
    ("one in the branch for the others", source("#if LOCKSTONE_GNU\nint f();\n#else\nint f() { return __builtin_clz(1); }\n#endif\n")),
    ("one behind the condition", source("#if LOCKSTONE_GNU\n#endif\nint f() { return __builtin_clz(1); }\n")),
    ("one where the compiler has not what is asked", source("#if !LOCKSTONE_GNU\nint f() { return __builtin_clz(1); }\n#endif\n")),
    ("one where something else will do", source("#if LOCKSTONE_GNU || X\nint f() { return __builtin_clz(1); }\n#endif\n")),
    ("one where a compiler's own macro is asked", source("#if defined(__GNUC__)\nint f() { return __builtin_clz(1); }\n#endif\n")),
    ("a 128-bit integer", {"include/lockstone/x.h": "#pragma once\ninline long f(long a) { return (__int128(a) * a) >> 64; }\n"}),
    ("an attribute in the old form", source("__attribute__((noinline)) int f();\n")),
    ("inline assembly", {"replay/x.cpp": 'void f() { asm volatile("" ::: "memory"); }\n'}),
    ("a pragma", source('#pragma GCC diagnostic ignored "-Wall"\n')),
    ("a header of x86", source("#include <immintrin.h>\n")),
    ("an instruction of x86", source("void f() { _mm_pause(); }\n")),
    ("a lane of another name", {"src/solve/lanes/avx3.h": "#pragma once\nvoid f() { _mm256_zeroall(); }\n"}),
]
GOOD = [
    ("a builtin function with a form for the others", source("#if LOCKSTONE_GNU && !defined(__clang__)\nint f() { return __builtin_clz(1); }\n#else\nint f() { return 31; }\n#endif\n")),
    ("one behind another condition", source("#if X\nint g();\n#elif LOCKSTONE_HAS_X86\n#include <immintrin.h>\nvoid f() { _mm_pause(); }\n#endif\n")),
    ("one inside another condition", source("#if LOCKSTONE_HAS_X86\n#if defined(_MSC_VER)\nvoid f() { _mm_pause(); }\n#endif\n#endif\n")),
    ("words in comments and texts", source('// __builtin_clz\nconst char* f() { return "__int128"; }\n')),
    ("an attribute that others ignore", source("[[gnu::cold]] int f();\n#pragma once\n")),
    ("tools, which are for g++ and clang", {"tools/x.cpp": "int f() { return __builtin_clz(1); }\n"}),
]
