// Rays against convex solids, planes and compounds.
//
// Most convex solids are an intersection of slabs, half-spaces, balls and tubes; the ray's interval in the
// solid is the intersection of its intervals in those. A capsule is a union; its interval is the hull of the
// intervals. For cones and rounded shapes the distance along the ray comes from Newton's method on a convex
// function, from the side where it is positive: no step can go too far.
//
// source: Ericson, Real-Time Collision Detection, 5.3; Kay and Kajiya, Ray Tracing Complex Scenes, 1986 (slabs)
#include "collide/convex/convex.h"
#include "collide/query/cast_line.h"
#include "shapes/bounds_hierarchy.h"

namespace lockstone::collide {
namespace {

constexpr std::int64_t far_30 = std::int64_t{1} << 62;

/// A ray relative to the solid's origin: s = 0 is the point of the ray nearest to that origin. Lengths are in
/// units of 2^-30 m, divided by the shape's scale. All relevant coordinates are within 2^9 m of the origin.
struct Local {
    Long3 o;       ///< the point at s = 0
    Long3 unit_60; ///< its direction
    std::int64_t start, end;
};

/// The ray's interval in a convex set, and the normal where it enters.
struct Part {
    std::int64_t enter = -far_30, exit = far_30;
    Long3 normal{}; ///< 30 bits, at `enter`

