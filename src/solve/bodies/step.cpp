#include "solve/bodies/step.h"

#include "lockstone/math/math.h"

#include <algorithm>

namespace lockstone::solve {

static Softness softness(Real hertz, Real damping, std::int64_t substeps_per_second) {
    const Real omega = two_pi * hertz;
    const Real omega_h = omega / Real(substeps_per_second);
    const Real a1 = damping * 2 + omega_h;
    const Real a2 = omega_h * a1;
    const Real a3 = Real(1) / (Real(1) + a2);
    const Unit mass_scale = to<Unit>(a2 * a3), impulse_scale = to<Unit>(a3);
    const std::int64_t ratio =
        (std::int64_t{impulse_scale.raw} << Unit::fraction_bits) / std::max(mass_scale.raw, 1);
    return {to<Speed>(omega / a1), mass_scale, impulse_scale,
            Unit::from_raw(static_cast<std::int32_t>(std::min<std::int64_t>(ratio, unit_one.raw)))};
}

SpringSoftness spring_softness(Real hertz, Real damping, const StepConstants& step) {
    const Real omega = two_pi * hertz;
    const Real omega_h = omega / Real(step.substeps_per_second);
    const Real a1 = damping * 2 + omega_h;
    const Real a2 = omega_h * a1;
    const Real a3 = Real(1) / (Real(1) + a2);
    return {omega / a1, to<Unit>(a2 * a3), to<Unit>(a3)};
}

StepConstants step_constants(const StepSettings& s) {
    StepConstants c{};
    c.ticks_per_second = s.ticks_per_second;
    c.substeps = s.substeps;
    c.substeps_per_second = std::int64_t{s.ticks_per_second} * s.substeps;
    c.substep_time = to<Unit>(Real(1) / Real(c.substeps_per_second));
    c.tick_time = to<Unit>(Real(1) / Real(c.ticks_per_second));
    c.linear_speed_max = to<Speed>(min(linear_speed_limit, Real(15) * s.ticks_per_second));
    c.tip_speed_max = to<Speed>(min(tip_speed_limit, Real(2) * s.ticks_per_second));
    c.push_speed_max = to<Speed>(s.push_speed_max);
    // The relaxing pass takes the push out of the contact's own two bodies. The speed that joints passed on to the rest
    // of a figure stays: at full push speed, ragdolls that land on their feet have more energy than at the start.
    c.push_jointed = to<Speed>(s.push_speed_max / Real(10));
    c.restitution_speed_min = to<Speed>(s.restitution_speed_min);
    // With one pass a substep, towers on contacts stiffer than 3 / 16 of the substep rate do not come to rest.
    const Real hertz = min(s.contact_hertz, Real(c.substeps_per_second * 3) / Real(16));
    c.soft = softness(hertz, s.contact_damping, c.substeps_per_second);
    c.soft_static = softness(hertz * 2, s.contact_damping, c.substeps_per_second);
    // Rigid locks gain energy in chains that swing, more with a heavier end: one pass is not the exact solution, and no
    // later step takes the difference out. A spring that gives up a twentieth of its impulse in each substep does.
    c.joint = spring_softness(Real(c.substeps_per_second) / Real(4), Real(5), c);
    // A lock that pushes a body also turns it until relaxing takes the turn out, and a part stays: chains that whip
    // gain energy from 1 / 12 of the substep rate on. A tenth of a second is quick enough where substeps are few.
    const Real rate = Real(c.substeps_per_second);
    c.tree_rate = max(rate / Real(16), min(Real(10), rate / Real(6)));
    c.tree_load = Real(4);
    c.joint_push_max = Real(4);
    // The turn of links that whip at the end of a chain changes in every substep: with a larger prediction they part,
    // and pull the load up when they close.
    c.tree_arc_max = Real(1) / Real(10);
    return c;
}

} // namespace lockstone::solve
