#include "solve/bodies/integrate.h"

#include "lockstone/math/math.h"
#include "solve/bodies/region.h"
#include "solve/joints/followed_turn.h"

namespace lockstone::solve {

static Vec3 acceleration_of(const FieldRow& field, Vec3 point) {
    if (!contains(field.def.region, point)) return {};
    if (field.def.kind == FieldKind::uniform) return field.def.acceleration;
    const Vec3 to_center = field.def.center - point;
    if (field.def.kind == FieldKind::spring) return to_center * field.def.strength;
    const Real softening = field.def.softening;
    const Real distance = length(to_center);
    const Real r = softening == Real{} ? distance : sqrt(mul_add(distance, distance, softening * softening));
    if (r == Real{}) return {};
    // strength / r^2 along to_center / r, in two divisions: r^3 would leave the range first.
    const Real g = field.def.strength / r / r;
    return {g * (to_center.x / r), g * (to_center.y / r), g * (to_center.z / r)};
}

Vec3 field_acceleration(std::span<const FieldRow> fields, Vec3 point, std::uint32_t categories) {
    Vec3 sum{};
    for (const FieldRow& field : fields) {
        const bool meant = field.def.mask == every_category || (field.def.mask & categories) != 0;
        if (meant && field.def.kind != FieldKind::fluid) sum += acceleration_of(field, point);
    }
    return sum;
}

namespace {

/// The free motion of one body over one substep: x' = v, v' = a(x), on Real.
struct Path {
    const FreeMotion& motion;
    Vec3 constant; ///< acceleration by gravity and force
    std::uint32_t categories;
    Vec3 x, v;
    std::int64_t substeps_per_second;

