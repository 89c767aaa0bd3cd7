#include "collide/narrow_phase.h"

#include "base/assert.h"
#include "collide/convex/convex.h"
#include "collide/integer.h"
#include "collide/pairs/pairs.h"

namespace lockstone::collide {
namespace {

using Routine = void (*)(const Geometry&, const Geometry&, const RelativePose&, Length, Manifold&);

/// The routine for a pair of spheres, capsules and boxes, if there is one; else null.
Routine routine_of(ShapeKind a, ShapeKind b) {
    switch (a) {
    case ShapeKind::sphere:
        return b == ShapeKind::sphere ? collide_sphere_sphere : nullptr;
    case ShapeKind::capsule:
        return b == ShapeKind::sphere    ? collide_capsule_sphere
               : b == ShapeKind::capsule ? collide_capsule_capsule
                                         : nullptr;
    case ShapeKind::box:
        return b == ShapeKind::sphere    ? collide_box_sphere
               : b == ShapeKind::capsule ? collide_box_capsule
               : b == ShapeKind::box     ? collide_box_box
                                         : nullptr;
    default:
        return nullptr;
    }
}

/// True for sizes for which the special routines are proved, and for boxes without rounding.
bool is_plain(const Geometry& g) {
    return g.scale.x == scale_one.x && (g.kind != ShapeKind::box || g.radius == Length{});
}

bool is_near(const CoordinateVec3& p, Coordinate limit) {
    return abs(p.x) < limit && abs(p.y) < limit && abs(p.z) < limit;
}

} // namespace

/// d is split as high 2^16 + low, so that all products fit 64 bits.
CoordinateVec3 into_frame(const Rotation& r, Vec3 d) {
    const Long3 d_32 = raw(d);
    constexpr std::int64_t reach = std::int64_t{32768} << Real::fraction_bits;
    constexpr Coordinate far = relative_position_max;
    for (int i = 0; i < 3; ++i)
        if (d_32[i] > reach || d_32[i] < -reach) return {far, far, far};
    const Long3 high{d_32[0] >> 16, d_32[1] >> 16, d_32[2] >> 16};
    const Long3 low{d_32[0] & 0xffff, d_32[1] & 0xffff, d_32[2] & 0xffff};
    const auto along = [&](Long3 axis) {
        return clamp(round_from<Coordinate>(dot(high, axis) + (dot(low, axis) >> 16), 46), -far, far);
    };
    return {along(raw(r.x)), along(raw(r.y)), along(raw(r.z))};
}

namespace {

/// The special routine for two solids, if there is one and it is proved for their sizes and distance; else
/// null.
Routine routine_of(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose) {
    const Routine found = routine_of(a.geometry.kind, b.geometry.kind);
    const bool fits = is_plain(a.geometry) && is_plain(b.geometry) && is_near(pose.position, Coordinate(128));
    return found != nullptr && fits ? found : nullptr;
}

void use(Routine routine, const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose,
         Length margin, Manifold& out) {
    out = Manifold{};
    routine(a.geometry, b.geometry, pose, margin, out);
    for (std::uint32_t k = 0; k < out.count; ++k) // from A's origin to B's
        out.points[k].position = to<Length>(to<Coordinate>(out.points[k].position) - pose.position);
}

} // namespace

RelativePose relative_pose(const Transform& a, const Transform& b) {
    return {to_rotation(conjugate(a.rotation) * b.rotation),
            into_frame(to_rotation(a.rotation), b.position - a.position)};
}

CoordinateVec3 plane_relative_position(UnitVec3 normal, Vec3 on_plane, Vec3 b) {
    constexpr Real height_max = 16000_r;
    const Real height = dot<Real>(normal, b - on_plane);
    return {Coordinate{}, to<Coordinate>(clamp(height, -height_max, height_max)), Coordinate{}};
}

RelativePose plane_relative_pose(const Transform& plane, const Transform& b) {
    return {to_rotation(conjugate(plane.rotation) * b.rotation),
            plane_relative_position(to_rotation(plane.rotation).y, plane.position, b.position)};
}

void collide_pair(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose, Length margin,
                  Manifold& out) {
    if (const Routine routine = routine_of(a, b, pose)) return use(routine, a, b, pose, margin, out);
    out = Manifold{};
    if (a.geometry.kind == ShapeKind::plane) return collide_plane(b, pose, margin, out);
    collide_convex(convex_of(a, Rotation::identity(), CoordinateVec3{}),
                   convex_of(b, pose.rotation, pose.position), margin, out);
}

void collide(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose, Length margin,
             NarrowScratch& scratch, Manifolds& out) {
    collide(a, b, pose, margin, PairHints{}, scratch, out);
}

void collide(const shapes::Solid& a, const shapes::Solid& b, const RelativePose& pose, Length margin,
             const PairHints& hints, NarrowScratch& scratch, Manifolds& out) {
    const ShapeKind kind_a = a.geometry.kind, kind_b = b.geometry.kind;
    const bool convex = kind_a < ShapeKind::compound && kind_b < ShapeKind::compound;
    LOCKSTONE_ASSERT(kind_a <= ShapeKind::plane && (convex || kind_b <= kind_a), "shape kinds ",
                     static_cast<std::uint32_t>(kind_a), " and ", static_cast<std::uint32_t>(kind_b));
    out.count = 0;
    out.apart = UnitVec3{};
    if (!is_near(pose.position, relative_position_max)) return;
    if (kind_b > ShapeKind::compound) return; // two of height field, mesh and plane have no contacts
    if (kind_b == ShapeKind::compound || kind_a == ShapeKind::compound)
        return collide_compound(a, b, pose, margin, scratch, out);
    if (kind_a == ShapeKind::height_field || kind_a == ShapeKind::mesh)
        return collide_triangles(a, b, pose, margin, scratch, out);
    if (const Routine routine = routine_of(a, b, pose)) {
        use(routine, a, b, pose, margin, out.items[0]);
        if (out.items[0].count == 0) out.apart = out.items[0].normal;
    } else if (kind_a != ShapeKind::plane) {
        collide_convex(convex_of(a, Rotation::identity(), CoordinateVec3{}),
                       convex_of(b, pose.rotation, pose.position), margin, out.items[0], hints);
        if (out.items[0].count == 0) out.apart = out.items[0].normal;
    } else {
        collide_pair(a, b, pose, margin, out.items[0]);
    }
    out.count = out.items[0].count > 0 ? 1 : 0;
}

namespace {

/// True when reach_along below supports the solid.
bool tells_reach(const shapes::Solid& solid) {
    const ShapeKind kind = solid.geometry.kind;
    if (kind == ShapeKind::hull) return true;
    return (kind == ShapeKind::sphere || kind == ShapeKind::capsule || kind == ShapeKind::box ||
            kind == ShapeKind::cylinder) &&
           is_plain(solid.geometry);
}

/// Reach of a sphere, capsule, cylinder, box or hull from its origin along a unit direction in its axes, 54
/// fraction bits.
std::int64_t reach_along(const shapes::Solid& solid, Long3 n_30) {
    const Geometry& g = solid.geometry;
    std::int64_t reach = up(g.radius.raw, 30);
    if (g.kind == ShapeKind::hull) return reach + furthest_along_54(*solid.hull, solid.kernel, n_30);
    if (g.kind == ShapeKind::box)
        reach += absolute(n_30[0]) * g.half_extent.x.raw + absolute(n_30[2]) * g.half_extent.z.raw;
    if (g.kind == ShapeKind::cylinder)
        reach += static_cast<std::int64_t>(
                     isqrt(static_cast<std::uint64_t>(n_30[0] * n_30[0] + n_30[2] * n_30[2])) + 1) *
                 g.half_extent.x.raw;
    if (g.kind != ShapeKind::sphere) reach += absolute(n_30[1]) * g.half_extent.y.raw;
    return reach;
}

} // namespace

bool are_parted(const PlacedSolid& a, const PlacedSolid& b, UnitVec3 axis, Length margin) {
    if (!tells_reach(a.solid) || !tells_reach(b.solid)) return false;
    // All sums must stay below 2^63: at most 111 m between the two shapes, and twice the 174 m that a shape
    // reaches at most.
    constexpr std::int64_t far_32 = std::int64_t{64} << Real::fraction_bits;
    constexpr Length spare = decimal<Length>("0.001");
    const Long3 way_32 = raw(b.position - a.position);
    for (int i = 0; i < 3; ++i)
        if (absolute(way_32[i]) > far_32) return false;
    const Long3 way{way_32[0] >> 8, way_32[1] >> 8, way_32[2] >> 8}; // 24 fraction bits
    const Long3 n = raw(axis), x = raw(a.axes.x), y = raw(a.axes.y), z = raw(a.axes.z);
    const Long3 in_world = shifted(x * n[0] + y * n[1] + z * n[2], 30);
    const Long3 in_b{dot(raw(b.axes.x), in_world) >> 30, dot(raw(b.axes.y), in_world) >> 30,
                     dot(raw(b.axes.z), in_world) >> 30};
    const std::int64_t gap_54 = dot(way, in_world) - reach_along(a.solid, n) - reach_along(b.solid, -in_b);
    return gap_54 > up(std::int64_t{margin.raw} + spare.raw, 30); // margins reach 128 m
}

} // namespace lockstone::collide
