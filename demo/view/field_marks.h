#pragma once
/// Fields as a viewer sees them: water by its surface.

#include "lockstone/world.h"
#include "render/frame.h"

#include <glm/mat4x4.hpp>

namespace lockstone::demo {

struct FieldMark {
    bool is_water;     ///< a fluid that bears, in a box: it has a surface
    glm::mat4 surface; ///< the place of its middle, y upwards
    glm::vec2 half;    ///< along x and z [m]
};
FieldMark read_field(const World& world, FieldId field);

/// A net on the surface of water, with its rim.
void draw_field(Frame& frame, const FieldMark& field);

} // namespace lockstone::demo
