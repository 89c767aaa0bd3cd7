// A motor or a spring that pushes a body against a limit of its joint. For the tests and for the planted faults.
#pragma once

#include "support/sim_scenes.h"

#include <string>

namespace lockstone::test {

struct LimitedDrive {
    double force; ///< [N] or [N m]
    double mass;  ///< [kg]
    bool slides;  ///< along an axis, not about one
    bool has_motor, has_spring;
};

/// Drives an arm for two seconds. Returns a sentence if it exceeds its limit of 0.8 m or rad by more than 0.02 at any
/// tick.
inline std::string limit_fault(const LimitedDrive& drive) {
    World w = scene::made(World::create(WorldDef{})); // four substeps: the largest impulses
    BodyDef arm{.pose = scene::at(0.5, 0, 0)};
    arm.mass = scene::real(drive.mass);
    const BodyId body = scene::add(w, arm, {.geometry = box(0.5_r, 0.1_r, 0.1_r)});
    const JointAxisIndex index = drive.slides ? along_x : about_x;
    JointDef def = drive.slides ? slider_joint() : hinge_joint();
    JointAxis& axis = def.axis[index];
    axis.mode = AxisMode::limited, axis.lower = scene::real(-0.8), axis.upper = scene::real(0.8);
    if (drive.has_spring)
        axis.spring = 1, axis.frequency = Real(1000), axis.damping_ratio = Real(1), axis.target = Real(3),
        axis.spring_force = scene::real(drive.force);
    if (drive.has_motor) axis.motor_speed = Real(20), axis.motor_force = scene::real(drive.force);
    const Transform frame =
        drive.slides ? scene::at(0, 0, 0) : scene::at(0, 0, 0, scene::turned(scene::axis_y, 90));
    const JointId joint = scene::made(w.create_joint(def, BodyId{}, body, frame));
    double most = -1;
    for (int t = 0; t < 120; ++t) {
        w.tick();
        most = std::max(most, to_double(w.joint_state(joint).position[index]) - 0.8);
    }
    return most <= 0.02 ? ""
                        : "a drive of " + std::to_string(drive.force) + " presses " +
                              std::to_string(drive.mass) + " kg beyond its limit by " + std::to_string(most);
}

/// Tests every force that a joint may have, on light and on heavy bodies.
inline std::string limits_fault() {
    for (const double force : {1e2, 1e4, 3e5, 1e6, 1e8, 2e9})
        for (const double mass : {0.01, 1.0, 100.0, 1e4})
            for (const bool slides : {false, true})
                for (const int drives : {1, 2, 3})
                    if (std::string fault =
                            limit_fault({force, mass, slides, (drives & 1) != 0, (drives & 2) != 0});
                        !fault.empty())
                        return fault;
    return {};
}

} // namespace lockstone::test
