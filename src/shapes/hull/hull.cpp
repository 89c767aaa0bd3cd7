#include "shapes/hull/hull.h"

#include "base/text.h"
#include "lockstone/math/math.h"

#include <algorithm>
#include <limits>

namespace lockstone::shapes {
namespace {

using base::join;

const char* sentence_of(HullFault fault) {
    switch (fault) {
    case HullFault::too_few_points:
        return "has fewer than four points";
    case HullFault::one_point:
        return "has all its points in one place";
    case HullFault::one_line:
        return "has all its points on one line";
    default:
        return "has all its points in one plane";
    }
}

Extent extent_of_points(std::span<const LengthVec3> points) {
    LengthVec3 lower = points[0], upper = points[0];
    for (const LengthVec3& p : points) lower = min(lower, p), upper = max(upper, p);
    return {to<Coordinate>(lower), to<Coordinate>(upper)};
}

/// The least thickness across a triangle, rounded down. Directions have 30 fraction bits, so it may be 4 steps
/// too small.
Length thickness_of(const Hull& hull) {
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (const auto& [a, b, c] : hull.triangles) {
        const UnitVec3 n = unit_of(exact_normal(hull.vertices[a], hull.vertices[b], hull.vertices[c]));
        const Reach reach = reach_along(hull.vertices, n);
        least = std::min(least, reach.high_54 - reach.low_54);
    }
    return Length::from_raw(saturate_to_int32((least >> 30) - 4));
}

void find_neighbours(Hull& hull) {
    std::vector<std::array<std::uint8_t, 2>> links;
    for (const auto& t : hull.triangles)
        for (std::size_t k = 0; k < 3; ++k)
            links.push_back({t[k], t[(k + 1) % 3]}); // each edge in both directions
    std::ranges::sort(links);
    hull.first_neighbour.assign(hull.vertices.size() + 1, 0);
    for (const auto& [from, to] : links) {
        ++hull.first_neighbour[std::size_t{from} + 1];
        hull.neighbours.push_back(to);
    }
    for (std::size_t v = 0; v < hull.vertices.size(); ++v)
        hull.first_neighbour[v + 1] =
            static_cast<std::uint16_t>(hull.first_neighbour[v + 1] + hull.first_neighbour[v]);
}

/// Distance of `interior` from the plane of the nearest triangle, rounded down; 0 when it is outside.
Length inner_radius_of(const Hull& hull) {
    Length least = Length::max();
    for (const auto& [a, b, c] : hull.triangles) {
        const WideVec3 n = exact_normal(hull.vertices[a], hull.vertices[b], hull.vertices[c]);
        const Scaled depth = -scaled(exact_height(n, hull.vertices[a], hull.interior), -72);
        least = min(least, unscaled<Length>(depth / length_of(n)) - Length::step());
    }
    return max(least, Length{});
}

} // namespace

Reach reach_along(std::span<const LengthVec3> vertices, UnitVec3 n) {
    Reach reach{std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min()};
    for (const LengthVec3& v : vertices) {
        const std::int64_t along = std::int64_t{n.x.raw} * v.x.raw + std::int64_t{n.y.raw} * v.y.raw +
                                   std::int64_t{n.z.raw} * v.z.raw;
        reach.low_54 = std::min(reach.low_54, along);
        reach.high_54 = std::max(reach.high_54, along);
    }
    return reach;
}

Length face_tolerance(const Hull& hull, Length thickness) {
    const CoordinateVec3 size = hull.extent.upper - hull.extent.lower;
    const std::int64_t widest = max(size.x, max(size.y, size.z)).raw;
    const std::int64_t tolerance =
        std::min(std::max<std::int64_t>(widest >> 12, 4), std::int64_t{thickness.raw} / 8);
    return Length::from_raw(saturate_to_int32(tolerance));
}

Result<Hull> make_hull(std::span<const LengthVec3> points) {
    ConvexSurface surface;
    if (const HullFault fault = convex_hull(points, surface); fault != HullFault::none)
        return Error{join("hull ", sentence_of(fault))};
    if (surface.vertices.size() > hull_vertices_max)
        return Error{join("hull has ", surface.vertices.size(), " corners, it may have ", hull_vertices_max)};
    Hull hull;
    hull.vertices = std::move(surface.vertices);
    for (const auto& [a, b, c] : surface.triangles)
        hull.triangles.push_back(
            {static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b), static_cast<std::uint8_t>(c)});
    hull.extent = extent_of_points(hull.vertices);
    const CoordinateVec3 furthest = max(abs(hull.extent.lower), abs(hull.extent.upper));
    if (max(furthest.x, max(furthest.y, furthest.z)) > to<Coordinate>(shape_size_max))
        return Error{"hull has a corner further than 100 m from the origin"};
    const Length thickness = thickness_of(hull);
    if (thickness < shape_size_min + shape_size_min - Length::step() * 8)
        return Error{join("hull is ", (std::int64_t{thickness.raw} * 1'000'000) >> Length::fraction_bits,
                          " um thick across one of its faces, it must be at least 5000 um")};
    find_neighbours(hull);
    find_faces(hull, thickness);
    index_corners(hull);
    const SurfaceMass mass = integrate(hull.vertices, hull.triangles);
    hull.volume = mass.volume;
    hull.properties = {unscaled<Real>(mass.volume), mass.center, mass.gyration_squared};
    hull.interior = to<Length>(mass.center);
    hull.inner_radius = inner_radius_of(hull);
    find_patches(hull);
    return hull;
}

} // namespace lockstone::shapes
