#include "solve/joints/pack/joint_point.h"

#include "lockstone/math/math.h"
#include "solve/joints/joint_work.h"

#include <algorithm>
#include <cstdint>

namespace lockstone::solve {

namespace {

void set_arm_shift(PackSide& side, std::uint32_t lane, int exponent) {
    // A shift by 62 leaves nothing of sums below 2^61.
    const std::int64_t shift = side.spin_shift[lane] + side.lever_bits[lane] + exponent - row_bits;
    side.arm_shift[lane] = std::clamp<std::int64_t>(shift, 1, 62);
    side.arm_half[lane] = std::int64_t{1} << (side.arm_shift[lane] - 1);
}

/// Sets e and all data that depends on it.
void set_exponent(JointPack& pack, std::uint32_t lane, int e, const Shares& shares,
                  const StepConstants& step) {
    pack.exponent[lane] = e;
    const std::int64_t one = e > row_bits ? 0 : std::int64_t{1} << (row_bits - e);
    pack.one[lane] = static_cast<std::int32_t>(one);
    pack.a.pull[lane] = static_cast<std::int32_t>((one * shares.a.mantissa) >> 30);
    pack.b.pull[lane] = static_cast<std::int32_t>((one * shares.b.mantissa) >> 30);
    pack.push_max[lane] = scaled_speed(step.joint_push_max.raw, Real::fraction_bits, e);
    pack.near_shift[lane] = std::min(Real::fraction_bits - Separation::fraction_bits + e, 62);
    pack.ahead_shift[lane] = std::min(Unit::fraction_bits + 1 + e, 62);
    set_arm_shift(pack.a, lane, e), set_arm_shift(pack.b, lane, e);
}

/// share * dot with 48 fraction bits; dot has 56 and is below 2^60.
std::int64_t shared(std::int64_t dot, Share share) {
    constexpr int low_bits = 28;
    const std::int64_t high = dot >> low_bits, low = dot & ((std::int64_t{1} << low_bits) - 1);
    const std::int64_t sum = high * share.mantissa + ((low * share.mantissa) >> low_bits); // 58 fraction bits
    return share.shift > 52 ? 0 : sum >> (10 + share.shift);
}

Share share_of(const PackSide& side, std::uint32_t lane) {
    return {side.share[lane], static_cast<std::int32_t>(side.shift[lane])};
}

void add_stiffness(Stiffness& s, const PackSide& side, std::uint32_t lane, std::int64_t one) {
    const Share share = share_of(side, lane);
    if (share.mantissa == 0) return;
    for (int r = 0; r < 3; ++r)
        for (int c = 0; c <= r; ++c) {
            std::int64_t dot = r == c ? one * one : 0;
            for (int i = 0; i < 3; ++i) dot += std::int64_t{side.x[r][i][lane]} * side.x[c][i][lane];
            s.k[r][c] += shared(dot, share);
        }
}

} // namespace

void give_gyration(PackSide& side, std::uint32_t lane, const BodyInertia& body) {
    const auto& [xx, yy, zz, xy, xz, yz] = body.inv_mantissa;
    const std::int32_t entries[6] = {xx, yy, zz, xy, xz, yz};
    for (int i = 0; i < 6; ++i) side.inverse[i][lane] = entries[i];
}

void enlarge_exponent(JointPack& pack, const JointWork& work, const StepConstants& step) {
    const std::uint32_t lane = work.lane;
    const int before = pack.exponent[lane], e = before + 1;
    set_exponent(pack, lane, e, work.shares, step);
    for (int r = 0; r < 3; ++r) {
        pack.impulse[r][lane] = rescaled_impulse(pack.impulse[r][lane], before, e);
        pack.sum[r][lane] = shifted(pack.sum[r][lane], before - e);
    }
}

static void invert_point(JointPack& pack, std::uint32_t lane) {
    Stiffness s{};
    add_stiffness(s, pack.a, lane, pack.one[lane]), add_stiffness(s, pack.b, lane, pack.one[lane]);
    s.largest = std::max({s.k[0][0], s.k[1][1], s.k[2][2]});
    set_inverse(pack.inverse, lane, invert(s, 3));
}

// ---- hinges -------------------------------------------------------------------------------------------------------

namespace {

/// Half the range of the limits of a twist.
Real half_range(const JointAxisPart& part) { return half(part.upper_at - part.lower_at); }

} // namespace

void set_hinge_frames(JointTick& tick, const JointWork& work) {
    TurnPack& turn = turn_pack(tick, work);
    const std::uint32_t lane = work.lane;
    const Rotation a = to_rotation(work.frame_a.rotation), b = to_rotation(work.frame_b.rotation);
    const UnitVec3 from_a[2] = {a.y, a.z}, from_b[2] = {b.x, b.y};
    for (int k = 0; k < 2; ++k)
        for (int i = 0; i < 3; ++i)
            turn.local_a[k][i][lane] = from_a[k][i].raw, turn.local_b[k][i][lane] = from_b[k][i].raw;
    turn.world_a[lane] = work.a.world ? -1 : 0, turn.world_b[lane] = work.b.world ? -1 : 0;
}

void plan_hinge(JointTick& tick, const JointWork& work) {
    set_hinge_frames(tick, work);
    if (work.axis_count != 1) return;
    TurnPack& turn = turn_pack(tick, work);
    const JointAxisPart& part = tick.axes[work.first_axis];
    const std::uint32_t lane = work.lane;
    const Real range = half_range(part), middle = part.lower_at + range;
    turn.middle_cos[lane] = to<Unit>(cos(middle)).raw, turn.middle_sin[lane] = to<Unit>(sin(middle)).raw;
    if (range >= pi) return;
    turn.limit_cos[lane] = to<Unit>(cos(range)).raw;
    turn.limit_rise[lane] = range > half_pi ? unit_one.raw : to<Unit>(sin(range)).raw;
}

/// An upper bound of the cosine of half the range minus `least`: cos(a - b) is at most cos a + b sin a up to a right
/// angle, and at most cos a + b beyond.
static std::int32_t reach_cosine(const TurnPack& turn, std::uint32_t lane, const JointAxisPart& part,
                                 Real least) {
    const Real range = half_range(part), reach = range - least;
    if (reach <= Real{}) return INT32_MAX;
    if (reach >= pi) return INT32_MIN;
    if (range >= pi) return to<Unit>(cos(reach)).raw;
    constexpr int down = Real::fraction_bits;
    const std::int64_t rise = (least.raw * turn.limit_rise[lane] >> down) + 1;
    return saturate_to_int32(turn.limit_cos[lane] + rise);
}

void set_reach(TurnPack& turn, const JointWork& work, const JointAxisPart* limits, Real least) {
    const std::uint32_t lane = work.lane;
    turn.reach_cos[lane] = limits != nullptr ? reach_cosine(turn, lane, *limits, least) : INT32_MIN;
}

static void invert_hinge(const JointPack& pack, TurnPack& turn, std::uint32_t lane) {
    Stiffness s{};
    const auto add = [&](const std::int32_t(&j)[3][3][pack_lanes], Share share) {
        if (share.mantissa == 0) return;
        for (int r = 0; r < 2; ++r)
            for (int c = 0; c <= r; ++c) {
                std::int64_t dot = 0;
                for (int i = 0; i < 3; ++i) dot += std::int64_t{j[r][i][lane]} * j[c][i][lane];
                s.k[r][c] += shared(dot, share);
            }
    };
    add(turn.ja, share_of(pack.a, lane)), add(turn.jb, share_of(pack.b, lane));
    s.largest = std::max(s.k[0][0], s.k[1][1]);
    set_inverse(turn.inverse, lane, invert(s, 2));
}

void invert_left(JointPack& pack, TurnPack* turns, std::uint32_t lane) {
    if (((pack.points_left >> lane) & 1u) != 0) invert_point(pack, lane);
    if (((pack.hinges_left >> lane) & 1u) != 0) invert_hinge(pack, turns[pack.turn], lane);
}

void leave_hinge(JointBlock& block, TurnPack& turn, std::uint32_t lane) {
    turn.generic[lane] = -1;
    block.exponent = turn.exponent[lane];
    for (Real& sum : block.sum) sum = Real{};
}

Vec3 hinge_axis(const TurnPack& turn, std::size_t row, std::uint32_t lane) {
    const auto one = [&](int i) {
        return Real::from_raw(std::int64_t{turn.axis[row][i][lane]} << (Real::fraction_bits - row_bits));
    };
    return {one(0), one(1), one(2)};
}

} // namespace lockstone::solve
