// Where bodies and frames are within a tick, and the rows made of that.
#include "dynamics/joint_work.h"

#include "lockstone/math.h"

#include <algorithm>

namespace lockstone::dynamics {

namespace {

/// K^-1 of a vector of 32-bit raw values with `fraction_bits`.
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

std::int32_t speed_of(std::int64_t v) { return saturate_to_int32(shift_right_rounded(v, row_bits)); }

Real from_separation(std::int32_t x) {
    return Real::from_raw(std::int64_t{x} << (Real::fraction_bits - Separation::fraction_bits));
}

// As operator* and to_rotation of vec.h, of unit quaternions: their sums need no clamping.

Quat product(Quat a, Quat b) {
    const std::int64_t ax = a.x.raw, ay = a.y.raw, az = a.z.raw, aw = a.w.raw;
    const auto one = [](std::int64_t sum) {
        return Unit::from_raw(static_cast<std::int32_t>(shift_right_rounded(sum, Unit::fraction_bits)));
    };
    return {one(aw * b.x.raw + ax * b.w.raw + ay * b.z.raw - az * b.y.raw),
            one(aw * b.y.raw - ax * b.z.raw + ay * b.w.raw + az * b.x.raw),
            one(aw * b.z.raw + ax * b.y.raw - ay * b.x.raw + az * b.w.raw),
            one(aw * b.w.raw - ax * b.x.raw - ay * b.y.raw - az * b.z.raw)};
}

Rotation rotation_of(Quat q) {
    const std::int64_t x = q.x.raw, y = q.y.raw, z = q.z.raw, w = q.w.raw;
    const std::int64_t xx = x * x, yy = y * y, zz = z * z, ww = w * w;
    const std::int64_t xy = x * y, yz = y * z, zx = z * x, wx = w * x, wy = w * y, wz = w * z;
    const auto once = [](std::int64_t sum) {
        return Unit::from_raw(saturate_to_int32(shift_right_rounded(sum, Unit::fraction_bits)));
    };
    const auto twice = [](std::int64_t sum) {
        return Unit::from_raw(saturate_to_int32(shift_right_rounded(sum, Unit::fraction_bits - 1)));
    };
    return {{once(ww + xx - yy - zz), twice(xy + wz), twice(zx - wy)},
            {twice(xy - wz), once(ww - xx + yy - zz), twice(yz + wx)},
            {twice(zx + wy), twice(yz - wx), once(ww - xx - yy + zz)}};
}

/// r v of a lever within 128 m: 30 bits times 32, three times.
Vec3 turned_lever(const Rotation& r, LengthVec3 v) {
    constexpr int extra = Unit::fraction_bits + Length::fraction_bits - Real::fraction_bits;
    const auto one = [&](Unit x, Unit y, Unit z) {
        return Real::from_raw(shift_right_rounded(
            std::int64_t{x.raw} * v.x.raw + std::int64_t{y.raw} * v.y.raw + std::int64_t{z.raw} * v.z.raw,
            extra));
    };
    return {one(r.x.x, r.y.x, r.z.x), one(r.x.y, r.y.y, r.z.y), one(r.x.z, r.y.z, r.z.z)};
}

/// Slower than this, an arc curves by less than the step of a Speed [rad/s].
bool turns_slowly(Vec3 w) {
    constexpr std::uint64_t slow = std::uint64_t{1} << (Real::fraction_bits - 6);
    return magnitude(w.x.raw) < slow && magnitude(w.y.raw) < slow && magnitude(w.z.raw) < slow;
}

JointSide side_of(const JointTick& tick, const JointWorkSide& side, const SolverBodies& bodies) {
    JointSide now{};
    now.body = &bodies.step[side.body];
    if (now.body->turn != 0) now.body = &bodies.turns[now.body->turn - 1].now;
    if (side.world) {
        now.anchor = side.anchor;
        now.rotation = side.frame;
        now.axes = rotation_of(now.rotation);
        return now;
    }
    const JointBody& body = tick.bodies[side.cache];
    now.lever = turned_lever(body.axes, side.lever);
    now.anchor = body.position + now.lever;
    now.rotation = product(body.rotation, side.frame);
    now.axes = rotation_of(now.rotation);
    now.w = body.w;
    now.velocity = body.velocity;
    if (!turns_slowly(body.w)) now.centripetal = cross(body.w, cross(body.w, now.lever));
    return now;
}

/// Adds what gears and racks went out by in the last move.
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

/// Where x can swing freely, a swing past the back of A adds turns that nobody made, and a limit would wind them off.
bool counts_turns(const JointDef& def) {
    return def.kind == JointKind::wheel ||
           (def.axis[about_y].mode == AxisMode::locked && def.axis[about_z].mode == AxisMode::locked);
}

JointPlace place_of(const JointTick& tick, JointWork& work, const SolverBodies& bodies) {
    JointPlace p{};
    p.def = work.def;
    p.a = side_of(tick, work.a, bodies);
    p.b = side_of(tick, work.b, bodies);
    p.s = p.b.anchor - p.a.anchor;
    p.arc = p.b.centripetal - p.a.centripetal;
    if (work.needs_slip) {
        const Vec3 slip = p.b.velocity + cross(p.b.w, p.b.lever) - p.a.velocity - cross(p.a.w, p.a.lever);
        p.arc_in_a = p.arc;
        if (!turns_slowly(p.a.w))
            p.arc_in_a = p.arc - cross(p.a.w, slip) * Real(2) + cross(p.a.w, cross(p.a.w, p.s));
    }
    if (work.needs_twist)
        work.twist = twist_between(p.a.rotation, p.b.rotation, counts_turns(*work.def) ? work.twist : Real{});
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

// ---- targets ------------------------------------------------------------------------------------------------------

/// x h / 2, at most `most`: at a radian per substep the arc is no guide any more.
Real half_step(Real x, Real most, const StepConstants& step) {
    const Real speed =
        Real::from_raw(narrow_rounded(Wide::product(x.raw, step.substep_time.raw), Unit::fraction_bits + 1));
    return clamp(speed, -most, most);
}

void set_block_targets(JointBlock& block, const RowValue* values, bool in_tree, const StepConstants& step) {
    const Real most = step.joint_push_max, arc_most = in_tree ? step.tree_arc_max : most;
    const Real rate = in_tree ? step.tree_rate : step.joint.rate;
    for (int i = 0; i < block.count; ++i) {
        const Real push = clamp((values[i].position - block.at[i]) * rate, -most, most);
        block.bias[i] = scaled_speed((push + half_step(values[i].arc, arc_most, step)).raw,
                                     Real::fraction_bits, block.exponent);
        block.direction[i] = values[i].direction;
        block.is_force[i] = values[i].is_force;
    }
}

/// Speed at which a limit may be approached, or is left when it is passed.
struct LimitTargets {
    std::int32_t bias, relax;
};
LimitTargets limit_targets(Real room, Real arc, int exponent, const StepConstants& step) {
    const Real open = room * step.substeps_per_second;
    const Real push = max(room * step.joint.rate, -step.joint_push_max);
    const auto scaled = [exponent](Real x) { return scaled_speed(x.raw, Real::fraction_bits, exponent); };
    return {scaled((room > Real{} ? open : push) + half_step(arc, step.joint_push_max, step)),
            scaled(max(open, Real{}))};
}

std::int32_t bound_of(Real most, int exponent) { return scaled_impulse(most, exponent); }

void set_axis_targets(JointAxisPart& part, const RowValue& value, const StepConstants& step) {
    const int e = part.exponent;
    const auto scaled = [e](Real x) { return scaled_speed(x.raw, Real::fraction_bits, e); };
    if (part.features & has_spring) {
        part.spring_bias = scaled((value.position - part.target) * part.rate);
        part.spring_bound = bound_of(part.spring_max, e);
    }
    if (part.features & has_motor) {
        part.motor_bias = scaled(-part.motor_speed);
        part.motor_bound = bound_of(part.motor_max, e);
    }
    if (part.features & has_lower) {
        const LimitTargets t = limit_targets(value.position - part.lower_at, value.arc, e, step);
        part.lower_bias = t.bias, part.lower_relax = t.relax;
    }
    if (part.features & has_upper) {
        const LimitTargets t = limit_targets(part.upper_at - value.position, -value.arc, e, step);
        part.upper_bias = -t.bias, part.upper_relax = -t.relax;
    }
    part.direction = value.direction;
    part.is_force = value.is_force;
}

// ---- rows ---------------------------------------------------------------------------------------------------------

struct Bodies {
    const SolverBody &a, &b;
};

void make_block(JointBlock& block, const JointWork& work, const JointPlace& place, Bodies bodies,
                const StepConstants& step) {
    RowValue values[3];
    WideRow wide[3];
    if (block.kind[0] == RowKind::point_x)
        point_values(place, values);
    else
        for (int i = 0; i < block.count; ++i) values[i] = row_value(block.kind[i], place);
    for (int i = 0; i < block.count; ++i) wide[i] = values[i].row;
    const int before = block.exponent;
    block.exponent = set_rows(block.row, wide, block.count);
    for (int i = 0; i < block.count; ++i) {
        set_responses(block.row[i], work.shares, bodies.a, bodies.b);
        if (!work.made) {
            block.impulse[i] = scaled_impulse(block.sum[i], block.exponent);
            block.sum[i] = Real{};
        } else if (before != block.exponent) {
            block.impulse[i] = rescaled_impulse(block.impulse[i], before, block.exponent);
        }
    }
    if (work.tree == no_tree) block.inverse = invert(block.row, block.count);
    set_block_targets(block, values, work.tree != no_tree, step);
}

void make_axis(JointAxisPart& part, const JointWork& work, const JointPlace& place, Bodies bodies,
               const StepConstants& step) {
    const RowValue value = row_value(part.kind, place);
    const int before = part.exponent;
    part.exponent = set_rows(&part.row, &value.row, 1);
    set_responses(part.row, work.shares, bodies.a, bodies.b);
    part.inverse = invert(&part.row, 1);
    const auto carry = [&](std::int32_t& p, Real warm) {
        p = work.made ? rescaled_impulse(p, before, part.exponent) : scaled_impulse(warm, part.exponent);
    };
    carry(part.spring, part.warm.spring), carry(part.motor, part.warm.motor);
    carry(part.lower, part.warm.lower), carry(part.upper, part.warm.upper);
    set_axis_targets(part, value, step);
}

} // namespace

void make_rows(JointTick& tick, JointWork& work, const StepConstants& step, const SolverBodies& bodies) {
    const JointPlace place = place_of(tick, work, bodies);
    const Bodies both{bodies.body[work.a.body], bodies.body[work.b.body]};
    for (std::uint32_t i = 0; i < work.axis_count; ++i)
        make_axis(tick.axes[work.first_axis + i], work, place, both, step);
    for (std::uint32_t i = 0; i < work.block_count; ++i)
        make_block(tick.blocks[work.first_block + i], work, place, both, step);
    work.made = work.remade = true;
}

void invert_blocks(JointTick& tick, const JointWork& work) {
    for (std::uint32_t i = 0; i < work.block_count; ++i) {
        JointBlock& block = tick.blocks[work.first_block + i];
        block.inverse = invert(block.row, block.count);
    }
}

void place_body(JointBody& now, const Transform& pose, const SolverBodies& bodies) {
    const SolverBody& body = bodies.body[now.body];
    const BodyStep& step = bodies.step[now.body];
    const bool still = std::equal(body.shift, body.shift + 3, now.shift) &&
                       std::equal(body.theta, body.theta + 3, now.theta);
    now.stirred = !still;
    now.moved = Vec3{};
    for (int i = 0; i < 3; ++i) now.turned[i] = 0;
    if (still) return;
    for (int i = 0; i < 3; ++i) {
        now.moved[i] = from_separation(body.shift[i]) - from_separation(now.shift[i]);
        now.turned[i] = saturate_to_int32(std::int64_t{body.theta[i]} - now.theta[i]);
        now.shift[i] = body.shift[i], now.theta[i] = body.theta[i];
        now.position[i] = pose.position[i] + from_separation(body.shift[i]);
        now.velocity[i] =
            Real::from_raw(shift_right_rounded(body.v[i], accumulator_bits - Real::fraction_bits));
    }
    now.rotation =
        step.turn != 0
            ? bodies.turns[step.turn - 1].rotation
            : integrate_rotation(pose.rotation, over_gyration(step, body.theta, Separation::fraction_bits));
    now.axes = rotation_of(now.rotation);
    const std::int32_t u[3] = {speed_of(body.u[0]), speed_of(body.u[1]), speed_of(body.u[2])};
    now.w = over_gyration(step, u, Speed::fraction_bits);
}

void start_body(JointBody& now, const Transform& pose, const SolverBodies& bodies) {
    now.shift[0] = bodies.body[now.body].shift[0] + 1; // whatever it is, not what it was
    place_body(now, pose, bodies);
    now.moved = Vec3{};
    for (int i = 0; i < 3; ++i) now.turned[i] = 0;
}

// ---- coordinates --------------------------------------------------------------------------------------------------

std::array<Real, joint_axis_count> joint_coordinates(const JointDef& def, const Transform& frame_a,
                                                     const Transform& frame_b, Real twist) {
    std::array<Real, joint_axis_count> position{};
    const Vec3 s = frame_b.position - frame_a.position;
    const Rotation a = to_rotation(frame_a.rotation), b = to_rotation(frame_b.rotation);
    switch (def.kind) {
    case JointKind::distance:
        position[along_x] = length(s);
        return position;
    case JointKind::pulley:
        position[along_x] = mul_add(def.ratio, length(frame_b.position - def.ground_b),
                                    length(frame_a.position - def.ground_a));
        return position;
    case JointKind::gear:
    case JointKind::rack_and_pinion:
        position[about_x] = twist;
        return position;
    default:
        break;
    }
    const Vec3 along = mul_transposed<Real>(a, s);
    position[along_x] = along.x, position[along_y] = along.y, position[along_z] = along.z;
    position[about_x] = twist_between(frame_a.rotation, frame_b.rotation, counts_turns(def) ? twist : Real{});
    position[about_y] = angle_y_between(a, b);
    position[about_z] = angle_z_between(a, b);
    return position;
}

} // namespace lockstone::dynamics