    Vec3 a(Vec3 at) const { return constant + field_acceleration(motion.fields, at, categories); }
    Vec3 times_h(Vec3 rate) const {
        const auto one = [this](Real r) {
            return Real::from_raw(divide_shifted(r.raw, substeps_per_second, 0));
        };
        return {one(rate.x), one(rate.y), one(rate.z)};
    }
    static Vec3 halved(Vec3 p) { return {half(p.x), half(p.y), half(p.z)}; }
};

struct Increment {
    Vec3 dv, dx;
};

Increment semi_implicit_euler(const Path& p) {
    const Vec3 dv = p.times_h(p.a(p.x));
    return {dv, p.times_h(p.v + dv)};
}

/// Position Verlet: drift half, kick, drift half. source: Tuckerman, Berne, Martyna 1992
Increment verlet(const Path& p) {
    const Vec3 half_drift = Path::halved(p.times_h(p.v));
    const Vec3 dv = p.times_h(p.a(p.x + half_drift));
    return {dv, half_drift + Path::halved(p.times_h(p.v + dv))};
}

/// Velocity Verlet: kick half, drift, kick half. source: Swope et al. 1982
Increment velocity_verlet(const Path& p) {
    const Vec3 first = Path::halved(p.times_h(p.a(p.x)));
    const Vec3 dx = p.times_h(p.v + first);
    return {first + Path::halved(p.times_h(p.a(p.x + dx))), dx};
}

/// The classical fourth-order method on (x, v). source: Hairer, Norsett, Wanner, Solving ODEs I, II.1
Increment runge_kutta_4(const Path& p) {
    const Vec3 kx1 = p.times_h(p.v), kv1 = p.times_h(p.a(p.x));
    const Vec3 kx2 = p.times_h(p.v + Path::halved(kv1)), kv2 = p.times_h(p.a(p.x + Path::halved(kx1)));
    const Vec3 kx3 = p.times_h(p.v + Path::halved(kv2)), kv3 = p.times_h(p.a(p.x + Path::halved(kx2)));
    const Vec3 kx4 = p.times_h(p.v + kv3), kv4 = p.times_h(p.a(p.x + kx3));
    const Real sixth = Real(6);
    const auto blend = [&](Vec3 a, Vec3 b, Vec3 c, Vec3 d) { return (a + (b + c) * Real(2) + d) / sixth; };
    return {blend(kv1, kv2, kv3, kv4), blend(kx1, kx2, kx3, kx4)};
}

Increment change_of(const Path& p) {
    switch (p.motion.scheme) {
    case Scheme::verlet:
        return verlet(p);
    case Scheme::velocity_verlet:
        return velocity_verlet(p);
    case Scheme::runge_kutta_4:
        return runge_kutta_4(p);
    default:
        return semi_implicit_euler(p);
    }
}

/// [m/s] per substep: far above the speed limit, and far below overflow
constexpr Real kick_max = Real(2048);

/// The general path in Real, for fields or for a scheme other than the solver's own.
void move_freely(const FreeMotion& motion, const BodyTraits& traits, std::uint32_t categories,
                 Vec3 acceleration, const Transform& pose, const StepConstants& step, SolverBody& b,
                 BodyDrift& drift) {
    const FreeMotion without{motion.scheme, {}, {}};
    const Path chosen{traits.enable_fields != 0 ? motion : without,
                      acceleration,
                      categories,
                      pose.position + Vec3{Real::from_raw(std::int64_t{b.shift[0]} << 5),
                                           Real::from_raw(std::int64_t{b.shift[1]} << 5),
                                           Real::from_raw(std::int64_t{b.shift[2]} << 5)},
                      {Real::from_raw(shift_right_rounded(b.v[0], real_to_accumulator)),
                       Real::from_raw(shift_right_rounded(b.v[1], real_to_accumulator)),
                       Real::from_raw(shift_right_rounded(b.v[2], real_to_accumulator))},
                      step.substeps_per_second};
    const Increment change = change_of(chosen);
    const Vec3 by_velocity = chosen.times_h(chosen.v + change.dv);
    for (int i = 0; i < 3; ++i) {
        b.v[i] += (clamp(change.dv[i], -kick_max, kick_max).raw << real_to_accumulator) & b.keep[i];
        drift[static_cast<std::size_t>(i)] = ((change.dx[i] - by_velocity[i]).raw) & b.keep[i];
    }
}

/// v times keep, rounded. `keep` is at most 1, so the product of the integer part has room, and that of the fraction is
/// below 2^60.
void damp(std::int64_t v[3], Unit keep) {
    if (keep == unit_one) return;
    constexpr std::int64_t rest = unit_one.raw - 1, half = unit_one.raw / 2;
    for (int i = 0; i < 3; ++i)
        v[i] = (v[i] >> Unit::fraction_bits) * keep.raw +
               (((v[i] & rest) * keep.raw + half) >> Unit::fraction_bits);
}

void damp_precession(SolverBodies& bodies, std::uint32_t turn, Unit keep) {
    FollowedFour& four = bodies.fours[(turn - 1) / followed_lanes];
    const unsigned lane = (turn - 1) % followed_lanes;
    std::int64_t g[3] = {four.precession[0][lane], four.precession[1][lane], four.precession[2][lane]};
    damp(g, keep);
    for (int i = 0; i < 3; ++i) four.precession[i][lane] = g[i];
}

struct SpeedLimits {
    LengthLimit linear, tip;
    explicit SpeedLimits(const StepConstants& step)
        : linear(step.linear_speed_max), tip(step.tip_speed_max) {}
};

/// Returns the number of velocities, of the two, that were clamped.
inline std::uint64_t clamp_speeds(SolverBodies& bodies, std::uint32_t i, SpeedLimits limits) {
    SolverBody& b = bodies.body[i];
    const bool turns_less = clamp_length(b.u, limits.tip);
    if (turns_less && bodies.step[i].turn != 0) [[unlikely]]
        forget_precession(bodies, bodies.step[i].turn);
    return (clamp_length(b.v, limits.linear) ? 1u : 0u) + (turns_less ? 1u : 0u);
}

using Move = decltype(BodyKernel::integrate_poses);

BodyPass pass_of(const StepConstants& step, SpeedLimits limits, SolverBodies& bodies) {
    BodyPass pass{bodies.body.data(),   bodies.step.data(), bodies.plain.data(), nullptr, 0, 0, {}, {},
                  step.substep_time.raw};
    for (int i = 0; i < 3; ++i) {
        pass.dv[i] = bodies.fall.dv[i];
        pass.most[i] = (std::int64_t{1} << limits.linear.k) - 1;
        pass.most[3 + i] = (std::int64_t{1} << limits.tip.k) - 1;
    }
    return pass;
}

/// Moves the plain bodies of a part of a pass by the kernel, if there is one. Calls visit(i) for each of the others,
/// and adds its results to the count of clamped speeds. At most body_chunk bodies.
template <class Visit>
void for_bodies_of(const BodyPass& part, Move kernel, SolverBodies& bodies, const Visit& visit) {
    std::uint64_t clamped = 0;
    if (kernel == nullptr) {
        for (std::uint32_t i = part.first; i < part.last; ++i)
            clamped += visit(part.rows != nullptr ? part.rows[i] : i);
    } else {
        std::uint32_t left[body_chunk];
        const std::uint32_t count = kernel(part, left);
        for (std::uint32_t k = 0; k < count; ++k) clamped += visit(left[k]);
    }
    base::add_count(bodies.clamps.speed, clamped);
}
template <class Visit>
void for_each_body(BodyPass pass, Move kernel, SolverBodies& bodies, Tasks* tasks, const Visit& visit) {
    // This runs twice in every substep: for fewer bodies it costs less than the start of workers.
    constexpr std::uint32_t shared_from = 2048;
    Tasks* const by = bodies.still() < shared_from ? nullptr : tasks;
    bodies.paths.take(by != nullptr, base::Path::moves_by_one, base::Path::moves_by_workers);
    base::for_chunks(by, bodies.still(), body_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         BodyPass part = pass;
                         part.first = first, part.last = last;
                         for_bodies_of(part, kernel, bodies, visit);
                     });
}
/// This version handles the bodies `rows` only.
template <class Visit>
void for_each_body(BodyPass pass, Move kernel, SolverBodies& bodies, std::span<const std::uint32_t> rows,
                   const Visit& visit) {
    pass.rows = rows.data();
    for (pass.last = 0; pass.last < rows.size();) {
        pass.first = pass.last;
        pass.last += std::min(static_cast<std::uint32_t>(rows.size()) - pass.last, body_chunk);
        for_bodies_of(pass, kernel, bodies, visit);
    }
}

/// Moves one body by its velocity, and by its drift if it has one.
std::uint64_t move_by_velocity(SolverBodies& bodies, std::uint32_t i, std::int64_t h, SpeedLimits limits) {
    // Velocity with 27 fraction bits times time with 30 is at most 2^61, since a body moves at most 15 m in a tick.
    constexpr int to_separation = accumulator_bits - Separation::fraction_bits;
    constexpr int drift_to_separation = Real::fraction_bits - Separation::fraction_bits;
    constexpr std::int64_t half = std::int64_t{1} << (Unit::fraction_bits - 1);
    const auto way = [h](std::int64_t v) { return ((v >> to_separation) * h + half) >> Unit::fraction_bits; };
    if (!bodies.step[i].moves) return 0;
    SolverBody& b = bodies.body[i];
    const std::uint64_t clamped = clamp_speeds(bodies, i, limits);
    for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t drift = bodies.drift.empty() ? 0 : bodies.drift[i][static_cast<std::size_t>(axis)];
        const std::int64_t more = drift == 0 ? 0 : shift_right_rounded(drift, drift_to_separation);
        b.shift[axis] = saturate_to_int32(b.shift[axis] + way(b.v[axis]) + more);
        b.theta[axis] = saturate_to_int32(b.theta[axis] + way(b.u[axis]));
    }
    return clamped;
}

