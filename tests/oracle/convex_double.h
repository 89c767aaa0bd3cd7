// Double-precision references for convex shapes, from the definitions: support functions and membership of the cores,
// and judges that prove an answer about two cores right or wrong without another algorithm.
#pragma once

#include "collide/convex/convex.h"
#include "oracle/double_shapes.h"

#include <algorithm>
#include <span>
#include <vector>

namespace oracle {

using lockstone::collide::Long3;
using lockstone::shapes::Solid;

inline D3 from_bits(const Long3& v, int bits) {
    const double step = std::ldexp(1.0, -bits);
    return {static_cast<double>(v[0]) * step, static_cast<double>(v[1]) * step,
            static_cast<double>(v[2]) * step};
}

/// A solid without its rounding, or a triangle, placed in A's frame.
struct DoubleCore {
    ShapeKind kind = ShapeKind::sphere;
    double radius = 0;
    D3 center{0, 0, 0};
    D3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    D3 half{0, 0, 0};
    std::vector<D3> points;                               ///< of a hull or a triangle
    std::span<const std::array<std::uint8_t, 3>> faces{}; ///< of a hull, which the caller keeps alive

    DoubleCore(const Solid& s, const RelativePose& pose)
        : kind(s.geometry.kind), radius(as_double(s.geometry.radius)),
          center(as_double(pose.position)), axes{as_double(pose.rotation.x), as_double(pose.rotation.y),
                                                 as_double(pose.rotation.z)},
          half(as_double(s.geometry.half_extent)) {
        if (kind == ShapeKind::hull) {
            points.reserve(s.hull->vertices.size());
            for (const lockstone::LengthVec3& v : s.hull->vertices) points.push_back(place(as_double(v)));
            faces = s.hull->triangles;
        } else {
            const double factor = as_double(s.geometry.scale.x);
            radius *= factor;
            half = half * factor;
        }
    }
    explicit DoubleCore(const Solid& s)
        : DoubleCore(s, {lockstone::Rotation::identity(), lockstone::CoordinateVec3{}}) {}

    D3 place(D3 p) const { return center + axes[0] * p.x + axes[1] * p.y + axes[2] * p.z; }
    D3 local(D3 p) const {
        const D3 d = p - center;
        return {dot(axes[0], d), dot(axes[1], d), dot(axes[2], d)};
    }
    bool is_smooth() const { return kind == ShapeKind::cylinder || kind == ShapeKind::cone; }
    double reach() const {
        double most = norm(half);
        for (const D3& p : points) most = std::max(most, norm(p - center));
        return most + radius;
    }

    D3 support_point(D3 n) const {
        const D3 d{dot(axes[0], n), dot(axes[1], n), dot(axes[2], n)};
        const auto sign = [](double x) { return x < 0 ? -1.0 : 1.0; };
        const double flat = std::hypot(d.x, d.z), rx = flat > 0 ? d.x / flat : 1,
                     rz = flat > 0 ? d.z / flat : 0;
        switch (kind) {
        case ShapeKind::sphere:
            return center;
        case ShapeKind::capsule:
            return place({0, sign(d.y) * half.y, 0});
        case ShapeKind::box:
            return place({sign(d.x) * half.x, sign(d.y) * half.y, sign(d.z) * half.z});
        case ShapeKind::cylinder:
            return place({half.x * rx, sign(d.y) * half.y, half.x * rz});
        case ShapeKind::cone:
            if (d.y * 2 * half.y > half.x * flat) return place({0, half.y, 0});
            return place({half.x * rx, -half.y, half.x * rz});
        default:
            return *std::max_element(points.begin(), points.end(),
                                     [&](D3 a, D3 b) { return dot(a, n) < dot(b, n); });
        }
    }
    double support(D3 n) const {
        if (points.empty()) return dot(n, support_point(n));
        double most = dot(n, points[0]);
        for (const D3& p : points) most = std::max(most, dot(n, p));
        return most;
    }

