// Spheres and capsules against each other: closest points of their cores, with a radius around each.
//
// source: Ericson, Real-Time Collision Detection, 5.1.9 (closest points of two segments)
#include "collide/integer.h"

namespace lockstone::collide {
namespace {

/// Two capsule cores: A's runs along y through the origin, B's along `axis` through `center`.
struct Segments {
    Long3 center, axis;          // 24 and 30 fraction bits
    std::int64_t half_a, half_b; // 24

    /// From A's point at height s to B's point at u, 30 fraction bits.
    Long3 gap(std::int64_t s, std::int64_t u) const {
        const Long3 between = up(center, 30) + axis * u;
        return shifted({between[0], between[1] - up(s, 30), between[2]}, 24);
    }
    std::int64_t closest_on_a(std::int64_t u) const {
        return clamped(center[1] + shift_right_rounded(u * axis[1], 30), -half_a, half_a);
    }
    std::int64_t closest_on_b(std::int64_t s) const {
        const std::int64_t along = s * axis[1] - dot(center, axis);
        return clamped(shift_right_rounded(along, 30), -half_b, half_b);
    }
    /// The range of heights on A that B is beside; low > high when it is empty.
    std::int64_t beside_low() const { return larger(-half_a, center[1] - reach_b()); }
    std::int64_t beside_high() const { return smaller(half_a, center[1] + reach_b()); }

  private:
    std::int64_t reach_b() const { return shift_right_rounded(half_b * absolute(axis[1]), 30); }
};

/// The parameter on A of the closest points, before B's ends are considered.
///   sin^2 s = center . (y - axis.y axis)        (sin^2 without cancellation: axis.x^2 + axis.z^2)
std::int64_t closest_parameter(const Segments& g) {
    const std::int64_t sin2_60 = g.axis[0] * g.axis[0] + g.axis[2] * g.axis[2];
    if (sin2_60 < (std::int64_t{1} << 34)) // within 1.2e-4 rad of parallel: the middle of the common range
        return clamped((g.beside_low() + g.beside_high()) >> 1, -g.half_a, g.half_a);
    const Long3 across{shift_right_rounded(-g.axis[1] * g.axis[0], 30), shift_right_rounded(sin2_60, 30),
                       shift_right_rounded(-g.axis[1] * g.axis[2], 30)};
    return ratio_clamped(dot(g.center, across), sin2_60, 30, -g.half_a, g.half_a);
}

/// When the cores cross, the shortest way out is along y x axis; when they are parallel, along x.
Long3 crossing_normal(const Segments& g) {
    const Direction across = direction_of_30({g.axis[2], 0, -g.axis[0]});
    if (across.length == 0) return {one_30, 0, 0};
    return dot(across.unit, g.center) < 0 ? -across.unit : across.unit;
}

/// Adds two points where B is beside A along one line of contact. Returns false when B crosses or leaves that
/// line.
bool add_line(const Geometry& a, const Geometry& b, const Segments& g, const Direction& to_b, Length margin,
              Manifold& out) {
    const std::int64_t low = g.beside_low(), high = g.beside_high();
    if (low >= high || absolute(g.axis[1]) < one_30 / 2) return false;
    const std::int64_t radius = smaller(a.radius.raw, b.radius.raw);
    const std::int64_t bias = smaller(face_bias.raw >> 3, radius / 64); // 24 fraction bits
    std::int64_t distance[2];
    const std::int64_t heights[2] = {low, high};
    for (int k = 0; k < 2; ++k) {
        const std::int64_t u = ratio_clamped(heights[k] - g.center[1], g.axis[1], 30, -g.half_b, g.half_b);
        const Long3 gap = g.gap(heights[k], u);
        const std::int64_t length = direction_of_30(gap).length;
        distance[k] = shift_right_rounded(dot(shifted(gap, 6), to_b.unit), 24);
        // The cores' points are off the line by w, w^2 = length^2 - distance^2, and the surface by w^2 / 2
        // radius.
        const std::int64_t w2_40 = ((length - distance[k]) >> 10) * ((length + distance[k]) >> 10);
        if (w2_40 > (2 * bias * radius) >> 8) return false;
    }
    constexpr std::int64_t micrometre_30 = 1 << 10;
    if (smaller(distance[0], distance[1]) > to_b.length + micrometre_30) return false; // the ends are closer
    for (std::uint32_t k = 0; k < 2; ++k)
        add_round_point(out, {0, up(heights[k], 6), 0}, to_b.unit, distance[k], a.radius, b.radius, margin,
                        1 + k);
    return true;
}

} // namespace

void collide_sphere_sphere(const Geometry& a, const Geometry& b, const RelativePose& pose, Length margin,
                           Manifold& out) {
    Direction to_b = direction_of_30(up(raw(pose.position), 6));
    if (to_b.length == 0) to_b.unit = {0, one_30, 0};
    out.normal = unit_of_30(to_b.unit);
    add_round_point(out, Long3{}, to_b.unit, to_b.length, a.radius, b.radius, margin, 1);
}

void collide_capsule_sphere(const Geometry& a, const Geometry& b, const RelativePose& pose, Length margin,
                            Manifold& out) {
    const Long3 center = raw(pose.position);
    const std::int64_t s = clamped(center[1], -a.half_extent.y.raw, a.half_extent.y.raw);
    Direction to_b = direction_of_30(up({center[0], center[1] - s, center[2]}, 6));
    if (to_b.length == 0) to_b.unit = {one_30, 0, 0};
    out.normal = unit_of_30(to_b.unit);
    add_round_point(out, {0, up(s, 6), 0}, to_b.unit, to_b.length, a.radius, b.radius, margin, 1);
}

void collide_capsule_capsule(const Geometry& a, const Geometry& b, const RelativePose& pose, Length margin,
                             Manifold& out) {
    const Segments g{raw(pose.position), raw(pose.rotation.y), a.half_extent.y.raw, b.half_extent.y.raw};
    const std::int64_t u = g.closest_on_b(closest_parameter(g));
    const std::int64_t s = g.closest_on_a(u);
    Direction to_b = direction_of_30(g.gap(s, u));
    if (to_b.length == 0) to_b.unit = crossing_normal(g);
    out.normal = unit_of_30(to_b.unit);
    if (to_b.length > up(std::int64_t{a.radius.raw} + b.radius.raw + margin.raw, 6)) return;
    if (add_line(a, b, g, to_b, margin, out)) return;
    add_round_point(out, {0, up(s, 6), 0}, to_b.unit, to_b.length, a.radius, b.radius, margin, 3);
}

} // namespace lockstone::collide
