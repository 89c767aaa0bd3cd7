#include "collide/query/cast_pieces.h"

namespace lockstone::collide {

namespace {

Between between_plane(const Convex& shape, Long3 position_24) {
    const Long3 lowest = support(shape, {0, -one_30, 0}).at_30;
    const std::int64_t height = up(position_24[1], 6) + lowest[1] - up(std::int64_t{shape.radius.raw}, 6);
    return {height <= 0, {0, one_30, 0}, height, {lowest[0], -up(position_24[1], 6), lowest[2]}};
}

/// The obstacle in the working frame. The frame's origin is at `position_24` in the frame of the obstacle's
/// solid.
Convex placed(const Obstacle& o, Long3 position_24) {
    if (o.kind == Obstacle::Kind::triangle) {
        const Long3 corners[3] = {raw(o.triangle->corner[0]) - position_24,
                                  raw(o.triangle->corner[1]) - position_24,
                                  raw(o.triangle->corner[2]) - position_24};
        return convex_of_triangle(corners);
    }
    if (o.place == nullptr) return convex_of(*o.solid, Rotation::identity(), coordinates(-position_24));
    return convex_of(*o.solid, to_rotation(o.place->rotation),
                     coordinates(raw(to<Coordinate>(o.place->position)) - position_24));
}

/// True when the plane of a triangle separates it from a shape by more than the limit; `out` is then a gap
/// along the plane's normal. Most triangles near a path are settled by this test.
bool is_off_plane(const shapes::Face& t, const Convex& shape, Long3 position_24, std::int64_t limit_30,
                  Between& out) {
    constexpr std::int64_t roundings = 64;
    const Long3 plane = raw(t.normal);
    const std::int64_t above = dot_dropped(up(position_24 - raw(t.corner[0]), 6), plane, 30);
    const Long3 n = above < 0 ? -plane : plane;
    const std::int64_t lowest = dot_dropped(support(shape, -n).at_30, n, 30);
    const std::int64_t gap = absolute(above) + lowest - up(std::int64_t{shape.radius.raw}, 6);
    if (gap <= limit_30 || gap - limit_30 <= roundings) return false;
    out = {false, n, gap, Long3{}};
    return true;
}

} // namespace

Between between(const Obstacle& o, const Convex& shape, Long3 position_24, std::int64_t limit_30) {
    if (o.kind == Obstacle::Kind::plane) return between_plane(shape, position_24);
    if (Between far; o.kind == Obstacle::Kind::triangle && shape.core != Convex::Core::point &&
                     is_off_plane(*o.triangle, shape, position_24, limit_30, far))
        return far;
    const Convex other = placed(o, position_24);
    const std::int64_t radius_a = up(std::int64_t{other.radius.raw}, 6);
    const std::int64_t radii = radius_a + up(std::int64_t{shape.radius.raw}, 6);
    const Gap gap = closest_points_within(other, shape, add_saturated(limit_30, radii));
    if (gap.overlap) return {true, Long3{}, -radii, Long3{}};
    const std::int64_t distance = gap.distance_30 - radii;
    const Long3 on = gap.on_a_30 + Long3{narrow_rounded(Wide::product(gap.normal_30[0], radius_a), 30),
                                         narrow_rounded(Wide::product(gap.normal_30[1], radius_a), 30),
                                         narrow_rounded(Wide::product(gap.normal_30[2], radius_a), 30)};
    return {distance <= 0, gap.normal_30, distance, on};
}

shapes::Extent swept_extent(Long3 from_24, Long3 to_24, std::int64_t radius_24) {
    Long3 low{}, high{};
    for (int i = 0; i < 3; ++i) {
        low[i] = smaller(from_24[i], to_24[i]) - radius_24;
        high[i] = larger(from_24[i], to_24[i]) + radius_24;
    }
    return {coordinates(low), coordinates(high)};
}

shapes::Extent swept_extent(Long3 from_24, Long3 to_24, const Box& box, std::int64_t guard_24) {
    Long3 low{}, high{};
    for (int i = 0; i < 3; ++i) {
        low[i] = smaller(from_24[i], to_24[i]) + box.lower_24[i] - guard_24;
        high[i] = larger(from_24[i], to_24[i]) + box.upper_24[i] + guard_24;
    }
    return {coordinates(low), coordinates(high)};
}

Box box_of(const Convex& shape) {
    Box box{};
    for (int i = 0; i < 3; ++i) {
        Long3 axis{};
        axis[i] = one_30;
        box.upper_24[i] = (support(shape, axis).at_30[i] >> 6) + shape.radius.raw + 1;
        axis[i] = -one_30;
        box.lower_24[i] = (support(shape, axis).at_30[i] >> 6) - shape.radius.raw;
    }
    return box;
}

} // namespace lockstone::collide
