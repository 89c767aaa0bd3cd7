// The only floating point of the simulation: first guesses for roots. A guess is never a result: roots.h accepts one
// only after exact integer arithmetic has proved or repaired it. So rounding modes, flushed denormals, -ffast-math,
// x87 precision and contraction can change the time a root takes, never its bits.
// LOCKSTONE_NO_DOUBLE=1 selects the integer versions in math.h instead.
#pragma once

#include <cmath>
#include <cstdint>

namespace lockstone::detail {

// Signed conversions, because most processors have no unsigned one. An odd last bit matters to the proof, not to the
// guess.

/// About sqrt(n).
inline std::uint64_t estimate_sqrt(std::uint64_t n) {
    const bool large = (n >> 63) != 0;
    const double root = std::sqrt(static_cast<double>(static_cast<std::int64_t>(large ? n >> 2 : n)));
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(root)) << (large ? 1 : 0);
}

/// About sqrt(high * 2^64 + low), for high < 2^40.
inline std::uint64_t estimate_sqrt(std::uint64_t high, std::uint64_t low) {
    const double n = static_cast<double>(static_cast<std::int64_t>(high)) * 18446744073709551616.0 +
                     static_cast<double>(static_cast<std::int64_t>(low >> 1)) * 2.0;
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::sqrt(n)));
}

/// About 2^63 / sqrt(n), for n in [2^62, 2^64).
inline std::uint64_t estimate_inverse_root(std::uint64_t n) {
    constexpr double two_to_62_and_a_half = 6521908912666391106.0;
    const double root = std::sqrt(static_cast<double>(static_cast<std::int64_t>(n >> 1)));
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(two_to_62_and_a_half / root));
}

} // namespace lockstone::detail
