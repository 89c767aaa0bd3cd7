// Engine, clutch, differentials and tracks: the rotating masses, solved with a prediction of the tyres' impulses.
#include "solve/vehicles/vehicle_tyre.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <type_traits>

namespace lockstone::solve {

namespace {

constexpr Real speed_per_rpm = decimal<Real>("0.10471975511965977462"); ///< 2 pi / 60
constexpr Real torque_max = Real(100000000);                            ///< [N m], of locked differentials
constexpr Real part_spin_max = Real(100000);                            ///< [rad/s], of wheels and engines
constexpr Real error_least = Real::from_raw(1 << 14); ///< [rad/s]: 4e-6; couplings ignore smaller errors

/// The fraction of the engine's largest torque at a relative speed.
template <class Number> Number torque_at(const Vehicle& v, Number relative) {
    const std::array<CurvePoint, 8>& curve = v.def->engine.torque;
    if (real(relative) <= curve.front().x) return number<Number>(curve.front().y);
    for (std::size_t i = 1; i < curve.size(); ++i) {
        const CurvePoint &a = curve[i - 1], &b = curve[i];
        if (real(relative) > b.x) continue;
        Number part = (relative - number<Number>(a.x)) * number<Number>(v.engine.run_inverse[i]);
        if (real(part) > Real(1)) part = number<Number>(Real(1));
        return number<Number>(a.y) + number<Number>(b.y - a.y) * part;
    }
    return number<Number>(curve.back().y);
}

template <class Number> Number within_one(Number x) {
    return number<Number>(clamp(real(x), Real{}, Real(1)));
}

/// The change of the engine's speed by its torque in a substep. The limiter reduces the throttle over the last
/// hundredth below rpm_max.
template <class Number> Number engine_push(const Vehicle& v) {
    const Number one = number<Number>(Real(1)),
                 throttle = number<Number>(v.memory->shift_ticks > 0 ? Real{} : v.input.throttle);
    const Number relative = number<Number>(v.engine_speed) * number<Number>(v.engine.per_speed);
    const Number left = within_one((one - relative) * number<Number>(Real(100)));
    const Number drag = (one - throttle) * relative * number<Number>(v.engine.drag);
    if (throttle.raw <= 0 || left.raw <= 0) return -drag;
    return throttle * left * torque_at(v, relative) * number<Number>(v.engine.push) - drag;
}

/// How far the clutch is closed, 0..1: it opens towards the idle speed, so the engine does not stall.
template <class Number> Number clutch_closed(const Vehicle& v) {
    const Number closed = (number<Number>(v.engine_speed) - number<Number>(v.engine.idle_speed)) *
                          number<Number>(v.engine.per_idle);
    return within_one(closed) * number<Number>(Real(1) - v.input.clutch);
}

/// The limit of the torque impulse of a coupling in this substep [N m s].
Real cap_of(const Vehicle& v, const Coupling& c, Real clutch_closed) {
    if (c.source > coupling_clutch || c.kind == DifferentialKind::locked) return c.most;
    if (c.source == coupling_clutch) return clutch_closed * c.most;
    const bool driven = v.coupling_count > 0 && v.coupling[0].source == coupling_clutch;
    const Real through = driven ? abs(v.coupling[0].impulse * v.ratio) : Real{};
    return c.most + v.def->differential[c.source].bias * through;
}

/// Predicts the impulse of one tyre. Returns true if the brake holds it.
template <class Number> bool try_wheel(Vehicle& v, std::uint32_t i, Real& stiff) {
    Wheel& wheel = v.wheel[i];
    SpinGroup& g = v.group[wheel.group];
    const Number ahead = number<Number>(wheel.ahead);
    const auto slides = TyreSlide<Number>::make(
        abs(ahead - number<Number>(g.spin) * number<Number>(wheel.radius)), abs(number<Number>(wheel.aside)));
    const TyreQuestion<Number, TyreAsks::gain> tyre{v.along[wheel.tyre], number<Number>(wheel.load),
                                                    number<Number>(wheel.most_along), slides,
                                                    number<Number>(wheel.along.kappa)};
    const RimAnswer<Number> a = turn_rim(g, wheel, number<Number>(free_spin(v, g, i, &Wheel::try_p)),
                                         number<Number>(wheel.ahead_free), abs(ahead), tyre);
    wheel.try_p = real(a.impulse);
    g.spin = real(a.spin);
    stiff += wheel.stiff * real(a.gain);
    return a.held;
}

/// One prediction pass over the tyres of a group: sets the spin that its torque leads to, and the change of the spin
/// per torque.
void settle(Vehicle& v, std::uint32_t group) {
    SpinGroup& g = v.group[group];
    Real stiff{};
    bool held = false;
    for (std::uint32_t i = g.first; i <= g.last && g.on_ground > 0; ++i) {
        const Wheel& wheel = v.wheel[i];
        if (wheel.group != group || !wheel.touches) continue;
        held = wheel.small_ahead && g.small ? try_wheel<Small>(v, i, stiff) : try_wheel<Real>(v, i, stiff);
    }
    if (g.on_ground == 0) {
        g.spin = braked_spin(g, g.free);
        held = g.spin == Real{} && g.brake > Real{};
    }
    g.answer = held ? Real{} : stiff == Real{} ? g.answer_free : quotient(Real(1), g.inertia + stiff);
}

/// Sets the speeds of the patch of a driven wheel relative to the ground, before tyres are predicted.
template <class Number> void look_ahead(const Chassis& chassis, const SolverBodies& bodies, Wheel& wheel) {
    const Number ahead = line_speed<Number>(chassis, wheel, wheel.along, bodies);
    wheel.ahead = real(ahead);
    wheel.aside = real(line_speed<Number>(chassis, wheel, wheel.across, bodies));
    wheel.ahead_free = real(ahead - number<Number>(wheel.along.kappa) * number<Number>(wheel.along_p));
}

template <class Number> void add_torque(SpinGroup& g, Number torque) {
    g.torque = real(number<Number>(g.torque) + torque);
    set_free(g, real(number<Number>(g.spin_begin) + number<Number>(g.torque) / g.by_inertia));
}
template <class Number> void turn_engine(Vehicle& v, Number by) {
    v.engine_speed = real(number<Number>(v.engine_speed) + by);
}

/// Solves a coupling once: its impulse removes its error, within its cap.
template <class Number> void solve_coupling(Vehicle& v, Coupling& c) {
    Number error = number<Number>(c.engine) * number<Number>(v.engine_speed);
    Real answer = c.engine_answer;
    for (std::uint32_t g = 0; g < v.group_count; ++g) {
        if (c.group[g] == Real{}) continue;
        error = error + number<Number>(c.group[g]) * number<Number>(v.group[g].spin);
        answer += real(number<Number>(c.group_square[g]) * number<Number>(v.group[g].answer));
    }
    if (answer <= Real{} || real(abs(error)) < error_least) return;
    const Real wanted = quotient(real(abs(error)), answer);
    const Real next = clamp(error.raw < 0 ? c.impulse - wanted : c.impulse + wanted, -c.cap, c.cap);
    if (next == c.impulse) return;
    const Number change = number<Number>(next - c.impulse);
    c.impulse = next;
    turn_engine<Number>(v, -(number<Number>(c.engine) * change / v.engine.inertia));
    for (std::uint32_t g = 0; g < v.group_count; ++g) {
        if (c.group[g] == Real{}) continue;
        add_torque<Number>(v.group[g], -(number<Number>(c.group[g]) * change));
        settle(v, g);
    }
}

/// Couplings start from the impulses of the last substep, within the caps of this one.
template <class Number> void start_couplings(Vehicle& v) {
    for (std::uint32_t k = 0; k < v.coupling_count; ++k) {
        Coupling& c = v.coupling[k];
        c.impulse = clamp(c.impulse, -c.cap, c.cap);
        const Number impulse = number<Number>(c.impulse);
        turn_engine<Number>(v, -(number<Number>(c.engine) * impulse / v.engine.inertia));
        for (std::uint32_t g = 0; g < v.group_count; ++g)
            if (c.group[g] != Real{}) add_torque<Number>(v.group[g], -(number<Number>(c.group[g]) * impulse));
    }
}

template <class Number> void solve_couplings(Vehicle& v) {
    start_couplings<Number>(v);
    for (std::uint32_t g = 0; g < v.group_count; ++g)
        if (v.group[g].coupled) settle(v, g);
    constexpr int passes = 3;
    for (int pass = 0; pass < passes; ++pass)
        for (std::uint32_t k = 0; k < v.coupling_count; ++k) solve_coupling<Number>(v, v.coupling[k]);
}

/// Sets the caps of this substep. Returns true if Small has room for all impulses.
template <class Number> bool begin_train(Vehicle& v) {
    turn_engine<Number>(v, engine_push<Number>(v));
    const Real closed = real(clutch_closed<Number>(v));
    bool small = v.small_train;
    for (std::uint32_t g = 0; g < v.group_count; ++g) small = small && v.group[g].small;
    for (std::uint32_t k = 0; k < v.coupling_count; ++k) {
        Coupling& c = v.coupling[k];
        c.cap = cap_of(v, c, closed);
        small = small && c.cap < small_torque;
    }
    return small;
}

TyreCurve curve_of(const std::array<CurvePoint, 4>& points) {
    TyreCurve out{};
    out.from_zero = points[0].x == Real{} && points[0].y == Real{};
    for (std::size_t i = 0; i < points.size(); ++i) {
        out.x[i] = points[i].x, out.y[i] = points[i].y;
        out.peak = max(out.peak, points[i].y);
        if (i == 0) continue;
        out.run[i - 1] = points[i].x - points[i - 1].x;
        out.rise[i - 1] = points[i].y - points[i - 1].y;
    }
    return out;
}

} // namespace

void prepare_train(Vehicle& v) {
    const VehicleDef& def = *v.def;
    const bool tracked = def.tracks.enabled != 0;
    v.group_count = tracked ? 2 : def.wheel_count;
    v.coupling_count = 0;
    for (std::uint32_t k = 0; k < v.group_count; ++k) {
        SpinGroup& g = v.group[k];
        const Divisor known = g.by_inertia;
        g = SpinGroup{};
        g.by_inertia = known;
    }
    std::array<Real, vehicle_wheels_max> share{};
    Real driven{};
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        const std::uint32_t group = v.wheel[i].group = tracked ? def.wheel[i].track : i;
        SpinGroup& g = v.group[group];
        g.inertia += def.wheel[i].inertia;
        g.first = tracked ? 0 : i, g.last = tracked ? def.wheel_count - 1 : i;
        g.spin = clamp(v.memory->wheel[i].spin, -part_spin_max, part_spin_max);
        share[group] = tracked ? half(Real(1)) : def.wheel[i].drive_share;
        driven += def.wheel[i].drive_share;
    }
    v.engine_speed = clamp(v.memory->engine_speed, Real{}, part_spin_max);
    if (v.ratio != Real{} && (tracked || driven > Real{})) {
        Coupling& c = v.coupling[v.coupling_count++];
        c = Coupling{};
        c.source = coupling_clutch, c.engine = Real(1), c.impulse = v.memory->clutch;
        for (std::uint32_t g = 0; g < v.group_count; ++g) c.group[g] = -(v.ratio * share[g]);
    } else {
        v.memory->clutch = Real{};
    }
    for (std::uint32_t d = 0; d < vehicle_couplings_max && !tracked; ++d) {
        const Differential& diff = def.differential[d];
        if (diff.kind == DifferentialKind::open || diff.wheels_a == 0 || diff.wheels_b == 0) continue;
        Coupling& c = v.coupling[v.coupling_count++];
        c = Coupling{};
        c.source = d, c.impulse = v.memory->differential[d];
        for (std::uint32_t g = 0; g < v.group_count; ++g) {
            if ((diff.wheels_a >> g & 1u) != 0) c.group[g] = Real(1) / Real(std::popcount(diff.wheels_a));
            if ((diff.wheels_b >> g & 1u) != 0) c.group[g] = -(Real(1) / Real(std::popcount(diff.wheels_b)));
        }
    }
    if (tracked) { // the left track is faster than the right one by steer / ratio of the engine's speed
        Coupling& c = v.coupling[v.coupling_count++];
        c = Coupling{};
        c.source = coupling_steering, c.engine = v.memory->steer / def.tracks.steer_ratio;
        c.impulse = v.memory->steer_coupling;
        c.group[0] = Real(-1);
        c.group[1] = Real(1);
    }
    for (std::uint32_t k = 0; k < v.coupling_count; ++k)
        for (std::uint32_t g = 0; g < v.group_count; ++g)
            v.group[g].coupled = v.group[g].coupled || v.coupling[k].group[g] != Real{};
}

