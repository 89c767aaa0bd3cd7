// Splits solids into the pieces that closest_points takes: convex shapes, triangles and planes.
#pragma once

#include "collide/convex/convex.h"
#include "collide/query/cast_line.h"
#include "shapes/mesh/face.h"

#include <type_traits>

namespace lockstone::collide {

/// A convex piece of a solid, in that solid's frame.
struct Obstacle {
    enum class Kind : std::uint8_t { convex, triangle, plane };
    Kind kind;
    std::uint32_t feature;        ///< index of the part or triangle; else 0
    const shapes::Solid* solid;   ///< of a convex piece or a plane
    const Transform* place;       ///< pose of a part; else null
    const shapes::Face* triangle; ///< of a triangle; else null
    bool one_sided;               ///< of a triangle; else false
};

/// The gap between an obstacle and a convex shape, including the radii of their rounding.
struct Between {
    bool overlap;    ///< distance_30 <= 0; normal and point are then valid only if the cores are apart
    Long3 normal_30; ///< from the obstacle to the shape, in the obstacle's frame
    std::int64_t distance_30; ///< [m]; negative when they overlap, and then exact only if the cores are apart
    Long3 on_obstacle_30;     ///< from the shape's origin; nearest point of the obstacle's surface
};
/// The origin of `shape` is at `position_24` in the frame of the obstacle's solid. shape.center_24 counts from
/// that origin. May stop early above `limit_30`, as closest_points_within does.
Between between(const Obstacle& obstacle, const Convex& shape, Long3 position_24, std::int64_t limit_30);

/// Box of a convex shape around its origin, in the axes of the working frame.
struct Box {
    Long3 lower_24, upper_24;
};
Box box_of(const Convex& shape);

/// The bounds of a ball that moves from `from` to `to`.
shapes::Extent swept_extent(Long3 from_24, Long3 to_24, std::int64_t radius_24);

/// The bounds of a box that moves from `from` to `to`, larger by `guard_24` on all sides.
shapes::Extent swept_extent(Long3 from_24, Long3 to_24, const Box& box, std::int64_t guard_24);

/// Calls visit(obstacle) for the pieces of a solid whose extents overlap `where`, in ascending order of
/// feature. Stops where visit() returns false; visit() may also return nothing.
template <class Visit>
void for_each_obstacle(const shapes::Solid& solid, const shapes::Extent& where, NarrowScratch& scratch,
                       Visit&& visit) {
    Obstacle o{Obstacle::Kind::convex, 0, &solid, nullptr, nullptr, false};
    const auto goes_on = [&visit](const Obstacle& piece) {
        if constexpr (std::is_void_v<std::invoke_result_t<Visit&, const Obstacle&>>)
            return visit(piece), true;
        else
            return visit(piece);
    };
    if (has_triangles(solid)) {
        o.kind = Obstacle::Kind::triangle;
        o.one_sided = !shapes::is_two_sided(solid);
        scratch.triangles.clear();
        shapes::find_triangles(solid, where, scratch.triangles);
        for (const std::uint32_t index : scratch.triangles) {
            const shapes::Face triangle = shapes::face_at(solid, index);
            o.feature = index;
            o.triangle = &triangle;
            if (!goes_on(o)) return;
        }
    } else if (solid.geometry.kind == ShapeKind::compound) {
        scratch.parts.clear();
        solid.compound->find(where, scratch.parts);
        for (const std::uint32_t index : scratch.parts) {
            const shapes::Compound::Part& part = solid.compound->parts[index];
            o.feature = index;
            o.solid = &part.solid;
            o.place = &part.local;
            if (!goes_on(o)) return;
        }
    } else {
        if (solid.geometry.kind == ShapeKind::plane) o.kind = Obstacle::Kind::plane;
        goes_on(o);
    }
}

/// Calls visit(solid, place, index) for the convex parts of a solid without triangles; `place` is null when the
/// solid is no compound.
template <class Visit> void for_each_part(const shapes::Solid& solid, Visit&& visit) {
    if (solid.geometry.kind != ShapeKind::compound) return visit(solid, nullptr, 0u);
    for (std::uint32_t i = 0; i < solid.compound->parts.size(); ++i) {
        const shapes::Compound::Part& part = solid.compound->parts[i];
        visit(part.solid, &part.local, i);
    }
}

} // namespace lockstone::collide
