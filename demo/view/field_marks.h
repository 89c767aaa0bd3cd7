#pragma once
/// Draws fields. Water is drawn by its surface.

#include "lockstone/world.h"
#include "render/frame.h"

#include <glm/mat4x4.hpp>

namespace lockstone::demo {

struct FieldMark {
    bool is_water;     ///< a fluid with buoyancy in a box, which has a surface
    glm::mat4 surface; ///< the pose of the surface's centre, y upwards
    glm::vec2 half;    ///< along x and z [m]
};
FieldMark read_field(const World& world, FieldId field);

/// Draws a net on the surface of water, and its rim.
void draw_field(Frame& frame, const FieldMark& field);

} // namespace lockstone::demo
