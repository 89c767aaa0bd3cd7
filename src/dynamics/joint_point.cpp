#include "dynamics/joint_point.h"

#include "dynamics/joint_work.h"

namespace lockstone::dynamics {

namespace {

constexpr int lever_bits = Length::fraction_bits;
constexpr std::int64_t lever_max = std::int64_t{1} << 31;

/// K^-1 (r x e) for the three axes e of the world.
struct Arms {
    std::int64_t m[3][3];
    int fraction_bits;
};
Arms arms_of(const BodyStep& body, const std::int64_t r[3]) {
    const auto& [xx, yy, zz, xy, xz, yz] = body.inv_mantissa;
    const std::int64_t x = r[0], y = r[1], z = r[2];
    // 30 bits times 31, twice
    return {{{xy * z - xz * y, yy * z - yz * y, yz * z - zz * y},
             {xz * x - xx * z, yz * x - xy * z, zz * x - xz * z},
             {xx * y - xy * x, xy * y - yy * x, xz * y - yz * x}},
            body.inv_exponent + lever_bits};
}

int top_bit(const Arms& arms) {
    std::uint64_t any = 0;
    for (const auto& row : arms.m)
        for (const std::int64_t x : row) any |= magnitude(x);
    return any == 0 ? -1000 : bit_length(any) - arms.fraction_bits;
}

void write(std::int32_t (&out)[3][3][pack_lanes], std::uint32_t lane, const Arms& arms, int exponent) {
    const int shift = arms.fraction_bits + exponent - row_bits;
    for (int r = 0; r < 3; ++r)
        for (int i = 0; i < 3; ++i) {
            const std::int64_t x = arms.m[r][i];
            // Entries are below 2: a shift to the left loses nothing.
            out[r][i][lane] = static_cast<std::int32_t>(shift > 62   ? 0
                                                        : shift >= 0 ? shift_right_rounded(x, shift)
                                                                     : x * (std::int64_t{1} << -shift));
        }
}

/// share * dot with 48 fraction bits; dot has 56 and is below 2^60.
std::int64_t shared(std::int64_t dot, Share share) {
    constexpr int low_bits = 28;
    const std::int64_t high = dot >> low_bits, low = dot & ((std::int64_t{1} << low_bits) - 1);
    const std::int64_t sum = high * share.mantissa + ((low * share.mantissa) >> low_bits); // 58 fraction bits
    return share.shift > 52 ? 0 : sum >> (10 + share.shift);
}

void add_stiffness(Stiffness& s, const PackSide& side, std::uint32_t lane, Share share, std::int64_t one) {
    if (share.mantissa == 0) return;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c <= r; ++c) {
            std::int64_t dot = r == c ? one * one : 0;
            for (int i = 0; i < 3; ++i) dot += std::int64_t{side.x[r][i][lane]} * side.x[c][i][lane];
            s.k[r][c] += shared(dot, share);
        }
}

/// Rows of one body, and the top bit of their arms.
struct SideRows {
    Arms arms{};
    int top = -1000;
};
SideRows rows_of(const JointSide& side, std::int64_t sign) {
    if (!side.body->moves) return {};
    std::int64_t r[3];
    for (int i = 0; i < 3; ++i)
        r[i] = sign * std::clamp(shift_right_rounded(side.lever[i].raw, Real::fraction_bits - lever_bits),
                                 -lever_max, lever_max);
    const Arms arms = arms_of(*side.body, r);
    return {arms, top_bit(arms)};
}

void set_side(PackSide& side, std::uint32_t lane, const SideRows& rows, Share share, std::int64_t one,
              int exponent) {
    write(side.x, lane, rows.arms, exponent);
    side.pull[lane] = static_cast<std::int32_t>((one * share.mantissa) >> 30);
}

/// J . (shift, theta), Separation.
std::int64_t moved_of(const JointPack& pack, std::uint32_t lane, int r, const SolverBody& a,
                      const SolverBody& b) {
    const std::int64_t apart = std::int64_t{b.shift[r]} - a.shift[r]; // 33 bits
    // 28 and 33 bits, and six products of 29 and 32: below 2^63
    std::int64_t sum = pack.one[lane] * apart;
    for (int i = 0; i < 3; ++i)
        sum +=
            std::int64_t{pack.a.x[r][i][lane]} * a.theta[i] + std::int64_t{pack.b.x[r][i][lane]} * b.theta[i];
    return shift_right_rounded(sum, row_bits);
}

std::int64_t shifted(std::int64_t v, int shift) {
    if (shift > 62) return 0;
    return shift >= 0 ? shift_right_rounded(v, shift) : shift_left_saturated(v, std::min(-shift, 63));
}

} // namespace

void make_point(JointPack& pack, const JointWork& work, const JointPlace& place, const StepConstants& step,
                const SolverBodies& bodies) {
    const std::uint32_t lane = work.lane;
    const SideRows rows_a = rows_of(place.a, -1), rows_b = rows_of(place.b, 1);
    const int before = pack.exponent[lane], e = std::max({0, rows_a.top - 1, rows_b.top - 1});
    pack.exponent[lane] = e;
    const std::int64_t one = e > row_bits ? 0 : std::int64_t{1} << (row_bits - e);
    pack.one[lane] = static_cast<std::int32_t>(one);
    set_side(pack.a, lane, rows_a, work.shares.a, one, e);
    set_side(pack.b, lane, rows_b, work.shares.b, one, e);
    Stiffness s{};
    add_stiffness(s, pack.a, lane, work.shares.a, one);
    add_stiffness(s, pack.b, lane, work.shares.b, one);
    s.largest = std::max({s.k[0][0], s.k[1][1], s.k[2][2]});
    set_inverse(pack.inverse, lane, invert(s, 3));
    pack.push_max[lane] = scaled_speed(step.joint_push_max.raw, Real::fraction_bits, e);
    const SolverBody &a = bodies.body[work.a.body], &b = bodies.body[work.b.body];
    for (int r = 0; r < 3; ++r) {
        pack.ahead[r][lane] =
            scaled_speed(half_step(place.arc[r], step.joint_push_max, step).raw, Real::fraction_bits, e);
        pack.error[r][lane] = scaled_error(place.s[r], e) - moved_of(pack, lane, r, a, b);
        if (before == e) continue;
        pack.impulse[r][lane] = rescaled_impulse(pack.impulse[r][lane], before, e);
        pack.sum[r][lane] = shifted(pack.sum[r][lane], before - e);
    }
}

} // namespace lockstone::dynamics