void damp_all(SolverBodies& bodies, std::uint32_t i) {
    SolverBody& b = bodies.body[i];
    const BodyStep& s = bodies.step[i];
    damp(b.v, s.linear_keep);
    damp(b.u, s.angular_keep);
    if (s.turn != 0) damp_precession(bodies, s.turn, s.angular_keep);
}
const BodyPush& push_of(const SolverBodies& bodies, std::uint32_t i) {
    return (bodies.plain[i] & plain_falls) != 0 ? bodies.fall : bodies.push[i];
}
/// Adds the constant push of a body to its velocity, and damps it.
std::uint64_t push_and_damp(SolverBodies& bodies, std::uint32_t i, SpeedLimits limits) {
    if (!bodies.step[i].moves) return 0;
    if (bodies.step[i].movable) {
        SolverBody& b = bodies.body[i];
        const BodyPush& push = push_of(bodies, i);
        for (int axis = 0; axis < 3; ++axis) b.v[axis] += push.dv[axis], b.u[axis] += push.du[axis];
        damp_all(bodies, i);
    }
    return clamp_speeds(bodies, i, limits);
}

Move velocity_kernel(const SolverBodies& bodies) {
    return bodies.kernel != nullptr ? bodies.kernel->integrate_velocities : nullptr;
}
Move pose_kernel(const SolverBodies& bodies) {
    return bodies.kernel != nullptr ? bodies.kernel->integrate_poses : nullptr;
}

} // namespace

