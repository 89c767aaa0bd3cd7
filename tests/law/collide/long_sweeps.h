// Sweeps of long bodies against one triangle. For the tests and for the planted faults.
#pragma once

#include "collide/query/cast.h"
#include "shapes/mesh/face.h"
#include "support/random.h"

#include <array>
#include <cmath>
#include <string>

namespace lockstone::test {

/// A body of 2 to 10 m that turns while it moves, and a triangle of up to 4 m that may move and turn too.
struct LongSweep {
    collide::Sweep triangle, body;
    shapes::Solid whole, thin; ///< the body, and the body with half of its rounding
    std::array<Vec3, 3> corners;
};

inline LongSweep long_sweep(scene::RandomPoint& random) {
    using namespace scene;
    const double half = random(1, 5);
    const Real h = real(half), r = real(random(0.03, 0.3));
    const Geometry shapes[] = {capsule(r, h), box(r, h, r), cylinder(r, h), rounded(box(r, h, r), r)};
    const shapes::Solid whole{shapes[static_cast<std::size_t>(random(0, 3.999))]};
    LongSweep s{{}, {}, whole, whole, {}};
    s.thin.geometry.radius = Length::from_raw(whole.geometry.radius.raw / 2);
    for (Vec3& corner : s.corners) corner = vec3(random(0.3, 2) * random.direction());
    const auto turned = [&](Quat from, double angle) {
        const D3 axis = random.direction();
        return normalized(
            from_axis_angle({quantize<Unit>(axis[0]), quantize<Unit>(axis[1]), quantize<Unit>(axis[2])},
                            real(angle)) *
            from);
    };
    const Quat from = random.rotation(), triangle = random.rotation();
    // A point of the body moves towards the triangle, from any part of the body's length.
    const Vec3 along = rotate(from, Vec3{Real{}, real(random(-half, half)), Real{}}),
               start = vec3(random(0.3, 3) * random.direction()),
               end = vec3(random(0, 1) * random.direction());
    s.body = {{start - along, from}, {end - along, turned(from, random(0, 0.9))}, Transform::identity()};
    s.triangle = {{Vec3{}, triangle}, {Vec3{}, triangle}, Transform::identity()};
    if (random(0, 1) < 0.3)
        s.triangle.to = {vec3(random(0, 0.2) * random.direction()), turned(triangle, random(0, 0.3))};
    return s;
}

/// A body that turns about its centre, and a triangle that its end reaches in the middle of the turn but neither at the
/// start nor at the end.
inline LongSweep pendulum(scene::RandomPoint& random) {
    using namespace scene;
    const double half = random(1, 5), radius = random(0.03, 0.3), angle = random(0.4, 0.9);
    const shapes::Solid whole{capsule(real(radius), real(half))};
    LongSweep s{{}, {}, whole, whole, {}};
    s.thin.geometry.radius = Length::from_raw(whole.geometry.radius.raw / 2);
    const Quat middle = random.rotation();
    const Vec3 x = rotate(middle, Vec3{Real(1), {}, {}}), y = rotate(middle, Vec3{{}, Real(1), {}}),
               z = rotate(middle, Vec3{{}, {}, Real(1)});
    const auto turned = [&](double by) {
        return normalized(from_axis_angle(normalized(z), real(by)) * middle);
    };
    s.body = {{Vec3{}, turned(-angle / 2)}, {Vec3{}, turned(angle / 2)}, Transform::identity()};
    s.triangle = {Transform::identity(), Transform::identity(), Transform::identity()};
    const double low = std::cos(angle / 2), height = radius + half * (low + random(0.1, 0.9) * (1 - low));
    for (std::size_t k = 0; k < 3; ++k) {
        const double at = 2.0944 * static_cast<double>(k) + random(-0.3, 0.3), far = random(0.3, 1.5);
        s.corners[k] = y * real(height) + x * real(far * std::cos(at)) + z * real(far * std::sin(at));
    }
    return s;
}

struct LongSweepCounts {
    int stopped = 0, passed = 0;
    int skipped = 0; ///< began too near, or behind the triangle
};

/// Returns a sentence if a sweep stops the body at another fraction than the search for the time of impact, which does
/// not test the plane of the triangle; or if the gap is below nine tenths of its target before that time.
inline std::string long_sweep_fault(scene::RandomPoint& random, LongSweepCounts& counts) {
    using collide::stop_gap;
    const LongSweep s = random(0, 1) < 0.1 ? pendulum(random) : long_sweep(random);
    AssetLibrary library;
    const std::array<std::uint32_t, 3> all{0, 1, 2};
    const Result<AssetId> id = library.add(bake_mesh({.vertices = s.corners, .triangles = {&all, 1}}));
    if (!id) return "";
    shapes::SolidCache cache(std::make_shared<const AssetLibrary>(std::move(library)));
    const shapes::Solid triangle = cache.resolve(instance(ShapeKind::mesh, *id)).value();
    collide::NarrowScratch scratch;
    const auto impact = [&](const shapes::Solid& of, Length target) {
        return collide::time_of_impact(triangle, s.triangle, of, s.body, target, scratch);
    };
    const shapes::Face face = shapes::face_at(triangle, 0);
    const CoordinateVec3 centre = collide::relative_pose(s.triangle.from, s.body.from).position;
    const Real above = dot<Real>(to<Real>(centre - face.corner[0]), face.normal);
    if (above < Real{} || impact(s.whole, stop_gap + stop_gap) == Unit{}) return ++counts.skipped, "";
    const Unit surface = impact(s.whole, stop_gap),
               stop = collide::stop_fraction(triangle, s.triangle, s.whole, s.body, {},
                                             collide::Held::not_at_all, scratch);
    const bool sinks =
        surface != unit_one && s.whole.geometry.radius != Length{} && impact(s.thin, stop_gap) == unit_one;
    if (stop != (sinks ? unit_one : surface))
        return "stops at " + std::to_string(to_double(stop)) + ", meets at " +
               std::to_string(to_double(surface));
    ++(stop == unit_one ? counts.passed : counts.stopped);
    for (int k = 1; k < 40; ++k) {
        const Unit at = Unit::from_raw(static_cast<std::int32_t>(std::int64_t{surface.raw} * k / 40));
        collide::Nearest nearest{};
        collide::nearest_points(
            triangle, s.whole,
            collide::relative_pose(collide::pose_at(s.triangle, at), collide::pose_at(s.body, at)),
            Coordinate(100), scratch, nearest);
        if (to_double(nearest.distance) < 0.9 * to_double(stop_gap))
            return "is at " + std::to_string(to_double(nearest.distance)) + " m before it meets";
    }
    return "";
}

/// Returns a sentence if a point of a body moves further, in the frame of another that turns, than relative_motion().
inline std::string relative_motion_fault(scene::RandomPoint& random) {
    using namespace scene;
    const LongSweep s = long_sweep(random);
    const double reach = random(0, 5);
    const Vec3 point = vec3(reach * random.direction());
    const auto in_triangle = [&](int k) {
        const Unit at = Unit::from_raw(static_cast<std::int32_t>((std::int64_t{1} << 30) * k / 40));
        return inverse_mul(collide::body_pose_at(s.triangle, at), collide::body_pose_at(s.body, at) * point);
    };
    const double bound = to_double(collide::relative_motion(s.triangle, s.body, real(reach + 0.001)));
    for (int k = 1; k <= 40; ++k)
        if (const double moved = to_double(length(in_triangle(k) - in_triangle(0))); moved > bound)
            return "moved by " + std::to_string(moved) + " m, and the bound is " + std::to_string(bound);
    return "";
}

} // namespace lockstone::test
