// Double-precision references for the narrow phase, from the definitions and not from its code: signed separations,
// support functions, distance to a surface, and one checker for all manifold tests.
#pragma once

#include "collide/narrow_phase.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>

namespace oracle {

using lockstone::Geometry;
using lockstone::ShapeKind;
using lockstone::collide::Manifold;
using lockstone::collide::RelativePose;

template <lockstone::FixedPoint T> double as_double(T x) {
    return static_cast<double>(x.raw) / static_cast<double>(std::int64_t{1} << T::fraction_bits);
}

struct D3 {
    double x, y, z;
    double& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
    double operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
    friend D3 operator+(D3 a, D3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend D3 operator-(D3 a, D3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend D3 operator*(D3 a, double s) { return {a.x * s, a.y * s, a.z * s}; }
};
inline double dot(D3 a, D3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline D3 cross(D3 a, D3 b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline double norm(D3 a) { return std::sqrt(dot(a, a)); }
template <lockstone::FixedPoint T> D3 as_double(const lockstone::Vector3<T>& v) {
    return {as_double(v.x), as_double(v.y), as_double(v.z)};
}

/// A shape placed in A's frame: centre and three axes.
struct Placed {
    ShapeKind kind;
    double radius;
    D3 half, center;
    std::array<D3, 3> axes;

    D3 local(D3 p) const {
        const D3 d = p - center;
        return {dot(axes[0], d), dot(axes[1], d), dot(axes[2], d)};
    }
};
inline Placed place_a(const Geometry& g) {
    return {g.kind,
            as_double(g.radius),
            as_double(g.half_extent),
            {0, 0, 0},
            {D3{1, 0, 0}, D3{0, 1, 0}, D3{0, 0, 1}}};
}
inline Placed place_b(const Geometry& g, const RelativePose& p) {
    return {g.kind,
            as_double(g.radius),
            as_double(g.half_extent),
            as_double(p.position),
            {as_double(p.rotation.x), as_double(p.rotation.y), as_double(p.rotation.z)}};
}

/// The greatest n . x over the shape; for a plane finite only along its normal.
inline double support(const Placed& s, D3 n) {
    if (s.kind == ShapeKind::plane)
        return norm(cross(n, s.axes[1])) < 1e-6 && dot(n, s.axes[1]) > 0
                   ? dot(n, s.center)
                   : std::numeric_limits<double>::infinity();
    double reach = s.radius * norm(n) + dot(n, s.center);
    for (int i = 0; i < 3; ++i) reach += std::abs(dot(n, s.axes[static_cast<std::size_t>(i)])) * s.half[i];
    return reach;
}
/// The gap between the shapes along n, from A to B.
inline double separation_along(const Placed& a, const Placed& b, D3 n) {
    return -support(b, n * -1.0) - support(a, n);
}

/// Distance to the surface: negative inside.
inline double surface_distance(const Placed& s, D3 point) {
    D3 p = s.local(point);
    if (s.kind == ShapeKind::plane) return p.y;
    if (s.kind == ShapeKind::capsule) p.y -= std::clamp(p.y, -s.half.y, s.half.y);
    if (s.kind != ShapeKind::box) return norm(p) - s.radius;
    double inside = -std::numeric_limits<double>::infinity(), outside = 0;
    for (int i = 0; i < 3; ++i) {
        const double e = std::abs(p[i]) - s.half[i];
        inside = std::max(inside, e);
        outside += e > 0 ? e * e : 0;
    }
    return inside > 0 ? std::sqrt(outside) : inside;
}

/// The offset from the nearest point of a box to a point outside.
inline D3 beyond(const Placed& box, D3 point) {
    const D3 p = box.local(point);
    D3 out{};
    for (int i = 0; i < 3; ++i) {
        const double along = p[i] - std::clamp(p[i], -box.half[i], box.half[i]);
        out = out + box.axes[static_cast<std::size_t>(i)] * along;
    }
    return out;
}

/// The least separation over all 15 axes of two boxes (a segment or a point is a box of zero width): the exact depth
/// of an overlap; for boxes apart, a lower bound of their distance.
inline double separating_axis(const Placed& a, const Placed& b, double sin_min = 1e-7) {
    double best = -std::numeric_limits<double>::infinity();
    const auto core = [](Placed s) {
        s.radius = 0;
        s.kind = ShapeKind::box;
        return s;
    };
    const Placed ca = core(a), cb = core(b);
    const auto try_axis = [&](D3 n) {
        const double length = norm(n);
        if (length < sin_min) return;
        n = n * (1 / length);
        best = std::max({best, separation_along(ca, cb, n), separation_along(ca, cb, n * -1.0)});
    };
    for (const D3& e : a.axes) try_axis(e);
    for (const D3& e : b.axes) try_axis(e);
    for (const D3& e : a.axes)
        for (const D3& f : b.axes) try_axis(cross(e, f));
    return best - a.radius - b.radius;
}

/// The least distance of a segment (B's core) from A's core, by halving: the distance is convex along the segment.
inline double core_distance(const Placed& a, const Placed& b) {
    const auto distance = [&](double s) {
        Placed core = a;
        core.radius = 0;
        const double d = surface_distance(core, b.center + b.axes[1] * s);
        return std::max(d, 0.0);
    };
    double low = -b.half.y, high = b.half.y;
    if (b.kind == ShapeKind::sphere) return distance(0);
    for (int i = 0; i < 120; ++i) {
        const double third = (high - low) / 3;
        if (distance(low + third) <= distance(high - third))
            high -= third;
        else
            low += third;
    }
    return std::min({distance(low), distance((low + high) / 2), distance(-b.half.y), distance(b.half.y)});
}

/// Signed separation of two shapes: the distance if they are apart, minus the least separating translation if they
/// overlap. For two boxes apart it is a lower bound of the distance.
inline double separation(const Placed& a, const Placed& b) {
    if (a.kind == ShapeKind::plane) return separation_along(a, b, {0, 1, 0});
    if (a.kind == ShapeKind::box && b.kind == ShapeKind::box) return separating_axis(a, b);
    const double apart = core_distance(a, b);
    if (apart > 1e-9 || a.kind != ShapeKind::box) return apart - a.radius - b.radius;
    return separating_axis(a, b);
}

/// The tolerances of a manifold [m], shared by all tests.
struct Tolerance {
    double length = 2e-7;   ///< positions and separations of metre-sized shapes, about three Length steps
    double relative = 5e-8; ///< added for each metre of the shapes' reach
    double normal = 4e-9;   ///< |n| - 1
    double bias = 0.0005;   ///< lockstone::collide::face_bias
    double sin_min = 0.004; ///< below this sine, edge axes are left to the faces
};

/// The reach of a shape from its centre. A plane adds nothing: only the other shape's size counts.
inline double reach(const Placed& s) { return s.radius + norm(s.half); }

/// The error of leaving nearly parallel edge axes to the faces: at most their sine times the reach of the boxes.
inline double parallel_slack(const Placed& a, const Placed& b, double sin_min) {
    double least = 1;
    for (const D3& e : a.axes)
        for (const D3& f : b.axes)
            if (a.kind == ShapeKind::box &&
                (b.kind == ShapeKind::box || (b.kind == ShapeKind::capsule && &f == &b.axes[1])))
                least = std::min(least, norm(cross(e, f)));
    return least < sin_min * 1.2 ? 2 * sin_min * (reach(a) + reach(b)) : 0;
}

/// Returns an error sentence unless a manifold point, moved to the two surfaces, lies on them.
inline std::string check_surfaces(const Placed& a, const Placed& b, D3 normal, D3 on_a, D3 on_b,
                                  std::uint32_t k, std::uint32_t count, double tolerance, double bias,
                                  bool apart) {
    const bool boxes = a.kind == ShapeKind::box && b.kind == ShapeKind::box;
    const bool leans =
        b.kind == ShapeKind::capsule; // a slanted core's ends touch inside of the capsule's side
    double out_a = tolerance, out_b = tolerance;
    // A face that the bias prefers to an edge lets the point slide sideways past the face a little.
    if (a.kind == ShapeKind::box && leans)
        out_a += std::sqrt(2.2 * bias * (b.radius + norm(b.half) + norm(on_b - on_a)));
    if (leans && count == 2)
        out_b += bias; // two points for a core that crosses the line of contact at a small angle
    if (boxes && count == 1) out_a = out_b = 0.05; // the point of clamped edges
    if (boxes && count > 1 && apart) {             // parallel edges, no further beside
        out_a += 1e-6;
        out_b += std::sqrt(2.0) * bias; // than two cylinders of radius `bias` would be
    }
    double off_a = surface_distance(a, on_a), off_b = surface_distance(b, on_b);
    if (boxes &&
        count > 1) { // a corner up to 15 um beyond each of two sides is kept; along the normal it is exact
        if (off_a > out_a && off_a < 2.2e-5) off_a = std::abs(dot(beyond(a, on_a), normal));
        if (off_b > out_b && off_b < 2.2e-5) off_b = std::abs(dot(beyond(b, on_b), normal));
    }
    std::ostringstream why;
    if (off_a > out_a || (off_a < -out_a && a.kind != ShapeKind::capsule))
        why << "point " << k << " is " << off_a << " off A; ";
    if (off_b > out_b || (off_b < -out_b && !leans)) why << "point " << k << " is " << off_b << " off B; ";
    return why.str();
}

/// Returns an error sentence unless the manifold is right. All tests and the planted faults use it.
///   - the normal is a unit vector, and the shapes' separation along it is the true one, except for the face preference
///   - overlapping shapes have a point, shapes further apart than the margin do not
///   - no point is deeper than the separation along the normal, none is beyond the margin
///   - a step of half the separation against and along the normal ends on A's and B's surface
inline std::string check_manifold(const Geometry& ga, const Geometry& gb, const RelativePose& pose,
                                  double margin, const Manifold& m, const Tolerance& t = {}) {
    std::ostringstream why;
    const Placed a = place_a(ga), b = place_b(gb, pose);
    const double truth = separation(a, b);
    const double length_tolerance = t.length + t.relative * (reach(a) + reach(b));
    const double slack = t.bias + parallel_slack(a, b, t.sin_min);
    if (m.count > 4) why << "count " << m.count << "; ";
    if (m.count == 0) {
        if (truth < -length_tolerance) why << "misses an overlap of " << -truth << "; ";
        if ((ga.kind != ShapeKind::box || gb.kind == ShapeKind::sphere) && truth < margin - length_tolerance)
            why << "misses a gap of " << truth << " within the margin; ";
        return why.str();
    }
    if (truth > margin + length_tolerance) why << "a point for shapes " << truth << " apart; ";
    const D3 n = as_double(m.normal);
    if (std::abs(norm(n) - 1) > t.normal) why << "normal of length " << norm(n) << "; ";
    double along = separation_along(a, b, n), deepest = margin + 1;
    if (ga.kind == ShapeKind::box && gb.kind == ShapeKind::box) {
        if (along < truth - slack - length_tolerance || (truth < 0 && along > truth + length_tolerance))
            why << "separation along the normal is " << along << ", the true one " << truth << "; ";
    } else { // a capsule may extend past the side of a face: only its deepest point counts
        along = truth - slack;
        for (std::uint32_t k = 0; k < std::min(m.count, 4u); ++k)
            deepest = std::min(deepest, as_double(m.points[k].separation));
        if (std::abs(deepest - truth) > slack + length_tolerance && truth > -15.9)
            why << "the deepest point is " << deepest << ", the true separation " << truth << "; ";
    }
    for (std::uint32_t k = 0; k < std::min(m.count, 4u); ++k) {
        const double s = as_double(m.points[k].separation);
        if (s > margin + length_tolerance) why << "point " << k << " is beyond the margin: " << s << "; ";
        // Deep overlaps are clamped to the range of Separation.
        if (s < along - length_tolerance - 1e-9 && s > -15.9)
            why << "point " << k << " is deeper (" << s << ") than the shapes (" << along << "); ";
        if (s < -15.9) continue;
        const D3 p = as_double(m.points[k].position) + b.center;
        for (std::uint32_t l = 0; l < k; ++l)
            if (m.points[l].feature == m.points[k].feature)
                why << "points " << l << " and " << k << " share a feature; ";
        why << check_surfaces(a, b, n, p - n * (s / 2), p + n * (s / 2), k, m.count, length_tolerance, t.bias,
                              truth > 0);
    }
    return why.str();
}

template <lockstone::FixedPoint T> T as_fixed(double x) {
    return T::from_raw(static_cast<typename T::rep>(std::llround(std::ldexp(x, T::fraction_bits))));
}
inline lockstone::Quat quat_of(D3 axis, double angle) {
    using lockstone::Unit;
    const D3 v = axis * std::sin(angle / 2);
    const auto q = [](double x) { return as_fixed<Unit>(x); };
    return {q(v.x), q(v.y), q(v.z), q(std::cos(angle / 2))};
}
/// A generator of this file, so that scenes are equal on all machines.
class RandomReal {
    std::uint64_t state;

  public:
    explicit RandomReal(std::uint64_t seed) : state(seed) {}
    std::uint64_t bits() { // SplitMix64
        std::uint64_t z = (state += 0x9e3779b97f4a7c15u);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }
    double uniform(double low, double high) {
        return low + (high - low) * static_cast<double>(bits() >> 11) / 9007199254740992.0;
    }
    double log_uniform(double low, double high) { return low * std::pow(high / low, uniform(0, 1)); }
    std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(bits() % n); }
    D3 direction() {
        while (true) {
            const double x = uniform(-1, 1), y = uniform(-1, 1), z = uniform(-1, 1);
            const D3 d{x, y, z};
            if (const double l = norm(d); l > 0.05 && l < 1) return d * (1 / l);
        }
    }
    // The order of evaluation of two draws in one expression depends on the compiler; these functions fix it.
    D3 vector(double length_min, double length_max) {
        const D3 d = direction();
        return d * uniform(length_min, length_max);
    }
    lockstone::Quat rotation(double angle_min, double angle_max) {
        const D3 axis = direction();
        return quat_of(axis, uniform(angle_min, angle_max));
    }
};

inline RelativePose pose_of(lockstone::Quat q, D3 position) {
    using lockstone::Coordinate;
    return {lockstone::to_rotation(q),
            {as_fixed<Coordinate>(position.x), as_fixed<Coordinate>(position.y),
             as_fixed<Coordinate>(position.z)}};
}

/// A pair of shapes and their relative pose.
struct Scene {
    Geometry a, b;
    RelativePose pose;
};

inline Geometry random_shape(RandomReal& random, ShapeKind kind, double size) {
    const auto real = [](double x) { return as_fixed<lockstone::Real>(x); };
    const double x = random.uniform(0.2, 1), y = random.uniform(0.2, 1), z = random.uniform(0.2, 1);
    switch (kind) {
    case ShapeKind::sphere:
        return lockstone::sphere(real(size));
    case ShapeKind::capsule:
        return lockstone::capsule(real(size * x), real(size * 1.5 * (y - 0.2)));
    case ShapeKind::box:
        return lockstone::box(real(size * x), real(size * y), real(size * z));
    default:
        return lockstone::plane();
    }
}

/// Random, axis-aligned and nearly aligned orientations in turn; about two thirds of the poses touch.
inline Scene random_scene(RandomReal& random, ShapeKind kind_a, ShapeKind kind_b, double size_min,
                          double size_max) {
    Scene s{};
    const double size_a = random.log_uniform(size_min, size_max);
    const double size_b =
        random.log_uniform(std::max(size_min, size_a / 300), std::min(size_max, size_a * 300));
    s.a = random_shape(random, kind_a, size_a);
    s.b = random_shape(random, kind_b, size_b);
    D3 axis = random.direction();
    double angle = random.uniform(0, 3.14159);
    if (const std::uint32_t style = random.below(3); style != 0) {
        axis = {0, 0, 0};
        axis[static_cast<int>(random.below(3))] = 1;
        angle = random.below(3) * 1.5707963267948966;
        if (style == 2) {
            const double turn = random.log_uniform(1e-6, 0.03), tilt = random.log_uniform(1e-6, 0.03);
            angle += turn * random.uniform(-1, 1);
            axis = axis + random.direction() * tilt;
            axis = axis * (1 / norm(axis));
        }
    }
    const double reaches = as_double(s.a.radius) + norm(as_double(s.a.half_extent)) + as_double(s.b.radius) +
                           norm(as_double(s.b.half_extent));
    D3 offset = random.vector(0, 1.2 * reaches);
    if (kind_a == ShapeKind::plane) offset = {0, random.uniform(-0.5, 1) * reaches, 0};
    s.pose = pose_of(quat_of(axis, angle), offset);
    return s;
}

/// The manifold of two shapes without assets.
inline Manifold collide_geometries(const Geometry& a, const Geometry& b, const RelativePose& pose,
                                   lockstone::Length margin) {
    lockstone::collide::NarrowScratch scratch;
    lockstone::collide::Manifolds all;
    std::memset(static_cast<void*>(&all), 0xa5, sizeof all); // earlier content must have no effect
    lockstone::collide::collide({a}, {b}, pose, margin, scratch, all);
    return all.count == 0 ? Manifold{} : all.items[0];
}

/// 10,000 poses by default, 100,000 with LOCKSTONE_LONG=1 in the environment.
inline int pose_count() { return std::getenv("LOCKSTONE_LONG") != nullptr ? 100'000 : 10'000; }

} // namespace oracle
