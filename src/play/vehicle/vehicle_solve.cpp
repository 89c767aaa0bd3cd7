// The rows of vehicles: springs, stops, anti-roll bars, tyres. See vehicle.h for the symbols.
#include "lockstone/math/math.h"
#include "play/vehicle/vehicle.h"
#include "play/vehicle/vehicle_lines.h"

namespace lockstone::sim {

using solve::SolverBodies;
using solve::SolverBody;
using solve::StepConstants;

// ---- rims ----------------------------------------------------------------------------------------------------------

namespace {

constexpr Real rest_slide = 0.1_r; ///< [m/s]: from here on the slide decides how a tyre shares its peak out

/// A Real of which it is known that no result comes near the end of its range: nothing is clamped.
struct Small {
    std::int64_t raw;

    friend Small operator+(Small a, Small b) { return {a.raw + b.raw}; }
    friend Small operator-(Small a, Small b) { return {a.raw - b.raw}; }
    friend Small operator*(Small a, Small b) {
        return {narrow_small(Wide::product(a.raw, b.raw), Real::fraction_bits)};
    }
    friend Small operator/(Small a, Small b) { return {divide_shifted(a.raw, b.raw, Real::fraction_bits)}; }
};

/// An answer that does not slide, or does so beyond the curve. Number: Real, or Small where is_small() holds.
template <class Number>
TyreAnswer on_curve(const TyreQuestion& tyre, Real slide_of, Real kappa_of, Real speed_of) {
    const auto number = [](Real x) { return Number{x.raw}; };
    const auto real = [](Number x) { return Real::from_raw(x.raw); };
    const std::array<CurvePoint, 4>& curve = tyre.curve;
    const Number slide = number(slide_of), kappa = number(kappa_of), speed = number(speed_of),
                 load = number(tyre.load);
    // g(s) = slide - kappa load grip(s) - speed s falls where the curve rises; its first root is where the tyre clings.
    const auto rest = [&](const CurvePoint& c) {
        return slide - kappa * (load * number(c.y)) - speed * number(c.x);
    };
    Number before = rest(curve[0]);
    if (before.raw <= 0) return {real(slide / kappa), Real{}, Real{}};
    for (std::size_t i = 1; i < curve.size(); ++i) {
        const Number after = rest(curve[i]);
        if (after.raw > 0) {
            before = after;
            continue;
        }
        const Number from = number(curve[i - 1].x), run = number(curve[i].x) - from;
        const Number slip = from + run * (before / (before - after));
        TyreAnswer out{real((slide - speed * slip) / kappa), Real::max(), real(slip)};
        if (!tyre.asks_give) return out;
        const Number rise = load * (number(curve[i].y) - number(curve[i - 1].y));
        if (rise.raw > 0) out.give = real(speed * run / rise);
        return out;
    }
    const Number impulse = load * number(curve.back().y);
    return {real(impulse), Real::max(), speed.raw > 0 ? real((slide - kappa * impulse) / speed) : Real{}};
}

/// No product of on_curve() comes near the end of a Real: kappa load y stays below 2^28, speed x below 2^23, and a quotient by them
/// has its own clamps.
bool is_small(const TyreQuestion& tyre, Real slide, Real kappa, Real speed) {
    return tyre.load < Real(1 << 9) && tyre.peak < Real(1 << 5) && kappa < Real(1 << 14) &&
           slide < Real(1 << 13) && speed < Real(1 << 13) && tyre.curve.back().x < Real(1 << 10);
}

/// Whether an impulse is within what share_of_peak() leaves, as far as that is seen without a root and a quotient: the slide is no
/// longer than its two parts together.
bool is_within_share(Real impulse, Real most, Real own, Real other) {
    return impulse * (own + other + rest_slide) <= most * (own + rest_slide);
}

} // namespace

Real share_of_peak(Real own, Real other) {
    return (own + rest_slide) / (length(Vec3{own, other, Real{}}) + rest_slide);
}

TyreAnswer tyre_answer(const TyreQuestion& tyre, Real slide, Real kappa, Real speed) {
    if (tyre.load <= Real{} || slide <= Real{} || kappa <= Real{})
        return {Real{}, Real::max(), speed > Real{} ? slide / speed : Real{}};
    const TyreAnswer out = is_small(tyre, slide, kappa, speed) ? on_curve<Small>(tyre, slide, kappa, speed)
                                                               : on_curve<Real>(tyre, slide, kappa, speed);
    const Real most = tyre.load * tyre.peak;
    if (is_within_share(out.impulse, most, tyre.own, tyre.other)) return out;
    const Real cap = most * share_of_peak(tyre.own, tyre.other);
    if (out.impulse <= cap) return out;
    return {cap, Real::max(), speed > Real{} ? (slide - kappa * cap) / speed : Real{}};
}

Real braked_spin(const SpinGroup& group, Real spin) {
    const Real most = group.brake_ahead;
    return spin > most ? spin - most : spin < -most ? spin + most : Real{};
}

Real free_spin(const Vehicle& v, std::uint32_t wheel, Real Wheel::*impulse) {
    const SpinGroup& g = v.group[v.wheel[wheel].group];
    if (g.on_ground == 1) return g.free;
    Real torque = g.torque;
    for (std::uint32_t i = 0; i < v.def->wheel_count; ++i)
        if (i != wheel && v.wheel[i].group == v.wheel[wheel].group && v.wheel[i].touches)
            torque -= v.wheel[i].*impulse * v.def->wheel[i].radius * v.mass;
    return g.spin_begin + torque / g.inertia;
}

RimAnswer turn_rim(const Vehicle& v, const Wheel& wheel, const WheelDef& def, Real free, Real patch,
                   Real ground_speed, const TyreQuestion& tyre) {
    const SpinGroup& g = v.group[wheel.group];
    const auto answer = [&](Real slide, Real kappa) {
        TyreAnswer a = tyre_answer(tyre, abs(slide), kappa, ground_speed);
        if (slide > Real{}) a.impulse = -a.impulse; // against the slide
        if (slide > Real{}) a.slip = -a.slip;       // a rim that is faster than the ground drives: positive
        return a;
    };
    // Held by the brake, if it can: then only the chassis gives. A rim that no tyre could stop is not.
    Real rest = free;
    if ((abs(free) - wheel.arm * (tyre.load * tyre.peak)) * g.inertia <= g.brake) {
        const TyreAnswer held = answer(patch, wheel.along.kappa);
        rest = free - wheel.arm * held.impulse;
        if (abs(rest) * g.inertia <= g.brake) return {held.impulse, Real{}, held.give, held.slip, true};
    }
    const Real braked = free + (rest > Real{} ? g.brake_back : g.brake_ahead);
    const TyreAnswer turning = answer(patch - braked * def.radius, wheel.kappa_rim);
    return {turning.impulse, braked - wheel.arm * turning.impulse, turning.give, turning.slip, false};
}

// ---- springs -------------------------------------------------------------------------------------------------------

namespace {

/// How far the patch moved along the normal since the start of the tick [m]. No body moves by more than 16 m in a tick, and no arm is
/// above 64: sums stay below 2^75.
Real moved(const Wheel& wheel, const SolverBodies& bodies, std::uint32_t chassis) {
    constexpr int finer = Real::fraction_bits - Separation::fraction_bits;
    const SolverBody &c = bodies.body[chassis], &g = bodies.body[wheel.ground];
    Wide along = Wide::from(0), turning = along;
    for (int i = 0; i < 3; ++i) {
        along = along + Wide::product(std::int64_t{c.shift[i]} - g.shift[i], wheel.normal.d[i].raw);
        turning = turning + Wide::product(c.theta[i], wheel.normal.xc[i].raw) +
                  Wide::product(g.theta[i], wheel.normal.xg[i].raw);
    }
    return Real::from_raw(narrow_small(along, Unit::fraction_bits - finer) +
                          narrow_small(turning, Real::fraction_bits - finer));
}

void set_normal(Vehicle& v, Wheel& wheel, Real Wheel::*part, Real impulse, SolverBodies& bodies) {
    push_line(wheel, wheel.normal, impulse - wheel.*part, bodies, v.chassis);
    wheel.*part = impulse;
}

void solve_spring(const StepConstants& step, SolverBodies& bodies, Vehicle& v, std::uint32_t i) {
    Wheel& wheel = v.wheel[i];
    const Real kappa = wheel.normal.kappa;
    Real speed = line_speed(wheel, wheel.normal, bodies, v.chassis), p{};
    if (wheel.compression > Real{}) {
        const Real a = wheel.spring_soft + wheel.damper[speed < Real{} ? 1 : 0];
        p = (wheel.spring_rate * wheel.compression + a * (kappa * wheel.spring - speed)) /
            (Real(1) + a * kappa);
    }
    p = max(p, Real{});
    speed += kappa * (p - wheel.spring);
    set_normal(v, wheel, &Wheel::spring, p, bodies);

    const Real gap = wheel.length - v.def->wheel[i].length_min;
    if (gap > Real{}) {
        p = wheel.stop - (speed + gap * step.substeps_per_second) / kappa;
    } else {
        const Real bias = max(gap * to<Real>(step.soft_static.bias_rate), -to<Real>(step.push_speed_max));
        p = wheel.stop - mul<Real>((speed + bias) / kappa, step.soft_static.mass_scale) -
            mul<Real>(wheel.stop, step.soft_static.impulse_scale);
    }
    set_normal(v, wheel, &Wheel::stop, max(p, Real{}), bodies);
}

void solve_bar(const StepConstants& step, SolverBodies& bodies, Vehicle& v, std::uint32_t k) {
    const AntiRollBar& bar = v.def->anti_roll[k];
    if (bar.wheel_a == bar.wheel_b || bar.stiffness == Real{}) return;
    Wheel &a = v.wheel[bar.wheel_a], &b = v.wheel[bar.wheel_b];
    Real& p = v.memory.anti_roll[k];
    Real next{};
    if (a.touches && b.touches && a.compression > Real{} && b.compression > Real{}) {
        const Real rate = bar.stiffness / v.mass / Real(step.substeps_per_second);
        const Real soft = rate / Real(step.substeps_per_second);
        Real shared = dot<Real>(a.normal.xc, b.normal.xc);
        for (int i = 0; i < 3; ++i)
            if (bodies.body[v.chassis].keep[i] != 0) shared += mul<Real>(a.normal.d[i], b.normal.d[i]);
        const Real kappa = max(a.normal.kappa + b.normal.kappa - shared * 2, Real{});
        const Real speed =
            line_speed(a, a.normal, bodies, v.chassis) - line_speed(b, b.normal, bodies, v.chassis);
        next =
            (rate * (a.compression - b.compression) + soft * (kappa * p - speed)) / (Real(1) + soft * kappa);
        // Neither wheel is lifted by more than it bears.
        next = clamp(next, p - (a.spring + a.stop + a.bars), p + (b.spring + b.stop + b.bars));
    }
    const Real change = next - p;
    p = next;
    set_normal(v, a, &Wheel::bars, a.bars + change, bodies);
    set_normal(v, b, &Wheel::bars, b.bars - change, bodies);
}

// ---- tyres ---------------------------------------------------------------------------------------------------------

void solve_tyre(SolverBodies& bodies, Vehicle& v, std::uint32_t i) {
    Wheel& wheel = v.wheel[i];
    const WheelDef& def = v.def->wheel[i];
    const Tyre& tyre = v.def->tyre[def.tyre];
    const TyrePeaks& peaks = v.peaks[def.tyre];
    SpinGroup& g = v.group[wheel.group];
    const PatchMotion motion = motion_of(wheel, bodies, v.chassis);
    const Real ahead = line_speed(motion, wheel.along), speed = abs(ahead);
    const Real aside = line_speed(motion, wheel.across);
    const Real slide_along = abs(ahead - g.spin * def.radius), slide_across = abs(aside);
    const RimAnswer rim =
        turn_rim(v, wheel, def, free_spin(v, i, &Wheel::along_p), ahead - wheel.along.kappa * wheel.along_p,
                 speed, {tyre.along, peaks.along, wheel.load, slide_along, slide_across, false});
    const Real change = rim.impulse - wheel.along_p;
    push_line(wheel, wheel.along, change, bodies, v.chassis);
    wheel.along_p = rim.impulse;
    wheel.slip = rim.slip;
    g.spin = rim.spin;

    const Real slide = aside + wheel.mixed * change - wheel.across.kappa * wheel.across_p;
    TyreAnswer side = tyre_answer({tyre.across, peaks.across, wheel.load, slide_across, slide_along, false},
                                  abs(slide), wheel.across.kappa, speed);
    if (slide > Real{}) side.impulse = -side.impulse;
    push_line(wheel, wheel.across, side.impulse - wheel.across_p, bodies, v.chassis);
    wheel.across_p = side.impulse;
    wheel.slip_side = slide > Real{} ? side.slip : -side.slip;
}

/// What the brakes and the rolling of the tyres can take from each group in this substep; the loads on the tyres.
void set_brakes(Vehicle& v) {
    for (std::uint32_t g = 0; g < v.group_count; ++g) v.group[g].brake = Real{};
    for (std::uint32_t i = 0; i < v.def->wheel_count; ++i) {
        const WheelDef& def = v.def->wheel[i];
        Wheel& wheel = v.wheel[i];
        const Real load = load_of(wheel);
        const Real rolling = v.def->tyre[def.tyre].rolling_resistance * load * v.mass * def.radius;
        v.group[wheel.group].brake += wheel.brake_torque + rolling;
        wheel.load = load * wheel.grip;
    }
    for (std::uint32_t k = 0; k < v.group_count; ++k) {
        SpinGroup& g = v.group[k];
        g.brake_ahead = g.brake / g.inertia;
        g.brake_back = -g.brake_ahead;
    }
}

/// Groups of which no wheel is on the ground.
void spin_in_the_air(Vehicle& v) {
    for (std::uint32_t k = 0; k < v.group_count; ++k)
        if (SpinGroup& g = v.group[k]; g.on_ground == 0) g.spin = braked_spin(g, g.free);
}

} // namespace

void VehicleSolver::warm_start(const StepConstants& step, SolverBodies& bodies) {
    for_each_vehicle([&](Vehicle& v) {
        for (std::uint32_t i = 0; i < v.def->wheel_count; ++i) {
            Wheel& wheel = v.wheel[i];
            const WheelDef& def = v.def->wheel[i];
            wheel.compression = Real{};
            if (!wheel.touches) continue;
            wheel.length = wheel.length_begin + wheel.per_length * moved(wheel, bodies, v.chassis);
            if (wheel.length < def.length_max)
                wheel.compression = def.length_max + def.preload - wheel.length;
            push_line(wheel, wheel.normal, wheel.spring + wheel.stop + wheel.bars, bodies, v.chassis);
            push_line(wheel, wheel.along, wheel.along_p, bodies, v.chassis);
            push_line(wheel, wheel.across, wheel.across_p, bodies, v.chassis);
        }
        for (std::uint32_t g = 0; g < v.group_count; ++g) {
            v.group[g].spin_begin = v.group[g].spin;
            v.group[g].torque = Real{};
        }
        set_brakes(v);
        solve_train(step, bodies, v);
        for (std::uint32_t g = 0; g < v.group_count; ++g) set_free(v.group[g]);
    });
}

void VehicleSolver::solve(const StepConstants& step, SolverBodies& bodies, bool bias) {
    for_each_vehicle([&](Vehicle& v) {
        const std::uint32_t count = v.def->wheel_count;
        for (std::uint32_t i = 0; i < count && bias; ++i)
            if (v.wheel[i].touches) solve_spring(step, bodies, v, i);
        for (std::uint32_t k = 0; k < vehicle_couplings_max && bias; ++k) solve_bar(step, bodies, v, k);
        for (std::uint32_t i = 0; i < count && bias; ++i)
            v.wheel[i].load = load_of(v.wheel[i]) * v.wheel[i].grip;
        for (std::uint32_t i = 0; i < count; ++i)
            if (v.wheel[i].touches) solve_tyre(bodies, v, i);
        spin_in_the_air(v);
        for (std::uint32_t i = 0; i < count && bias; ++i) {
            Real& turned = v.memory.wheel[i].rotation;
            turned += v.group[v.wheel[i].group].spin / Real(step.substeps_per_second);
        }
    });
}

/// Nobody drives it, and nothing in it turns: it may sleep once its chassis rests.
static bool is_parked(const Model& w, const Vehicle& v) {
    const Real slow = w.state.rows(w.m.config)[0].sleep_speed;
    const Real engine_before = w.state.rows(w.m.vehicle_memory)[v.row].engine_speed;
    if (v.input.throttle != Real{} || v.input.steer != v.memory.steer || v.memory.shift_ticks != 0)
        return false;
    if (abs(v.engine_speed - engine_before) > Real(1)) return false; // [rad/s] in a tick
    for (std::uint32_t i = 0; i < v.def->wheel_count; ++i)
        if (abs(v.group[v.wheel[i].group].spin * v.def->wheel[i].radius) > slow) return false;
    return true;
}

void VehicleSolver::store(Model& w, const solve::SolverBodies& bodies) {
    stands.clear();
    for (const Vehicle& v : vehicles) {
        if (!is_parked(w, v)) restart(w.state.edit_row(w.m.body_sleep, v.chassis));
        VehicleMemory& m = w.state.edit_row(w.m.vehicle_memory, v.row);
        m = v.memory;
        m.engine_speed = v.engine_speed;
        m.clutch = m.steer_coupling = Real{};
        m.differential = {};
        for (std::uint32_t k = 0; k < v.coupling_count; ++k) {
            const Coupling& c = v.coupling[k];
            (c.source == coupling_clutch     ? m.clutch
             : c.source == coupling_steering ? m.steer_coupling
                                             : m.differential[c.source]) = c.impulse;
        }
        for (std::uint32_t i = 0; i < v.def->wheel_count; ++i) {
            const Wheel& wheel = v.wheel[i];
            WheelMemory& out = m.wheel[i];
            out.spin = v.group[wheel.group].spin;
            const Real turns = out.rotation / two_pi;
            out.rotation = clamp(out.rotation - two_pi * floor(turns), Real{}, two_pi);
            if (!wheel.touches) continue;
            if (wheel.ground != bodies.still()) stands.push_back({v.chassis, wheel.ground});
            out.length = clamp(wheel.length, min(v.def->wheel[i].length_min, wheel.length),
                               v.def->wheel[i].length_max);
            out.spring = wheel.spring;
            out.stop = wheel.stop;
            out.along = wheel.along_p;
            out.across = wheel.across_p;
            out.slip = wheel.slip;
            out.slip_side = wheel.slip_side;
        }
    }
}

} // namespace lockstone::sim
