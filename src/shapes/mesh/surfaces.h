// What triangles are made of and what they were before baking; their surfaces as an asset's bytes hold them.
#pragma once

#include "base/bytes.h"
#include "shapes/asset/asset.h"

namespace lockstone::shapes {

/// A triangle of a mesh or height field, or a part of a compound.
struct Piece {
    std::uint32_t source;   ///< index in MeshDef::triangles, cell of a height field, part of a compound
    std::uint32_t material; ///< 0: none
    const MaterialSurface* surface; ///< null: that of the shape
};
/// By index as in hits and manifolds; all 0 for other solids, and for an index that the solid has not.
Piece piece_of(const Solid& solid, std::uint32_t index);
/// Of a triangle: 1 + its place among the asset's surfaces, 0: that of the shape. Contacts of different ones stay apart.
std::uint32_t surface_number(const Solid& solid, std::uint32_t triangle);

/// What is wrong with a list of surfaces, or nothing.
std::string complaint_of_surfaces(std::span<const MaterialSurface> surfaces);
void write_surfaces(base::ByteWriter& out, std::span<const MaterialSurface> surfaces);
std::vector<MaterialSurface> read_surfaces(base::ByteReader& in);

} // namespace lockstone::shapes
