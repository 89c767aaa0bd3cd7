// Rows of joints: scaling, responses, the inverse of a part. See joint.h for the symbols.
//
// A row is first built wide: each of its four vectors has its own exponent. Then one power of two scales all four. A
// lever of 100 m on a body of 1 mm and a body of 10 km therefore neither lose bits nor leave the range.
#pragma once

#include "solve/bodies/solver_body.h"

#include <algorithm>
#include <array>

namespace lockstone::solve {

/// Components m / 2^fraction_bits.
struct Scaled3 {
    std::int64_t m[3] = {};
    int fraction_bits = 0;
};

/// A row before scaling: directions, and K^-1 times the arms about which the row turns the bodies.
struct WideRow {
    Scaled3 da, xa, db, xb;
};

/// A body's part of the inverse mass of the pair, mantissa / 2^(30 + shift): mantissa in [2^29, 2^30], or zero.
struct Share {
    std::int32_t mantissa;
    std::int32_t shift;
};
struct Shares {
    Share a, b;
};
/// share_A = mB / (mA + mB), share_B = mA / (mA + mB); zero for a body that impulses do not move
Shares joint_shares(const BodyMass& a, const BodyStep& sa, const BodyMass& b, const BodyStep& sb);

/// Six components: along x y z, about x y z. Jacobian entries are below 2 in magnitude.
struct Row {
    std::int32_t ja[6], jb[6]; ///< Jacobian
    std::int32_t ra[6], rb[6]; ///< responses: Jacobian entries times the share's mantissa, 28 fraction bits
    std::int32_t shift_a, shift_b; ///< v += (r p) / 2^shift
};

/// The inverse matrix of up to three rows: entry = mantissa / 2^shift, applied to Speed.
struct Inverse {
    std::int32_t m[6]; ///< 11, 21, 22, 31, 32, 33
    std::int32_t shift;
};
inline constexpr int inverse_index[3][3] = {{0, 1, 3}, {1, 2, 4}, {3, 4, 5}};

inline constexpr std::int32_t joint_impulse_max = (1 << 30) - 1; ///< 2048 m/s; twice this fits into 32 bits
inline constexpr std::int32_t joint_speed_max = 1 << 29;         ///< 1024 m/s: faster velocities are clamped
/// Largest change of the impulse of a part in one pass. An impulse plus a change then stays within 32 bits.
inline constexpr std::int32_t impulse_change_max = 1 << 30;
/// A change of impulse below this changes a velocity by less than 16 m/s. One joint makes about 30 changes in a pass,
/// so velocities stay below the 2048 m/s that can be read without clamping.
inline constexpr std::int32_t small_impulse = 1 << 22;
inline constexpr int motion_bits = 29 + row_bits; ///< log2 of joint_speed_max with 47 fraction bits
inline constexpr std::int64_t motion_max = std::int64_t{1} << motion_bits;

/// v / 2^shift, rounded. A negative shift multiplies and saturates.
inline std::int64_t shifted(std::int64_t v, int shift) {
    if (shift > 0 && shift <= 62) [[likely]]
        return (v >> shift) + ((v >> (shift - 1)) & 1);
    return shift > 62 ? 0 : shift_left_saturated(v, std::min(-shift, 63));
}

/// K^-1 arm; zero about axes that the body may not turn about, and for a body that does not move. `arm` has
/// `fraction_bits`, and its components are below 2^31.
Scaled3 turning(const BodyInertia& body, const std::int64_t arm[3], int fraction_bits);

/// Writes the Jacobians of `count` rows, all scaled by 2^-exponent, and returns the exponent. For zero rows it is 0.
int set_rows(Row* rows, const WideRow* wide, int count);
/// As set_rows(), set_responses() and invert(), for rows without linear part. They do not touch the linear entries,
/// which stay zero.
int set_turning_rows(Row* rows, const WideRow* wide, int count);
void set_turning_responses(Row& row, const Shares& shares);
Inverse invert_turning(const Row* rows, int count);
/// Computes the responses of a row from the shares and from the axes along which the bodies may move.
void set_responses(Row& row, const Shares& shares, const SolverBody& a, const SolverBody& b);
inline constexpr int mobility_bits = 48;
/// k = J . r of one row, below 2^54.
std::int64_t mobility(const Row& row);
/// J of one row times r of another, with angular entries only: one of the rows has no linear part.
std::int64_t turning_product(const Row& j, const Row& r);
/// 1 / k; zero if no body can move along the row
Inverse invert_mobility(std::int64_t k);
/// k of a part, lower triangle, 48 fraction bits; and its largest diagonal entry
struct Stiffness {
    std::int64_t k[3][3];
    std::int64_t largest;
};
Inverse invert(const Stiffness& stiffness, int count);
/// Inverse of k for one to three rows. Directions in which the bodies cannot move are left out.
Inverse invert(const Row* rows, int count);

/// value 2^-exponent as Speed, clamped to joint_speed_max. `raw` has `fraction_bits`.
inline std::int32_t scaled_speed(std::int64_t raw, int fraction_bits, int exponent) {
    const std::int64_t v = shifted(raw, fraction_bits + exponent - Speed::fraction_bits);
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(v, -joint_speed_max, joint_speed_max));
}
/// p 2^exponent, clamped to joint_impulse_max; p is an unscaled impulse
inline std::int32_t scaled_impulse(Real p, int exponent) {
    const std::int64_t v = shifted(p.raw, Real::fraction_bits - Speed::fraction_bits - exponent);
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(v, -joint_impulse_max, joint_impulse_max));
}
/// p 2^-exponent
inline Real unscaled_impulse(std::int64_t p, int exponent) {
    return Real::from_raw(shifted(p, Speed::fraction_bits + exponent - Real::fraction_bits));
}
/// Converts an impulse from the exponent `from` to the exponent `to`.
inline std::int32_t rescaled_impulse(std::int32_t p, int from, int to) {
    const std::int64_t v = shifted(p, from - to);
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(v, -joint_impulse_max, joint_impulse_max));
}

} // namespace lockstone::solve
