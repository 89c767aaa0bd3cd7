// Every kind of joint with a name of its own: the kinds, and further names for some tables of them.
#pragma once

#include "support/rigs/joint_scenes.h"

namespace lockstone::test::scene {

struct JointVariant {
    const char* name;
    JointDef def;
    std::uint32_t taken; ///< degrees of freedom that the pair loses
};

/// Springs are so slow that they have no effect within a tick.
inline std::vector<JointVariant> joint_variants() {
    const Real slow = real(0.01);
    JointDef cone = ball_joint();
    cone.swing = real(1);
    cone.axis[about_x] = {.mode = AxisMode::limited, .lower = real(-1), .upper = real(1)};
    JointDef steered = wheel_joint(slow, Real(1));
    steered.axis[about_y].mode = AxisMode::free;
    JointDef planar = six_dof_joint();
    for (const std::uint32_t i : {along_z, about_x, about_y}) planar.axis[i].mode = AxisMode::locked;
    JointDef slack = pulley_joint(vec(-1, 3, 0), vec(1, 3, 0), Real(6));
    slack.axis[along_x] = {.mode = AxisMode::limited, .upper = Real(7)};
    return {{"six_dof", six_dof_joint(), 0},
            {"six_dof, planar", planar, 3},
            {"ball", ball_joint(), 3},
            {"ball within cone and twist", cone, 3},
            {"hinge", hinge_joint(), 5},
            {"slider", slider_joint(), 5},
            {"weld", weld_joint(), 6},
            {"weld, soft", weld_joint(slow), 0},
            {"wheel", wheel_joint(slow, Real(1)), 4},
            {"wheel, steered", steered, 3},
            {"motor", motor_joint(slow, Real(50000), Real(20000)), 0},
            {"mouse", mouse_joint(slow, Real(50000)), 0},
            {"distance", distance_joint(Real(1)), 1},
            {"rope, slack", rope_joint(Real(2)), 0},
            {"spring", spring_joint(Real(1), slow, Real(1)), 0},
            {"pulley", pulley_joint(vec(-1, 3, 0), vec(1, 3, 0), Real(6)), 1},
            {"pulley, slack", slack, 0},
            {"gear", gear_joint(Real(2)), 1},
            {"rack_and_pinion", rack_and_pinion_joint(Real(2)), 1}};
}

} // namespace lockstone::test::scene
