// The kinds of joints as tables of six axes.
#include "lockstone/joint.h"

namespace lockstone {

namespace {

constexpr JointAxis free_axis{.mode = AxisMode::free};

JointDef all_free(JointKind kind) {
    JointDef d{};
    d.kind = kind;
    d.axis.fill(free_axis);
    return d;
}

JointAxis spring_axis(Real frequency, Real force_max) {
    return {.mode = AxisMode::free, .spring = 1, .frequency = frequency, .spring_force = force_max};
}

} // namespace

JointDef six_dof_joint() { return all_free(JointKind::six_dof); }

JointDef ball_joint() {
    JointDef d{};
    d.kind = JointKind::ball;
    d.axis[about_x] = d.axis[about_y] = d.axis[about_z] = free_axis;
    return d;
}

JointDef hinge_joint() {
    JointDef d{};
    d.kind = JointKind::hinge;
    d.axis[about_x] = free_axis;
    return d;
}

JointDef slider_joint() {
    JointDef d{};
    d.kind = JointKind::slider;
    d.axis[along_x] = free_axis;
    return d;
}

JointDef weld_joint(Real frequency, Real damping_ratio) {
    JointDef d{};
    d.kind = JointKind::weld;
    for (JointAxis& a : d.axis) a.frequency = frequency, a.damping_ratio = damping_ratio;
    return d;
}

JointDef wheel_joint(Real frequency, Real damping_ratio) {
    JointDef d{};
    d.kind = JointKind::wheel;
    d.axis[along_y] = {
        .mode = AxisMode::free, .spring = 1, .frequency = frequency, .damping_ratio = damping_ratio};
    d.axis[about_x] = free_axis;
    return d;
}

JointDef motor_joint(Real frequency, Real force_max, Real torque_max) {
    JointDef d{};
    d.kind = JointKind::motor;
    for (std::uint32_t i = 0; i < joint_axis_count; ++i)
        d.axis[i] = spring_axis(frequency, i < about_x ? force_max : torque_max);
    return d;
}

JointDef mouse_joint(Real frequency, Real force_max) {
    JointDef d = all_free(JointKind::mouse);
    for (std::uint32_t i = along_x; i <= along_z; ++i) d.axis[i] = spring_axis(frequency, force_max);
    return d;
}

JointDef distance_joint(Real length) {
    JointDef d = all_free(JointKind::distance);
    d.axis[along_x] = {.mode = AxisMode::locked, .target = length};
    return d;
}

JointDef rope_joint(Real length) {
    JointDef d = all_free(JointKind::distance);
    d.axis[along_x] = {.mode = AxisMode::limited, .upper = length};
    return d;
}

JointDef spring_joint(Real length, Real frequency, Real damping_ratio) {
    JointDef d = all_free(JointKind::distance);
    d.axis[along_x] = {.mode = AxisMode::free,
                       .spring = 1,
                       .frequency = frequency,
                       .damping_ratio = damping_ratio,
                       .target = length};
    return d;
}

JointDef pulley_joint(Vec3 ground_a, Vec3 ground_b, Real total_length, Real ratio) {
    JointDef d = all_free(JointKind::pulley);
    d.axis[along_x] = {.mode = AxisMode::locked, .target = total_length};
    d.ground_a = ground_a, d.ground_b = ground_b, d.ratio = ratio;
    return d;
}

JointDef gear_joint(Real ratio) {
    JointDef d = all_free(JointKind::gear);
    d.ratio = ratio;
    return d;
}

JointDef rack_and_pinion_joint(Real radians_per_metre) {
    JointDef d = all_free(JointKind::rack_and_pinion);
    d.ratio = radians_per_metre;
    return d;
}

const char* name_of(JointKind kind) {
    constexpr const char* names[] = {"six_dof", "ball",  "hinge",    "slider", "weld", "wheel",
                                     "motor",   "mouse", "distance", "pulley", "gear", "rack_and_pinion"};
    const auto i = static_cast<std::uint32_t>(kind);
    return i < sizeof names / sizeof names[0] ? names[i] : "unknown";
}

} // namespace lockstone
