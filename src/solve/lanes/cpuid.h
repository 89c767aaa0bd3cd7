// The instruction sets that an x86 processor reports, for compilers without a function for it.
#pragma once

#include "lockstone/simd.h"

#include <cstdint>

namespace lockstone::solve {

/// Registers after the instructions CPUID and XGETBV. The last two are 0 where the processor has no leaf 7, or no
/// XGETBV.
struct CpuidWords {
    std::uint32_t leaf1_ecx = 0;
    std::uint32_t leaf7_ebx = 0;
    std::uint32_t kept = 0; ///< XCR0: the registers that the operating system saves for each thread
};

/// True if leaf 1 reports XGETBV, and that the operating system uses it.
constexpr bool has_xgetbv(std::uint32_t leaf1_ecx) { return (leaf1_ecx >> 27 & 1) != 0; }

/// True if the processor has the instructions, and the operating system saves their registers.
/// source: Intel 64 and IA-32 Architectures Software Developer's Manual, vol. 1, 12.13 (SSE4.1), 14.7.1 (AVX2), 15.2 (AVX-512)
constexpr bool has_simd(const CpuidWords& words, Simd level) {
    const auto bit = [](std::uint32_t word, int at) { return (word >> at & 1) != 0; };
    const auto keeps = [&](std::uint32_t registers) { return (words.kept & registers) == registers; };
    const bool has_avx2 = bit(words.leaf1_ecx, 28) && bit(words.leaf7_ebx, 5) && keeps(0x06);
    switch (level) {
    case Simd::sse41:
        return bit(words.leaf1_ecx, 19);
    case Simd::avx2:
        return has_avx2;
    case Simd::avx512: // F, DQ, VL
        return has_avx2 && bit(words.leaf7_ebx, 16) && bit(words.leaf7_ebx, 17) && bit(words.leaf7_ebx, 31) &&
               keeps(0xe6);
    default:
        return false;
    }
}

} // namespace lockstone::solve
