// Points and triangles in double precision, as models contain them before quantisation. Right-handed, y up, metres.
// Also checks of them, and evenly spread samples of their surface.
#pragma once

#include "lockstone/asset.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

namespace lockstone::cook {

struct Point {
    double x = 0, y = 0, z = 0;

    double& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
    double operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
    friend bool operator==(const Point&, const Point&) = default;
    friend Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend Point operator*(Point a, double s) { return {a.x * s, a.y * s, a.z * s}; }
};
inline double dot(Point a, Point b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Point cross(Point a, Point b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline double length(Point a) { return std::sqrt(dot(a, a)); }

/// True if the value is neither infinite nor not-a-number. It tests the bits, because with -ffast-math std::isfinite is
/// always true.
inline bool is_finite(double v) { return ((std::bit_cast<std::uint64_t>(v) >> 52) & 0x7ff) != 0x7ff; }

using Indices = std::array<std::uint32_t, 3>; ///< a triangle, counter-clockwise seen from outside

struct Soup {
    std::vector<Point> vertices;
    std::vector<Indices> triangles;

    std::array<Point, 3> corners(std::size_t triangle) const {
        const Indices& t = triangles[triangle];
        return {vertices[t[0]], vertices[t[1]], vertices[t[2]]};
    }
    void append(const Soup& other);
};

/// An axis-aligned box; empty while lower exceeds upper.
struct Box {
    Point lower{1e300, 1e300, 1e300}, upper{-1e300, -1e300, -1e300};

    void add(Point p) {
        for (int i = 0; i < 3; ++i) lower[i] = std::min(lower[i], p[i]), upper[i] = std::max(upper[i], p[i]);
    }
    bool empty() const { return lower.x > upper.x; }
    Point size() const { return empty() ? Point{} : upper - lower; }
    double largest() const { return std::max({size().x, size().y, size().z}); }
};
Box bounds_of(const std::vector<Point>& points);

/// Larger coordinates are an error: no asset extends so far, and products of three such coordinates do not lose digits
/// [m].
inline constexpr double coordinate_max = 16'000;

/// Empty if every coordinate is finite and within `limit` of 0 and every index refers to a vertex; otherwise an error
/// sentence.
std::string check(const Soup& soup, double limit = coordinate_max);
/// Merges vertices with equal coordinates. Drops triangles that use a vertex twice or have no area.
Soup welded(const Soup& soup);
/// Removes the vertices that no triangle uses.
Soup compacted(const Soup& soup);

struct SurfacePoint {
    Point at, normal; ///< unit length, to the side from which the triangle is counter-clockwise
};
/// `count` points spread evenly over the surface; equal soups give equal points. Empty if the soup has no area.
std::vector<SurfacePoint> sample_surface_points(const Soup& soup, std::size_t count);
/// These points without their normals.
std::vector<Point> sample_surface(const Soup& soup, std::size_t count);
/// The `index`-th point of a sequence that fills the unit cube evenly.
/// Source: Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018.
Point even_point(std::uint64_t index);

/// The triangles of a shape as doubles.
Soup to_soup(const TriangleSoup& soup);

} // namespace lockstone::cook
