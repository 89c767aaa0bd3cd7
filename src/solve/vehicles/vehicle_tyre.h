// A tyre, and a rim between its brake and its tyre. Number is Real, or Small for a small wheel; both give the same
// bits.
#pragma once

#include "solve/vehicles/vehicle_lines.h"

#include "lockstone/math/math.h"

namespace lockstone::solve {

/// The slide of a patch. A tyre shares its peak between the two directions of the slide: the share of a direction is
/// (own + rest) / (slide + rest). At rest both directions have their full peaks.
template <class Number> struct TyreSlide {
    static constexpr Real rest = 0.1_r; ///< [m/s]: above it the slide decides
    Number own, other; ///< slides along this direction and across it, at least 0, plus rest [m/s]
    Number both;       ///< the sum of both slides plus rest
    static TyreSlide make(Number own, Number other) {
        const Number more = number<Number>(rest);
        return {own + more, other + more, own + other + more};
    }
    TyreSlide turned() const { return {other, own, both}; }
};

/// Impulse of a tyre against its slide.
template <class Number> struct TyreAnswer {
    Number impulse; ///< at least 0, against the slide
    Number gain; ///< change of the impulse per slide, with the mobility kappa_gain; 0 where the tyre slides
    Real slip;
};
enum class TyreAsks { impulse, gain, slip };

/// A tyre problem: find the q >= 0 with q = load grip(s), s = (slide - kappa q) / speed, that has the least slip,
/// limited to the share of the peak at this slide. `slide` >= 0 is the slide of the patch without q. A speed of 0 is
/// rest: the tyre sticks up to the peak of the curve.
template <class Number, TyreAsks asks> struct TyreQuestion {
    const TyreCurve& curve;
    Number load, most; ///< load times the peak of the curve
    TyreSlide<Number> slides;
    Number kappa_gain; ///< the mobility for TyreAnswer::gain
};

/// The share of the peak for a direction while a tyre slides. At most 1, although the rounding of the slide's length
/// could make it more.
Real share_of_peak(Real own, Real other);

/// Slip of a tyre where the curve does not determine it.
template <TyreAsks asks, class Number>
Real slip_of(Number slide, Number kappa, Number impulse, Number speed) {
    if (asks != TyreAsks::slip || speed.raw <= 0) return Real{};
    return quotient(real(slide - kappa * impulse), real(speed));
}

/// The impulse of a tyre that sticks, slips along its curve, or slides beyond the end of the curve.
template <class Number, TyreAsks asks>
[[gnu::always_inline]] inline TyreAnswer<Number> on_curve(const TyreQuestion<Number, asks>& tyre,
                                                          Number slide, Number kappa, Number speed) {
    // g(s) = slide - kappa load grip(s) - speed s falls where the curve rises; the tyre clings at the first root of g.
    const TyreCurve& curve = tyre.curve;
    const Number stiff = kappa * tyre.load;
    Number before = slide;
    if (!curve.from_zero) {
        before = before - stiff * number<Number>(curve.y[0]) - speed * number<Number>(curve.x[0]);
        if (before.raw <= 0) // it sticks, or slips below the first corner, where the curve is level
            return {
                number<Number>(
                    min(quotient(real(slide), real(kappa)), real(tyre.load * number<Number>(curve.y[0])))),
                number<Number>(asks == TyreAsks::gain ? quotient(Real(1), real(tyre.kappa_gain)) : Real{}),
                Real{}};
    }
    for (std::size_t i = 0; i < curve.run.size(); ++i) {
        const Number rise = number<Number>(curve.rise[i]), run = number<Number>(curve.run[i]);
        const Number fall = stiff * rise + speed * run;
        if (before > fall) {
            before = before - fall;
            continue;
        }
        const std::int64_t share = share_of(before.raw, fall.raw);
        TyreAnswer<Number> out{tyre.load * (number<Number>(curve.y[i]) + part_of(rise, share)), {}, {}};
        if (asks == TyreAsks::slip) out.slip = curve.x[i] + real(part_of(run, share));
        if (asks != TyreAsks::gain || rise.raw <= 0) return out;
        const Number lifts = tyre.load * rise, yields = tyre.kappa_gain * lifts + speed * run;
        if (yields.raw > 0) out.gain = number<Number>(quotient(real(lifts), real(yields)));
        return out;
    }
    const Number impulse = tyre.load * number<Number>(curve.y.back());
    return {impulse, {}, slip_of<asks>(slide, kappa, impulse, speed)};
}

template <class Number, TyreAsks asks>
[[gnu::always_inline]] inline TyreAnswer<Number> tyre_answer(const TyreQuestion<Number, asks>& tyre,
                                                             Number slide, Number kappa, Number speed) {
    if (tyre.load.raw <= 0 || slide.raw <= 0 || kappa.raw <= 0)
        return {{}, {}, slip_of<asks>(slide, kappa, Number{}, speed)};
    const TyreAnswer<Number> out = on_curve(tyre, slide, kappa, speed);
    // A test without a root and a quotient, which most tyres pass: the slide is at most the sum of its two parts.
    if (out.impulse * tyre.slides.both <= tyre.most * tyre.slides.own) return out;
    const Number cap =
        tyre.most * number<Number>(share_of_peak(real(tyre.slides.own), real(tyre.slides.other)));
    if (out.impulse <= cap) return out;
    return {cap, {}, slip_of<asks>(slide, kappa, cap, speed)};
}

/// A rim, its brake and its tyre solved together.
template <class Number> struct RimAnswer {
    Number impulse; ///< of the tyre on the chassis, forwards
    Number spin, gain;
    Real slip;
    bool held; ///< the brake holds the rim
};
/// `free`: spin of the rim without this tyre and without the brake; `patch`: speed of the chassis' patch without this
/// tyre; `speed`: speed over the ground, for the slip.
template <class Number, TyreAsks asks>
RimAnswer<Number> turn_rim(const SpinGroup& g, const Wheel& wheel, Number free, Number patch, Number speed,
                           const TyreQuestion<Number, asks>& tyre) {
    const Number arm = number<Number>(wheel.arm), brake = number<Number>(g.brake_spin);
    // First the brake holds the rim, if it can; then only the chassis changes its speed. It does not hold a rim that no
    // tyre could stop.
    Number rest = free;
    if (abs(free) <= brake + number<Number>(wheel.arm_most)) {
        TyreAnswer<Number> held = tyre_answer(tyre, abs(patch), number<Number>(wheel.along.kappa), speed);
        if (patch.raw > 0) held.impulse = -held.impulse, held.slip = -held.slip; // against the slide
        rest = free - arm * held.impulse;
        if (abs(rest) <= brake) return {held.impulse, {}, held.gain, held.slip, true};
    }
    const Number braked = rest.raw > 0 ? free - brake : free + brake;
    const Number slide = patch - braked * number<Number>(wheel.radius);
    TyreAnswer<Number> turning = tyre_answer(tyre, abs(slide), number<Number>(wheel.kappa_rim), speed);
    // A rim that is faster than the ground drives the chassis: its slip is positive.
    if (slide.raw > 0) turning.impulse = -turning.impulse, turning.slip = -turning.slip;
    return {turning.impulse, braked - arm * turning.impulse, turning.gain, turning.slip, false};
}

/// Spin of a group under its torque and its brake, without its tyres.
inline Real braked_spin(const SpinGroup& group, Real spin) {
    const Real most = group.brake_spin;
    return spin > most ? spin - most : spin < -most ? spin + most : Real{};
}
/// Spin of a wheel's group under its torque and all tyres except this one, without the brake. shared_spin() is for
/// groups of several wheels, free_spin() for any group.
Real shared_spin(const Vehicle& v, std::uint32_t wheel, Real Wheel::*impulse);
inline Real free_spin(const Vehicle& v, const SpinGroup& g, std::uint32_t wheel, Real Wheel::*impulse) {
    return g.on_ground == 1 ? g.free : shared_spin(v, wheel, impulse);
}
/// Sets the spin of a group under its torque, without tyres and brake. Call it also when the brake has changed.
inline void set_free(SpinGroup& g, Real free) {
    constexpr std::int64_t most = Real(1 << 16).raw;
    g.free = free;
    g.small = abs(g.free).raw < most && abs(g.spin).raw < most && g.brake_spin.raw < most;
}

} // namespace lockstone::solve
