// Planes against convex solids: scenes, and a judge that uses the definition of the support point.
#pragma once

#include "oracle/convex_scenes.h"

namespace oracle {

/// A plane and a solid in the world, and their pose in the plane's frame as the engine computes it. Designed: the solid
/// lies on a face, an edge or a corner or nearly so, touches or nearly touches, has 5 mm to 800 m, and may be far from
/// the origin.
inline ConvexScene plane_scene(RandomReal& random, const HullPool& pool, ConvexKind kind, bool designed) {
    ConvexScene s{};
    s.is_ordinary = !designed || random.below(3) != 0;
    s.a = {lockstone::plane()};
    s.b = random_solid(random, pool, kind,
                       s.is_ordinary ? random.log_uniform(0.02, 4) : random.log_uniform(0.005, 800));
    const lockstone::Quat turn =
        designed ? awkward_rotation(random) : lockstone::normalized(random.rotation(0, 3.14159));
    const double reach = DoubleCore(s.b).reach();
    double height = random.uniform(-1.1, 1.1) * reach;
    if (designed) {
        const double gaps[] = {0, 0, 1e-7, -1e-7, 1e-4, -1e-4, 0.01, -0.01};
        const DoubleCore b(s.b, pose_of(turn, {0, 0, 0}));
        height = b.support({0, -1, 0}) + b.radius + gaps[random.below(8)];
    }
    using lockstone::Real;
    const lockstone::Vec3 ground{as_fixed<Real>(random.uniform(-100, 100)),
                                 as_fixed<Real>(random.uniform(-9, 9)),
                                 random.below(4) == 0 ? Real(9'000'000) : Real{}};
    const lockstone::Quat tilt =
        lockstone::normalized(random.rotation(0, random.below(2) == 0 ? 0 : 3.14159));
    const lockstone::UnitVec3 up = lockstone::to_rotation(tilt).y;
    const D3 at = as_double(up) * height;
    const lockstone::Vec3 above{as_fixed<Real>(at.x), as_fixed<Real>(at.y), as_fixed<Real>(at.z)};
    s.pose = lockstone::collide::plane_relative_pose({ground, tilt}, {ground + above, tilt * turn});
    return s;
}

/// The corners of a core; for a disc sixteen points of its rim and the lowest one.
inline std::vector<D3> corners_of(const DoubleCore& s) {
    std::vector<D3> out = s.points;
    const D3 down{0, -1, 0};
    switch (s.kind) {
    case ShapeKind::capsule:
        return {s.place({0, s.half.y, 0}), s.place({0, -s.half.y, 0})};
    case ShapeKind::box:
        for (int i = 0; i < 8; ++i)
            out.push_back(s.place(
                {i & 1 ? s.half.x : -s.half.x, i & 2 ? s.half.y : -s.half.y, i & 4 ? s.half.z : -s.half.z}));
        return out;
    case ShapeKind::cylinder:
    case ShapeKind::cone:
        for (int i = 0; i < 32; ++i) {
            const double angle = i * 0.39269908169872415;
            const double y = i < 16 ? -s.half.y : s.half.y,
                         r = s.kind == ShapeKind::cone && i >= 16 ? 0 : s.half.x;
            out.push_back(s.place({r * std::cos(angle), y, r * std::sin(angle)}));
        }
        out.push_back(s.support_point(down));
        return out;
    default:
        if (out.empty()) out.push_back(s.support_point(down));
        return out;
    }
}

/// The signed separation of a shape from the plane y = 0: the height of its lowest point.
inline double height_above_plane(const DoubleCore& b) { return -b.support({0, -1, 0}) - b.radius; }

inline double extent_of(const std::vector<D3>& points) {
    double most = 0;
    for (const D3& p : points)
        for (const D3& q : points) most = std::max(most, std::hypot(p.x - q.x, p.z - q.z));
    return most;
}

/// Returns an error sentence unless the manifold is right: it has points exactly when the lowest point is within the
/// margin, the plane's own normal, the lowest point among its points, all points on the shape's underside, and a spread
/// as wide as the shape's lowest part.
inline std::string judge_plane(const DoubleCore& b, double margin, const Manifold& m) {
    std::ostringstream why;
    const double truth = height_above_plane(b),
                 tolerance = 1.3e-7 + 1e-8 * (b.reach() + std::abs(b.center.y));
    if (m.count == 0) {
        if (truth < margin - tolerance) why << "no point for a separation of " << truth << "; ";
        return why.str();
    }
    if (truth > margin + tolerance) why << "a point for shapes " << truth << " apart; ";
    if (m.normal.x.raw != 0 || m.normal.y != lockstone::unit_one || m.normal.z.raw != 0)
        why << "another normal; ";
    double lowest = 1e300;
    std::vector<D3> points;
    for (std::uint32_t k = 0; k < m.count; ++k) {
        const double separation = as_double(m.points[k].separation);
        lowest = std::min(lowest, separation);
        if (separation > margin + 1e-7) why << "point " << k << " beyond the margin: " << separation << "; ";
        for (std::uint32_t l = 0; l < k; ++l)
            if (m.points[l].feature == m.points[k].feature)
                why << "points " << l << " and " << k << " share a feature; ";
        const D3 offset = as_double(m.points[k].position);
        if (truth < -15.9 || norm(offset) > 127) return why.str(); // the limits of separations and positions
        const D3 p = offset + b.center, on_b = p + D3{0, separation / 2, 0};
        points.push_back(on_b);
        if (std::abs(p.y - separation / 2) > tolerance) why << "point " << k << " is " << p.y << " high; ";
        const double out = b.outside(on_b) - b.radius, under = b.outside(on_b - D3{0, 0.001, 0}) - b.radius;
        if (out > tolerance) why << "point " << k << " is " << out << " outside; ";
        // Below a higher corner of a rounded core, the lowest point of its ball may lie within the shape.
        if (under <= 0 && b.radius == 0) why << "point " << k << " is not on the under side; ";
    }
    // A reduction of more than four points may keep a deepest point that is higher by this much.
    const double reduced = b.is_smooth() || b.points.size() > 4 ? std::ldexp(1, -13) : 0;
    if (lowest < truth - tolerance || lowest > truth + reduced + tolerance)
        why << "the deepest point is " << lowest << ", truly " << truth << "; ";
    std::vector<D3> flat;
    for (const D3& p : corners_of(b))
        if (p.y - b.radius < truth + 1e-7 * b.reach()) flat.push_back(p);
    if (extent_of(flat) > 0.01 * b.reach() && extent_of(points) < 0.7 * extent_of(flat))
        why << "points " << extent_of(points) << " apart of " << extent_of(flat) << "; ";
    return why.str();
}

} // namespace oracle