bool is_plain_motion(const FreeMotion& motion) {
    return motion.scheme == Scheme::semi_implicit_euler && motion.fields.empty();
}

void integrate_velocities(const FreeMotion& motion, const BodyColumns& columns, const StepConstants& step,
                          SolverBodies& bodies, Tasks* tasks) {
    const SpeedLimits limits(step);
    if (is_plain_motion(motion))
        return for_each_body(pass_of(step, limits, bodies), velocity_kernel(bodies), bodies, tasks,
                             [&](std::uint32_t i) { return push_and_damp(bodies, i, limits); });
    // Fields and other schemes add to the move of a body too, so it is no plain motion.
    for (std::uint8_t& plain : bodies.plain) plain &= plain_end | plain_round | plain_falls | plain_struck;
    if (bodies.drift.empty()) bodies.drift.assign(bodies.still(), {});
    for_each_body(pass_of(step, limits, bodies), velocity_kernel(bodies), bodies, tasks,
                  [&](std::uint32_t i) -> std::uint64_t {
                      SolverBody& b = bodies.body[i];
                      if (!bodies.step[i].moves) return 0;
                      if (bodies.step[i].movable) {
                          const BodyPush& push = push_of(bodies, i);
                          move_freely(motion, columns.traits(i),
                                      motion.categories.empty() ? every_category : motion.categories[i],
                                      push.acceleration, columns.pose[i], step, b, bodies.drift[i]);
                          for (int axis = 0; axis < 3; ++axis) b.u[axis] += push.du[axis];
                          damp_all(bodies, i);
                      }
                      return clamp_speeds(bodies, i, limits);
                  });
}

void integrate_velocities(const StepConstants& step, SolverBodies& bodies,
                          std::span<const std::uint32_t> rows) {
    const SpeedLimits limits(step);
    for_each_body(pass_of(step, limits, bodies), velocity_kernel(bodies), bodies, rows,
                  [&](std::uint32_t i) { return push_and_damp(bodies, i, limits); });
}

void integrate_poses(const StepConstants& step, SolverBodies& bodies, Tasks* tasks) {
    const SpeedLimits limits(step);
    for_each_body(pass_of(step, limits, bodies), pose_kernel(bodies), bodies, tasks, [&](std::uint32_t i) {
        return move_by_velocity(bodies, i, step.substep_time.raw, limits);
    });
    advance_turns(step, bodies, tasks);
}

void integrate_poses(const StepConstants& step, SolverBodies& bodies, std::span<const std::uint32_t> rows) {
    const SpeedLimits limits(step);
    for_each_body(pass_of(step, limits, bodies), pose_kernel(bodies), bodies, rows, [&](std::uint32_t i) {
        return move_by_velocity(bodies, i, step.substep_time.raw, limits);
    });
}

void move_driven(const StepConstants& step, SolverBodies& bodies, bool has_begun) {
    for (std::uint32_t row = 0; row < bodies.still(); ++row) {
        if (!bodies.step[row].moves || bodies.step[row].movable) continue;
        for (std::int32_t i = 0; i < step.substeps; ++i) {
            if (i != 0 || !has_begun) integrate_velocities(step, bodies, {&row, 1});
            integrate_poses(step, bodies, {&row, 1});
        }
    }
}

} // namespace lockstone::solve
