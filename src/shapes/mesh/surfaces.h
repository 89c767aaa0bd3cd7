// The materials and source indices of triangles, and the format of surfaces in an asset's bytes.
#pragma once

#include "base/bytes.h"
#include "shapes/asset/asset.h"

namespace lockstone::shapes {

/// A triangle of a mesh or height field, or a part of a compound.
struct Piece {
    std::uint32_t source;   ///< index in MeshDef::triangles, cell of a height field, part of a compound
    std::uint32_t material; ///< 0: none
    const MaterialSurface* surface; ///< null: the shape's own surface
};
/// The piece of an index as in hits and manifolds. All 0 for other solids, and for an index out of range.
Piece piece_of(const Solid& solid, std::uint32_t index);
/// 1 + index of the triangle's surface in the asset's list; 0: the shape's own surface. Contacts of different
/// surfaces are not merged.
std::uint32_t surface_number(const Solid& solid, std::uint32_t triangle);

/// Returns the error in a list of surfaces, or an empty string.
std::string complaint_of_surfaces(std::span<const MaterialSurface> surfaces);
void write_surfaces(base::ByteWriter& out, std::span<const MaterialSurface> surfaces);
std::vector<MaterialSurface> read_surfaces(base::ByteReader& in);

} // namespace lockstone::shapes
