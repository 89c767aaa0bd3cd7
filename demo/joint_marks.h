#pragma once
/// Joints as a viewer sees them: ropes and springs always, axes, limits and cones on demand.

#include "lockstone/world.h"
#include "render/frame.h"

#include <glm/mat4x4.hpp>

namespace lockstone::demo {

struct JointMark {
    BodyId body_a, body_b; ///< A may be null: the world
    JointKind kind;
    glm::mat4 frame_a, frame_b; ///< in the body's axes
    glm::vec3 ground_a, ground_b;
    AxisMode mode;      ///< of the axis that the kind turns or slides by
    float lower, upper; ///< of that axis
    float swing;        ///< [rad]
};
JointMark read_joint(const World& world, JointId joint);

/// `a`, `b`: poses of the bodies; of a body that is not there the identity.
void draw_line_joint(Frame& frame, const JointMark& joint, const glm::mat4& a, const glm::mat4& b);
/// An axis, an arc between limits with a hand that shows where B is, a cone; a line where the frames part.
void draw_joint(Frame& frame, const JointMark& joint, const glm::mat4& a, const glm::mat4& b);

} // namespace lockstone::demo
