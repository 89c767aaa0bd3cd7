// Placement of bodies and frames within a tick, and the rows computed from it.
#include "solve/joints/joint_motion.h"
#include "solve/joints/joint_work.h"

#include "lockstone/math/math.h"

#include <algorithm>

namespace lockstone::solve {

namespace {

/// K^-1 v, with 32-bit raw values of `fraction_bits`
Vec3 over_gyration(const BodyStep& body, const std::int32_t v[3], int fraction_bits) {
    const std::int64_t arm[3] = {v[0], v[1], v[2]};
    const Scaled3 x = turning(body, arm, fraction_bits);
    const int shift = x.fraction_bits - Real::fraction_bits;
    if (shift > 0 && shift <= 62)
        return {Real::from_raw(shift_right_rounded(x.m[0], shift)),
                Real::from_raw(shift_right_rounded(x.m[1], shift)),
                Real::from_raw(shift_right_rounded(x.m[2], shift))};
    return {round_from<Real>(x.m[0], x.fraction_bits), round_from<Real>(x.m[1], x.fraction_bits),
            round_from<Real>(x.m[2], x.fraction_bits)};
}

/// Avoids std::equal, which would call memcmp.
bool are_same(const std::int32_t (&a)[3], const std::int32_t (&b)[3]) {
    return ((a[0] ^ b[0]) | (a[1] ^ b[1]) | (a[2] ^ b[2])) == 0;
}

std::int32_t speed_of(std::int64_t v) { return saturate_to_int32(shift_right_rounded(v, row_bits)); }

Real from_separation(std::int32_t x) {
    return Real::from_raw(std::int64_t{x} << (Real::fraction_bits - Separation::fraction_bits));
}

/// r v for a lever within 128 m: 30 bits times 32, three times.
Vec3 turned_lever(const Rotation& r, LengthVec3 v) {
    constexpr int extra = Unit::fraction_bits + Length::fraction_bits - Real::fraction_bits;
    const auto one = [&](Unit x, Unit y, Unit z) {
        return Real::from_raw(shift_right_rounded(
            std::int64_t{x.raw} * v.x.raw + std::int64_t{y.raw} * v.y.raw + std::int64_t{z.raw} * v.z.raw,
            extra));
    };
    return {one(r.x.x, r.y.x, r.z.x), one(r.x.y, r.y.y, r.z.y), one(r.x.z, r.y.z, r.z.z)};
}

/// True if the body turns so slowly that the arc curves by less than the step of a Speed [rad/s].
bool turns_slowly(Vec3 w) {
    constexpr std::uint64_t slow = std::uint64_t{1} << (Real::fraction_bits - 6);
    return magnitude(w.x.raw) < slow && magnitude(w.y.raw) < slow && magnitude(w.z.raw) < slow;
}

/// w x (w x lever). w is clamped to 2048 rad/s and the inner product to 2048 m/s, beyond which the arc is of no use.
Vec3 turned_twice(Vec3 w, Vec3 lever) {
    constexpr std::int64_t most = std::int64_t{1} << 30;
    constexpr int speed_drop = Real::fraction_bits - Speed::fraction_bits,
                  lever_drop = Real::fraction_bits - Length::fraction_bits;
    std::int64_t a[3], r[3], v[3];
    for (int i = 0; i < 3; ++i) {
        a[i] = std::clamp(w[i].raw >> speed_drop, -most, most);
        r[i] = lever[i].raw >> lever_drop; // within 2^31
    }
    const auto inner = [&](int i, int j) {
        return std::clamp((a[i] * r[j] - a[j] * r[i]) >> Length::fraction_bits, -most, most);
    };
    v[0] = inner(1, 2), v[1] = inner(2, 0), v[2] = inner(0, 1);
    const auto outer = [&](int i, int j) {
        return Real::from_raw((a[i] * v[j] - a[j] * v[i]) >>
                              (2 * Speed::fraction_bits - Real::fraction_bits));
    };
    return {outer(1, 2), outer(2, 0), outer(0, 1)};
}

/// Present state of one side. Rows of a hinge need directions but no positions, and rows of a point need no
/// directions.
JointSide side_of(const JointTick& tick, const JointWork& work, const JointWorkSide& side,
                  const JointFrame& frame, const SolverBodies& bodies) {
    JointSide now{};
    now.body = &inertia_now(side.body, bodies);
    if (side.world) {
        now.anchor = frame.anchor;
        if (!work.framed) return now;
        now.rotation = frame.rotation;
        now.axes = to_rotation(now.rotation);
        return now;
    }
    const JointBody& body = tick.bodies[side.cache];
    if (work.needs_lever) {
        now.lever = turned_lever(body.axes, frame.lever);
        now.anchor = body.position + now.lever;
        now.w = body.w;
        now.velocity = body.velocity;
        if (!turns_slowly(body.w)) now.centripetal = turned_twice(body.w, now.lever);
    }
    if (!work.framed) return now;
    now.rotation = quat_product(body.rotation, frame.rotation);
    now.axes = to_rotation(now.rotation);
    return now;
}

/// Adds the error that the last move caused, for gears and racks.
void add_travel(const JointTick& tick, JointWork& work, const JointPlace& p, const SolverBodies& bodies) {
    const auto turned = [&](const JointWorkSide& side) {
        if (side.world) return Vec3{};
        return over_gyration(bodies.step[side.body], tick.bodies[side.cache].turned,
                             Separation::fraction_bits);
    };
    const Vec3 xa = to<Real>(p.a.axes.x), xb = to<Real>(p.b.axes.x);
    const Real turn_a = dot(xa, turned(work.a)), ratio = work.def->ratio;
    if (work.def->kind == JointKind::gear) {
        work.travel += mul_add(ratio, dot(xb, turned(work.b)), turn_a);
        return;
    }
    const Vec3 moved = work.b.world ? Vec3{} : tick.bodies[work.b.cache].moved;
    work.travel += turn_a - ratio * dot(xb, moved + cross(turned(work.b), p.b.lever));
}

JointPlace place_of(const JointTick& tick, JointWork& work, const SolverBodies& bodies) {
    JointPlace p{};
    p.def = work.def;
    p.a = side_of(tick, work, work.a, work.frame_a, bodies);
    p.b = side_of(tick, work, work.b, work.frame_b, bodies);
    p.s = p.b.anchor - p.a.anchor;
    p.arc = p.b.centripetal - p.a.centripetal;
    if (work.needs_slip) {
        const Vec3 slip = p.b.velocity + cross(p.b.w, p.b.lever) - p.a.velocity - cross(p.a.w, p.a.lever);
        p.arc_in_a = p.arc;
        if (!turns_slowly(p.a.w))
            p.arc_in_a = p.arc - cross(p.a.w, slip) * Real(2) + cross(p.a.w, cross(p.a.w, p.s));
    }
    if (work.needs_twist)
        work.twist = twist_between(p.a.rotation, p.b.rotation,
                                   work.counts_turns ? expected_twist(tick, work, p.a.rotation,
                                                                      tick.memory[work.memory].twist, bodies)
                                                     : Real{});
    if (work.needs_travel) add_travel(tick, work, p, bodies);
    p.twist = work.twist;
    p.travel = work.travel;
    if (work.needs_orientation) p.orientation_error = orientation_between(p.a.rotation, p.b.rotation);
    if (work.needs_target) {
        const auto target = [&](std::uint32_t i) {
            return work.def->axis[i].mode == AxisMode::locked ? Real{} : work.def->axis[i].target;
        };
        p.target_error =
            target_between(p.a.rotation, p.b.rotation, {target(about_x), target(about_y), target(about_z)});
    }
    return p;
}

struct Bodies {
    const SolverBody &a, &b;
};

// ---- targets ------------------------------------------------------------------------------------------------------

/// J . (shift, theta)
template <class Part> std::int64_t moved_of(const Part& part, const Row& row, Bodies bodies) {
    return part.turns ? turned_along(row, bodies.a, bodies.b) : moved_along(row, bodies.a, bodies.b);
}

std::int32_t speed_within(std::int64_t v) {
    return static_cast<std::int32_t>(std::clamp<std::int64_t>(v, -joint_speed_max, joint_speed_max));
}

void set_block_errors(JointBlock& block, const RowValue* values, bool in_tree, const StepConstants& step,
                      Bodies bodies) {
    const Real arc_most = in_tree ? step.tree_arc_max : step.joint_push_max;
    const Real rate = in_tree ? step.tree_rate : step.joint.rate;
    const int e = block.exponent;
    block.push_max = scaled_speed(step.joint_push_max.raw, Real::fraction_bits, e);
    for (int i = 0; i < block.count; ++i) {
        block.error[i] =
            scaled_error(values[i].position - block.at[i], e) - moved_of(block, block.row[i], bodies);
        const Real ahead = half_step(values[i].arc, arc_most, step);
        block.ahead[i] = scaled_speed(ahead.raw, Real::fraction_bits, e);
        // As set_block_bias(), but finer: if two joints lock the same motion, the difference of their roundings
        // accumulates.
        const Real push =
            clamp((values[i].position - block.at[i]) * rate, -step.joint_push_max, step.joint_push_max);
        block.bias[i] = scaled_speed((push + ahead).raw, Real::fraction_bits, e);
        block.direction[i] = values[i].direction;
        block.is_force[i] = values[i].is_force;
    }
}

void set_block_bias(JointBlock& block, bool in_tree, const StepConstants& step, Bodies bodies) {
    const Real rate = in_tree ? step.tree_rate : step.joint.rate;
    for (int i = 0; i < block.count; ++i) {
        const std::int64_t error = block.error[i] + moved_of(block, block.row[i], bodies);
        block.bias[i] = speed_within(bias_of(error, rate, block.push_max) + block.ahead[i]);
    }
}

/// The largest allowed speed towards a limit; beyond the limit, the speed that leads back.
struct LimitTargets {
    std::int32_t bias, relax;
};
LimitTargets limit_targets(std::int64_t room, std::int32_t ahead, std::int32_t push_max,
                           const StepConstants& step) {
    constexpr std::int64_t far = std::int64_t{1} << 35; // multiplied by up to 2^14 substeps per second
    if (room <= 0) return {speed_within(bias_of(room, step.joint.rate, push_max) + ahead), 0};
    const std::int64_t open = shift_right_rounded(std::min(room, far) * step.substeps_per_second,
                                                  Separation::fraction_bits - Speed::fraction_bits);
    return {speed_within(open + ahead), speed_within(open)};
}

/// Updates biases and the idle flag from the present state of the bodies.
void set_axis_targets(JointAxisPart& part, const StepConstants& step, Bodies bodies) {
    if (part.unmade) return;
    const std::int64_t moved = moved_of(part, part.row, bodies);
    if (part.features & has_spring)
        part.spring_bias = speed_within(bias_of(part.stretch + moved, part.rate, joint_speed_max));
    if (part.features & has_lower) {
        const LimitTargets t = limit_targets(part.room + moved, part.ahead, part.push_max, step);
        part.lower_bias = t.bias, part.lower_relax = t.relax;
    }
    if (part.features & has_upper) {
        const LimitTargets t = limit_targets(part.room_up - moved, part.ahead_up, part.push_max, step);
        part.upper_bias = -t.bias, part.upper_relax = -t.relax;
    }
    const bool low = (part.features & has_lower) != 0, up = (part.features & has_upper) != 0;
    part.idle = (part.features & (has_spring | has_motor)) == 0 && (part.lower | part.upper) == 0 &&
                (!low || part.lower_relax > part.far) && (!up || part.upper_relax < -part.far);
}

/// Computes the reference value of the row's error; called when the row is made.
void set_axis_errors(JointAxisPart& part, const RowValue& value, const StepConstants& step, Bodies bodies) {
    const int e = part.exponent;
    const auto scaled = [e](Real x) { return scaled_speed(x.raw, Real::fraction_bits, e); };
    const std::int64_t moved = moved_of(part, part.row, bodies);
    const Real ahead = half_step(value.arc, step.joint_push_max, step);
    part.stretch = scaled_error(value.position - part.target, e) - moved;
    part.room = scaled_error(value.position - part.lower_at, e) - moved;
    part.room_up = scaled_error(part.upper_at - value.position, e) + moved;
    part.ahead = scaled(ahead), part.ahead_up = scaled(-ahead);
    part.push_max = scaled(step.joint_push_max);
    part.far = scaled(limit_speed_far);
    // Limits have the whole range, so that they can hold against the spring and the motor, whatever the forces of
    // these.
    if (part.features & has_spring)
        part.spring_bound = std::min(scaled_impulse(part.spring_max, e), joint_impulse_max / 4);
    if (part.features & has_motor) {
        part.motor_bias = scaled(-part.motor_speed);
        part.motor_bound = std::min(scaled_impulse(part.motor_max, e), joint_impulse_max / 2);
    }
    part.direction = value.direction;
    part.is_force = value.is_force;
}

// ---- rows ---------------------------------------------------------------------------------------------------------

void make_block(JointBlock& block, const JointWork& work, const JointPlace& place, Bodies bodies,
                const StepConstants& step) {
    RowValue values[3];
    WideRow wide[3];
    if (block.kind[0] == RowKind::point_x)
        point_values(place, values);
    else
        for (int i = 0; i < block.count; ++i) values[i] = row_value(block.kind[i], place);
    for (int i = 0; i < block.count; ++i) wide[i] = values[i].row;
    block.turns = only_turns(block.kind[0]);
    const int before = block.exponent;
    block.exponent =
        block.turns ? set_turning_rows(block.row, wide, block.count) : set_rows(block.row, wide, block.count);
    for (int i = 0; i < block.count; ++i) {
        if (block.turns)
            set_turning_responses(block.row[i], work.shares);
        else
            set_responses(block.row[i], work.shares, bodies.a, bodies.b);
        if (!work.made) {
            block.impulse[i] = scaled_impulse(block.sum[i], block.exponent);
            block.sum[i] = Real{};
        } else if (before != block.exponent) {
            block.impulse[i] = rescaled_impulse(block.impulse[i], before, block.exponent);
        }
    }
    // Trees need no inverses, except for a point: motors and limits use it (axis_with_point.h).
    if (work.tree == no_tree || (work.axis_count != 0 && block.kind[0] == RowKind::point_x))
        block.inverse = block.turns ? invert_turning(block.row, block.count) : invert(block.row, block.count);
    set_block_errors(block, values, work.tree != no_tree, step, bodies);
}

/// `last`: see is_out_of_reach().
void make_axis(JointAxisPart& part, const JointAxisImpulses* last, const JointWork& work,
               const JointPlace& place, Real least, const StepConstants& step, const SolverBodies& bodies) {
    part.unmade = part.kind == RowKind::twist && is_out_of_reach(part, last, place.twist, least);
    if (part.unmade) {
        part.turns = part.idle = true;
        return;
    }
    make_axis_row(part, last, work, row_value(part.kind, place), step, bodies);
}

/// True if the x axes are nearly opposite: a small turn of the bodies then changes the twist a lot.
bool is_opposite(const JointPlace& place) {
    return dot<Real>(place.a.axes.x, place.b.axes.x) < decimal<Real>("-0.5");
}

/// True if the direction of an angle about y or z of A turns by more than twice the turn of the bodies: xB is within
/// 30 degrees of that axis.
bool has_quick_angle(const JointTick& tick, const JointWork& work, const JointPlace& place) {
    const auto is_near = [&](UnitVec3 axis) {
        return abs(dot<Real>(place.b.axes.x, axis)) > decimal<Real>("0.866");
    };
    for (std::uint32_t i = 0; i < work.axis_count; ++i) {
        const RowKind kind = tick.axes[work.first_axis + i].kind;
        if ((kind == RowKind::angle_y && is_near(place.a.axes.y)) ||
            (kind == RowKind::angle_z && is_near(place.a.axes.z)))
            return true;
    }
    return false;
}

/// Largest change of the twist while rows are reused [rad]: both bodies turn by 2^-given_turn_bits rad about each
/// axis, and the twist by up to twice their sum: 4 sqrt(3) / 16.
constexpr Real far_turn_room = decimal<Real>("0.44");

} // namespace

const BodyInertia& inertia_now(std::uint32_t body, const SolverBodies& bodies) {
    const BodyStep& step = bodies.step[body];
    if (step.turn != 0) return bodies.turns[step.turn - 1].now;
    return step;
}

void make_axis_row(JointAxisPart& part, const JointAxisImpulses* last, const JointWork& work,
                   const RowValue& value, const StepConstants& step, const SolverBodies& bodies) {
    const Bodies both{bodies.body[work.a.body], bodies.body[work.b.body]};
    const int before = part.exponent;
    part.turns = only_turns(part.kind);
    if (part.turns) {
        part.exponent = set_turning_rows(&part.row, &value.row, 1);
        set_turning_responses(part.row, work.shares);
        part.inverse = invert_turning(&part.row, 1);
    } else {
        part.exponent = set_rows(&part.row, &value.row, 1);
        set_responses(part.row, work.shares, both.a, both.b);
        part.inverse = invert(&part.row, 1);
    }
    const auto carry = [&](std::int32_t& p, Real JointAxisImpulses::*of) {
        if (last == nullptr)
            p = p == 0 ? 0 : rescaled_impulse(p, before, part.exponent);
        else
            p = last->*of == Real{} ? 0 : scaled_impulse(last->*of, part.exponent);
    };
    carry(part.spring, &JointAxisImpulses::spring), carry(part.motor, &JointAxisImpulses::motor);
    carry(part.lower, &JointAxisImpulses::lower), carry(part.upper, &JointAxisImpulses::upper);
    set_axis_errors(part, value, step, both);
    set_axis_targets(part, step, both);
}

Real half_step(Real x, Real most, const StepConstants& step) {
    const Real speed =
        Real::from_raw(narrow_rounded(Wide::product(x.raw, step.substep_time.raw), Unit::fraction_bits + 1));
    return clamp(speed, -most, most);
}

std::int64_t scaled_error(Real x, int exponent) {
    constexpr std::int64_t far = std::int64_t{1} << 60; // leaves room for the motion of the bodies since
    const int drop = Real::fraction_bits - Separation::fraction_bits + exponent;
    return std::clamp(drop >= 0 ? shift_right_rounded(x.raw, std::min(drop, 62))
                                : shift_left_saturated(x.raw, std::min(-drop, 24)),
                      -far, far);
}

bool is_made_in_pack(const JointTick& tick, const JointWork& work) {
    return work.hinge && tick.turn_packs[tick.packs[work.pack].turn].generic[work.lane] == 0;
}

bool has_own_rows(const JointTick& tick, const JointWork& work) {
    if (!is_made_in_pack(tick, work)) return work.axis_count + work.block_count != 0;
    return work.axis_count > 1 || (work.axis_count == 1 && !tick.axes[work.first_axis].unmade);
}

bool has_axes_alone(const JointTick& tick, const JointWork& work) {
    if (work.pack == no_pack || work.axis_count == 0) return false;
    if (work.block_count != 0 && !is_made_in_pack(tick, work)) return false;
    for (std::uint32_t i = 0; i < work.axis_count; ++i) {
        const JointAxisPart& part = tick.axes[work.first_axis + i];
        // Within 2^-given_turn_bits rad the direction of a narrower cone turns too far.
        if (part.kind == RowKind::swing && part.upper_at < decimal<Real>("0.5")) return false;
    }
    return true;
}

void make_rows(JointTick& tick, JointWork& work, const StepConstants& step, const SolverBodies& bodies) {
    if (work.made && work.pack != no_pack) take_axes(tick, work);
    if (work.hinge && make_hinge(tick, work, step, bodies)) return;
    const JointPlace place = place_of(tick, work, bodies);
    const Bodies both{bodies.body[work.a.body], bodies.body[work.b.body]};
    Real least = work.needs_twist ? least_room(tick, work, step) : Real{};
    if (work.needs_twist && has_axes_alone(tick, work)) least += far_turn_room;
    for (std::uint32_t i = 0; i < work.axis_count; ++i) {
        JointAxisPart& part = tick.axes[work.first_axis + i];
        JointAxisImpulses last;
        if (!work.made) last = impulses_of(part, tick.memory[work.memory]);
        make_axis(part, work.made ? nullptr : &last, work, place, least, step, bodies);
    }
    if (work.hinge && !work.made) {
        TurnPack& turn = turn_pack(tick, work);
        if (turn.apart[work.lane] == 0) {
            set_reach(turn, work, nullptr, least);
        } else {
            turn.generic[work.lane] = -1;
            restart_block(tick.blocks[work.first_block], tick.memory[work.memory]);
        }
    }
    const std::uint32_t blocks = is_made_in_pack(tick, work) ? 0 : work.block_count;
    for (std::uint32_t i = 0; i < blocks; ++i) {
        JointBlock& block = tick.blocks[work.first_block + i];
        TurnPack* turn = work.turns_packed ? &turn_pack(tick, work) : nullptr;
        if (turn != nullptr && work.made) take_impulses(block, *turn, work.lane);
        make_block(block, work, place, both, step);
        if (turn != nullptr) put_turn(block, *turn, work.lane);
    }
    work.steady = work.stays && work.tree == no_tree && !(work.needs_twist && is_opposite(place)) &&
                  !has_quick_angle(tick, work, place);
    work.made = work.remade = true;
    set_glance(tick, work);
    if (work.pack != no_pack)
        put_axes(tick, work);
    else
        set_acting(tick, work);
}

/// True if a lane of a hinge's pack needs rows of its joint that do not exist.
static bool asks_for_rows(const JointTick& tick, std::uint32_t pack, const TurnPack& turn,
                          std::uint32_t lane) {
    if ((turn.apart[lane] | turn.reaches[lane]) == 0 || turn.generic[lane] != 0) return false;
    return turn.apart[lane] != 0 || !has_own_rows(tick, tick.joints[tick.packed[pack * pack_lanes + lane]]);
}

bool asks_for_rows(const JointTick& tick, std::uint32_t i) {
    if (!tick.packs[i].hinges) return false;
    const TurnPack& turn = tick.turn_packs[tick.packs[i].turn];
    std::uint32_t any = 0;
    for (std::uint32_t lane = 0; lane < pack_lanes; ++lane) any |= turn.apart[lane] | turn.reaches[lane];
    for (std::uint32_t lane = 0; any != 0 && lane < tick.packs[i].count; ++lane)
        if (asks_for_rows(tick, i, turn, lane)) return true;
    return false;
}

void make_asked_rows(JointTick& tick, std::uint32_t i, const StepConstants& step,
                     const SolverBodies& bodies) {
    const auto place = [&](const JointWorkSide& s) {
        if (!s.world) place_body(tick.bodies[s.cache], tick.pose[tick.bodies[s.cache].body], bodies);
    };
    TurnPack& turn = tick.turn_packs[tick.packs[i].turn];
    for (std::uint32_t lane = 0; lane < tick.packs[i].count; ++lane) {
        if (!asks_for_rows(tick, i, turn, lane)) continue;
        JointWork& w = tick.joints[tick.packed[i * pack_lanes + lane]];
        if (turn.apart[lane] != 0) leave_hinge(tick.blocks[w.first_block], turn, lane);
        place(w.a), place(w.b);
        make_rows(tick, w, step, bodies);
    }
}

void follow_errors(JointTick& tick, JointWork& work, const StepConstants& step, const SolverBodies& bodies) {
    const Bodies both{bodies.body[work.a.body], bodies.body[work.b.body]};
    if (work.pack != no_pack) take_axes(tick, work);
    for (std::uint32_t i = 0; i < work.axis_count; ++i) {
        set_axis_targets(tick.axes[work.first_axis + i], step, both);
    }
    const std::uint32_t blocks = is_made_in_pack(tick, work) ? 0 : work.block_count;
    for (std::uint32_t i = 0; i < blocks; ++i) {
        JointBlock& block = tick.blocks[work.first_block + i];
        set_block_bias(block, work.tree != no_tree, step, both);
        if (work.turns_packed) put_bias(block, turn_pack(tick, work), work.lane);
    }
    if (work.pack != no_pack)
        put_axis_biases(tick, work);
    else
        set_acting(tick, work);
}

void invert_blocks(JointTick& tick, const JointWork& work) {
    for (std::uint32_t i = 0; i < work.block_count; ++i) {
        JointBlock& block = tick.blocks[work.first_block + i];
        block.inverse = invert(block.row, block.count);
    }
}

Quat rotation_now(const Transform& pose, std::uint32_t body, const SolverBodies& bodies) {
    const BodyStep& step = bodies.step[body];
    const auto& theta = bodies.body[body].theta;
    return step.turn != 0 ? bodies.turns[step.turn - 1].rotation
           : (theta[0] | theta[1] | theta[2]) == 0
               ? unit_of(pose.rotation)
               : integrate_rotation(pose.rotation, over_gyration(step, theta, Separation::fraction_bits));
}

static void set_motion(JointBody& now, const SolverBodies& bodies) {
    const SolverBody& body = bodies.body[now.body];
    for (int i = 0; i < 3; ++i)
        now.velocity[i] =
            Real::from_raw(shift_right_rounded(body.v[i], accumulator_bits - Real::fraction_bits));
    const BodyStep& step = bodies.step[now.body];
    if (step.turn != 0) {
        const std::int32_t* const w = bodies.turns[step.turn - 1].turned + 9;
        now.w = to<Real>(SpeedVec3{Speed::from_raw(w[0]), Speed::from_raw(w[1]), Speed::from_raw(w[2])});
        return;
    }
    const std::int32_t u[3] = {speed_of(body.u[0]), speed_of(body.u[1]), speed_of(body.u[2])};
    now.w = over_gyration(step, u, Speed::fraction_bits);
}

static void set_pose(JointBody& now, const Transform& pose, const SolverBodies& bodies) {
    const SolverBody& body = bodies.body[now.body];
    for (int i = 0; i < 3; ++i) now.shift[i] = body.shift[i], now.theta[i] = body.theta[i];
    now.rotation = rotation_now(pose, now.body, bodies);
}

/// Computes the members that levers depend on. The pose must be set.
static void set_place(JointBody& now, const Transform& pose) {
    for (int i = 0; i < 3; ++i) now.position[i] = pose.position[i] + from_separation(now.shift[i]);
    now.axes = to_rotation(now.rotation);
}

void place_body(JointBody& now, const Transform& pose, const SolverBodies& bodies) {
    const SolverBody& body = bodies.body[now.body];
    const bool still = are_same(body.shift, now.shift) && are_same(body.theta, now.theta);
    for (int i = 0; i < 3 && now.motion_asked; ++i) {
        now.moved[i] = from_separation(body.shift[i]) - from_separation(now.shift[i]);
        now.turned[i] = saturate_to_int32(std::int64_t{body.theta[i]} - now.theta[i]);
    }
    if (still) return;
    set_pose(now, pose, bodies);
    if (now.lever_asked) set_place(now, pose);
    if (now.motion_asked) set_motion(now, bodies);
}

void start_body(JointBody& now, const Transform& pose, const SolverBodies& bodies) {
    const Vec3& most = bodies.step[now.body].radii_inv;
    now.given = false;
    now.radii_bits = bit_length(magnitude(most.x.raw) | magnitude(most.y.raw) | magnitude(most.z.raw));
    set_pose(now, pose, bodies);
}

void start_motion(JointBody& now, const Transform& pose, const SolverBodies& bodies) {
    now.moved = Vec3{};
    for (std::int32_t& turned : now.turned) turned = 0;
    if (now.lever_asked) set_place(now, pose);
    set_motion(now, bodies);
}

} // namespace lockstone::solve
