// Hinges that packs make: their twist and its limits. Also computes when limits of a twist are out of reach, and
// counts whole turns of a twist within a tick.
#include "solve/joints/joint_work.h"

#include "lockstone/math/math.h"

namespace lockstone::solve {

namespace {

/// Upper bound of the angular speed of a side, the sum of the components [rad/s]. For hinges it is read from the pack
/// data.
Real spin_size(const JointTick& tick, const JointWork& work, const JointWorkSide& side) {
    if (side.world) return {};
    if (!work.hinge) {
        const Vec3 w = abs(tick.bodies[side.cache].w);
        return w.x + w.y + w.z;
    }
    std::uint64_t size = 0;
    for (const std::int32_t w : tick.turned[side.cache + 1].spin) size += magnitude(w);
    return Real::from_raw(static_cast<std::int64_t>(size) << (Real::fraction_bits - Speed::fraction_bits));
}

/// Upper bound of the relative angular speed of both sides [rad/s].
Real most_spin(const JointTick& tick, const JointWork& work) {
    return spin_size(tick, work, work.a) + spin_size(tick, work, work.b);
}

constexpr Real room_slack = Real(1) / Real(16);

/// If the twist changes by more than this in a tick, it is computed from the turns of the bodies [rad].
constexpr Real fast_turn = Real(1);

} // namespace

Real least_room(const JointTick& tick, const JointWork& work, const StepConstants& step) {
    constexpr Real given = Real(20);
    const Real speed = given + most_spin(tick, work);
    return mul<Real>(min(speed, limit_speed_far), step.substep_time) + room_slack;
}

bool is_out_of_reach(const JointAxisPart& part, const JointAxisImpulses* last, Real position, Real least) {
    if ((part.features & (has_spring | has_motor)) != 0 || part.sum != Real{}) return false;
    if (last == nullptr ? (part.lower | part.upper) != 0 : last->lower != Real{} || last->upper != Real{})
        return false;
    return ((part.features & has_lower) == 0 || position - part.lower_at > least) &&
           ((part.features & has_upper) == 0 || part.upper_at - position > least);
}

namespace {

/// The frame of one side in world axes.
Quat frame_now(const JointTick& tick, const JointWorkSide& side, const JointFrame& frame) {
    return side.world ? frame.rotation : quat_product(tick.bodies[side.cache].rotation, frame.rotation);
}
/// The x axis of to_rotation(), for a unit quaternion.
UnitVec3 x_axis(Quat q) {
    const std::int64_t x = q.x.raw, y = q.y.raw, z = q.z.raw, w = q.w.raw;
    const auto dropped = [](std::int64_t sum, int bits) {
        return Unit::from_raw(static_cast<std::int32_t>((sum + (std::int64_t{1} << (bits - 1))) >> bits));
    };
    constexpr int whole = Unit::fraction_bits;
    return {dropped(w * w + x * x - y * y - z * z, whole), dropped(x * y + w * z, whole - 1),
            dropped(x * z - w * y, whole - 1)};
}

/// True if a body of a joint in a pack has turned by more than 2^-given_turn_bits rad since the tick began.
bool has_turned_far(const JointTick& tick, const JointWork& work) {
    const auto seen = [&](const JointWorkSide& s) { return s.world ? 0u : unsigned{tick.seen[s.cache + 1]}; };
    return ((seen(work.a) | seen(work.b)) & seen_far) != 0;
}

/// True if limits are out of reach at the twist of the last tick and no angle needs to be computed now: the pack
/// checks if they stay out of reach. The twist is then set to the middle of the range, which requires that the limits
/// are less than a half turn from it on either side.
bool stays_out_of_reach(const JointWork& work, const JointAxisPart& part, const JointAxisImpulses& last,
                        Real least) {
    return is_out_of_reach(part, &last, work.twist, least) &&
           half(part.upper_at - part.lower_at) - least < pi;
}

/// Distance at which limits come within reach. The pack does not check limits that are a whole turn apart, so fast
/// joints that may reach them within the tick keep a row throughout.
Real room_of(const JointTick& tick, const JointWork& work, const JointAxisPart& part, Real least,
             const StepConstants& step) {
    if (half(part.upper_at - part.lower_at) - least < pi) return least;
    const Real way = mul<Real>(most_spin(tick, work), step.tick_time);
    return way > fast_turn ? max(least, way + room_slack) : least;
}

/// Computes the twist of a hinge, and the row of its limits. Returns false, without a row, if they are out of reach.
bool make_twist(JointTick& tick, JointWork& work, JointAxisPart& part, Real least, const StepConstants& step,
                const SolverBodies& bodies) {
    JointAxisImpulses last;
    if (!work.made) last = impulses_of(part, tick.memory[work.memory]);
    if (!work.made && stays_out_of_reach(work, part, last, least)) {
        work.twist = part.lower_at + half(part.upper_at - part.lower_at);
        return false;
    }
    const Quat qa = frame_now(tick, work.a, work.frame_a), qb = frame_now(tick, work.b, work.frame_b);
    const UnitVec3 xa = x_axis(qa), xb = x_axis(qb);
    const JointAxisImpulses* const before = work.made ? nullptr : &last;
    const Real before_tick = tick.memory[work.memory].twist;
    work.twist = twist_between(
        qa, qb, work.counts_turns ? expected_twist(tick, work, qa, before_tick, bodies) : Real{});
    // If the x axes are nearly opposite, a small turn of the bodies changes the twist a lot.
    work.steady = work.stays && dot<Real>(xa, xb) >= decimal<Real>("-0.5");
    if (is_out_of_reach(part, before, work.twist, room_of(tick, work, part, least, step))) return false;
    const RowValue value =
        twist_value(work.twist, xa, xb, inertia_now(work.a.body, bodies), inertia_now(work.b.body, bodies));
    part.unmade = false;
    make_axis_row(part, before, work, value, step, bodies);
    return true;
}

} // namespace

/// Turn of B relative to A about x since the tick began [rad]. Includes whole turns, which poses do not contain.
static Real turned_about(const JointWork& work, UnitVec3 x, const SolverBodies& bodies) {
    const auto turned = [&](const JointWorkSide& side) {
        if (side.world) return Real{};
        const auto& theta = bodies.body[side.body].theta;
        const Vector3<Separation> by{Separation::from_raw(theta[0]), Separation::from_raw(theta[1]),
                                     Separation::from_raw(theta[2])};
        return dot<Real>(x, over_gyration<Real>(bodies.step[side.body], by));
    };
    return turned(work.b) - turned(work.a);
}

Real expected_twist(const JointTick& tick, const JointWork& work, Quat a, Real before,
                    const SolverBodies& bodies) {
    if (work.hinge && !has_turned_far(tick, work)) return work.twist;
    const Real turned = turned_about(work, x_axis(a), bodies);
    if (abs(turned) <= fast_turn) return work.twist;
    const auto start = [&](const JointWorkSide& s, const JointFrame& frame) {
        return s.world ? frame.rotation : quat_product(unit_of(tick.pose[s.body].rotation), frame.rotation);
    };
    return twist_between(start(work.a, work.frame_a), start(work.b, work.frame_b), before) + turned;
}

Real twist_to_store(const JointTick& tick, const JointWork& work, Real before, const SolverBodies& bodies) {
    const auto now = [&](const JointWorkSide& s, const JointFrame& frame) {
        return s.world ? frame.rotation
                       : quat_product(rotation_now(tick.pose[s.body], s.body, bodies), frame.rotation);
    };
    if (!work.hinge || has_turned_far(tick, work)) {
        const Quat a = now(work.a, work.frame_a);
        const Real near = expected_twist(tick, work, a, before, bodies);
        if (near != work.twist) return twist_between(a, now(work.b, work.frame_b), near);
    }
    // A stored twist from the start of the tick or later is enough: the next tick chooses the nearest equivalent
    // angle.
    if (work.hinge && work.needs_twist) return work.twist;
    const auto kept = [&](const JointWorkSide& s, const JointFrame& frame) {
        return s.world ? frame.rotation : tick.bodies[s.cache].rotation * frame.rotation;
    };
    return twist_between(kept(work.a, work.frame_a), kept(work.b, work.frame_b), work.twist);
}

bool make_hinge(JointTick& tick, JointWork& work, const StepConstants& step, const SolverBodies& bodies) {
    TurnPack& turn = turn_pack(tick, work);
    JointAxisPart* const part = work.axis_count == 1 ? &tick.axes[work.first_axis] : nullptr;
    const bool is_other = turn.apart[work.lane] != 0 || turn.generic[work.lane] != 0;
    if (work.axis_count > 1 || is_other || (part != nullptr && part->kind != RowKind::twist)) return false;
    const Real least = least_room(tick, work, step);
    work.steady = work.stays; // trees have no packed hinges
    const bool has_row = part != nullptr && make_twist(tick, work, *part, least, step, bodies);
    if (part != nullptr && !has_row) part->turns = part->unmade = part->idle = true;
    if (!work.made) set_reach(turn, work, has_row ? nullptr : part, least);
    work.made = work.remade = true;
    set_glance(tick, work, has_row, part != nullptr);
    put_axes(tick, work);
    return true;
}

} // namespace lockstone::solve
