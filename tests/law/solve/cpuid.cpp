// Decodes the CPUID words of an x86 processor. Only builds by MSVC's compilers use this code, so other builds test it
// here.
#include "solve/lanes/cpuid.h"

#include "lockstone/compiler.h"

#include <doctest/doctest.h>

#if LOCKSTONE_HAS_X86 && LOCKSTONE_GNU
#include <cpuid.h>
#endif

namespace lockstone {
namespace {

using solve::CpuidWords;

constexpr std::uint32_t bit(int at) { return std::uint32_t{1} << at; }

TEST_CASE("has_simd() requires exactly the CPUID bits of each instruction set") {
    struct Needs {
        Simd level;
        CpuidWords needed;
    };
    const Needs levels[] = {
        {Simd::sse41, {bit(19), 0, 0}},
        {Simd::avx2, {bit(28), bit(5), 0x06}},
        {Simd::avx512, {bit(28), bit(5) | bit(16) | bit(17) | bit(31), 0xe6}},
    };
    for (const Needs& needs : levels) { // clang's lambdas take no structured bindings
        const Simd level = needs.level;
        const CpuidWords needed = needs.needed;
        CAPTURE(name_of(level));
        CHECK(solve::has_simd(needed, level));
        for (std::uint32_t CpuidWords::*word :
             {&CpuidWords::leaf1_ecx, &CpuidWords::leaf7_ebx, &CpuidWords::kept})
            for (int at = 0; at < 32; ++at) {
                CpuidWords without = needed, alone = {~0u, ~0u, ~0u};
                without.*word &= ~bit(at), alone.*word &= ~bit(at);
                const bool is_needed = (needed.*word & bit(at)) != 0;
                CAPTURE(at);
                CHECK(solve::has_simd(without, level) == !is_needed);
                CHECK(solve::has_simd(alone, level) == !is_needed);
            }
    }
    CHECK_FALSE(solve::has_simd({~0u, ~0u, ~0u}, Simd::neon));
}

#if LOCKSTONE_HAS_X86 && LOCKSTONE_GNU
TEST_CASE("has_simd() reads this processor's CPUID words as the compiler's own function does") {
    unsigned a = 0, b = 0, c = 0, d = 0;
    CpuidWords words;
    REQUIRE(__get_cpuid(1, &a, &b, &c, &d));
    words.leaf1_ecx = c;
    if (__get_cpuid_count(7, 0, &a, &b, &c, &d)) words.leaf7_ebx = b;
    if (solve::has_xgetbv(words.leaf1_ecx)) asm volatile("xgetbv" : "=a"(words.kept), "=d"(d) : "c"(0));
    for (const Simd level : {Simd::sse41, Simd::avx2, Simd::avx512}) {
        CAPTURE(name_of(level));
        CHECK(solve::has_simd(words, level) == has_simd(level));
    }
}
#endif

} // namespace
} // namespace lockstone
