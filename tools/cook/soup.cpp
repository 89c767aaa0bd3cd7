#include "cook/soup.h"

#include "lockstone/math/convert.h"

#include <map>
#include <numeric>

namespace lockstone::cook {

void Soup::append(const Soup& other) {
    const auto base = static_cast<std::uint32_t>(vertices.size());
    vertices.insert(vertices.end(), other.vertices.begin(), other.vertices.end());
    for (const Indices& t : other.triangles) triangles.push_back({base + t[0], base + t[1], base + t[2]});
}

Box bounds_of(const std::vector<Point>& points) {
    Box box;
    for (const Point& p : points) box.add(p);
    return box;
}

std::string check(const Soup& soup, double limit) {
    for (std::size_t i = 0; i < soup.vertices.size(); ++i)
        for (int axis = 0; axis < 3; ++axis) {
            const double v = soup.vertices[i][axis];
            if (!is_finite(v)) return "vertex " + std::to_string(i) + " is not a finite point";
            if (std::abs(v) > limit)
                return "vertex " + std::to_string(i) + " lies " + std::to_string(v) +
                       " from the origin along an axis, the limit is " +
                       std::to_string(static_cast<std::int64_t>(limit)) + " (--scale shrinks a model)";
        }
    for (std::size_t i = 0; i < soup.triangles.size(); ++i)
        for (const std::uint32_t v : soup.triangles[i])
            if (v >= soup.vertices.size())
                return "triangle " + std::to_string(i) + " names vertex " + std::to_string(v) + " of " +
                       std::to_string(soup.vertices.size());
    return {};
}

Soup welded(const Soup& soup) {
    std::vector<std::uint32_t> order(soup.vertices.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](std::uint32_t i) {
        const Point& p = soup.vertices[i];
        return std::array<double, 3>{p.x, p.y, p.z};
    };
    std::stable_sort(order.begin(), order.end(), [&](auto a, auto b) { return key(a) < key(b); });
    Soup out;
    std::vector<std::uint32_t> index(soup.vertices.size());
    for (const std::uint32_t i : order) {
        if (out.vertices.empty() || out.vertices.back() != soup.vertices[i])
            out.vertices.push_back(soup.vertices[i]);
        index[i] = static_cast<std::uint32_t>(out.vertices.size() - 1);
    }
    for (const Indices& t : soup.triangles) {
        const Indices now{index[t[0]], index[t[1]], index[t[2]]};
        const Point a = out.vertices[now[0]];
        const Point normal = cross(out.vertices[now[1]] - a, out.vertices[now[2]] - a);
        if (normal != Point{}) out.triangles.push_back(now);
    }
    return out;
}

Soup compacted(const Soup& soup) {
    constexpr std::uint32_t unused = UINT32_MAX;
    std::vector<std::uint32_t> index(soup.vertices.size(), unused);
    Soup out;
    for (const Indices& t : soup.triangles) {
        Indices now{};
        for (std::size_t k = 0; k < 3; ++k) {
            if (index[t[k]] == unused) {
                index[t[k]] = static_cast<std::uint32_t>(out.vertices.size());
                out.vertices.push_back(soup.vertices[t[k]]);
            }
            now[k] = index[t[k]];
        }
        out.triangles.push_back(now);
    }
    return out;
}

Point even_point(std::uint64_t index) {
    // The positive root of x^4 = x + 1. The steps are powers of its inverse.
    constexpr double g = 1.2207440846057596;
    const double n = static_cast<double>(index + 1);
    const auto wrap = [](double v) { return v - std::floor(v); };
    return {wrap(0.5 + n / g), wrap(0.5 + n / (g * g)), wrap(0.5 + n / (g * g * g))};
}

std::vector<SurfacePoint> sample_surface_points(const Soup& soup, std::size_t count) {
    std::vector<double> until; // area of all triangles up to and including this one
    double area = 0;
    for (std::size_t i = 0; i < soup.triangles.size(); ++i) {
        const auto [a, b, c] = soup.corners(i);
        until.push_back(area += 0.5 * length(cross(b - a, c - a)));
    }
    std::vector<SurfacePoint> out;
    if (area <= 0) return out;
    for (std::uint64_t i = 0; i < count; ++i) {
        Point u = even_point(i);
        const auto at = std::upper_bound(until.begin(), until.end(), u.x * area);
        const auto t = std::min(static_cast<std::size_t>(at - until.begin()), soup.triangles.size() - 1);
        const auto [a, b, c] = soup.corners(t);
        if (u.y + u.z > 1) u.y = 1 - u.y, u.z = 1 - u.z;
        const Point normal = cross(b - a, c - a);
        const double size = length(normal);
        out.push_back({a + (b - a) * u.y + (c - a) * u.z, size > 0 ? normal * (1 / size) : Point{}});
    }
    return out;
}

std::vector<Point> sample_surface(const Soup& soup, std::size_t count) {
    std::vector<Point> out;
    for (const SurfacePoint& point : sample_surface_points(soup, count)) out.push_back(point.at);
    return out;
}

Soup to_soup(const TriangleSoup& soup) {
    Soup out;
    for (const Vec3& v : soup.vertices)
        out.vertices.push_back({to_double(v.x), to_double(v.y), to_double(v.z)});
    out.triangles = soup.triangles;
    return out;
}

} // namespace lockstone::cook
