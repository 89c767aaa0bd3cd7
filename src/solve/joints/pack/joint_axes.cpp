// Copies single axes of joints to the lanes of their packs, and impulses back.
#include "solve/joints/joint_work.h"

namespace lockstone::solve {

namespace {

/// Calls visit(axis, its AxisPack) for the axes of a joint in a pack.
template <class Visit> void for_axes(JointTick& tick, const JointWork& work, const Visit& visit) {
    const std::uint32_t first = tick.packs[work.pack].first_axis;
    for (std::uint32_t k = 0; k < work.axis_count; ++k)
        visit(tick.axes[work.first_axis + k], tick.axis_packs[first + k]);
}

void put_biases(const JointAxisPart& part, AxisPack& to, std::uint32_t lane) {
    const auto mask = [&](std::uint8_t feature) {
        return !part.idle && (part.features & feature) != 0 ? -1 : 0;
    };
    to.acts[lane] = part.idle ? 0 : -1;
    to.has_spring[lane] = mask(has_spring), to.has_motor[lane] = mask(has_motor);
    to.has_lower[lane] = mask(has_lower), to.has_upper[lane] = mask(has_upper);
    to.spring_bias[lane] = part.spring_bias, to.motor_bias[lane] = part.motor_bias;
    to.lower_bias[lane] = part.lower_bias, to.lower_relax[lane] = part.lower_relax;
    to.upper_bias[lane] = part.upper_bias, to.upper_relax[lane] = part.upper_relax;
}

/// Shifts in lanes are at least 1. If an axis turns so easily that its inverse exceeds that, it gets the largest
/// inverse.
void put_inverse(const Inverse& inverse, AxisPack& to, std::uint32_t lane) {
    constexpr std::int32_t most = (1 << 30) - 1;
    const bool fits = inverse.shift >= 1 && inverse.shift <= 62;
    to.inverse[lane] = fits ? inverse.m[0] : inverse.m[0] == 0 || inverse.shift > 62 ? 0 : most;
    to.shift[lane] = fits ? inverse.shift : 1;
}

void put_axis(const JointAxisPart& part, AxisPack& to, std::uint32_t lane) {
    put_biases(part, to, lane);
    to.spring[lane] = part.spring, to.motor[lane] = part.motor;
    to.lower[lane] = part.lower, to.upper[lane] = part.upper;
    if (part.unmade) return;
    for (int i = 0; i < 3; ++i) {
        to.ja[i][lane] = part.row.ja[i + 3], to.jb[i][lane] = part.row.jb[i + 3];
        to.ra[i][lane] = part.row.ra[i + 3], to.rb[i][lane] = part.row.rb[i + 3];
    }
    put_inverse(part.inverse, to, lane);
    to.spring_bound[lane] = part.spring_bound, to.motor_bound[lane] = part.motor_bound;
    to.mass_scale[lane] = part.mass_scale.raw, to.impulse_scale[lane] = part.impulse_scale.raw;
}

} // namespace

void put_axes(JointTick& tick, const JointWork& work) {
    for_axes(tick, work, [&](const JointAxisPart& part, AxisPack& to) { put_axis(part, to, work.lane); });
}

void put_axis_biases(JointTick& tick, const JointWork& work) {
    for_axes(tick, work, [&](const JointAxisPart& part, AxisPack& to) { put_biases(part, to, work.lane); });
}

void take_axes(JointTick& tick, const JointWork& work) {
    for_axes(tick, work, [&](JointAxisPart& part, AxisPack& from) {
        part.spring = from.spring[work.lane], part.motor = from.motor[work.lane];
        part.lower = from.lower[work.lane], part.upper = from.upper[work.lane];
        if (from.sum[work.lane] == 0) return;
        part.sum += unscaled_impulse(from.sum[work.lane], part.exponent);
        from.sum[work.lane] = 0;
    });
}

} // namespace lockstone::solve