void prepare_rims(const StepConstants& step, Vehicle& v) {
    std::uint32_t tyres = 0;
    for (std::uint32_t k = 0; k < v.group_count; ++k)
        if (SpinGroup& g = v.group[k]; g.by_inertia.of != g.inertia || g.inertia <= Real{})
            g.by_inertia = Divisor::make(g.inertia);
    for (std::uint32_t i = 0; i < v.def->wheel_count; ++i) {
        const WheelDef& def = v.def->wheel[i];
        Wheel& wheel = v.wheel[i];
        SpinGroup& g = v.group[wheel.group];
        tyres |= 1u << def.tyre;
        wheel.tyre = def.tyre, wheel.radius = def.radius;
        wheel.brake_torque = v.input.brake * def.brake_torque + v.input.hand_brake * def.hand_brake_torque;
        if (wheel.brake_torque != Real{})
            wheel.brake_torque = divided(wheel.brake_torque, step.substeps_per_second);
        if (!wheel.touches) continue;
        ++g.on_ground;
        const Real lever = def.radius * v.mass;
        wheel.rolling = v.def->tyre[def.tyre].rolling_resistance * lever;
        wheel.arm = lever / g.by_inertia;
        wheel.kappa_rim = wheel.along.kappa + wheel.arm * def.radius;
        wheel.stiff = def.radius * lever;
        wheel.ordinary = wheel.arm < small_arm && wheel.kappa_rim < small_kappa_rim &&
                         max(max(wheel.normal.kappa, wheel.along.kappa),
                             max(wheel.across.kappa, abs(wheel.mixed))) < small_kappa;
    }
    v.any_in_air = false;
    for (std::uint32_t k = 0; k < v.group_count; ++k) {
        SpinGroup& g = v.group[k];
        v.any_in_air = v.any_in_air || g.on_ground == 0;
        if (g.coupled) g.answer_free = quotient(Real(1), g.inertia);
    }
    for (std::uint32_t t = 0; t < vehicle_tyres_max; ++t) {
        if ((tyres >> t & 1u) == 0) continue;
        v.along[t] = curve_of(v.def->tyre[t].along);
        v.across[t] = curve_of(v.def->tyre[t].across);
    }
}

