#include "solve/bodies/solver_body.h"

#include "base/room.h"
#include "lockstone/math/math.h"
#include "solve/bodies/free_turn.h"
#include "solve/bodies/momentum.h"
#include "solve/joints/followed_turn.h"

#include <bit>

namespace lockstone::solve {

Symmetric<Real> rotated_diagonal(const Rotation& r, Vec3 d) {
    if (d.x == d.y && d.y == d.z) return {d.x, d.x, d.x, Real{}, Real{}, Real{}};
    // 31 bits of the entries are enough: so their products with entries of a rotation are below 2^61.
    const int bits = bit_length(magnitude(d.x.raw) | magnitude(d.y.raw) | magnitude(d.z.raw));
    const int drop = bits > 31 ? bits - 31 : 0;
    const std::int64_t dx = shift_right_rounded(d.x.raw, drop), dy = shift_right_rounded(d.y.raw, drop),
                       dz = shift_right_rounded(d.z.raw, drop);
    constexpr int unit = Unit::fraction_bits;
    std::int64_t a[3][3];
    for (int i = 0; i < 3; ++i) {
        a[i][0] = shift_right_rounded(r.x[i].raw * dx, unit);
        a[i][1] = shift_right_rounded(r.y[i].raw * dy, unit);
        a[i][2] = shift_right_rounded(r.z[i].raw * dz, unit);
    }
    const int down = drop < unit ? unit - drop : 0, up = drop < unit ? 0 : drop - unit;
    const std::int64_t half = (std::int64_t{1} << down) >> 1;
    const auto entry = [&](int i, int j) {
        const std::int64_t sum = a[i][0] * r.x[j].raw + a[i][1] * r.y[j].raw + a[i][2] * r.z[j].raw;
        return Real::from_raw(((sum + half) >> down) << up);
    };
    return {entry(0, 0), entry(1, 1), entry(2, 2), entry(0, 1), entry(0, 2), entry(1, 2)};
}

/// 1 / radius along each axis; zero where the radius is zero. Most bodies have two or three equal radii.
static Vec3 reciprocals(Vec3 radii) {
    const auto inverse = [](Real r) { return r > Real{} ? Real(1) / r : Real{}; };
    const Real x = inverse(radii.x), y = radii.y == radii.x ? x : inverse(radii.y);
    return {x, y, radii.z == radii.x ? x : radii.z == radii.y ? y : inverse(radii.z)};
}

/// One of the two diagonals of a GyrationForm, in the format of rotated_diagonal(). Returns false if it has no room in
/// 32 bits.
static bool set_form(Vec3 d, std::int32_t (&out)[4]) {
    const int bits = bit_length(magnitude(d.x.raw) | magnitude(d.y.raw) | magnitude(d.z.raw));
    const int drop = bits > 31 ? bits - 31 : 0;
    // it is multiplied by a component of a rotation, which may exceed 1 by one unit
    constexpr std::int64_t most = (std::int64_t{1} << 31) - 8;
    if (drop >= Unit::fraction_bits) return false;
    for (int i = 0; i < 3; ++i) {
        const std::int64_t part = shift_right_rounded(d[i].raw, drop);
        if (part > most) return false;
        out[i] = static_cast<std::int32_t>(part);
    }
    out[3] = Unit::fraction_bits - drop;
    return true;
}

static GyrationForm form_of(const BodyMass& mass) {
    GyrationForm form{};
    form.spin = spin_form(reciprocals(mass.gyration));
    form.principal = mass.principal, form.radii_inv = reciprocals(mass.gyration);
    form.is_round = mass.gyration.x == mass.gyration.y && mass.gyration.y == mass.gyration.z;
    form.has_room = set_form(mass.gyration, form.radii) && set_form(form.radii_inv, form.inverses);
    return form;
}

static bool is_round(const BodyStep& s) { return s.radii.x == s.radii.y && s.radii.y == s.radii.z; }

bool clamp_long(std::int64_t v[3], Speed limit) {
    const std::int64_t x = v[0] >> row_bits, y = v[1] >> row_bits, z = v[2] >> row_bits;
    const std::int64_t bound = limit.raw;
    const auto outside = [](std::int64_t c) {
        return c > (std::int64_t{1} << 30) || c < -(std::int64_t{1} << 30);
    };
    if (!outside(x) && !outside(y) && !outside(z) && x * x + y * y + z * z <= bound * bound) return false;
    const Vec3 wide{Real::from_raw(x), Real::from_raw(y), Real::from_raw(z)};
    const UnitVec3 direction = normalized(wide);
    for (int i = 0; i < 3; ++i) // 30 + 19 bits to 47
        v[i] = (std::int64_t{direction[i].raw} * bound) >>
               (Unit::fraction_bits + Speed::fraction_bits - accumulator_bits);
    return true;
}

static std::uint64_t entries_or(const Symmetric<Real>& k) {
    return magnitude(k.xx.raw) | magnitude(k.yy.raw) | magnitude(k.zz.raw) | magnitude(k.xy.raw) |
           magnitude(k.xz.raw) | magnitude(k.yz.raw);
}

/// Sets K^-1 as mantissas and exponent. Entries are below 2^bits, so a mantissa is at most 2^30.
static void set_mantissa(BodyStep& s) {
    const Symmetric<Real>& k = s.gyration_inv;
    const int drop = s.gyration_inv_bits - 30; // bits of the mantissa without its sign: 30
    s.inv_exponent = Real::fraction_bits - drop;
    const auto set = [&](auto&& mantissa) {
        const auto low = [&](Real x) { return static_cast<std::int32_t>(mantissa(x.raw)); };
        s.inv_mantissa = {low(k.xx), low(k.yy), low(k.zz), low(k.xy), low(k.xz), low(k.yz)};
    };
    if (drop <= 0)
        set([up = -drop](std::int64_t x) { return x * (std::int64_t{1} << up); });
    else if (drop <= 32)
        set([drop, half = std::int64_t{1} << (drop - 1)](std::int64_t x) { return (x + half) >> drop; });
    else
        set([drop](std::int64_t x) { return shift_right_rounded(x, drop); });
}

static void set_sizes(BodyStep& s) {
    s.gyration_bits = bit_length(entries_or(s.gyration));
    s.gyration_inv_bits = bit_length(entries_or(s.gyration_inv));
    set_mantissa(s);
}

void set_gyration(BodyStep& s, const Rotation& axes) {
    s.gyration = rotated_diagonal(axes, s.radii), s.gyration_inv = rotated_diagonal(axes, s.radii_inv);
    set_sizes(s);
}

/// Sets K of a body with known reciprocals of its radii.
static void set_gyration(BodyStep& s, Quat principal, Quat rotation) {
    const auto multiple = [](Real d) { return Symmetric<Real>{d, d, d, Real{}, Real{}, Real{}}; };
    if (is_round(s)) {
        s.gyration = multiple(s.radii.x), s.gyration_inv = multiple(s.radii_inv.x);
        set_sizes(s);
    } else {
        set_gyration(s, to_rotation(principal == Quat::identity() ? rotation : rotation * principal));
    }
}

/// The factor of a velocity by damping in a substep: 1 / (1 + damping * substep).
static Unit kept(Real damping, const StepConstants& step) {
    if (damping == Real{}) return unit_one;
    return to<Unit>(Real(step.substeps_per_second) / (Real(step.substeps_per_second) + damping));
}

template <FixedPoint T> static Vector3<T> masked(Vector3<T> v, std::uint32_t mask) {
    if (mask == 7u) return v;
    return {mask & 1u ? v.x : T{}, mask & 2u ? v.y : T{}, mask & 4u ? v.z : T{}};
}

/// acceleration / substeps_per_second with 47 fraction bits.
static void per_substep(Vec3 acceleration, const StepConstants& step, std::int64_t out[3]) {
    constexpr int extra = accumulator_bits - Real::fraction_bits;
    // Above 2048 m/s a substep the speed limit acts anyway; the clamp keeps the sum with any velocity in range.
    constexpr std::int64_t most = std::int64_t{2048} << accumulator_bits;
    for (int i = 0; i < 3; ++i) {
        const std::int64_t change = divide_shifted(acceleration[i].raw, step.substeps_per_second, extra);
        out[i] = change > most ? most : change < -most ? -most : change;
    }
}

/// Sets K, and u of the velocity within its limit. Applies locks here too, for velocities of states from files.
static void begin_turning(Quat principal, const Transform& pose, const Velocity& velocity,
                          const StepConstants& step, SolverBody& b, BodyStep& s, ClampCounts& clamps) {
    set_gyration(s, principal, pose.rotation);
    const SpeedVec3 u = by_gyration<Speed>(s, masked(velocity.angular, s.angular_mask));
    for (int i = 0; i < 3; ++i) b.u[i] = std::int64_t{u[i].raw} << row_bits;
    clamps.speed += clamp_length(b.u, step.tip_speed_max) ? 1u : 0u;
}

static void begin_torque(const BodyMass& mass, const BodyForce& force, const StepConstants& step,
                         const BodyStep& s, BodyPush& push) {
    const Vec3 torque = masked(force.torque, s.angular_mask);
    if (torque != Vec3{}) per_substep(mul<Real>(s.gyration_inv, torque / mass.mass), step, push.du);
}

static bool turns_about_all_axes(const BodyStep& s) { return s.movable && s.angular_mask == 7u; }

/// The PlainMotion bits for the end of the tick.
static std::uint8_t plain_end_of(const BodyTraits& traits, const BodyStep& s) {
    if (!turns_about_all_axes(s)) return 0;
    return plain_end | (traits.gyroscopic == 0 || is_round(s) ? plain_round : 0);
}

/// Sets v from the parts of the velocity that are not locked, within its limit.
static void begin_moving(const Velocity& velocity, LengthLimit limit, SolverBody& b, ClampCounts& clamps) {
    for (int i = 0; i < 3; ++i) b.v[i] = (std::int64_t{velocity.linear[i].raw} << row_bits) & b.keep[i];
    // Commands may set any velocity; rows have room for velocities within the limit.
    clamps.speed += clamp_length(b.v, limit) ? 1u : 0u;
}

/// Sets all data of a body except K, the data that follows from K, v and du. Returns PlainMotion.
static std::uint8_t begin_body(const BodyInfo& info, const BodyTraits& traits, const BodyForce& force,
                               const GyrationForm& form, const BodyPush& fall, const StepConstants& step,
                               std::int64_t (&keep)[3], BodyStep& s, BodyPush& push) {
    const BodyMass& mass = traits.mass;
    s.movable = info.kind == BodyKind::dynamic && mass.mass > Real{};
    s.moves = info.kind != BodyKind::static_;
    s.jointed = info.first_joint != 0;
    if (s.movable) s.mass = mass.mass;
    s.linear_mask = s.movable ? ~traits.locks & 7u : 7u;
    s.angular_mask = s.movable ? ~(traits.locks >> 3) & 7u : 7u;
    for (int i = 0; i < 3; ++i) keep[i] = (s.linear_mask >> i) & 1u ? -1 : 0;
    if (!s.moves) return 0;
    s.radii = mass.gyration, s.radii_inv = form.radii_inv;
    s.linear_keep = s.angular_keep = unit_one;
    if (!s.movable) return plain_pose;
    s.linear_keep = kept(traits.linear_damping, step);
    s.angular_keep = kept(traits.angular_damping, step);
    Vec3 acceleration =
        traits.gravity_scale == Real(1) ? fall.acceleration : fall.acceleration * traits.gravity_scale;
    if (force.force != Vec3{}) acceleration += force.force / mass.mass;
    acceleration = masked(acceleration, s.linear_mask);
    const bool is_plain = acceleration == fall.acceleration && force.torque == Vec3{},
               is_damped = s.linear_keep != unit_one || s.angular_keep != unit_one;
    if (!is_plain) push = {{}, {}, acceleration}, per_substep(acceleration, step, push.dv);
    return plain_pose | (is_plain ? plain_velocity | plain_falls : 0) | (is_damped ? plain_damped : 0) |
           plain_end_of(traits, s);
}

void set_radii(const BodyColumns& c, std::uint32_t row, Vec3 radii, const StepConstants& step,
               SolverBodies& bodies, ClampCounts& clamps) {
    BodyStep& s = bodies.step[row];
    s.radii = radii, s.radii_inv = reciprocals(radii);
    begin_turning(c.mass[row].principal, c.pose[row], c.velocity[row], step, bodies.body[row], s, clamps);
    if (c.pushes[row] != 0) begin_torque(c.mass[row], c.force[row], step, s, bodies.push[row]);
    // Its radii differ from those of its traits.
    const auto motion = static_cast<std::uint8_t>(bodies.plain[row] &
                                                  (plain_velocity | plain_pose | plain_damped | plain_falls));
    const std::uint8_t end = plain_end_of(c.traits(row), s);
    bodies.plain[row] = (end & plain_round) != 0 ? motion | end : motion;
}

/// The start of dynamic bodies with these traits that no force pushes.
static BodyStart start_of(const BodyTraits& traits, const GyrationForm& form, const BodyPush& fall,
                          const StepConstants& step) {
    BodyStart start{};
    BodyInfo info{};
    info.kind = BodyKind::dynamic;
    start.plain = begin_body(info, traits, BodyForce{}, form, fall, step, start.keep, start.step, start.push);
    start.has_gyration = form.is_round && start.step.angular_mask == 7u;
    if (start.has_gyration) set_gyration(start.step, Quat::identity(), Quat::identity());
    return start;
}

static void find_forms(const BodyColumns& c, const StepConstants& step, SolverBodies& out) {
    out.forms.clear(), out.starts.clear();
    base::make_room(out.form_of, c.all_traits.size());
    out.form_of.assign(c.all_traits.size(), 0);
    for (const BodyInfo& info : c.info) {
        std::uint32_t& number = out.form_of[info.traits];
        if (number != 0) continue;
        const BodyTraits& traits = c.all_traits[info.traits];
        GyrationForm& form = out.forms.emplace_back(form_of(traits.mass));
        number = static_cast<std::uint32_t>(out.forms.size());
        if (info.kind != BodyKind::dynamic) continue;
        out.paths.take(out.starts.size() == starts_max, base::Path::starts_shared, base::Path::starts_alone);
        if (out.starts.size() == starts_max) continue;
        out.starts.push_back(start_of(traits, form, out.fall, step));
        form.start = static_cast<std::uint32_t>(out.starts.size());
    }
}

/// The bodies of a piece of work whose K and u are not set yet.
struct Unturned {
    std::uint32_t in_lanes[body_chunk], alone[body_chunk], lane_count = 0, alone_count = 0;
};

/// Sets K and u of bodies whose other data is set.
static void begin_turns(const BodyColumns& c, const StepConstants& step, LengthLimit tip, SolverBodies& out,
                        Unturned& rows, ClampCounts& clamps) {
    if (rows.lane_count != 0) {
        const StartPass pass{out.body.data(),    out.step.data(),
                             c.info.data(),      out.forms.data(),
                             out.form_of.data(), c.pose.data(),
                             c.velocity.data(),  (std::int64_t{1} << (tip.k - row_bits)) - 1};
        rows.alone_count +=
            out.kernel->begin_turning(pass, rows.in_lanes, rows.lane_count, rows.alone + rows.alone_count);
    }
    for (std::uint32_t k = 0; k < rows.alone_count; ++k) {
        const std::uint32_t i = rows.alone[k];
        begin_turning(c.mass[i].principal, c.pose[i], c.velocity[i], step, out.body[i], out.step[i], clamps);
    }
}

/// Sets u of a body with equal radii that turns about all axes: K is a multiple of the unit matrix.
static void begin_round_turning(SpeedVec3 w, LengthLimit tip, const BodyStep& s, SolverBody& b,
                                ClampCounts& clamps) {
    constexpr int drop = Real::fraction_bits;
    const std::int64_t k = s.gyration.xx.raw, half = std::int64_t{1} << (drop - 1);
    if (s.gyration_bits <= 31) { // products below 2^62
        for (int i = 0; i < 3; ++i) b.u[i] = ((k * w[i].raw + half) >> drop) * (std::int64_t{1} << row_bits);
    } else {
        const SpeedVec3 u = by_gyration<Speed>(s, w);
        for (int i = 0; i < 3; ++i) b.u[i] = std::int64_t{u[i].raw} << row_bits;
    }
    clamps.speed += clamp_length(b.u, tip) ? 1u : 0u;
}

/// Begins bodies [first, last).
static void begin_some(const BodyColumns& c, const StepConstants& step, SolverBodies& out,
                       std::uint32_t first, std::uint32_t last, ClampCounts& clamps) {
    const LengthLimit linear(step.linear_speed_max), tip(step.tip_speed_max);
    Unturned unturned;
    for (std::uint32_t i = first; i < last; ++i) {
        const BodyInfo& info = c.info[i];
        const GyrationForm& form = out.forms[out.form_of[info.traits] - 1];
        SolverBody& b = out.body[i];
        BodyStep& s = out.step[i];
        if (form.start != 0 && info.kind == BodyKind::dynamic && c.pushes[i] == 0) {
            const BodyStart& start = out.starts[form.start - 1];
            s = start.step, out.plain[i] = start.plain;
            if ((start.plain & plain_falls) == 0) out.push[i] = start.push;
            s.jointed = info.first_joint != 0;
            for (int k = 0; k < 3; ++k) b.u[k] = b.shift[k] = b.theta[k] = 0, b.keep[k] = start.keep[k];
            begin_moving(c.velocity[i], linear, b, clamps);
            if (start.has_gyration) {
                begin_round_turning(c.velocity[i].angular, tip, s, b, clamps);
                continue;
            }
        } else {
            b = {}, s = {};
            out.plain[i] =
                begin_body(info, c.traits(i), c.force[i], form, out.fall, step, b.keep, s, out.push[i]);
            if (!s.moves) continue;
            begin_moving(c.velocity[i], linear, b, clamps);
        }
        const bool fits = out.kernel != nullptr && form.has_room && !form.is_round;
        if (fits && turns_about_all_axes(s))
            unturned.in_lanes[unturned.lane_count++] = i;
        else
            unturned.alone[unturned.alone_count++] = i;
    }
    begin_turns(c, step, tip, out, unturned, clamps);
    for (std::uint32_t i = first; i < last; ++i)
        if (c.pushes[i] != 0 && out.step[i].movable)
            begin_torque(c.mass[i], c.force[i], step, out.step[i], out.push[i]);
}

void begin_step(const BodyColumns& c, Vec3 gravity, const StepConstants& step, SolverBodies& out,
                Tasks* tasks) {
    const std::uint32_t count = static_cast<std::uint32_t>(c.info.size());
    out.body.resize(count + 1);
    out.step.resize(count + 1);
    out.plain.resize(count), out.push.resize(count);
    out.turns.clear(), out.fours.clear(), out.drift.clear();
    out.clamps = {};
    out.fall = {{}, {}, gravity};
    per_substep(gravity, step, out.fall.dv);
    find_forms(c, step, out);
    out.paths.take(base::is_shared(tasks, count, body_chunk), base::Path::bodies_by_one,
                   base::Path::bodies_by_workers);
    base::for_chunks(tasks, count, body_chunk, [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
        ClampCounts clamps;
        begin_some(c, step, out, first, last, clamps);
        base::add_count(out.clamps.speed, clamps.speed);
    });
    // The still body keeps no motion along any axis.
    out.body[count] = {};
    out.step[count] = {};
}

static SpeedVec3 rounded(const std::int64_t v[3]) {
    const auto one = [](std::int64_t x) {
        return Speed::from_raw(saturate_to_int32(shift_right_rounded(x, row_bits)));
    };
    return {one(v[0]), one(v[1]), one(v[2])};
}

/// Steps of the midpoint rule in a tick without torque, for a body that turns far enough to need them: so a spinning
/// top keeps its energy to 0.1 % and its phase for minutes.
constexpr std::int32_t free_turn_steps = 4;

/// A smaller turn changes w by less than a unit of Speed [rad].
constexpr Real least_turn = decimal<Real>("0.0001");

constexpr Real least_free_turn = decimal<Real>("0.01"), free_turn_noise = decimal<Real>("0.00001");

static Vec3 in_a_tick(Vec3 w, const StepConstants& step) {
    return {mul<Real>(w.x, step.tick_time), mul<Real>(w.y, step.tick_time), mul<Real>(w.z, step.tick_time)};
}

/// True if the body's own spin alone turned it in this tick, by more than a hundredth of a radian.
static bool is_free_turn(Vec3 rotation, Vec3 by_spin) {
    const Vec3 size = abs(rotation);
    if (size.x + size.y + size.z <= least_free_turn) return false;
    const Vec3 off = abs(rotation - by_spin);
    return off.x + off.y + off.z < free_turn_noise;
}

static std::int64_t spin_most(const StepConstants& step) {
    return (std::int64_t{step.ticks_per_second} * tick_turn_most) << spin_bits;
}

/// Shortens a spin with a component that exceeds the format. Clamping the components one by one would turn the spin of
/// a thin body about its long axis partly into spin across it. The lanes of turn_kernel.h skip the same spins.
static SpeedVec3 spin_within(Vec3 spin) {
    constexpr int drop = Real::fraction_bits - Speed::fraction_bits;
    const Vec3 size = abs(spin);
    const auto fits = [](Real x) { return magnitude(shift_right_rounded(x.raw, drop)) <= 0x7fffffffu; };
    if (fits(spin.x) && fits(spin.y) && fits(spin.z)) return to<Speed>(spin);
    return to<Speed>(scale<Real>(spin, Real(4095) / max(size.x, max(size.y, size.z))));
}

/// Replaces turn() where rounds of the midpoint rule do not converge: for a body that is thin or spins fast. The change
/// of the direction adds no energy to that of the tick's impulses.
static void turn_far(const StepConstants& step, const Momentum& momentum, Quat principal, const SolverBody& b,
                     const BodyStep& s, bool is_free, Transform& pose, Velocity& velocity) {
    const FreeTurn turn(s.radii_inv, principal);
    const Real rate = Real(step.ticks_per_second);
    const Quat from = pose.rotation;
    Vec3 last = momentum.per_mass();
    if (is_free) {
        pose.rotation = turn.turned_exactly(from, last, rate);
    } else { // by the mean momentum of the tick
        const Vector3<Separation> theta{Separation::from_raw(b.theta[0]), Separation::from_raw(b.theta[1]),
                                        Separation::from_raw(b.theta[2])};
        const Vec3 mean = mul<Real>(s.gyration, to<Real>(theta) * rate);
        pose.rotation = turn.turned(from, mean, rate);
        last = turn.with_energy(turn.energy(from, last), pose.rotation, last, FreeTurn::Keep::not_above);
    }
    velocity.angular = spin_within(turn.spin_at(pose.rotation, last));
}

/// Computes the rotation of the tick and the angular velocity after it. Without torque, the angular momentum per mass K
/// u stays constant except for rounding: K is that of the middle of the turn (midpoint rule, second order).
static void turn(const BodyTraits& traits, const StepConstants& step, const SolverBody& b, BodyStep& s,
                 bool is_struck, const base::Paths& paths, Transform& pose, Velocity& velocity) {
    const Vector3<Separation> theta{Separation::from_raw(b.theta[0]), Separation::from_raw(b.theta[1]),
                                    Separation::from_raw(b.theta[2])};
    const Vec3 rotation = masked(over_gyration<Real>(s, theta), s.angular_mask);
    const SpeedVec3 u = rounded(b.u);
    const Vec3 size = abs(rotation);
    const bool turns = size.x > least_turn || size.y > least_turn || size.z > least_turn;
    const bool gyroscopic = s.movable && traits.gyroscopic != 0 && s.angular_mask == 7u && !is_round(s);
    const Vec3 w = over_gyration<Real>(s, u);
    if (!gyroscopic || !turns) {
        pose.rotation = integrate_rotation(pose.rotation, rotation);
        velocity.angular = spin_within(masked(w, s.angular_mask));
        return;
    }
    const Momentum momentum(s, u, traits.mass.principal);
    const bool is_free = is_free_turn(rotation, in_a_tick(w, step));
    if (momentum.spins_above(spin_most(step))) {
        paths.take(base::Path::turn_far);
        return turn_far(step, momentum, traits.mass.principal, b, s, is_free, pose, velocity);
    }
    paths.take(base::Path::turn_by_midpoint);
    const auto halved = [](Vec3 v) { return Vec3{half(v.x), half(v.y), half(v.z)}; };
    if (is_free) {
        for (std::int32_t i = 0; i < free_turn_steps; ++i) {
            const Real time = Real(step.ticks_per_second * free_turn_steps);
            const Vec3 now = momentum.spin_at(pose.rotation) / time;
            Vec3 at_middle = now; // of the turn to which it leads: so energy does not drift
            for (int round = 0; round < 3; ++round)
                at_middle = momentum.spin_at(integrate_rotation(pose.rotation, halved(at_middle))) / time;
            pose.rotation = integrate_rotation(pose.rotation, at_middle);
        }
    } else {
        const Quat from = pose.rotation;
        const Vec3 middle = momentum.spin_at(integrate_rotation(from, halved(rotation)));
        pose.rotation = integrate_rotation(from, rotation + in_a_tick(middle - w, step));
        // The turn before an elastic impact had another direction, so the momentum after the impact has another energy
        // at the present rotation. Without this correction, capsules that spin fast in a closed room grow to a hundred
        // times their energy in a minute.
        if (is_struck) {
            const FreeTurn free(s.radii_inv, traits.mass.principal);
            const Vec3 whole = momentum.per_mass();
            velocity.angular = spin_within(
                free.spin_at(pose.rotation, free.with_energy(free.energy(from, whole), pose.rotation, whole,
                                                             FreeTurn::Keep::all)));
            return;
        }
    }
    velocity.angular = spin_within(momentum.spin_at(pose.rotation));
}

/// Moves a position. Returns the number of components that reached the end of their range.
static std::uint64_t shift_position(const SolverBody& b, Vec3& position) {
    constexpr int up = Real::fraction_bits - Separation::fraction_bits;
    constexpr std::int64_t edge = std::int64_t{1000000000} << Real::fraction_bits;
    std::uint64_t clamped = 0;
    for (int axis = 0; axis < 3; ++axis) {
        Real& x = position[axis];
        x = x + Real::from_raw(std::int64_t{b.shift[axis]} << up);
        if (magnitude(x.raw) <= static_cast<std::uint64_t>(edge)) continue;
        x.raw = x.raw < 0 ? -edge : edge;
        ++clamped;
    }
    return clamped;
}

/// Finishes one body. Returns the number of components of its position that reached the end of their range.
static std::uint64_t finish_body(const StepConstants& step, SolverBodies& bodies, const BodyColumns& c,
                                 std::uint32_t i) {
    const SolverBody& b = bodies.body[i];
    BodyStep& s = bodies.step[i];
    const std::uint64_t clamped = shift_position(b, c.pose[i].position);
    if (s.movable) c.velocity[i].linear = rounded(b.v);
    Velocity turned = c.velocity[i];
    if (s.turn != 0) {
        c.pose[i].rotation = bodies.turns[s.turn - 1].rotation;
        c.velocity[i].angular = bodies.turns[s.turn - 1].spin;
        return clamped;
    }
    turn(c.traits(i), step, b, s, (bodies.plain[i] & plain_struck) != 0, bodies.paths, c.pose[i], turned);
    if (s.movable) c.velocity[i].angular = turned.angular;
    return clamped;
}

void finish_step(const StepConstants& step, SolverBodies& bodies, const BodyColumns& c, Tasks* tasks,
                 std::span<Transform> before) {
    const std::uint32_t count = static_cast<std::uint32_t>(c.info.size());
    find_spins(step, bodies);
    const EndPass pass{bodies.body.data(),  bodies.step.data(),    bodies.plain.data(), c.info.data(),
                       bodies.forms.data(), bodies.form_of.data(), c.pose.data(),       c.velocity.data(),
                       least_turn.raw,      least_free_turn.raw,   free_turn_noise.raw, step.tick_time.raw,
                       spin_most(step)};
    base::for_chunks(tasks, count, body_chunk, [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
        std::uint32_t rows[body_chunk], left[body_chunk], in_lanes = 0, alone = 0;
        if (!before.empty()) std::copy(&c.pose[first], &c.pose[first] + (last - first), &before[first]);
        for (std::uint32_t i = first; i < last; ++i)
            if (bodies.kernel != nullptr && (bodies.plain[i] & plain_end) != 0)
                rows[in_lanes++] = i;
            else if (bodies.step[i].moves)
                left[alone++] = i;
        if (in_lanes != 0) {
            const std::uint32_t by_lanes = bodies.kernel->finish(pass, rows, in_lanes, left + alone);
            bodies.paths.take(by_lanes != 0, base::Path::ends_in_lanes, base::Path::ends_left_by_lanes);
            alone += by_lanes;
        }
        std::uint64_t clamped = 0;
        for (std::uint32_t k = 0; k < alone; ++k) clamped += finish_body(step, bodies, c, left[k]);
        base::add_count(bodies.clamps.position, clamped);
    });
}

} // namespace lockstone::solve
