// A hull found by trying all triples of points, on small integers: a reference that shares no code with the baker.
#pragma once

#include "oracle/convex_double.h"
#include "shapes/hull/hull.h"

#include <array>
#include <memory>
#include <set>

namespace oracle {

using Grid =
    std::array<std::int64_t, 3>; ///< coordinates below 2^18 in absolute value: all products are exact

/// Every triple of points whose plane has all points on one side.
inline std::vector<std::array<std::size_t, 3>> outer_triangles(const std::vector<Grid>& points) {
    const auto minus = [](const Grid& a, const Grid& b) {
        return Grid{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    };
    const auto times = [](const Grid& a, const Grid& b) {
        return Grid{a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    };
    const auto along = [](const Grid& a, const Grid& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
    std::vector<std::array<std::size_t, 3>> triangles;
    for (std::size_t i = 0; i < points.size(); ++i)
        for (std::size_t j = i + 1; j < points.size(); ++j)
            for (std::size_t k = j + 1; k < points.size(); ++k) {
                const Grid n = times(minus(points[j], points[i]), minus(points[k], points[i]));
                if (n == Grid{0, 0, 0}) continue;
                bool above = false, below = false;
                for (const Grid& p : points) {
                    const std::int64_t side = along(n, minus(p, points[i]));
                    above = above || side > 0;
                    below = below || side < 0;
                }
                if (above == below) continue;
                triangles.push_back(above ? std::array{i, k, j} : std::array{i, j, k});
            }
    return triangles;
}

/// The corners, outer triangles (all of them), neighbours and extent of the hull of `points`, whose unit is 2^shift
/// Length steps. Null when the points lie in one plane or more than 255 are corners.
inline std::shared_ptr<lockstone::shapes::Hull> brute_hull(const std::vector<Grid>& points, int shift) {
    using lockstone::Length;
    const std::vector<std::array<std::size_t, 3>> triangles = outer_triangles(points);
    std::set<std::size_t> corners;
    for (const auto& t : triangles) corners.insert(t.begin(), t.end());
    if (triangles.empty() || corners.size() > 255) return nullptr;
    auto hull = std::make_shared<lockstone::shapes::Hull>();
    std::vector<std::uint8_t> name(points.size());
    lockstone::CoordinateVec3 low{}, high{};
    for (std::size_t c : corners) {
        name[c] = static_cast<std::uint8_t>(hull->vertices.size());
        const auto at = [&](int i) {
            return Length::from_raw(
                static_cast<std::int32_t>(points[c][static_cast<std::size_t>(i)] << shift));
        };
        const lockstone::LengthVec3 v{at(0), at(1), at(2)};
        const auto wide = lockstone::to<lockstone::Coordinate>(v);
        low = hull->vertices.empty() ? wide : min(low, wide);
        high = hull->vertices.empty() ? wide : max(high, wide);
        hull->vertices.push_back(v);
    }
    hull->extent = {low, high};
    std::vector<std::set<std::uint8_t>> beside(hull->vertices.size());
    for (const auto& t : triangles) {
        const std::array<std::uint8_t, 3> named{name[t[0]], name[t[1]], name[t[2]]};
        hull->triangles.push_back(named);
        for (std::size_t k = 0; k < 3; ++k) beside[named[k]].insert({named[(k + 1) % 3], named[(k + 2) % 3]});
    }
    for (const auto& t : hull->triangles) { // each triangle is a face
        const D3 p = as_double(hull->vertices[t[0]]);
        D3 n = cross(as_double(hull->vertices[t[1]]) - p, as_double(hull->vertices[t[2]]) - p);
        n = n * (1 / norm(n));
        using lockstone::Unit;
        hull->faces.push_back({{as_fixed<Unit>(n.x), as_fixed<Unit>(n.y), as_fixed<Unit>(n.z)},
                               as_fixed<lockstone::Coordinate>(dot(n, p)),
                               static_cast<std::uint16_t>(hull->loops.size()),
                               3,
                               0,
                               0});
        hull->loops.insert(hull->loops.end(), t.begin(), t.end());
        hull->face_of.push_back(static_cast<std::uint16_t>(hull->faces.size() - 1));
    }
    for (const auto& set : beside) {
        hull->first_neighbour.push_back(static_cast<std::uint16_t>(hull->neighbours.size()));
        hull->neighbours.insert(hull->neighbours.end(), set.begin(), set.end());
    }
    hull->first_neighbour.push_back(static_cast<std::uint16_t>(hull->neighbours.size()));
    lockstone::shapes::index_corners(*hull);
    return hull;
}

} // namespace oracle
