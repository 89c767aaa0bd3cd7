// Exact roots from any guess. Each function takes the guess as an argument, so tests can pass bad guesses.
#pragma once

#include "lockstone/math/math.h"

namespace lockstone::detail {

/// floor(sqrt(n)). The function proves the guess, corrects it by one, or ignores it.
inline std::uint64_t isqrt_from(std::uint64_t guess, std::uint64_t n) {
    std::uint64_t s = guess > 0xffffffffu ? 0xffffffffu : guess;
    // s is the root exactly when 0 <= n - s^2 <= 2 s. A negative difference wraps to more than 2 s.
    if (n - s * s <= 2 * s) return s;
    if (s * s > n)
        --s;
    else if (s < 0xffffffffu)
        ++s;
    if (n - s * s <= 2 * s) return s;
    return isqrt_integer(n);
}

/// Replaces each number of a list that is not negative by floor(sqrt(n)): processors compute several roots at the
/// same time.
void take_roots(std::int64_t* n, std::size_t count);

/// floor(sqrt(high * 2^64 + low)) for high < 2^40.
inline std::uint64_t isqrt_from(std::uint64_t guess, std::uint64_t high, std::uint64_t low) {
    std::uint64_t s = guess;
    const Wide n = (Wide::from(static_cast<std::int64_t>(high)) << 64) + Wide::product_unsigned(low, 1);
    for (int attempt = 0; attempt < 2 && s < (std::uint64_t{1} << 53); ++attempt) {
        const Wide rest = n - Wide::product_unsigned(s, s);
        if (rest.is_negative())
            --s;
        else if (Wide::product_unsigned(2 * s, 1) < rest)
            ++s;
        else
            return s;
    }
    return isqrt_integer(high, low);
}

/// min(floor(2^63 / sqrt(n)), 2^32 - 1) for n in [2^62, 2^64).
inline std::uint64_t inverse_root_from(std::uint64_t guess, std::uint64_t n) {
    constexpr std::uint64_t largest = 0xffffffffu;
    // q is right exactly when 0 <= left < (2 q + 1) n with left = 2^126 - q^2 n.
    const auto left = [n](std::uint64_t q) {
        return (Wide::from(1) << 126) - Wide::product_unsigned(q * q, n);
    };
    // A product above 2^126 shows as a negative rest or, past 2^127 + 2^126, as one above 2^126.
    const auto is_right = [n](std::uint64_t q, Wide rest) {
        return static_cast<std::uint64_t>(rest.high_bits()) < std::uint64_t{1} << 62 &&
               (q == largest || rest < Wide::product_unsigned(2 * q + 1, n));
    };
    std::uint64_t q = guess > largest ? largest : guess;
    const Wide rest = left(q);
    if (is_right(q, rest)) return q;
    if (rest.is_negative())
        --q;
    else
        ++q;
    if (q <= largest && is_right(q, left(q))) return q;
    return inverse_root_integer(n);
}

} // namespace lockstone::detail
