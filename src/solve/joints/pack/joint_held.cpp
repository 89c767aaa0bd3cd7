// Placement of bodies with joints, as packs read it. Lanes compute it from theta. For bodies that turned far or are
// followed (followed_turn.h), this file computes it from their rotations.
#include "solve/joints/joint_motion.h"
#include "solve/joints/joint_work.h"

#include "lockstone/math/math.h"

#include <algorithm>
#include <cstddef>
#include <cstring>

namespace lockstone::solve {

/// HeldBodies per chunk of work
static constexpr std::uint32_t groups_chunk = body_chunk / (2 * pack_lanes);

/// Marks a body whose turn theta cannot represent from now on.
static void give_body(JointTick& tick, std::uint32_t at) {
    if (tick.bodies[at].given) return;
    tick.bodies[at].given = true;
    tick.held[at / pack_lanes].strays[at % pack_lanes] = -1;
    tick.given.push_back(at);
}

/// Fills HeldBodies [first, last) for the start of the tick.
static void hold_groups(JointTick& tick, const SolverBodies& bodies, std::uint32_t first,
                        std::uint32_t last) {
    const std::size_t count = tick.bodies.size();
    for (std::uint32_t i = first * pack_lanes; i < last * pack_lanes; ++i) {
        HeldBodies& held = tick.held[i / pack_lanes];
        const std::uint32_t lane = i % pack_lanes, body = i < count ? tick.bodies[i].body : bodies.still();
        const BodyStep& step = bodies.step[body];
        const bool fits = i < count && tick.planned[i].moves && tick.planned[i].fits;
        const auto& [xx, yy, zz, xy, xz, yz] = step.inv_mantissa;
        const std::int32_t inverse[6] = {xx, yy, zz, xy, xz, yz};
        held.place[lane] = body * static_cast<std::uint32_t>(sizeof(SolverBody));
        for (int k = 0; k < 6; ++k) held.inverse[k][lane] = fits ? inverse[k] : 0;
        held.turn_shift[lane] = fits ? step.inv_exponent + Separation::fraction_bits - pack_angle_bits : 1;
        held.spin_shift[lane] = fits ? step.inv_exponent : 1;
        held.strays[lane] = fits ? 0 : -1;
        for (int k = 0; k < 3; ++k) held.packed_at[k][lane] = held.alone_at[k][lane] = 0;
    }
}

void hold_bodies(JointTick& tick, const SolverBodies& bodies, Tasks* tasks) {
    const std::size_t groups = (tick.bodies.size() + pack_lanes - 1) / pack_lanes;
    tick.held.resize(groups);
    tick.turned.resize(1 + groups * pack_lanes), tick.seen.assign(tick.turned.size(), 0);
    tick.turned[0] = {{{unit_one.raw, 0, 0}, {0, unit_one.raw, 0}, {0, 0, unit_one.raw}}, {}, {}, 0};
    tick.given.clear();
    tick.paths.take(base::is_shared(tasks, static_cast<std::uint32_t>(groups), groups_chunk),
                    base::Path::held_by_one, base::Path::held_by_workers);
    base::for_chunks(tasks, static_cast<std::uint32_t>(groups), groups_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         hold_groups(tick, bodies, first, last);
                     });
    for (const FollowedTurn& turn : bodies.turns)
        if (const std::uint32_t at = tick.cache_of[turn.body]; at != 0) give_body(tick, at - 1);
}

namespace {

/// Writes the rotation matrix of a quaternion, with the same bits as lanes.
void set_turn(TurnedBody& to, Quat turn) {
    const std::int64_t q[4] = {turn.x.raw, turn.y.raw, turn.z.raw, turn.w.raw};
    const auto twice = [](std::int64_t sum) { return shift_right_rounded(sum, Unit::fraction_bits - 1); };
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        to.turn[i][i] = static_cast<std::int32_t>(unit_one.raw - twice(q[j] * q[j] + q[k] * q[k]));
        to.turn[i][j] = static_cast<std::int32_t>(twice(q[i] * q[j] - q[3] * q[k]));
        to.turn[j][i] = static_cast<std::int32_t>(twice(q[i] * q[j] + q[3] * q[k]));
    }
}