/// Computes the data that depends on the definition alone, unless it is cached.
static void find_engine(const StepConstants& step, const EngineDef& def, EngineRow& engine) {
    static_assert(std::has_unique_object_representations_v<EngineDef>);
    if (engine.known_rate == step.substeps_per_second && std::memcmp(&engine.known, &def, sizeof def) == 0)
        return;
    const Real per_second = Real(step.substeps_per_second);
    engine.known_rate = step.substeps_per_second;
    engine.known = def;
    engine.inertia = Divisor::make(def.inertia);
    engine.push = def.torque_max / def.inertia / per_second;
    engine.drag = def.brake_torque / def.inertia / per_second;
    engine.per_speed = rpm_per_speed / def.rpm_max;
    engine.idle_speed = def.rpm_idle * speed_per_rpm;
    engine.per_idle = Real(2) / engine.idle_speed;
    for (std::size_t i = 1; i < def.torque.size(); ++i)
        engine.run_inverse[i] = Real(1) / (def.torque[i].x - def.torque[i - 1].x);
}

void prepare_engine(const StepConstants& step, Vehicle& v) {
    const EngineDef& def = v.def->engine;
    EngineRow& engine = v.engine;
    find_engine(step, def, engine);
    for (std::uint32_t k = 0; k < v.coupling_count; ++k) {
        Coupling& c = v.coupling[k];
        c.engine_answer = c.engine == Real(1) ? engine.inertia.inverse : c.engine * c.engine / def.inertia;
        for (std::uint32_t g = 0; g < v.group_count; ++g) c.group_square[g] = c.group[g] * c.group[g];
        c.kind = c.source < coupling_clutch ? v.def->differential[c.source].kind : DifferentialKind::open;
        const Real most = c.source == coupling_clutch          ? v.def->gearbox.clutch_torque
                          : c.source == coupling_steering      ? v.def->tracks.steer_torque
                          : c.kind == DifferentialKind::locked ? torque_max
                                                               : v.def->differential[c.source].preload;
        c.most = divided(most, step.substeps_per_second);
    }
    v.small_engine = max(engine.push, engine.drag) < small_push;
    v.small_train = v.small_engine && engine.inertia.inverse < small_inverse && !engine.inertia.large;
    for (std::uint32_t g = 0; g < v.group_count; ++g) {
        const Divisor& d = v.group[g].by_inertia;
        v.small_train = v.small_train && d.inverse < small_inverse && !d.large;
    }
    for (std::uint32_t k = 0; k < v.coupling_count; ++k) {
        const Coupling& c = v.coupling[k];
        v.small_train = v.small_train && abs(c.engine) < small_ratio;
        for (std::uint32_t g = 0; g < v.group_count; ++g)
            v.small_train = v.small_train && abs(c.group[g]) < small_ratio;
    }
}

void solve_train(const Chassis& chassis, const SolverBodies& bodies, Vehicle& v) {
    const bool small = v.small_engine ? begin_train<Small>(v) : begin_train<Real>(v);
    for (std::uint32_t i = 0; i < v.def->wheel_count; ++i) {
        Wheel& wheel = v.wheel[i];
        if (!wheel.touches || !v.group[wheel.group].coupled) continue;
        wheel.try_p = wheel.along_p;
        wheel.small_ahead = wheel.small && chassis.has_room();
        if (wheel.small_ahead)
            look_ahead<Small>(chassis, bodies, wheel);
        else
            look_ahead<Real>(chassis, bodies, wheel);
    }
    if (small)
        solve_couplings<Small>(v);
    else
        solve_couplings<Real>(v);
    v.engine_speed = clamp(v.engine_speed, v.engine.idle_speed, part_spin_max);
}

} // namespace lockstone::solve
