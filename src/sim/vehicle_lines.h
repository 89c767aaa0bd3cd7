// What the rows of wheels share: their speeds and impulses, and a rim between its brake and its tyre. See vehicle.h.
#pragma once

#include "sim/vehicle.h"

namespace lockstone::sim {

/// Speed of the chassis' patch over the ground along a line [m/s].
inline Real line_speed(const Wheel& wheel, const WheelLine& line, const dynamics::SolverBodies& bodies,
                       std::uint32_t chassis) {
    constexpr int down = dynamics::accumulator_bits - Real::fraction_bits;
    const auto real = [](std::int64_t x) { return Real::from_raw(shift_right_rounded(x, down)); };
    const dynamics::SolverBody &c = bodies.body[chassis], &g = bodies.body[wheel.ground];
    SumOfProducts<Real, Unit> along;
    SumOfProducts<Real, Real> turning;
    for (int i = 0; i < 3; ++i) {
        along.add(real(c.v[i]) - real(g.v[i]) - wheel.surface[i], line.d[i]);
        turning.add(real(c.u[i]), line.xc[i]).add(real(g.u[i]), line.xg[i]);
    }
    return along.round<Real>() + turning.round<Real>();
}

/// Adds an impulse along a line to the chassis, and against it to the ground. Velocities stay within 2048 m/s, where
/// the rows of contacts can read them.
inline void push_line(const Wheel& wheel, const WheelLine& line, Real impulse, dynamics::SolverBodies& bodies,
                      std::uint32_t chassis) {
    constexpr std::int64_t most = std::int64_t{2048} << dynamics::accumulator_bits;
    const auto add = [](std::int64_t& v, Wide product, int shift) {
        const std::int64_t sum = add_saturated(v, narrow_rounded(product, shift));
        v = sum > most ? most : sum < -most ? -most : sum;
    };
    constexpr int unit = Real::fraction_bits + Unit::fraction_bits - dynamics::accumulator_bits;
    constexpr int real = 2 * Real::fraction_bits - dynamics::accumulator_bits;
    dynamics::SolverBody& c = bodies.body[chassis];
    for (int i = 0; i < 3; ++i) {
        if (c.keep[i] != 0) add(c.v[i], Wide::product(impulse.raw, line.d[i].raw), unit);
        add(c.u[i], Wide::product(impulse.raw, line.xc[i].raw), real);
    }
    if (wheel.ratio <= Real{}) return;
    const Real back = impulse * wheel.ratio;
    dynamics::SolverBody& g = bodies.body[wheel.ground];
    for (int i = 0; i < 3; ++i) {
        if (g.keep[i] != 0) add(g.v[i], Wide::product(-back.raw, line.d[i].raw), unit);
        add(g.u[i], Wide::product(back.raw, line.xg[i].raw), real);
    }
}

inline Real load_of(const Wheel& wheel) { return max(wheel.spring + wheel.stop + wheel.bars, Real{}); }

/// The most that each direction can hold: a tyre that slides shares its peak out along the slide.
struct TyreCaps {
    Real along, across;
};
TyreCaps tyre_caps(const Tyre& tyre, Real load, Real slide_along, Real slide_across);

/// Spin of a group that `torque` and its brake act on, if no tyre did.
Real braked_spin(const SpinGroup& group, Real spin);

/// A rim, its brake and its tyre solved together.
struct RimAnswer {
    Real impulse; ///< of the tyre on the chassis, forwards
    Real spin, give, slip;
    bool held; ///< by the brake
};
/// `free_spin`: of the rim without this tyre and without the brake; `patch`: speed of the chassis' patch without this
/// tyre; `ground_speed` for the slip.
RimAnswer turn_rim(const Vehicle& v, const Wheel& wheel, std::uint32_t index, Real free_spin, Real patch,
                   Real ground_speed, Real cap);
/// Spin of a wheel's group under its torque and all tyres but this one's, the brake left out.
Real free_spin(const Vehicle& v, std::uint32_t wheel, Real Wheel::*impulse);

} // namespace lockstone::sim
