#include "math/estimate.h"

#include "math/roots.h"

namespace lockstone::detail {

#if LOCKSTONE_NO_DOUBLE

std::uint64_t isqrt_estimated(std::uint64_t n) { return isqrt_integer(n); }
std::uint64_t isqrt_estimated(std::uint64_t high, std::uint64_t low) { return isqrt_integer(high, low); }
std::uint64_t inverse_root_estimated(std::uint64_t n) { return inverse_root_integer(n); }

#else

std::uint64_t isqrt_estimated(std::uint64_t n) { return isqrt_from(estimate_sqrt(n), n); }

std::uint64_t isqrt_estimated(std::uint64_t high, std::uint64_t low) {
    if (high == 0) return isqrt_estimated(low);
    // Below 2^104 the root fits the guess's 53 bits; above, half of it is guessed and half comes from a division.
    if (high < (std::uint64_t{1} << 40)) return isqrt_from(estimate_sqrt(high, low), high, low);
    return isqrt_128(high, low, [](std::uint64_t n) { return isqrt_from(estimate_sqrt(n), n); });
}

std::uint64_t inverse_root_estimated(std::uint64_t n) {
    return inverse_root_from(estimate_inverse_root(n), n);
}

#endif

void take_roots(std::int64_t* n, std::size_t count) {
    for (std::size_t i = 0; i < count; ++i)
        n[i] = static_cast<std::int64_t>(isqrt_estimated(static_cast<std::uint64_t>(n[i])));
}

} // namespace lockstone::detail
