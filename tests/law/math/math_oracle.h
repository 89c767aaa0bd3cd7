// Shared parts of the math tests: operands at all edges, and an independent reference (MPFR).
#pragma once

#include "lockstone/math/math.h"
#include "lockstone/math/random.h"

#define MPFR_USE_INTMAX_T
#include <mpfr.h>

#include <cmath>
#include <cstdlib>
#include <vector>

namespace oracle {

using namespace lockstone;

/// LOCKSTONE_LONG=1: sweeps fifty times as wide, and whole 32-bit domains.
inline bool long_run() {
    const char* value = std::getenv("LOCKSTONE_LONG");
    return value != nullptr && value[0] == '1';
}
inline int points(int normally) { return long_run() ? normally * 50 : normally; }

/// 0, +-1, the extremes, and each power of two with its neighbours.
template <class Rep> std::vector<Rep> edges() {
    std::vector<Rep> all = {0, std::numeric_limits<Rep>::min(), std::numeric_limits<Rep>::min() + 1,
                            std::numeric_limits<Rep>::max(), std::numeric_limits<Rep>::max() - 1};
    for (int bit = 0; bit < std::numeric_limits<Rep>::digits; ++bit)
        for (int d = -1; d <= 1; ++d) {
            const Rep v = static_cast<Rep>((Rep{1} << bit) + d);
            all.push_back(v);
            all.push_back(static_cast<Rep>(-v));
        }
    return all;
}

/// A value of a random number of bits and a random sign.
inline std::int64_t any_magnitude(Random& random, int bits_max = 63) {
    const int bits = random.range(std::int32_t{0}, bits_max);
    const std::int64_t v = bits == 0 ? 0 : static_cast<std::int64_t>(random.next_u64() >> (64 - bits));
    return (random.next_u32() & 1u) != 0 ? v : -v;
}

/// A real number of 160 bits.
struct Exact {
    mpfr_t value, other;
    Exact() { mpfr_inits2(160, value, other, static_cast<mpfr_ptr>(nullptr)); }
    Exact(const Exact&) = delete;
    Exact& operator=(const Exact&) = delete;
    ~Exact() { mpfr_clears(value, other, static_cast<mpfr_ptr>(nullptr)); }

    void set(std::int64_t raw, int fraction_bits) {
        mpfr_set_sj(value, raw, MPFR_RNDN);
        mpfr_div_2si(value, value, fraction_bits, MPFR_RNDN);
    }
    /// |raw - value * 2^fraction_bits| in steps, after the value is clamped to the range of 64 bits. Changes the value.
    double steps_off(std::int64_t raw, int fraction_bits) {
        mpfr_mul_2si(value, value, fraction_bits, MPFR_RNDN);
        if (mpfr_cmp_d(value, 9223372036854775807.0) >= 0)
            mpfr_set_sj(value, std::numeric_limits<std::int64_t>::max(), MPFR_RNDN);
        if (mpfr_cmp_d(value, -9223372036854775808.0) <= 0)
            mpfr_set_sj(value, std::numeric_limits<std::int64_t>::min(), MPFR_RNDN);
        mpfr_set_sj(other, raw, MPFR_RNDN);
        mpfr_sub(value, value, other, MPFR_RNDN);
        return std::fabs(mpfr_get_d(value, MPFR_RNDN));
    }
};

inline long double value_of(Real x) { return static_cast<long double>(x.raw) / 4294967296.0L; }
inline long double value_of(Unit x) { return static_cast<long double>(x.raw) / 1073741824.0L; }

/// The result of a sweep: how many results were outside their bound, and the largest distance in steps.
struct Sweep {
    long failures = 0, count = 0;
    double worst = 0;

    void add(double steps, double bound) {
        ++count;
        if (!(steps <= bound)) ++failures;
        if (steps > worst) worst = steps;
    }
};

} // namespace oracle
