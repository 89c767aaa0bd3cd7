#include "dynamics/joint_point.h"

#include "dynamics/joint_work.h"

namespace lockstone::dynamics {

namespace {

constexpr int lever_bits = Length::fraction_bits;
constexpr std::int64_t lever_max = std::int64_t{1} << 31;
constexpr std::int64_t impulse_change_max = std::int64_t{4} * joint_impulse_max;

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

void write(std::int32_t out[3][3], const Arms& arms, int exponent) {
    const int shift = arms.fraction_bits + exponent - row_bits;
    for (int r = 0; r < 3; ++r)
        for (int i = 0; i < 3; ++i) {
            const std::int64_t x = arms.m[r][i];
            // Entries are below 2: a shift to the left loses nothing.
            out[r][i] = static_cast<std::int32_t>(shift > 62   ? 0
                                                  : shift >= 0 ? shift_right_rounded(x, shift)
                                                               : x * (std::int64_t{1} << -shift));
        }
}

/// share * dot with 48 fraction bits; dot has 56 and is below 2^60.
std::int64_t shared(std::int64_t dot, const PointSide& side) {
    constexpr int low_bits = 28;
    const std::int64_t high = dot >> low_bits, low = dot & ((std::int64_t{1} << low_bits) - 1);
    const std::int64_t sum = high * side.share + ((low * side.share) >> low_bits); // 58 fraction bits
    return side.shift > 52 ? 0 : sum >> (10 + side.shift);
}

void add_stiffness(Stiffness& s, const PointSide& side, std::int64_t one) {
    if (side.share == 0) return;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c <= r; ++c) {
            std::int64_t dot = r == c ? one * one : 0;
            for (int i = 0; i < 3; ++i) dot += std::int64_t{side.x[r][i]} * side.x[c][i];
            s.k[r][c] += shared(dot, side);
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

void set_side(PointSide& side, const SideRows& rows, Share share, std::int64_t one, int exponent) {
    write(side.x, rows.arms, exponent);
    side.share = share.mantissa, side.shift = share.shift;
    side.pull = static_cast<std::int32_t>((one * share.mantissa) >> 30);
}

/// x . v
std::int64_t dot(const std::int32_t x[3], const std::int32_t v[3]) {
    return std::int64_t{x[0]} * v[0] + std::int64_t{x[1]} * v[1] + std::int64_t{x[2]} * v[2];
}

/// J . (shift, theta), Separation.
void add_moved(const PointPart& part, const SolverBody& a, const SolverBody& b, std::int64_t sign,
               std::int64_t out[3]) {
    for (int r = 0; r < 3; ++r) {
        const std::int64_t apart = std::int64_t{b.shift[r]} - a.shift[r]; // 33 bits
        // 28 and 33 bits, and six products of 29 and 32: below 2^63
        const std::int64_t sum = part.one * apart + dot(part.a.x[r], a.theta) + dot(part.b.x[r], b.theta);
        out[r] += sign * shift_right_rounded(sum, row_bits);
    }
}

std::int64_t times_unit(std::int64_t x, Unit scale) {
    return shift_right_rounded(x * scale.raw, Unit::fraction_bits);
}

std::int64_t shifted(std::int64_t v, int shift) {
    if (shift > 62) return 0;
    return shift >= 0 ? shift_right_rounded(v, shift) : shift_left_saturated(v, std::min(-shift, 63));
}

void add_pushed(const PointSide& side, const std::int32_t p[3], std::int64_t sign, std::int64_t (&v)[6]) {
    if (side.share == 0) return;
    std::int64_t sum[6];
    std::int32_t part[3];
    for (int r = 0; r < 3; ++r) {
        sum[r] = sign * side.pull * p[r];
        part[r] = static_cast<std::int32_t>(shift_right_rounded(std::int64_t{side.share} * p[r], 30));
    }
    for (int i = 0; i < 3; ++i)
        sum[i + 3] = std::int64_t{side.x[0][i]} * part[0] + std::int64_t{side.x[1][i]} * part[1] +
                     std::int64_t{side.x[2][i]} * part[2];
    add_rounded(v, sum, side.shift);
}

} // namespace

bool fits_point(const JointWork& work, const SolverBodies& bodies) {
    const auto fits = [&](std::uint32_t body) {
        const BodyStep& s = bodies.step[body];
        const SolverBody& b = bodies.body[body];
        return !s.movable || (s.angular_mask == 7u && (b.keep[0] & b.keep[1] & b.keep[2]) == -1);
    };
    return fits(work.a.body) && fits(work.b.body);
}

void take_point(JointTick& tick, JointWork& work) {
    --work.block_count;
    work.point = static_cast<std::uint32_t>(tick.points.size());
    tick.points.push_back({});
}

void make_point(PointPart& part, const JointWork& work, const JointPlace& place, const StepConstants& step,
                const SolverBodies& bodies) {
    const SideRows rows_a = rows_of(place.a, -1), rows_b = rows_of(place.b, 1);
    const int before = part.exponent, e = std::max({0, rows_a.top - 1, rows_b.top - 1});
    part.exponent = e;
    const std::int64_t one = e > row_bits ? 0 : std::int64_t{1} << (row_bits - e);
    part.one = static_cast<std::int32_t>(one);
    set_side(part.a, rows_a, work.shares.a, one, e);
    set_side(part.b, rows_b, work.shares.b, one, e);
    Stiffness s{};
    add_stiffness(s, part.a, one);
    add_stiffness(s, part.b, one);
    s.largest = std::max({s.k[0][0], s.k[1][1], s.k[2][2]});
    part.inverse = invert(s, 3);
    part.push_max = scaled_speed(step.joint_push_max.raw, Real::fraction_bits, e);
    for (int r = 0; r < 3; ++r) {
        part.ahead[r] =
            scaled_speed(half_step(place.arc[r], step.joint_push_max, step).raw, Real::fraction_bits, e);
        part.error[r] = scaled_error(place.s[r], e);
        if (before == e) continue;
        part.impulse[r] = rescaled_impulse(part.impulse[r], before, e);
        part.sum[r] = shifted(part.sum[r], before - e);
    }
    add_moved(part, bodies.body[work.a.body], bodies.body[work.b.body], -1, part.error);
}

void solve_point(PointPart& part, Motion& m, const SolverBody& a, const SolverBody& b,
                 const StepConstants& step, bool bias, std::uint64_t& clamped) {
    const Speeds now(m);
    std::int64_t speed[3];
    for (int r = 0; r < 3; ++r) {
        const std::int64_t apart = std::int64_t{now.b[r]} - now.a[r];
        const std::int64_t sum = part.one * apart + dot(part.a.x[r], now.a + 3) + dot(part.b.x[r], now.b + 3);
        speed[r] = std::clamp<std::int64_t>(shift_right_rounded(sum, row_bits), -joint_impulse_max,
                                            joint_impulse_max);
    }
    if (bias) {
        std::int64_t error[3] = {part.error[0], part.error[1], part.error[2]};
        add_moved(part, a, b, 1, error);
        for (int r = 0; r < 3; ++r)
            speed[r] += bias_of(error[r], step.joint.rate, part.push_max) + part.ahead[r];
    }
    const std::int32_t* k = part.inverse.m;
    const std::int64_t sum[3] = {k[0] * speed[0] + k[1] * speed[1] + k[3] * speed[2],
                                 k[1] * speed[0] + k[2] * speed[1] + k[4] * speed[2],
                                 k[3] * speed[0] + k[4] * speed[1] + k[5] * speed[2]};
    std::int32_t change[3];
    std::uint32_t any = 0;
    for (int r = 0; r < 3; ++r) {
        std::int64_t wanted = std::clamp<std::int64_t>(shifted(sum[r], part.inverse.shift),
                                                       -impulse_change_max, impulse_change_max);
        if (bias)
            wanted = times_unit(wanted, step.joint.mass_scale) +
                     times_unit(part.impulse[r], step.joint.impulse_scale);
        const std::int64_t next = part.impulse[r] - wanted;
        const auto p =
            static_cast<std::int32_t>(std::clamp<std::int64_t>(next, -joint_impulse_max, joint_impulse_max));
        clamped += p != next ? 1u : 0u;
        change[r] = p - part.impulse[r];
        part.impulse[r] = p;
        any |= static_cast<std::uint32_t>(change[r] < 0 ? -change[r] : change[r]);
    }
    push_point(part, change, m);
    if (any >= static_cast<std::uint32_t>(small_impulse)) clamp_motion(m);
}

void push_point(const PointPart& part, const std::int32_t p[3], Motion& m) {
    add_pushed(part.a, p, -1, m.a);
    add_pushed(part.b, p, 1, m.b);
}

} // namespace lockstone::dynamics
