// What the rows of wheels share: their speeds and impulses, and a rim between its brake and its tyre. See vehicle.h.
#pragma once

#include "play/vehicle/vehicle.h"

namespace lockstone::sim {

/// floor(w / 2^shift + 1/2) of a w whose result is below 2^62: nothing is clamped.
constexpr std::int64_t narrow_small(Wide w, int shift) {
    return (static_cast<std::int64_t>((w >> (shift - 1)).low_bits()) + 1) >> 1;
}

/// What a wheel's rows read of its two bodies, in raw steps of a Real.
struct PatchMotion {
    std::int64_t v[3];         ///< of the chassis over the ground, its surface left out [m/s]
    std::int64_t uc[3], ug[3]; ///< tip speeds; of a ground that stands still zero
    bool stands;               ///< the ground
};

inline PatchMotion motion_of(const Wheel& wheel, const solve::SolverBodies& bodies, std::uint32_t chassis) {
    constexpr int down = solve::accumulator_bits - Real::fraction_bits;
    const auto real = [](std::int64_t x) { return shift_right_rounded(x, down); };
    const solve::SolverBody &c = bodies.body[chassis], &g = bodies.body[wheel.ground];
    PatchMotion out{};
    out.stands = wheel.ground == bodies.still();
    for (int i = 0; i < 3; ++i) {
        out.v[i] = real(c.v[i]) - wheel.surface[i].raw;
        out.uc[i] = real(c.u[i]);
        if (out.stands) continue;
        out.v[i] -= real(g.v[i]);
        out.ug[i] = real(g.u[i]);
    }
    return out;
}

/// Speed of the chassis' patch over the ground along a line [m/s]. No velocity is above 2^12 m/s and no arm above 2^6: sums stay
/// below 2^84, and what they are rounded to below 2^52.
inline Real line_speed(const PatchMotion& motion, const WheelLine& line) {
    Wide along = Wide::from(0), turning = along;
    for (int i = 0; i < 3; ++i) {
        along = along + Wide::product(motion.v[i], line.d[i].raw);
        turning = turning + Wide::product(motion.uc[i], line.xc[i].raw);
    }
    for (int i = 0; i < 3 && !motion.stands; ++i)
        turning = turning + Wide::product(motion.ug[i], line.xg[i].raw);
    return Real::from_raw(narrow_small(along, Unit::fraction_bits) +
                          narrow_small(turning, Real::fraction_bits));
}
inline Real line_speed(const Wheel& wheel, const WheelLine& line, const solve::SolverBodies& bodies,
                       std::uint32_t chassis) {
    return line_speed(motion_of(wheel, bodies, chassis), line);
}

/// Adds an impulse along d, and turning along x, to a body; narrow(product, shift) rounds. Velocities stay within 2048 m/s, where the
/// rows of contacts can read them.
template <class Narrow>
void push_body(solve::SolverBody& body, UnitVec3 d, Vec3 x, std::int64_t moves, std::int64_t turns,
               Narrow&& narrow) {
    constexpr std::int64_t most = std::int64_t{2048} << solve::accumulator_bits;
    constexpr int unit = Real::fraction_bits + Unit::fraction_bits - solve::accumulator_bits;
    constexpr int real = 2 * Real::fraction_bits - solve::accumulator_bits;
    const auto add = [](std::int64_t& v, std::int64_t change) {
        const std::int64_t sum = add_saturated(v, change);
        v = sum > most ? most : sum < -most ? -most : sum;
    };
    for (int i = 0; i < 3; ++i) {
        if (body.keep[i] != 0) add(body.v[i], narrow(Wide::product(moves, d[i].raw), unit));
        add(body.u[i], narrow(Wide::product(turns, x[i].raw), real));
    }
}
/// The same, quick below 256 m/s: an arm is at most 2^6, so a product stays below 2^78.
inline void push_body(solve::SolverBody& body, UnitVec3 d, Vec3 x, Real moves, Real turns) {
    if (abs(moves) < Real(256)) [[likely]]
        push_body(body, d, x, moves.raw, turns.raw, [](Wide w, int shift) { return narrow_small(w, shift); });
    else
        push_body(body, d, x, moves.raw, turns.raw,
                  [](Wide w, int shift) { return narrow_rounded(w, shift); });
}

/// Adds an impulse along a line to the chassis, and against it to the ground.
inline void push_line(const Wheel& wheel, const WheelLine& line, Real impulse, solve::SolverBodies& bodies,
                      std::uint32_t chassis) {
    push_body(bodies.body[chassis], line.d, line.xc, impulse, impulse);
    if (wheel.ratio <= Real{}) return;
    const Real back = impulse * wheel.ratio;
    push_body(bodies.body[wheel.ground], line.d, line.xg, -back, back);
}

inline Real load_of(const Wheel& wheel) { return max(wheel.spring + wheel.stop + wheel.bars, Real{}); }

/// How the patch slides over the ground, along and across; at least 0 [m/s].
struct TyreSlide {
    Real along, across;
};
/// What is left of a direction's peak for a tyre that slides `own` along it and `other` across it: the tyre shares its
/// peak out along the slide. At rest both directions hold their peaks.
Real share_of_peak(Real own, Real other);

/// Impulse of a tyre against a slide.
struct TyreAnswer {
    Real impulse; ///< at least 0, against the slide
    Real give;    ///< slide per impulse beside kappa: 0 where it sticks, the largest Real where it slides
    Real slip;
};
/// The q >= 0 with q = load grip(s), s = (slide - kappa q) / speed, that has the least slip; at most what is left of the peak when the
/// tyre slides `own` along and `other` across. `slide` >= 0 is what the patch does without q. A speed of 0 is rest: the
/// tyre sticks while the peak of the curve lasts. `peak` is the curve's; the give is found only when it is asked for.
struct TyreQuestion {
    const std::array<CurvePoint, 4>& curve;
    Real peak, load, own, other;
    bool asks_give;
};
TyreAnswer tyre_answer(const TyreQuestion& tyre, Real slide, Real kappa, Real speed);

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
RimAnswer turn_rim(const Vehicle& v, const Wheel& wheel, const WheelDef& def, Real free_spin, Real patch,
                   Real ground_speed, const TyreQuestion& tyre);
/// Spin of a wheel's group under its torque and all tyres but this one's, the brake left out.
Real free_spin(const Vehicle& v, std::uint32_t wheel, Real Wheel::*impulse);
/// The torque of a group has changed.
inline void set_free(SpinGroup& g) { g.free = g.spin_begin + g.torque / g.inertia; }

} // namespace lockstone::sim
