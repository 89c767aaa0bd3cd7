// Volume, centre and inertia of closed surfaces as sums over tetrahedra with one common corner.
//
// A tetrahedron with corners 0, a, b, c and D = a . (b x c) has the volume D / 6, the first moment
// D (a + b + c) / 24 and the second moments D / 120 (s_i s_j + a_i a_j + b_i b_j + c_i c_j), where s = a + b + c.
// source: Tonon, Explicit Exact Formulas for the 3-D Tetrahedron Inertia Tensor, 2004.
#include "shapes/hull/hull.h"

#include "lockstone/math/math.h"
#include "shapes/mass.h"

#include <algorithm>
#include <tuple>

namespace lockstone::shapes {
namespace {

/// Sums of D times a polynomial. The common corner is inside the surface, so D is not negative except for
/// rounding, and no terms cancel.
struct Moments {
    Scaled volume{}, first[3]{}, second[6]{}; // second: xx, yy, zz, xy, xz, yz

    void add(LengthVec3 origin, LengthVec3 a, LengthVec3 b, LengthVec3 c) {
        const Scaled d = scaled(Wide::from(0) - exact_height(exact_normal(a, b, c), a, origin), -72);
        const std::int64_t p[3][3] = {
            {std::int64_t{a.x.raw} - origin.x.raw, std::int64_t{b.x.raw} - origin.x.raw,
             std::int64_t{c.x.raw} - origin.x.raw},
            {std::int64_t{a.y.raw} - origin.y.raw, std::int64_t{b.y.raw} - origin.y.raw,
             std::int64_t{c.y.raw} - origin.y.raw},
            {std::int64_t{a.z.raw} - origin.z.raw, std::int64_t{b.z.raw} - origin.z.raw,
             std::int64_t{c.z.raw} - origin.z.raw}};
        std::int64_t sum[3];
        for (int i = 0; i < 3; ++i) sum[i] = p[i][0] + p[i][1] + p[i][2];
        const auto product = [&](int i, int j) {
            Wide w = Wide::product(sum[i], sum[j]);
            for (int k = 0; k < 3; ++k) w = w + Wide::product(p[i][k], p[j][k]);
            return d * scaled(w, -48);
        };
        volume = volume + d;
        for (int i = 0; i < 3; ++i) {
            first[i] = first[i] + d * scaled(sum[i], 24);
            second[i] = second[i] + product(i, i);
        }
        second[3] = second[3] + product(0, 1);
        second[4] = second[4] + product(0, 2);
        second[5] = second[5] + product(1, 2);
    }

