// The rows of vehicles: springs, stops, anti-roll bars, tyres. See vehicle.h for the symbols.
#include "solve/vehicles/vehicle.h"
#include "solve/vehicles/vehicle_tyre.h"

namespace lockstone::solve {

// ---- rims ----------------------------------------------------------------------------------------------------------

Real share_of_peak(Real own, Real other) {
    constexpr Real short_below = Real(1 << 14), rest = TyreSlide<Real>::rest;
    const Vec3 slide{own - rest, other - rest, Real{}};
    const Real long_slide = own < short_below && other < short_below
                                ? lockstone::to<Real>(length(lockstone::to<I16F16>(slide)))
                                : length(slide);
    return min(quotient(own, long_slide + rest), Real(1));
}

Real shared_spin(const Vehicle& v, std::uint32_t wheel, Real Wheel::*impulse) {
    const SpinGroup& g = v.group[v.wheel[wheel].group];
    Real spin = g.free;
    for (std::uint32_t i = g.first; i <= g.last; ++i)
        if (i != wheel && v.wheel[i].group == v.wheel[wheel].group && v.wheel[i].touches)
            spin -= v.wheel[i].*impulse * v.wheel[i].arm;
    return spin;
}

// ---- springs -------------------------------------------------------------------------------------------------------

namespace {

/// The distance that the patch moved along the normal since the start of the tick [m], below 2^12. No body moves by
/// more than 16 m in a tick: three products of 31 and 30 bits.
Real moved(const Wheel& wheel, const SolverBodies& bodies, std::uint32_t chassis) {
    constexpr int finer = Real::fraction_bits - Separation::fraction_bits;
    const auto products = [](const std::int32_t(&way)[3], const auto& by) {
        return std::int64_t{way[0]} * by.x.raw + std::int64_t{way[1]} * by.y.raw +
               std::int64_t{way[2]} * by.z.raw;
    };
    const WheelLine& line = wheel.normal;
    const SolverBody& c = bodies.body[chassis];
    std::int64_t sum = rounded<Unit::fraction_bits - finer>(products(c.shift, line.d)) +
                       rounded<Arm::fraction_bits - finer>(products(c.theta, line.xc));
    if (wheel.rides) {
        const SolverBody& g = bodies.body[wheel.ground];
        sum += rounded<Arm::fraction_bits - finer>(products(g.theta, line.xg)) -
               rounded<Unit::fraction_bits - finer>(products(g.shift, line.d));
    }
    return Real::from_raw(sum);
}

/// The impulse of a stop that the wheel touches, or reaches within the substep.
Real stop_of(const StepConstants& step, const Wheel& wheel, Real speed) {
    const Real kappa = wheel.normal.kappa;
    Real stop = wheel.stop;
    if (wheel.gap > Real{}) {
        stop -= (speed + wheel.gap_rate) / kappa;
    } else {
        const Real bias =
            max(wheel.gap * to<Real>(step.soft_static.bias_rate), -to<Real>(step.push_speed_max));
        stop -= mul<Real>((speed + bias) / kappa, step.soft_static.mass_scale) +
                mul<Real>(wheel.stop, step.soft_static.impulse_scale);
    }
    return max(stop, Real{});
}

/// A pass over one vehicle.
struct Pass {
    const StepConstants& step;
    SolverBodies& bodies;
    Chassis& chassis;
    Vehicle& v;
};

template <class Number> void solve_spring(const Pass& pass, Wheel& wheel) {
    const Number kappa = number<Number>(wheel.normal.kappa), before = number<Number>(wheel.spring);
    Number speed = line_speed<Number>(pass.chassis, wheel, wheel.normal, pass.bodies), spring{};
    if (wheel.compression > Real{}) {
        const int side = speed.raw < 0 ? 1 : 0;
        spring = number<Number>(wheel.pull[side]) * number<Number>(wheel.compression) +
                 number<Number>(wheel.yield[side]) * (kappa * before - speed);
        if (spring.raw < 0) spring.raw = 0;
    }
    Number change = spring - before;
    speed = speed + kappa * change;
    wheel.spring = real(spring);
    const bool closes = wheel.gap <= Real{} || (speed + number<Number>(wheel.gap_rate)).raw < 0;
    if (closes || wheel.stop != Real{}) {
        const Real stop = stop_of(pass.step, wheel, real(speed));
        change = change + number<Number>(stop - wheel.stop);
        wheel.stop = stop;
    }
    push_line(pass.chassis, wheel, wheel.normal, real(change), pass.bodies);
}

void add_to_bars(const Pass& pass, Wheel& wheel, Real change) {
    wheel.bars += change;
    push_line(pass.chassis, wheel, wheel.normal, change, pass.bodies);
}

void solve_bar(const Pass& pass, std::uint32_t k) {
    Vehicle& v = pass.v;
    const BarRow& row = v.bar[k];
    if (!row.holds) return;
    Wheel &a = v.wheel[v.def->anti_roll[k].wheel_a], &b = v.wheel[v.def->anti_roll[k].wheel_b];
    Real& p = v.memory->anti_roll[k];
    Real next{};
    if (a.compression > Real{} && b.compression > Real{}) {
        const Real speed = line_speed<Real>(pass.chassis, a, a.normal, pass.bodies) -
                           line_speed<Real>(pass.chassis, b, b.normal, pass.bodies);
        next = row.pull * (a.compression - b.compression) + row.yield * (row.kappa * p - speed);
        // The bar lifts a wheel at most by the load on it.
        next = clamp(next, p - (a.spring + a.stop + a.bars), p + (b.spring + b.stop + b.bars));
    }
    const Real change = next - p;
    p = next;
    add_to_bars(pass, a, change);
    add_to_bars(pass, b, -change);
}

// ---- tyres ---------------------------------------------------------------------------------------------------------

template <class Number, TyreAsks asks>
void solve_tyre(const Pass& pass, Wheel& wheel, SpinGroup& g, std::uint32_t i) {
    const Vehicle& v = pass.v;
    const Number ahead = line_speed<Number>(pass.chassis, wheel, wheel.along, pass.bodies),
                 speed = abs(ahead),
                 aside = line_speed<Number>(pass.chassis, wheel, wheel.across, pass.bodies),
                 load = number<Number>(wheel.load);
    const auto slides = TyreSlide<Number>::make(
        abs(ahead - number<Number>(g.spin) * number<Number>(wheel.radius)), abs(aside));
    const Number along_before = number<Number>(wheel.along_p), across_before = number<Number>(wheel.across_p);
    const TyreQuestion<Number, asks> along{v.along[wheel.tyre], load, number<Number>(wheel.most_along),
                                           slides, Number{}};
    const RimAnswer<Number> rim =
        turn_rim(g, wheel, number<Number>(free_spin(v, g, i, &Wheel::along_p)),
                 ahead - number<Number>(wheel.along.kappa) * along_before, speed, along);
    const Number change = rim.impulse - along_before;
    wheel.along_p = real(rim.impulse);
    g.spin = real(rim.spin);

    const Number kappa = number<Number>(wheel.across.kappa),
                 slide = aside + number<Number>(wheel.mixed) * change - kappa * across_before;
    const TyreQuestion<Number, asks> across{v.across[wheel.tyre], load, number<Number>(wheel.most_across),
                                            slides.turned(), Number{}};
    TyreAnswer<Number> side = tyre_answer(across, abs(slide), kappa, speed);
    if (slide.raw > 0) side.impulse = -side.impulse;
    wheel.across_p = real(side.impulse);
    push_tyre(pass.chassis, wheel, real(change), real(side.impulse - across_before), pass.bodies);
    if constexpr (asks == TyreAsks::slip) {
        wheel.slip = rim.slip;
        wheel.slip_side = slide.raw > 0 ? side.slip : -side.slip;
    }
}

template <class Number> void set_peaks(const Vehicle& v, Wheel& wheel) {
    const Number load = number<Number>(wheel.load), most = load * number<Number>(v.along[wheel.tyre].peak);
    wheel.most_along = real(most);
    wheel.most_across = real(load * number<Number>(v.across[wheel.tyre].peak));
    wheel.arm_most = real(number<Number>(wheel.arm) * most);
}

void set_load(const Vehicle& v, Wheel& wheel, Real load) {
    wheel.load = wheel.grip == Real(1) ? load : load * wheel.grip;
    wheel.small = wheel.ordinary && wheel.load < small_load;
    if (wheel.small)
        set_peaks<Small>(v, wheel);
    else
        set_peaks<Real>(v, wheel);
}

/// Sets the largest spin change of each group by brakes and rolling tyres in this substep. Sets the loads on tyres at
/// the start of a tick; later substeps keep the loads that solve_normals() set.
void set_brakes(Vehicle& v, bool begins_tick) {
    for (std::uint32_t g = 0; g < v.group_count; ++g) v.group[g].brake = Real{};
    for (std::uint32_t i = 0; i < v.def->wheel_count; ++i) {
        Wheel& wheel = v.wheel[i];
        SpinGroup& g = v.group[wheel.group];
        g.brake += wheel.brake_torque;
        if (!wheel.touches) continue;
        const Real load = load_of(wheel);
        g.brake += wheel.rolling * load;
        if (begins_tick) set_load(v, wheel, load);
    }
    for (std::uint32_t k = 0; k < v.group_count; ++k) {
        SpinGroup& g = v.group[k];
        g.brake_spin = g.brake / g.by_inertia;
        g.spin_begin = g.spin;
        g.torque = Real{};
        set_free(g, g.spin_begin);
    }
}

/// Sets the spins of groups without a wheel on the ground.
void spin_in_the_air(Vehicle& v) {
    for (std::uint32_t k = 0; k < v.group_count; ++k)
        if (SpinGroup& g = v.group[k]; g.on_ground == 0) g.spin = braked_spin(g, g.free);
}

void begin_wheel(const StepConstants& step, const WheelDef& def, Real way, Wheel& wheel) {
    wheel.length = wheel.length_begin + real(number<Small>(wheel.per_length) * number<Small>(way));
    wheel.compression = wheel.length < def.length_max ? def.length_max + def.preload - wheel.length : Real{};
    wheel.gap = wheel.length - def.length_min;
    wheel.gap_rate = wheel.gap * step.substeps_per_second;
}

/// True if 64 bits have room for the speeds of the chassis along the lines of this wheel, and for the wheel's own
/// numbers.
bool is_small(const Pass& pass, const Wheel& wheel) {
    return wheel.small && pass.v.group[wheel.group].small && pass.chassis.roomy;
}

void solve_normals(const Pass& pass) {
    Vehicle& v = pass.v;
    const std::uint32_t count = v.def->wheel_count;
    pass.chassis.look();
    for (std::uint32_t i = 0; i < count; ++i) {
        if (!v.wheel[i].touches) continue;
        const bool small = is_small(pass, v.wheel[i]);
        pass.bodies.paths.take(small, base::Path::wheel_real, base::Path::wheel_small);
        if (small) [[likely]] {
            solve_spring<Small>(pass, v.wheel[i]);
        } else {
            solve_spring<Real>(pass, v.wheel[i]);
            pass.chassis.look();
        }
    }
    for (std::uint32_t k = 0; k < vehicle_couplings_max; ++k) solve_bar(pass, k);
    for (std::uint32_t i = 0; i < count; ++i)
        if (v.wheel[i].touches) set_load(v, v.wheel[i], load_of(v.wheel[i]));
}

template <TyreAsks asks> void solve_tyres(const Pass& pass) {
    pass.chassis.look();
    for (std::uint32_t i = 0; i < pass.v.def->wheel_count; ++i) {
        Wheel& wheel = pass.v.wheel[i];
        if (!wheel.touches) continue;
        SpinGroup& g = pass.v.group[wheel.group];
        if (is_small(pass, wheel)) [[likely]] {
            solve_tyre<Small, asks>(pass, wheel, g, i);
        } else {
            solve_tyre<Real, asks>(pass, wheel, g, i);
            pass.chassis.look();
        }
    }
}

} // namespace

void VehicleSolver::warm_start(const StepConstants& step, SolverBodies& bodies) {
    const bool begins_tick = substeps_left-- == step.substeps;
    for_each_vehicle([&](Vehicle& v) {
        Chassis chassis(bodies.body[v.chassis]);
        for (std::uint32_t i = 0; i < v.def->wheel_count; ++i) {
            Wheel& wheel = v.wheel[i];
            if (!wheel.touches) continue;
            begin_wheel(step, v.def->wheel[i], moved(wheel, bodies, v.chassis), wheel);
            push_lines(chassis, wheel, bodies);
        }
        write_back(chassis, bodies.body[v.chassis]);
        set_brakes(v, begins_tick);
        solve_train(chassis, bodies, v);
    });
}

void VehicleSolver::solve(const StepConstants& step, SolverBodies& bodies, bool bias) {
    // The memory keeps only the slip at the end of the tick.
    const bool is_last = substeps_left == 0 && !bias;
    for_each_vehicle([&](Vehicle& v) {
        Chassis chassis(bodies.body[v.chassis]);
        const Pass pass{step, bodies, chassis, v};
        if (bias) solve_normals(pass);
        if (is_last)
            solve_tyres<TyreAsks::slip>(pass);
        else
            solve_tyres<TyreAsks::impulse>(pass);
        if (v.any_in_air) spin_in_the_air(v);
        write_back(chassis, bodies.body[v.chassis]);
        for (std::uint32_t g = 0; g < v.group_count && bias; ++g) v.group[g].turned += v.group[g].spin;
    });
}

void VehicleSolver::store(const StepConstants& step, const SolverBodies& bodies,
                          std::span<DrivenVehicle> driven) {
    stands.clear();
    for (std::size_t n = 0; n < vehicles.size(); ++n) {
        const Vehicle& v = vehicles[n];
        VehicleMemory& m = driven[n].memory;
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
            out.rotation += divided(v.group[wheel.group].turned, step.substeps_per_second);
            if (out.rotation < Real{} || out.rotation >= two_pi - decimal<Real>("0.001")) {
                const Real turns = out.rotation / two_pi;
                out.rotation = clamp(out.rotation - two_pi * floor(turns), Real{}, two_pi);
            }
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

} // namespace lockstone::solve
