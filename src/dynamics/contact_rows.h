// Rows of contacts while they are prepared, one lane at a time. See contact.h for the symbols.
#pragma once

#include "dynamics/contact.h"

#include "lockstone/math.h"

#include <algorithm>

namespace lockstone::dynamics {

inline constexpr std::int64_t jacobian_limit = std::int64_t{4} << row_bits; ///< |x| per component

struct Row {
    std::int32_t x[3];
};

/// sign * K^-1 (r x d) with locked axes left out.
inline Row angular_row(const BodyStep& body, LengthVec3 lever, UnitVec3 d, std::int64_t sign) {
    const LengthVec3 c = cross<Length>(lever, d);
    const std::int64_t x = body.angular_mask & 1u ? c.x.raw : 0;
    const std::int64_t y = body.angular_mask & 2u ? c.y.raw : 0;
    const std::int64_t z = body.angular_mask & 4u ? c.z.raw : 0;
    const Symmetric<std::int32_t>& m = body.inv_mantissa;
    // 30 bits times 31 bits, three times: below 2^63.
    const std::int64_t sums[3] = {m.xx * x + m.xy * y + m.xz * z, m.xy * x + m.yy * y + m.yz * z,
                                  m.xz * x + m.yz * y + m.zz * z};
    const int shift = body.inv_exponent + Length::fraction_bits - row_bits;
    Row row{};
    for (int i = 0; i < 3; ++i) {
        const std::int64_t v = shift >= 63  ? 0
                               : shift >= 0 ? shift_right_rounded(sums[i], shift)
                                            : shift_left_saturated(sums[i], std::min(-shift, 63));
        row.x[i] = static_cast<std::int32_t>(sign * std::clamp(v, -jacobian_limit, jacobian_limit));
    }
    return row;
}

/// |d|^2 over the axes the body may move along, plus |x|^2, with 56 fraction bits.
inline std::int64_t row_length_squared(const SolverBody& body, const std::int32_t d[3], const Row& row) {
    std::int64_t sum = 0;
    for (int i = 0; i < 3; ++i)
        sum += ((std::int64_t{d[i]} * d[i]) & body.keep[i]) + std::int64_t{row.x[i]} * row.x[i];
    return sum;
}

/// The share of each body in the pair's inverse mass: alpha + beta = 1; 0 for what impulses do not move.
struct Shares {
    std::int64_t a, b; ///< 30 fraction bits
};

/// Fills one lane of the block of a contact; leaves it empty, its count 0, where points have to do. `inverse_min` is
/// that of the contact's impulses, `inverse_mean` the mean k' of its points' normal rows, 30 fraction bits.
template <unsigned N>
void fill_block(ContactPack<N>& pack, unsigned lane, const SolverBodies& bodies, const Contact& contact,
                const UnitVec3 (&directions)[3], Shares shares, const Softness& soft,
                std::int64_t inverse_min, std::int64_t inverse_mean);

} // namespace lockstone::dynamics
