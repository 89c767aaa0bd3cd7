#include "scene/surface.h"

#include "shapes/mesh/surfaces.h"

namespace lockstone::sim {

Touch touch_of_piece(const ShapeTraits& shape, const shapes::Solid& solid, std::uint32_t piece) {
    if (const MaterialSurface* s = shapes::piece_of(solid, piece).surface; s != nullptr)
        return {s->friction, s->restitution, s->rolling_resistance, s->surface_velocity};
    return {shape.friction, shape.restitution, shape.rolling_resistance, shape.surface_velocity};
}

SurfacePart part_of(const Model& w, const PlacedShapes& s, ShapeId shape, std::uint32_t piece) {
    const shapes::Piece p = shapes::piece_of(s.shape[shape.index - 1].solid, piece);
    return {p.source,
            p.material != 0 ? p.material : w.traits_of(w.state.rows(w.m.shape)[w.row_of(shape)]).material};
}

} // namespace lockstone::sim
