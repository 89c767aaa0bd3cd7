// Nearest points of two solids, piece by piece.
#include "collide/query/cast_pieces.h"

namespace lockstone::collide {
namespace {

struct Search {
    const Convex& shape;
    Long3 position_24; ///< of B's part in A's frame
    std::int64_t limit_30;
    bool found;
    Nearest best;
    std::int64_t best_30;
};

/// Returns false where no other obstacle can be nearer.
bool try_obstacle(Search& s, const Obstacle& o) {
    const Between b =
        between(o, s.shape, s.position_24, s.found ? smaller(s.limit_30, s.best_30) : s.limit_30);
    const std::int64_t distance = b.overlap ? 0 : b.distance_30;
    if (distance > s.limit_30 || (s.found && distance >= s.best_30)) return true;
    s.found = true;
    s.best_30 = distance;
    Nearest& n = s.best;
    n.feature_a = o.feature;
    n.distance = Coordinate::from_raw(shift_right_rounded(distance, 6));
    if (b.overlap) {
        n.normal = UnitVec3{};
        n.on_a = n.on_b = coordinates(s.position_24);
        return false;
    }
    n.normal = unit_of_30(b.normal_30);
    const Long3 across{narrow_rounded(Wide::product(b.normal_30[0], distance), 30),
                       narrow_rounded(Wide::product(b.normal_30[1], distance), 30),
                       narrow_rounded(Wide::product(b.normal_30[2], distance), 30)};
    n.on_a = coordinates(s.position_24 + shifted(b.on_obstacle_30, 6));
    n.on_b = coordinates(s.position_24 + shifted(b.on_obstacle_30 + across, 6));
    return true;
}

/// Searches a solid with many pieces in growing boxes. The first box that holds a point nearer than its half
/// width holds the nearest one.
void search_pieces(const shapes::Solid& a, std::int64_t reach, NarrowScratch& scratch, Search& s) {
    const std::int64_t limit = s.limit_30;
    const std::int64_t limit_24 = (limit >> 6) + 1;
    const Box box = box_of(s.shape);
    std::int64_t width = smaller(larger(reach, std::int64_t{1} << 20), limit_24);
    for (;;) {
        s.limit_30 = smaller(limit, up(width, 6));
        for_each_obstacle(a, swept_extent(s.position_24, s.position_24, box, width + 16), scratch,
                          [&](const Obstacle& o) { return try_obstacle(s, o); });
        if (s.found || width >= limit_24) return;
        width = smaller(width * 4, limit_24);
    }
}

} // namespace

bool nearest_points(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose,
                    Coordinate limit, NarrowScratch& scratch, Nearest& out) {
    if (has_triangles(b) || b.geometry.kind == ShapeKind::plane) return false;
    constexpr std::int64_t limit_max_30 = std::int64_t{1} << (15 + 30);
    const std::int64_t limit_30 = limit.raw > (limit_max_30 >> 6) ? limit_max_30 : up(limit.raw, 6);
    bool found = false;
    for_each_part(b, [&](const shapes::Solid& part, const Transform* place, std::uint32_t) {
        const RelativePose where = place == nullptr ? pose : part_pose(pose, *place);
        const Convex shape = convex_of(part, where.rotation, CoordinateVec3{});
        Search s{shape, raw(where.position), limit_30, false, {}, 0};
        if (found) s.limit_30 = smaller(s.limit_30, up(out.distance.raw, 6));
        if (has_triangles(a) || a.geometry.kind == ShapeKind::compound)
            search_pieces(a, reach_24(part), scratch, s);
        else
            for_each_obstacle(a, {}, scratch, [&](const Obstacle& o) { return try_obstacle(s, o); });
        if (!s.found || (found && s.best.distance >= out.distance)) return;
        out = s.best;
        found = true;
    });
    return found;
}

} // namespace lockstone::collide
