// The floors for the objects: all have their surface at y = 0 and extend at least 60 m.
#pragma once

#include "lockstone/asset.h"
#include "lockstone/world.h"

#include <memory>

namespace lockstone::zoo {

/// `slab` is a box of 2 cm, `sheet` a mesh with two sides: a body that passes through one of them keeps falling.
enum class Floor { plane, box, seam, parts, hull, mesh, height_field, slab, sheet };
inline constexpr int floor_count = 7; ///< the thick ones
inline constexpr int all_floor_count = 9;
const char* name_of(Floor floor);

/// A new library with the assets of all floors.
std::shared_ptr<AssetLibrary> floor_library();
void add_floor(World& w, Floor floor, Vec3 offset);

} // namespace lockstone::zoo