    /// The distance of a point outside of the core; 0 or less inside. For a hull: the distance to the furthest plane.
    double outside(D3 point) const {
        const D3 p = local(point);
        const auto beyond = [](double x, double h) { return std::max(std::abs(x) - h, 0.0); };
        const double rim = std::hypot(p.x, p.z);
        switch (kind) {
        case ShapeKind::sphere:
            return norm(p);
        case ShapeKind::capsule:
            return norm({p.x, beyond(p.y, half.y), p.z});
        case ShapeKind::box:
            return norm({beyond(p.x, half.x), beyond(p.y, half.y), beyond(p.z, half.z)});
        case ShapeKind::cylinder:
            return std::hypot(std::max(rim - half.x, 0.0), beyond(p.y, half.y));
        case ShapeKind::cone: {
            const double side = ((p.y - half.y) * half.x + rim * 2 * half.y) / std::hypot(half.x, 2 * half.y);
            return std::max(side, -half.y - p.y);
        }
        default:
            break;
        }
        double most = -1e300;
        for (const auto& t : faces) {
            const D3 a = points[t[0]], n = cross(points[t[1]] - a, points[t[2]] - a);
            if (norm(n) > 0) most = std::max(most, dot(n, point - a) / norm(n));
        }
        return most;
    }
};

inline double separation_along(const DoubleCore& a, const DoubleCore& b, D3 n) {
    return -b.support(n * -1.0) - a.support(n);
}

/// The result of `closest_points` and `penetration` for two cores.
struct CoreAnswer {
    bool overlap;
    D3 normal;       ///< from a to b
    double distance; ///< negative: the depth
    D3 on_a, on_b;   ///< if apart
};
inline CoreAnswer ask(const Solid& a, const Solid& b, const RelativePose& pose) {
    using namespace lockstone;
    const collide::Convex ca = collide::convex_of(a, Rotation::identity(), CoordinateVec3{}),
                          cb = collide::convex_of(b, pose.rotation, pose.position);
    const collide::Gap gap = collide::closest_points(ca, cb);
    const auto metres = [](std::int64_t x) { return std::ldexp(static_cast<double>(x), -30); };
    if (!gap.overlap)
        return {false, from_bits(gap.normal_30, 30), metres(gap.distance_30), from_bits(gap.on_a_30, 30),
                from_bits(gap.on_b_30, 30)};
    const collide::Penetration p = collide::penetration(ca, cb);
    return {true, from_bits(p.normal_30, 30), -metres(p.depth_30), {}, {}};
}

/// The tolerance of answers: two steps of 2^-30 m, and the 30 bits of a direction over the shapes' reach.
inline double core_tolerance(const DoubleCore& a, const DoubleCore& b) {
    return 1e-8 + 1e-8 * (a.reach() + b.reach() + norm(b.center - a.center));
}

/// Concentric round shapes are nearly equally deep in all directions, and the search of the depth ends within 1 %.
inline double deep_slack(const DoubleCore& a, const DoubleCore& b, double separation) {
    const bool deep = -separation > 0.5 * std::min(a.reach() - a.radius, b.reach() - b.radius);
    return deep ? -0.01 * separation : 0;
}

/// The greatest separation of the cores over the exact directions of polytopes, a spread of others, and a search near
/// the best one. For overlapping cores it is minus the depth.
class SeparationSearch {
  public:
    SeparationSearch(const DoubleCore& first, const DoubleCore& second) : a(first), b(second) {}
    void consider(D3 n) {
        const double length = norm(n);
        if (length < 1e-9) return;
        n = n * (1 / length);
        if (const double s = separation_along(a, b, n); s > most) most = s, best = n;
    }
    void consider_both(D3 n) { consider(n), consider(n * -1.0); }
    void consider_axes() {
        for (const D3& x : a.axes) consider_both(x);
        for (const D3& y : b.axes) consider_both(y);
        for (const D3& x : a.axes)
            for (const D3& y : b.axes) consider_both(cross(x, y));
        consider_both(b.center - a.center);
        for (const auto& t : a.faces) consider_out_of(a, t, 1);
        for (const auto& t : b.faces) consider_out_of(b, t, -1);
    }
    void search(RandomReal& random, int spread, int tries) {
        for (int k = 0; k < spread; ++k) consider(random.direction());
        for (double step = 0.3; step > 1e-7; step *= 0.6)
            for (int k = 0; k < tries; ++k) {
                const D3 way = random.direction();
                consider(best + way * step);
            }
    }
    double separation() const { return most; }

  private:
    /// The inward normal of a face cannot separate two cores.
    void consider_out_of(const DoubleCore& s, const std::array<std::uint8_t, 3>& t, double side) {
        consider(cross(s.points[t[1]] - s.points[t[0]], s.points[t[2]] - s.points[t[0]]) * side);
    }

    const DoubleCore &a, &b;
    double most = -1e300;
    D3 best{0, 1, 0};
};

/// Returns an error sentence unless the answer is right. Apart: a plane that separates the cores by the distance, and
/// two points of them at that distance, prove it. Overlapping: moving b along the normal by the depth separates them,
/// and the search finds no direction with a shorter move.
inline std::string judge(const DoubleCore& a, const DoubleCore& b, const CoreAnswer& answer,
                         RandomReal& random, int effort) {
    std::ostringstream why;
    const double tolerance = core_tolerance(a, b);
    if (std::abs(norm(answer.normal) - 1) > 4e-9) why << "a normal of length " << norm(answer.normal) << "; ";
    const double along = separation_along(a, b, answer.normal);
    if (!answer.overlap) {
        const double between = norm(answer.on_b - answer.on_a);
        const double smooth = a.is_smooth() || b.is_smooth() ? 1e-6 * between + 5e-7 : 0;
        // Points are rounded to 2^-30 m. Across a small gap that turns the direction, and so the planes, by this much.
        const double turned =
            std::min(3e-9 / between, 2e-7) * (a.reach() + b.reach() + norm(b.center - a.center));
        if (answer.distance <= 0) why << "apart by " << answer.distance << "; ";
        if (between > along + tolerance + smooth + turned)
            why << "points " << between << " apart, planes " << along << "; ";
        if (std::abs(between - answer.distance) > tolerance)
            why << "says " << answer.distance << ", points " << between << "; ";
        const double out = std::max(a.outside(answer.on_a), b.outside(answer.on_b));
        if (out > tolerance) why << "a point " << out << " outside; ";
        return why.str();
    }
    if (std::abs(along - answer.distance) > 2 * tolerance)
        why << "a depth of " << -answer.distance << ", along its normal " << -along << "; ";
    SeparationSearch search(a, b);
    search.consider(answer.normal);
    search.consider_axes();
    search.search(random, 10 * effort, effort);
    double slack = a.is_smooth() || b.is_smooth() ? 5e-7 + tolerance - 2.5e-4 * along : 0;
    slack += deep_slack(a, b, along);
    if (search.separation() > along + tolerance + slack)
        why << "a depth of " << -along << ", another direction " << -search.separation() << "; ";
    return why.str();
}

} // namespace oracle
