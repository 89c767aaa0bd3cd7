// The surface of a shape at a contact: that of the triangle's or cell's material, or the shape's own.
#pragma once

#include "scene/placed_shapes.h"

namespace lockstone::sim {

struct Touch {
    Real friction, restitution, rolling;
    Vec3 velocity; ///< in the shape's axes [m/s]
};
/// `piece`: index of a triangle or part, as in hits and manifolds.
Touch touch_of_piece(const ShapeTraits& shape, const shapes::Solid& solid, std::uint32_t piece);
inline Touch touch_of(const ShapeTraits& shape, const PlacedShapes::Shape& at, std::uint32_t piece) {
    if (at.has_pieces) return touch_of_piece(shape, at.solid, piece);
    return {shape.friction, shape.restitution, shape.rolling_resistance, shape.surface_velocity};
}
/// The part of a living shape; the tick or a query must have resolved its solid.
SurfacePart part_of(const Model& w, const PlacedShapes& s, ShapeId shape, std::uint32_t piece);

} // namespace lockstone::sim
