// Engine, clutch, differentials and tracks: what turns, solved against what the tyres will answer.
#include "lockstone/math/math.h"
#include "play/vehicle/vehicle.h"
#include "play/vehicle/vehicle_lines.h"

namespace lockstone::sim {

using solve::SolverBodies;
using solve::StepConstants;

namespace {

constexpr Real speed_per_rpm = decimal<Real>("0.10471975511965977462"); ///< 2 pi / 60
constexpr Real torque_max = Real(100000000);                            ///< [N m], of what is locked
constexpr Real engine_speed_max = Real(100000);                         ///< [rad/s]
constexpr Real error_least = Real::from_raw(1 << 14); ///< [rad/s]: 4e-6; couplings leave smaller ones

/// Torque of the engine [N m]. The limiter takes the fuel away over the last hundredth below rpm_max.
Real engine_torque(const EngineDef& engine, Real throttle, Real rpm) {
    const Real relative = rpm / engine.rpm_max;
    const Real left = clamp((Real(1) - relative) * 100, Real{}, Real(1));
    const Real pull = throttle * left * engine.torque_max * curve_at(engine.torque, relative);
    return pull - (Real(1) - throttle) * engine.brake_torque * relative;
}

/// How far the clutch is closed: it opens towards the idle speed, so the engine does not stall.
Real clutch_closed(const EngineDef& engine, const VehicleInput& input, Real rpm) {
    const Real closed = (rpm - engine.rpm_idle) / (half(engine.rpm_idle));
    return clamp(closed, Real{}, Real(1)) * (Real(1) - input.clutch);
}

/// Most torque impulse of a coupling in this substep [N m s].
Real cap_of(const Vehicle& v, const Coupling& c, Real clutch_torque, Real substeps_per_second) {
    if (c.source == coupling_clutch) return clutch_torque / substeps_per_second;
    if (c.source == coupling_steering) return v.def->tracks.steer_torque / substeps_per_second;
    const Differential& d = v.def->differential[c.source];
    if (d.kind == DifferentialKind::locked) return torque_max / substeps_per_second;
    const bool driven = v.coupling_count > 0 && v.coupling[0].source == coupling_clutch;
    const Real through = driven ? abs(v.coupling[0].impulse * v.ratio) : Real{};
    return d.preload / substeps_per_second + d.bias * through;
}

/// One pass over the tyres of a group, on trial: the spin that its torque leads to, and how it would answer more.
void settle(Vehicle& v, std::uint32_t group) {
    SpinGroup& g = v.group[group];
    set_free(g);
    Real stiff{};
    bool held = false;
    for (std::uint32_t i = 0; i < v.def->wheel_count && g.on_ground > 0; ++i) {
        Wheel& wheel = v.wheel[i];
        if (wheel.group != group || !wheel.touches) continue;
        const WheelDef& def = v.def->wheel[i];
        const RimAnswer a = turn_rim(v, wheel, def, free_spin(v, i, &Wheel::try_p),
                                     wheel.ahead - wheel.along.kappa * wheel.along_p, abs(wheel.ahead),
                                     {v.def->tyre[def.tyre].along, v.peaks[def.tyre].along, wheel.load,
                                      abs(wheel.ahead - g.spin * def.radius), abs(wheel.aside), true});
        wheel.try_p = a.impulse;
        g.spin = a.spin;
        held = a.held;
        stiff += wheel.stiff / (wheel.along.kappa + a.give);
    }
    if (g.on_ground == 0) {
        g.spin = braked_spin(g, g.free);
        held = g.spin == Real{} && g.brake > Real{};
    }
    g.answer = held ? Real{} : Real(1) / (g.inertia + stiff);
}

/// One visit of a coupling: its impulse is what its error wants, up to its cap.
void solve_coupling(Vehicle& v, Coupling& c) {
    const Real inertia = v.def->engine.inertia;
    Real error = c.engine * v.engine_speed, answer = c.engine * c.engine / inertia;
    for (std::uint32_t g = 0; g < v.group_count; ++g) {
        error += c.group[g] * v.group[g].spin;
        answer += c.group[g] * c.group[g] * v.group[g].answer;
    }
    if (answer <= Real{} || abs(error) < error_least) return;
    const Real next = clamp(c.impulse + error / answer, -c.cap, c.cap), change = next - c.impulse;
    if (change == Real{}) return;
    c.impulse = next;
    v.engine_speed -= c.engine * change / inertia;
    for (std::uint32_t g = 0; g < v.group_count; ++g) {
        if (c.group[g] == Real{}) continue;
        v.group[g].torque -= c.group[g] * change;
        settle(v, g);
    }
}

} // namespace

void solve_train(const StepConstants& step, const SolverBodies& bodies, Vehicle& v) {
    const Real sps = Real(step.substeps_per_second);
    const EngineDef& engine = v.def->engine;
    const Real rpm = v.engine_speed / speed_per_rpm;
    const Real throttle = v.memory.shift_ticks > 0 ? Real{} : v.input.throttle;
    v.engine_speed += engine_torque(engine, throttle, rpm) / engine.inertia / sps;
    const Real clutch_torque = clutch_closed(engine, v.input, rpm) * v.def->gearbox.clutch_torque;
    for (std::uint32_t k = 0; k < v.coupling_count; ++k) {
        Coupling& c = v.coupling[k];
        c.cap = cap_of(v, c, clutch_torque, sps);
        c.impulse = clamp(c.impulse, -c.cap, c.cap);
        v.engine_speed -= c.engine * c.impulse / engine.inertia;
        for (std::uint32_t g = 0; g < v.group_count; ++g) v.group[g].torque -= c.group[g] * c.impulse;
    }
    for (std::uint32_t i = 0; i < v.def->wheel_count; ++i) {
        Wheel& wheel = v.wheel[i];
        if (!wheel.touches || !v.group[wheel.group].coupled) continue;
        wheel.try_p = wheel.along_p;
        const PatchMotion motion = motion_of(wheel, bodies, v.chassis);
        wheel.ahead = line_speed(motion, wheel.along);
        wheel.aside = line_speed(motion, wheel.across);
    }
    for (std::uint32_t g = 0; g < v.group_count; ++g)
        if (v.group[g].coupled) settle(v, g);
    constexpr int passes = 3;
    for (int pass = 0; pass < passes; ++pass)
        for (std::uint32_t k = 0; k < v.coupling_count; ++k) solve_coupling(v, v.coupling[k]);
    v.engine_speed = clamp(v.engine_speed, engine.rpm_idle * speed_per_rpm, engine_speed_max);
}

} // namespace lockstone::sim