/// Writes K^-1 u, truncated and clamped as in lanes.
void set_spin(TurnedBody& to, const BodyStep& step, const SolverBody& body) {
    constexpr std::int64_t most = std::int64_t{1} << 30;
    const auto& [xx, yy, zz, xy, xz, yz] = step.inv_mantissa;
    const std::int64_t x = Speeds::speed_of(body.u[0]), y = Speeds::speed_of(body.u[1]),
                       z = Speeds::speed_of(body.u[2]);
    const auto set = [&](std::int32_t& out, std::int64_t sum) {
        out = static_cast<std::int32_t>(std::clamp(sum >> step.inv_exponent, -most, most));
    };
    set(to.spin[0], xx * x + xy * y + xz * z);
    set(to.spin[1], xy * x + yy * y + yz * z);
    set(to.spin[2], xz * x + yz * y + zz * z);
}

/// Computes the placement of a body whose turn theta cannot represent.
void turn_given(JointTick& tick, std::uint32_t at, const SolverBodies& bodies) {
    const std::uint32_t body = tick.bodies[at].body;
    const Transform& pose = tick.pose[body];
    const BodyStep& own = bodies.step[body];
    TurnedBody& to = tick.turned[at + 1];
    if (own.turn != 0) {
        tick.seen[at + 1] |= seen_followed;
        const auto& turned = bodies.turns[own.turn - 1].turned;
        static_assert(offsetof(TurnedBody, shift) == sizeof(turned));
        std::memcpy(&to, turned, sizeof(turned));
        return;
    }
    if (!fits_pack(body, bodies)) return; // no pack reads it
    set_turn(to, rotation_now(pose, body, bodies) * conjugate(pose.rotation));
    set_spin(to, own, bodies.body[body]);
}

} // namespace

void turn_four(JointTick& tick, std::uint32_t group, const JointKernel& kernel, const JointPassData& data,
               const SolverBodies& bodies) {
    kernel.turn(data, group, group + 1);
    for (std::uint32_t at = group * pack_lanes; at < (group + 1) * pack_lanes; ++at) {
        if (at >= tick.bodies.size()) return;
        if ((tick.seen[at + 1] & seen_far) != 0) give_body(tick, at);
        if (!tick.bodies[at].given) continue;
        turn_given(tick, at, bodies);
        // The substep stored the angular velocity of a followed body, but joint_close.cpp has stopped the body since.
        set_spin(tick.turned[at + 1], bodies.step[tick.bodies[at].body], bodies.body[tick.bodies[at].body]);
    }
}

void turn_bodies(JointTick& tick, const JointKernel& kernel, const JointPassData& data,
                 const SolverBodies& bodies, Tasks* tasks) {
    base::for_chunks(
        tasks, static_cast<std::uint32_t>(tick.held.size()), groups_chunk,
        [&](std::uint32_t first, std::uint32_t last, std::uint32_t) { kernel.turn(data, first, last); });
    for (std::uint32_t at = 0; at < tick.bodies.size(); ++at)
        if ((tick.seen[at + 1] & seen_far) != 0) give_body(tick, at);
    base::for_chunks(tasks, static_cast<std::uint32_t>(tick.given.size()), body_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         for (std::uint32_t i = first; i < last; ++i) turn_given(tick, tick.given[i], bodies);
                     });
}

void give_gyration(JointTick& tick, const JointWork& work, const SolverBodies& bodies) {
    JointPack& pack = tick.packs[work.pack];
    const auto give = [&](PackSide& side, const JointWorkSide& s) {
        const std::uint32_t turn = s.world ? 0 : bodies.step[s.body].turn;
        if (turn == 0) return;
        give_gyration(side, work.lane, bodies.turns[turn - 1].now);
    };
    give(pack.a, work.a), give(pack.b, work.b);
}

} // namespace lockstone::solve
