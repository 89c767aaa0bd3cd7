// Convex solids in double precision for the tests of casts, from the definitions: distance of a point to a core,
// support, and the point where a ray enters, found by ternary search and bisection.
#pragma once

#include "collide/query/cast.h"
#include "double_shapes.h"
#include "lockstone/math/math.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

namespace cast_oracle {

using namespace lockstone;

// Own names: other references of this family have functions with the names of convert.h.
template <FixedPoint T> double value(T x) {
    return static_cast<double>(x.raw) / static_cast<double>(std::int64_t{1} << T::fraction_bits);
}
template <FixedPoint T> T fixed(double x) {
    return T::from_raw(static_cast<typename T::rep>(
        std::llround(x * static_cast<double>(std::int64_t{1} << T::fraction_bits))));
}

using V = oracle::D3;
using oracle::cross, oracle::dot, oracle::norm;
inline V unit(V a) { return a * (1 / norm(a)); }
template <FixedPoint T> V of(const Vector3<T>& v) { return {value(v.x), value(v.y), value(v.z)}; }
inline CoordinateVec3 coordinates(V v) {
    return {fixed<Coordinate>(v.x), fixed<Coordinate>(v.y), fixed<Coordinate>(v.z)};
}

/// Sizes with the scale applied.
struct Body {
    ShapeKind kind;
    double radius;
    V half;
};
inline Body body_of(const Geometry& g) {
    const double s = value(g.scale.x);
    return {g.kind, value(g.radius) * s, of(g.half_extent) * s};
}

/// Distance of a point in a half plane (rho >= 0) to the segment from a to b.
inline double to_segment(double px, double py, double ax, double ay, double bx, double by) {
    const double dx = bx - ax, dy = by - ay, n = dx * dx + dy * dy;
    const double t = n == 0 ? 0 : std::clamp(((px - ax) * dx + (py - ay) * dy) / n, 0.0, 1.0);
    return std::hypot(px - ax - t * dx, py - ay - t * dy);
}
/// Distance of a point to the core; 0 inside.
inline double core_distance(const Body& s, V p) {
    const double rho = std::hypot(p.x, p.z);
    switch (s.kind) {
    case ShapeKind::sphere:
        return norm(p);
    case ShapeKind::capsule:
        return std::hypot(rho, std::max(0.0, std::abs(p.y) - s.half.y));
    case ShapeKind::cylinder:
        return std::hypot(std::max(0.0, rho - s.half.x), std::max(0.0, std::abs(p.y) - s.half.y));
    case ShapeKind::cone: {
        const bool inside = p.y >= -s.half.y && rho * 2 * s.half.y <= s.half.x * (s.half.y - p.y);
        return inside ? 0
                      : std::min(to_segment(rho, p.y, 0, -s.half.y, s.half.x, -s.half.y),
                                 to_segment(rho, p.y, s.half.x, -s.half.y, 0, s.half.y));
    }
    default:
        return norm({std::max(0.0, std::abs(p.x) - s.half.x), std::max(0.0, std::abs(p.y) - s.half.y),
                     std::max(0.0, std::abs(p.z) - s.half.z)});
    }
}
inline double outside(const Body& s, V p) { return core_distance(s, p) - s.radius; }
inline double support(const Body& s, V n) {
    const double side = std::hypot(n.x, n.z);
    const double round = s.radius * norm(n);
    switch (s.kind) {
    case ShapeKind::sphere:
        return round;
    case ShapeKind::capsule:
        return round + std::abs(n.y) * s.half.y;
    case ShapeKind::cylinder:
        return round + std::abs(n.y) * s.half.y + side * s.half.x;
    case ShapeKind::cone:
        return round + std::max(n.y * s.half.y, -n.y * s.half.y + side * s.half.x);
    default:
        return round + std::abs(n.x) * s.half.x + std::abs(n.y) * s.half.y + std::abs(n.z) * s.half.z;
    }
}
inline double reach(const Body& s) { return s.radius + norm(s.half); }

/// A search along a unit direction, for a function that is convex along it and at most 0 inside: the place of its least
/// value in 0..length, and the first place where it is at most 0.
struct Entry {
    double lowest, least;
    std::optional<double> at;
};
template <class F> Entry entry_of(F&& f, double begin, double end) {
    double a = begin, b = end;
    for (int i = 0; i < 120; ++i) {
        const double x = a + (b - a) / 3, y = b - (b - a) / 3;
        const double fx = f(x), fy = f(y);
        if (fx <= fy)
            b = y;
        else
            a = x;
    }
    const double low = (a + b) / 2;
    Entry e{low, f(low), std::nullopt};
    if (e.least > 0) return e;
    double out = begin, in = low;
    if (f(begin) <= 0) {
        e.at = begin;
        return e;
    }
    for (int i = 0; i < 80; ++i) {
        const double middle = (out + in) / 2;
        (f(middle) <= 0 ? in : out) = middle;
    }
    e.at = in;
    return e;
}

struct RandomCast {
    std::mt19937_64 engine;
    double operator()(double low, double high) {
        return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53;
    }
    V direction() {
        for (;;) {
            const V v{(*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1)};
            if (norm(v) > 0.05 && norm(v) < 1) return unit(v);
        }
    }
    V in_box(double half) { return {(*this)(-half, half), (*this)(-half, half), (*this)(-half, half)}; }
    /// A size, uniform on a logarithmic scale.
    double size(double low, double high) { return std::exp((*this)(std::log(low), std::log(high))); }
    Quat rotation() {
        const V a = direction();
        return from_axis_angle({fixed<Unit>(a.x), fixed<Unit>(a.y), fixed<Unit>(a.z)},
                               fixed<Real>((*this)(-3.1, 3.1)));
    }
};
inline Real real(double x) { return fixed<Real>(x); }

/// A primitive of one of the five kinds, sometimes rounded, sometimes with one thin side.
inline Geometry random_primitive(RandomCast& random, ShapeKind kind, double low, double high, bool round) {
    const auto size = [&] { return real(random.size(low, high)); };
    Geometry g{};
    switch (kind) {
    case ShapeKind::sphere:
        return sphere(size());
    case ShapeKind::capsule:
        return capsule(size(), size());
    case ShapeKind::cylinder:
        g = cylinder(size(), size());
        break;
    case ShapeKind::cone:
        g = cone(size(), size());
        break;
    default:
        g = box(size(), size(), size());
    }
    return round ? rounded(g, size()) : g;
}

/// Solids by geometry. Hulls, compounds and ground come from the library.
struct Solids {
    std::shared_ptr<AssetLibrary> library = std::make_shared<AssetLibrary>();
    std::optional<shapes::SolidCache> cache;

    shapes::Solid operator()(const Geometry& g) {
        if (!cache) cache.emplace(library);
        return cache->resolve(g).value();
    }
};

inline int samples(int quick, int thorough) {
    return std::getenv("LOCKSTONE_LONG") != nullptr ? thorough : quick;
}

} // namespace cast_oracle
