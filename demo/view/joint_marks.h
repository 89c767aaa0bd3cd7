#pragma once
/// Draws joints: rods, ropes, springs and pulleys always; axes, limits, cones and gears on demand.

#include "lockstone/world.h"
#include "render/frame.h"

#include <glm/mat4x4.hpp>

#include <array>

namespace lockstone::demo {

namespace joint_colour {
inline const glm::vec3 axis{1.0f, 0.55f, 0.1f}, ///< axes about which B may turn or along which it may slide
    limit{0.3f, 0.85f, 1.0f},                   ///< bars, arcs and cones between limits
    hand{1.0f, 0.95f, 0.4f},                    ///< the position of B between its limits
    spring{0.55f, 0.9f, 0.35f}, rope{0.16f, 0.13f, 0.1f}, ///< `rope` also for rods
    /// `gap`: the distance by which locked axes have separated.
    gear{0.9f, 0.5f, 0.95f}, gap{1.0f, 0.1f, 0.2f};
} // namespace joint_colour

constexpr float joint_reach = 0.25f; ///< length of axes and arcs from a joint's position [m]

struct JointMark {
    /// An axis of A's frame: [m] along it or [rad] about it.
    struct Axis {
        AxisMode mode;
        float lower, upper; ///< of a limited axis
        bool has_spring;    ///< also for a soft lock
        float target;       ///< of the spring
    };
    BodyId body_a, body_b; ///< A may be null: the world
    JointKind kind;
    glm::mat4 frame_a, frame_b; ///< in the axes of the bodies
    glm::vec3 ground_a, ground_b;
    std::array<Axis, joint_axis_count> axis;
    float swing; ///< [rad]
    float ratio;
};
JointMark read_joint(const World& world, JointId joint);

/// Draws the part of a joint that connects the bodies. `a`, `b`: poses of the bodies; the identity if a body does not
/// exist.
void draw_line_joint(Frame& frame, const JointMark& joint, const glm::mat4& a, const glm::mat4& b);
/// Draws each axis that is not locked, with its limits, its spring and a hand at the position of B; a cone; wheels of a
/// gear; and a line for the gap of locked axes.
void draw_joint(Frame& frame, const JointMark& joint, const glm::mat4& a, const glm::mat4& b);

} // namespace lockstone::demo
