#pragma once
/// The edges of shapes, to draw a body as a cage of lines.

#include "lockstone/asset.h"
#include "lockstone/command.h"

#include <glm/glm.hpp>

#include <utility>
#include <vector>

namespace lockstone::demo {

/// Both ends [m].
using Edge = std::pair<glm::vec3, glm::vec3>;

/// The outline in the body's frame: the sharp edges of boxes, hulls, meshes and compounds; rings and lines along round
/// shapes, which make rotation visible. Empty for a plane.
std::vector<Edge> outline_of(const ShapeDef& shape, const AssetLibrary& assets);

} // namespace lockstone::demo
