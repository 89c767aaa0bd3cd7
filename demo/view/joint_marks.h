#pragma once
/// Joints as a viewer sees them: rods, ropes, springs and pulleys always, axes, limits, cones and gears on demand.

#include "lockstone/world.h"
#include "render/frame.h"

#include <glm/mat4x4.hpp>

#include <array>

namespace lockstone::demo {

namespace joint_colour {
inline const glm::vec3 axis{1.0f, 0.55f, 0.1f},           ///< that B may turn about or slide along
    limit{0.3f, 0.85f, 1.0f},                             ///< bars, arcs and cones between limits
    hand{1.0f, 0.95f, 0.4f},                              ///< where B is between them
    spring{0.55f, 0.9f, 0.35f}, rope{0.16f, 0.13f, 0.1f}, ///< and rods
    gear{0.9f, 0.5f, 0.95f}, gap{1.0f, 0.1f, 0.2f};       ///< by which locked axes are parted
} // namespace joint_colour

constexpr float joint_reach = 0.25f; ///< of axes and arcs from a joint's place [m]

struct JointMark {
    /// In m along, in rad about an axis of A's frame.
    struct Axis {
        AxisMode mode;
        float lower, upper; ///< of a limited one
        bool has_spring;    ///< or is a lock that gives
        float target;       ///< of the spring
    };
    BodyId body_a, body_b; ///< A may be null: the world
    JointKind kind;
    glm::mat4 frame_a, frame_b; ///< in the body's axes
    glm::vec3 ground_a, ground_b;
    std::array<Axis, joint_axis_count> axis;
    float swing; ///< [rad]
    float ratio;
};
JointMark read_joint(const World& world, JointId joint);

/// What goes from body to body. `a`, `b`: poses of the bodies; of a body that is not there the identity.
void draw_line_joint(Frame& frame, const JointMark& joint, const glm::mat4& a, const glm::mat4& b);
/// Each axis that is not locked, with its limits, its spring and a hand that shows where B is; a cone; wheels in gear; a line
/// where locked axes part.
void draw_joint(Frame& frame, const JointMark& joint, const glm::mat4& a, const glm::mat4& b);

} // namespace lockstone::demo