    bool empty() const { return enter > exit; }
    void clear() { enter = 1, exit = 0; }
    void enter_at(std::int64_t s, Long3 n) {
        if (s > enter) enter = s, normal = n;
    }
    void leave_at(std::int64_t s) { exit = smaller(exit, s); }
};

Long3 axis_normal(int axis, std::int64_t direction) {
    Long3 n{};
    n[axis] = direction > 0 ? -one_30 : one_30;
    return n;
}

/// Intersects with the slab |x| <= half along an axis.
void clip_slab(const Local& ray, int axis, std::int64_t half, Part& part) {
    const std::int64_t o = ray.o[axis], u = ray.unit_60[axis];
    if (u == 0) {
        if (absolute(o) > half) part.clear();
        return;
    }
    const std::int64_t near = u > 0 ? -half : half;
    part.enter_at(divide_shifted(near - o, u, 60), axis_normal(axis, u));
    part.leave_at(divide_shifted(-near - o, u, 60));
}

/// The ray's interval in the ball around (0, y, 0).
Part part_in_ball(const Local& ray, std::int64_t y, std::int64_t radius) {
    const Long3 p{ray.o[0], ray.o[1] - y, ray.o[2]};
    const std::int64_t along = dot_dropped(p, ray.unit_60, 60);
    const Wide left = Wide::product(radius, radius) + Wide::product(along, along) -
                      Wide::product(p[0], p[0]) - Wide::product(p[1], p[1]) - Wide::product(p[2], p[2]);
    Part part;
    if (left.is_negative()) {
        part.clear();
        return part;
    }
    const std::int64_t half = static_cast<std::int64_t>(isqrt(left));
    part.enter = -along - half;
    part.exit = -along + half;
    part.normal = direction_of_30(p + times_60(ray.unit_60, part.enter)).unit;
    return part;
}

/// Intersects with the endless tube around the y axis. In the x-z plane it computes the ray's direction (60
/// bits), the ray's position along it and its distance from the axis.
void clip_tube(const Local& ray, std::int64_t radius, Part& part) {
    const std::int64_t ux = ray.unit_60[0], uz = ray.unit_60[2], ox = ray.o[0], oz = ray.o[2];
    const std::int64_t across =
        static_cast<std::int64_t>(isqrt(Wide::product(ux, ux) + Wide::product(uz, uz)));
    if (across == 0) {
        if (Wide::product(radius, radius) < Wide::product(ox, ox) + Wide::product(oz, oz)) part.clear();
        return;
    }
    const std::int64_t dx = divide_shifted(ux, across, 60), dz = divide_shifted(uz, across, 60);
    const std::int64_t along = narrow_rounded(Wide::product(ox, dx) + Wide::product(oz, dz), 60);
    const std::int64_t beside = narrow_rounded(Wide::product(ox, dz) - Wide::product(oz, dx), 60);
    const Wide left = Wide::product(radius, radius) - Wide::product(beside, beside);
    if (left.is_negative()) return part.clear();
    const std::int64_t half = static_cast<std::int64_t>(isqrt(left));
    const std::int64_t enter = divide_shifted(-half - along, across, 60);
    const Long3 at{ox + times_60(enter, ux), 0, oz + times_60(enter, uz)};
    // A ray almost along the axis enters far outside of the shape, where its normal is never used.
    if (enter > -one_30 * 4096) part.enter_at(enter, direction_of_30(at).unit);
    part.leave_at(divide_shifted(half - along, across, 60));
}

Part part_in_capsule(const Local& ray, const Geometry& g) {
    const std::int64_t radius = up(g.radius.raw, 6), half = up(g.half_extent.y.raw, 6);
    Part whole;
    clip_tube(ray, radius, whole);
    clip_slab(ray, 1, half, whole);
    for (const std::int64_t y : {-half, half}) {
        const Part cap = part_in_ball(ray, y, radius);
        if (cap.empty()) continue;
        if (whole.empty()) {
            whole = cap;
            continue;
        }
        if (cap.enter < whole.enter) whole.enter = cap.enter, whole.normal = cap.normal;
        whole.exit = larger(whole.exit, cap.exit);
    }
    return whole;
}

/// The ray's interval in the polytope bounded by the merged faces. The polytope contains the hull and is larger
/// by at most the flatness of the faces.
Part part_in_faces(const Local& ray, const shapes::Hull& hull) {
    Part part;
    for (const shapes::Hull::Face& face : hull.faces) {
        const Long3 n = raw(face.normal);
        const std::int64_t above = up(face.offset.raw, 6) - dot_dropped(n, ray.o, 30);
        const std::int64_t slope = dot_dropped(n, ray.unit_60, 30);
        if (slope < 0) {
            part.enter_at(divide_shifted(above, slope, 60), n);
        } else if (slope > 0) {
            part.leave_at(divide_shifted(above, slope, 60));
        } else if (above < 0) {
            part.clear();
        }
        if (part.empty()) break;
    }
    return part;
}

/// The value of a convex function on the ray, its derivative along the ray, and the surface normal.
struct Value {
    std::int64_t above_30, slope_60;
    Long3 normal_30;
};

constexpr int newton_steps_max = 64;

/// Finds the first s not before `start` where `value_at` is at most `close`. Tangents of a convex function lie
/// below it, so no step passes the first zero; at a tangential zero each step halves the error.
template <class ValueAt>
bool newton(const Local& ray, std::int64_t start, std::int64_t close, ValueAt&& value_at, Part& part) {
    std::int64_t s = start;
    for (int i = 0; i < newton_steps_max; ++i) {
        const Value value = value_at(s);
        if (value.above_30 <= close) {
            part.enter = i == 0 ? s - 1 : s;
            part.normal = value.normal_30;
            return true;
        }
        if (value.slope_60 >= 0) return false;
        s = add_saturated(s, larger(1, divide_shifted(value.above_30, -value.slope_60, 60)));
        if (s > ray.end) return false;
    }
    part.enter = s;
    part.normal = value_at(s).normal_30;
    return true;
}

/// The greater of the signed distances to the mantle's cone and to the plane of the base.
Value cone_value(const Local& ray, const Geometry& g, std::int64_t cosine_60, std::int64_t sine_60,
                 std::int64_t s) {
    const std::int64_t half = up(g.half_extent.y.raw, 6);
    const Long3 p = ray.o + times_60(ray.unit_60, s);
    const std::int64_t below = -half - p[1];
    // Ten bits more than p: near the apex the direction of the normal depends on it.
    const std::int64_t rho_40 =
        static_cast<std::int64_t>(isqrt((Wide::product(p[0], p[0]) + Wide::product(p[2], p[2])) << 20));
    const std::int64_t beside =
        narrow_rounded(Wide::product(rho_40, cosine_60) - Wide::product(up(half - p[1], 10), sine_60), 70);
    if (below >= beside) return {below, -ray.unit_60[1], {0, -one_30, 0}};
    const std::int64_t ux = ray.unit_60[0], uz = ray.unit_60[2];
    const std::int64_t across =
        static_cast<std::int64_t>(isqrt(Wide::product(ux, ux) + Wide::product(uz, uz)));
    const std::int64_t outward_50 = narrow_rounded(Wide::product(p[0], ux) + Wide::product(p[2], uz), 40);
    const std::int64_t outward =
        rho_40 == 0 ? across : clamped(divide_shifted(outward_50, rho_40, 50), -across, across);
    const std::int64_t slope =
        narrow_rounded(Wide::product(outward, cosine_60) + Wide::product(ray.unit_60[1], sine_60), 60);
    if (rho_40 == 0) return {beside, slope, {0, one_30, 0}};
    const Long3 normal{times_60(up(p[0], 10), cosine_60), times_60(rho_40, sine_60),
                       times_60(up(p[2], 10), cosine_60)};
    return {beside, slope, direction_of_30(normal).unit};
}

bool cast_cone(const Local& ray, const Geometry& g, Part& part) {
    const std::int64_t r = g.half_extent.x.raw, height = 2 * std::int64_t{g.half_extent.y.raw};
    const std::int64_t slant_36 =
        static_cast<std::int64_t>(isqrt((Wide::product(r, r) + Wide::product(height, height)) << 24));
    const std::int64_t cosine = divide_shifted(up(height, 12), slant_36, 60),
                       sine = divide_shifted(up(r, 12), slant_36, 60);
    return newton(
        ray, ray.start, 2, [&](std::int64_t s) { return cone_value(ray, g, cosine, sine, s); }, part);
}

/// Newton's method on the distance of a point to the core, minus the radius of the rounding. The point has 24
/// fraction bits.
bool cast_rounded(const Local& ray, const shapes::Solid& solid, std::int64_t start, Part& part) {
    constexpr std::int64_t close_30 = 512; // 0.5 um
    const Convex core = convex_of(solid, Rotation::identity(), CoordinateVec3{});
    Convex point{};
    point.core = Convex::Core::point;
    const std::int64_t radius_30 = up(core.radius.raw, 6);
    const auto value_at = [&](std::int64_t s) -> Value {
        point.center_24 = shifted(ray.o + times_60(ray.unit_60, s), 6);
        const Gap gap = closest_points(point, core);
        if (gap.overlap) return {0, 0, Long3{}};
        return {gap.distance_30 - radius_30, -dot_dropped(gap.normal_30, ray.unit_60, 30), -gap.normal_30};
    };
    return newton(ray, start, close_30, value_at, part);
}

/// Starts where the ray enters the merged faces, whose normals are the hull's, and continues to the surface
/// itself.
bool cast_hull(const Local& ray, const shapes::Solid& solid, Part& part) {
    part = part_in_faces(ray, *solid.hull);
    if (part.empty() || part.exit < ray.start || part.enter > ray.end) return false;
    if (part.enter < ray.start) return cast_rounded(ray, solid, ray.start, part);
    const Long3 normal = part.normal;
    const std::int64_t enter = part.enter;
    if (!cast_rounded(ray, solid, enter, part)) return false;
    part.enter = larger(part.enter, enter);
    part.normal = normal;
    return true;
}

bool part_in(const shapes::Solid& solid, const Local& ray, Part& part) {
    const Geometry& g = solid.geometry;
    switch (g.kind) {
    case ShapeKind::sphere:
        part = part_in_ball(ray, 0, up(g.radius.raw, 6));
        break;
    case ShapeKind::capsule:
        part = part_in_capsule(ray, g);
        break;
    case ShapeKind::cylinder:
        if (g.radius.raw != 0) return cast_rounded(ray, solid, ray.start, part);
        clip_slab(ray, 1, up(g.half_extent.y.raw, 6), part);
        if (!part.empty()) clip_tube(ray, up(g.half_extent.x.raw, 6), part);
        break;
    case ShapeKind::cone:
        if (g.radius.raw != 0) return cast_rounded(ray, solid, ray.start, part);
        return cast_cone(ray, g, part);
    case ShapeKind::box:
        if (g.radius.raw != 0) return cast_rounded(ray, solid, ray.start, part);
        for (int axis = 0; axis < 3 && !part.empty(); ++axis)
            clip_slab(ray, axis, up(raw(g.half_extent)[axis], 6), part);
        break;
    default:
        if (g.radius.raw != 0) return cast_rounded(ray, solid, ray.start, part);
        return cast_hull(ray, solid, part);
    }
    return !part.empty();
}

/// The exponent of a primitive's scale, which is a power of two; 0 for hulls.
int scale_shift(const Geometry& g) {
    return g.kind == ShapeKind::hull ? 0 : bit_length(static_cast<std::uint64_t>(g.scale.x.raw >> 24)) - 1;
}

bool cast_ray_plane(const Line& line, CastHit& hit) {
    const std::int64_t height = line.from_24[1], down = -line.way_24[1];
    if (height <= 0) {
        hit = hit_at_start(line, 0);
        return true;
    }
    if (down < height) return false;
    hit = hit_at(line, times_60(line.length_30, divide_shifted(height, down, 60)), {0, one_30, 0}, 0);
    return true;
}

bool cast_ray_compound(const shapes::Solid& solid, const Line& line, CastHit& hit) {
    const Span span = span_of_box(line, solid.compound->extent);
    if (span.empty()) return false;
    const shapes::Compound& compound = *solid.compound;
    bool found = false;
    const auto may_be_nearer = [&](const shapes::Extent& box) {
        const Span here = span_of_box(line, box);
        return !here.empty() && !(found && shift_right_rounded(here.enter_30, 6) > hit.distance.raw);
    };
    const auto cast = [&](std::uint32_t index) {
        CastHit at{};
        if (!cast_ray_part(compound.parts[index], line, at)) return;
        at.feature = index;
        if (!found || comes_first(at, hit)) hit = at;
        found = true;
    };
    if (compound.hierarchy == nullptr)
        for (std::uint32_t i = 0; i < compound.parts.size(); ++i) cast(i);
    else
        compound.hierarchy->visit_if(may_be_nearer, [&](std::uint32_t i) { cast(compound.order[i]); });
    return found;
}

} // namespace

bool cast_ray_convex(const shapes::Solid& solid, const Line& line, CastHit& hit) {
    const std::int64_t reach = up(reach_24(solid), 6) + 64;
    const std::int64_t nearest = nearest_30(line, Long3{});
    if (nearest < -reach || nearest > line.length_30 + reach) return false;
    const Long3 o = point_30(line, nearest);
    for (int i = 0; i < 3; ++i)
        if (absolute(o[i]) > reach) return false;
    const int shift = scale_shift(solid.geometry);
    shapes::Solid unscaled = solid;
    if (shift != 0) unscaled.geometry.scale = scale_one;
    const Local ray{shifted(o, shift), line.unit_60, shift_right_rounded(larger(-nearest, -reach), shift),
                    shift_right_rounded(line.length_30 - nearest, shift)};
    Part part;
    if (!part_in(unscaled, ray, part)) return false;
    const std::int64_t begin = shift_right_rounded(-nearest, shift);
    if (part.exit < begin || part.enter > ray.end) return false;
    if (part.enter < begin)
        hit = hit_at_start(line, 0);
    else
        hit = hit_at(line, nearest + up(part.enter, shift), part.normal, 0);
    return true;
}

/// Shortens the line to the part's surroundings before it turns it, so that rounding errors of the rotation do
/// not grow with its length.
bool cast_ray_part(const shapes::Compound::Part& part, const Line& line, CastHit& hit) {
    const CoordinateVec3 center = to<Coordinate>(part.local.position);
    const Span span = span_of_ball(line, raw(center), reach_24(part.solid));
    if (span.empty()) return false;
    const Rotation axes = to_rotation(part.local.rotation);
    const Long3 from = shifted(point_30(line, span.enter_30), 6),
                to_point = shifted(point_30(line, span.exit_30), 6);
    const CoordinateVec3 local_from = mul_transposed<Coordinate>(axes, coordinates(from) - center);
    const CoordinateVec3 local_way = mul_transposed<Coordinate>(axes, coordinates(to_point - from));
    Line local{};
    if (!make_line(local_from, local_way, local) || !cast_ray_convex(part.solid, local, hit)) return false;
    const Long3 normal = raw(lockstone::mul<Unit>(axes, hit.normal));
    hit = hit_at(line, span.enter_30 + up(hit.distance.raw, 6), normal, hit.feature);
    return true;
}

bool cast_ray(const shapes::Solid& solid, CoordinateVec3 from, CoordinateVec3 translation,
              NarrowScratch& scratch, CastHit& hit) {
    Line line{};
    if (!make_line(from, translation, line)) return false;
    if (solid.geometry.kind == ShapeKind::plane) return cast_ray_plane(line, hit);
    if (solid.geometry.kind == ShapeKind::compound) return cast_ray_compound(solid, line, hit);
    if (has_triangles(solid)) return cast_ray_triangles(solid, line, scratch, hit);
    return cast_ray_convex(solid, line, hit);
}

} // namespace lockstone::collide