    SurfaceMass result(LengthVec3 origin) const {
        if (volume.mantissa <= 0) return {Scaled{}, to<Real>(origin), Matrix3<I20F44>{}};
        Scaled center[3], mean[6];
        for (int i = 0; i < 3; ++i) center[i] = first[i] / (4 * volume);
        const int row[6] = {0, 1, 2, 0, 0, 1}, column[6] = {0, 1, 2, 1, 2, 2};
        for (int i = 0; i < 6; ++i) mean[i] = second[i] / (20 * volume) - center[row[i]] * center[column[i]];
        const auto entry = [](Scaled s) { return unscaled<I20F44>(s); };
        const I20F44 xy = entry(-mean[3]), xz = entry(-mean[4]), yz = entry(-mean[5]);
        const auto at = [](Length o, Scaled offset) { return unscaled<Real>(scaled(o) + offset); };
        return {volume / scaled(6, 0),
                {at(origin.x, center[0]), at(origin.y, center[1]), at(origin.z, center[2])},
                {{entry(mean[1] + mean[2]), xy, xz},
                 {xy, entry(mean[0] + mean[2]), yz},
                 {xz, yz, entry(mean[0] + mean[1])}}};
    }
};

LengthVec3 mean_of(std::span<const LengthVec3> points) {
    const auto mean = [&](auto component) {
        std::int64_t sum = 0;
        for (const LengthVec3& p : points) sum += component(p).raw;
        return Length::from_raw(saturate_to_int32(divide_shifted(sum, std::ssize(points), 0)));
    };
    return {mean([](const LengthVec3& p) { return p.x; }), mean([](const LengthVec3& p) { return p.y; }),
            mean([](const LengthVec3& p) { return p.z; })};
}

template <class Index>
SurfaceMass sum_over(std::span<const LengthVec3> vertices, std::span<const std::array<Index, 3>> triangles) {
    if (vertices.empty()) return {};
    const LengthVec3 origin = mean_of(vertices);
    Moments moments;
    for (const auto& [a, b, c] : triangles) moments.add(origin, vertices[a], vertices[b], vertices[c]);
    return moments.result(origin);
}

} // namespace

// Volume + area r + sum over edges of length times angle between the triangles r^2 / 2 + ball.
Scaled rounded_volume(const Hull& hull, Scaled r) {
    struct Side {
        std::uint8_t low, high; // vertices of an edge
        std::uint16_t triangle;
    };
    std::vector<Side> sides;
    std::vector<UnitVec3> normals;
    Scaled twice_area{}, twice_wedges{};
    for (std::uint16_t i = 0; i < hull.triangles.size(); ++i) {
        const auto& t = hull.triangles[i];
        const WideVec3 n = exact_normal(hull.vertices[t[0]], hull.vertices[t[1]], hull.vertices[t[2]]);
        twice_area = twice_area + length_of(n);
        normals.push_back(unit_of(n));
        for (std::size_t k = 0; k < 3; ++k)
            sides.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3]), i});
    }
    std::ranges::sort(sides, [](const Side& a, const Side& b) {
        return std::tuple(a.low, a.high, a.triangle) < std::tuple(b.low, b.high, b.triangle);
    });
    for (std::size_t i = 0; i + 1 < sides.size(); i += 2) { // each edge has two sides
        const Vec3 m = to<Real>(normals[sides[i].triangle]), n = to<Real>(normals[sides[i + 1].triangle]);
        const Real angle = atan2(length(cross(m, n)), dot(m, n));
        const Vec3 edge = to<Real>(hull.vertices[sides[i].high]) - to<Real>(hull.vertices[sides[i].low]);
        twice_wedges = twice_wedges + scaled(angle) * scaled(length(edge));
    }
    const Scaled two = scaled(2, 0), ball = 4 * scaled_pi * (r * r * r) / scaled(3, 0);
    return hull.volume + twice_area * r / two + twice_wedges * (r * r) / two + ball;
}

namespace {

// The hull of the 26 vectors from a cube's centre to its corners, edges and faces, all of this length, has the
// volume of the unit ball. With length 1 its volume is 8 / sqrt(6).
constexpr Real corner_length = decimal<Real>("1.08648754");

} // namespace

SurfaceMass integrate(std::span<const LengthVec3> vertices,
                      std::span<const std::array<std::uint8_t, 3>> triangles) {
    return sum_over(vertices, triangles);
}
SurfaceMass integrate(std::span<const LengthVec3> vertices,
                      std::span<const std::array<std::uint32_t, 3>> triangles) {
    return sum_over(vertices, triangles);
}

ConvexSurface rounded_surface(const Hull& hull, Length radius, Real factor) {
    std::vector<LengthVec3> points;
    const Real reach = mul<Real>(radius, factor);
    for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
            for (int z = -1; z <= 1; ++z) {
                if (x == 0 && y == 0 && z == 0) continue;
                const LengthVec3 offset = scale<Length>(normalized(Vec3{Real(x), Real(y), Real(z)}), reach);
                for (const LengthVec3& v : hull.vertices) points.push_back(v + offset);
            }
    ConvexSurface surface;
    // Cannot fail: the points are not in one plane, because those of the hull are not.
    convex_hull(points, surface);
    return surface;
}

SurfaceMass integrate_rounded(const Hull& hull, Length radius) {
    const ConvexSurface surface = rounded_surface(hull, radius, corner_length);
    SurfaceMass mass = integrate(surface.vertices, surface.triangles);
    mass.volume = rounded_volume(hull, scaled(radius));
    return mass;
}

} // namespace lockstone::shapes
