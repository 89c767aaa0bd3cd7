// Reads and writes the velocities of the two bodies of a joint, in the formats of the rows.
#pragma once

#include "solve/joints/joint_rows.h"

#include <algorithm>

namespace lockstone::solve {

/// Velocities of the two bodies of a joint: linear, then angular.
struct Motion {
    std::int64_t a[6], b[6]; ///< 47 fraction bits
};

/// 32768 m/s: bound of velocities between the impulses of a tree. It leaves room for the impulse of one more part.
inline constexpr std::int64_t motion_between_max = std::int64_t{1} << 62;

inline Motion read(const SolverBody& a, const SolverBody& b) {
    Motion m;
    for (int i = 0; i < 3; ++i) m.a[i] = a.v[i], m.a[i + 3] = a.u[i], m.b[i] = b.v[i], m.b[i + 3] = b.u[i];
    return m;
}
inline void write(const std::int64_t (&m)[6], SolverBody& body) {
    for (int i = 0; i < 3; ++i) body.v[i] = m[i], body.u[i] = m[i + 3];
}
inline void write(const Motion& m, SolverBody& a, SolverBody& b) { write(m.a, a), write(m.b, b); }

/// Clamps velocities to `most`, by default to the 1024 m/s that rows can read. Only extreme impulses exceed that.
inline void clamp_motion(Motion& m, std::int64_t most) {
    for (int i = 0; i < 6; ++i) {
        m.a[i] = std::clamp(m.a[i], -most, most);
        m.b[i] = std::clamp(m.b[i], -most, most);
    }
}

inline void clamp_motion(Motion& m) {
    std::uint64_t any = 0; // sums of velocities within the bound have no bit above that of 2 motion_max
    for (int i = 0; i < 6; ++i)
        any |=
            static_cast<std::uint64_t>(m.a[i] + motion_max) | static_cast<std::uint64_t>(m.b[i] + motion_max);
    if (any >= static_cast<std::uint64_t>(2 * motion_max)) clamp_motion(m, motion_max);
}

/// The velocities as Speed, the format that rows read.
struct Speeds {
    std::int32_t a[6], b[6];
    explicit Speeds(const Motion& m) {
        for (int i = 0; i < 6; ++i) {
            a[i] = speed_of(m.a[i]);
            b[i] = speed_of(m.b[i]);
        }
    }
    static std::int32_t speed_of(std::int64_t v) { // within 2^30: the low bits of a logical shift are right
        constexpr std::uint64_t half_step = std::uint64_t{1} << (row_bits - 1);
        return static_cast<std::int32_t>(
            static_cast<std::uint32_t>((static_cast<std::uint64_t>(v) + half_step) >> row_bits));
    }
};

/// The angular velocities as Speed, for rows without linear part.
struct Turning {
    std::int32_t a[3], b[3];
    explicit Turning(const Motion& m) {
        for (int i = 0; i < 3; ++i) a[i] = Speeds::speed_of(m.a[i + 3]), b[i] = Speeds::speed_of(m.b[i + 3]);
    }
};
inline std::int32_t speed_along(const Row& row, const Turning& now) {
    std::int64_t sum = 0;
    for (int i = 0; i < 3; ++i)
        sum += std::int64_t{row.ja[i + 3]} * now.a[i] + std::int64_t{row.jb[i + 3]} * now.b[i];
    const std::int64_t speed = shift_right_rounded(sum, row_bits);
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(speed, -joint_impulse_max, joint_impulse_max));
}

/// J . (v, u), Speed: twelve products of 29 and 30 bits.
inline std::int32_t speed_along(const Row& row, const Speeds& now) {
    std::int64_t sum = 0;
    for (int i = 0; i < 6; ++i)
        sum += std::int64_t{row.ja[i]} * now.a[i] + std::int64_t{row.jb[i]} * now.b[i];
    const std::int64_t speed = shift_right_rounded(sum, row_bits);
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(speed, -joint_impulse_max, joint_impulse_max));
}

/// J . theta, Separation, for a row without linear part.
inline std::int64_t turned_along(const Row& row, const SolverBody& a, const SolverBody& b) {
    std::int64_t sum = 0;
    for (int i = 0; i < 3; ++i)
        sum += std::int64_t{row.ja[i + 3]} * a.theta[i] + std::int64_t{row.jb[i + 3]} * b.theta[i];
    return shift_right_rounded(sum, row_bits);
}
/// J . (shift, theta), Separation: six products of 29 and 32 bits and six of 29 and 29.
inline std::int64_t moved_along(const Row& row, const SolverBody& a, const SolverBody& b) {
    std::int64_t sum = 0;
    for (int i = 0; i < 3; ++i)
        sum += std::int64_t{row.ja[i]} * a.shift[i] + std::int64_t{row.ja[i + 3]} * a.theta[i] +
               std::int64_t{row.jb[i]} * b.shift[i] + std::int64_t{row.jb[i + 3]} * b.theta[i];
    return shift_right_rounded(sum, row_bits);
}

/// The speed C rate of an error C, clamped to `most`. C is in Separation and clamped to 256 m.
inline std::int64_t bias_of(std::int64_t error, Real rate, std::int32_t most) {
    constexpr std::int64_t far = std::int64_t{1} << 35;
    constexpr int rate_bits = 16, shift = Separation::fraction_bits - Speed::fraction_bits + rate_bits;
    const std::int64_t near = std::clamp(error, -far, far),
                       by = rate.raw >> (Real::fraction_bits - rate_bits);
    // 2^35 times 2^27. With substeps shorter than half a millisecond the rate exceeds that.
    const std::int64_t wanted = by < std::int64_t{1} << 27 ? shift_right_rounded(near * by, shift)
                                                           : narrow_rounded(Wide::product(near, by), shift);
    return std::clamp<std::int64_t>(wanted, -most, most);
}

inline void add_rounded(std::int64_t (&v)[6], const std::int64_t (&sum)[6], int shift) {
    if (shift == 0)
        for (int i = 0; i < 6; ++i) v[i] += sum[i];
    else
        for (int i = 0; i < 6; ++i) v[i] += (sum[i] >> shift) + ((sum[i] >> (shift - 1)) & 1);
}

/// v += sum of r p over the rows of a part: 29 bits times 31, three times. Returns all |p| combined by bitwise or.
inline std::uint32_t push(const Row* rows, const std::int32_t* p, int count, Motion& m) {
    std::int64_t a[6] = {}, b[6] = {};
    std::uint32_t any = 0;
    for (int r = 0; r < count; ++r) {
        any |= static_cast<std::uint32_t>(p[r] < 0 ? -p[r] : p[r]);
        for (int i = 0; i < 6; ++i) {
            a[i] += std::int64_t{rows[r].ra[i]} * p[r];
            b[i] += std::int64_t{rows[r].rb[i]} * p[r];
        }
    }
    add_rounded(m.a, a, rows[0].shift_a);
    add_rounded(m.b, b, rows[0].shift_b);
    return any;
}

/// As push(), for rows without linear part.
inline std::uint32_t push_turning(const Row* rows, const std::int32_t* p, int count, Motion& m) {
    std::int64_t a[3] = {}, b[3] = {};
    std::uint32_t any = 0;
    for (int r = 0; r < count; ++r) {
        any |= static_cast<std::uint32_t>(p[r] < 0 ? -p[r] : p[r]);
        for (int i = 0; i < 3; ++i) {
            a[i] += std::int64_t{rows[r].ra[i + 3]} * p[r];
            b[i] += std::int64_t{rows[r].rb[i + 3]} * p[r];
        }
    }
    for (int i = 0; i < 3; ++i) {
        m.a[i + 3] += shift_right_rounded(a[i], rows[0].shift_a);
        m.b[i + 3] += shift_right_rounded(b[i], rows[0].shift_b);
    }
    return any;
}

} // namespace lockstone::solve
