// Pairs of convex solids of every kind in random and in awkward poses.
#pragma once

#include "oracle/convex_double.h"
#include "support/rigs/scale_field.h"

#include <memory>

namespace oracle {

/// The kinds of the matrix: primitives, hulls, and rounded forms of both.
enum class ConvexKind {
    sphere,
    capsule,
    cylinder,
    cone,
    box,
    hull,
    round_cylinder,
    round_cone,
    round_box,
    round_hull,
    plane ///< only as A
};
inline constexpr int convex_kinds = 10; ///< without the plane
inline const char* name_of(ConvexKind kind) {
    constexpr const char* names[] = {"sphere",    "capsule", "cylinder", "cone",  "box",  "hull",
                                     "~cylinder", "~cone",   "~box",     "~hull", "plane"};
    return names[static_cast<std::size_t>(kind)];
}
inline ShapeKind core_kind(ConvexKind kind) {
    constexpr ShapeKind kinds[] = {ShapeKind::sphere,   ShapeKind::capsule, ShapeKind::cylinder,
                                   ShapeKind::cone,     ShapeKind::box,     ShapeKind::hull,
                                   ShapeKind::cylinder, ShapeKind::cone,    ShapeKind::box,
                                   ShapeKind::hull,     ShapeKind::plane};
    return kinds[static_cast<std::size_t>(kind)];
}

/// Hulls of many sizes: blobs, cut cubes, needles, plates near the least width, and one of 200 corners.
class HullPool {
  public:
    explicit HullPool(std::uint64_t seed) {
        RandomReal random(seed);
        for (int i = 0; hulls.size() < 48 && i < 4000; ++i) add(random, i);
    }
    const std::vector<Solid>& all() const { return hulls; }
    /// A hull of about this size, within a factor of 3 if there is one.
    const Solid& pick(RandomReal& random, double size) const {
        const Solid* best = nullptr;
        double least = 1e300;
        for (int k = 0; k < 6; ++k) {
            const std::size_t i = random.below(static_cast<std::uint32_t>(hulls.size()));
            const double off = std::abs(std::log(reaches[i] / size));
            if (off < least) least = off, best = &hulls[i];
        }
        return *best;
    }

  private:
    void add(RandomReal& random, int i) {
        const double size = random.log_uniform(0.01, 20);
        const int style = i % 6,
                  count = style == 5 ? 200 : 5 + static_cast<int>(random.below(i % 4 == 0 ? 40 : 12));
        D3 stretch{1, 1, 1};
        if (style == 1) stretch.y = std::min(1.0, 0.006 / size);                             // a plate
        if (style == 2) stretch.x = stretch.z = std::min(1.0, std::max(0.006 / size, 0.01)); // a needle
        std::vector<lockstone::LengthVec3> points;
        for (int k = 0; k < count; ++k) {
            D3 p = style == 5 ? random.direction() : random.vector(0, 1);
            if (style == 3 || (style == 4 && random.below(3) != 0)) // corners of a cube
                for (int axis = 0; axis < 3; ++axis) p[axis] = p[axis] < 0 ? -0.5 : 0.5;
            points.push_back({as_fixed<lockstone::Length>(p.x * stretch.x * size),
                              as_fixed<lockstone::Length>(p.y * stretch.y * size),
                              as_fixed<lockstone::Length>(p.z * stretch.z * size)});
        }
        const auto baked = lockstone::bake_hull(points);
        if (!baked) return;
        const auto id = library.add(baked);
        if (!id) return;
        hulls.push_back({library.geometry(*id).value(), library.find(*id)->hull.get()});
        reaches.push_back(DoubleCore(hulls.back()).reach());
    }

    lockstone::AssetLibrary library;
    std::vector<Solid> hulls;
    std::vector<double> reaches; ///< of each hull
};

struct ConvexScene {
    Solid a, b;
    RelativePose pose;
    /// sizes within a factor of 100 of each other and of a metre: the tests then compare with FCL
    bool is_ordinary;
};

inline Solid random_solid(RandomReal& random, const HullPool& pool, ConvexKind kind, double size) {
    const auto real = [](double x) { return as_fixed<lockstone::Real>(std::clamp(x, 0.0025, 100.0)); };
    const double thin = random.below(4) == 0 ? 0.01 : 0.2;
    const double x = random.log_uniform(thin, 1), y = random.log_uniform(thin, 1),
                 z = random.log_uniform(thin, 1);
    const double factor = size > 90 ? 8 : 1; // static shapes of up to 800 m
    const double s = size / factor;
    Solid solid{lockstone::sphere(real(s))};
    switch (core_kind(kind)) {
    case ShapeKind::capsule:
        solid = {lockstone::capsule(real(s * x / 2), real(s * y / 2))};
        break;
    case ShapeKind::cylinder:
        solid = {lockstone::cylinder(real(s * x), real(s * y))};
        break;
    case ShapeKind::cone:
        solid = {lockstone::cone(real(s * x), real(s * y))};
        break;
    case ShapeKind::box:
        solid = {lockstone::box(real(s * x), real(s * y), real(s * z))};
        break;
    case ShapeKind::hull:
        solid = pool.pick(random, size);
        break;
    default:
        break;
    }
    if (kind >= ConvexKind::round_cylinder)
        solid.geometry.radius = lockstone::to<lockstone::Length>(real(s * random.log_uniform(0.01, 0.3)));
    if (core_kind(kind) != ShapeKind::hull && factor > 1)
        solid.geometry = lockstone::test::with_scale(solid.geometry, lockstone::Real(8));
    return solid;
}

/// Up to three quarter turns about an axis, half of them slightly off; or any rotation.
inline lockstone::Quat awkward_rotation(RandomReal& random) {
    const std::uint32_t style = random.below(4);
    if (style == 0) return lockstone::Quat::identity();
    if (style == 1) return lockstone::normalized(random.rotation(0, 3));
    D3 axis{0, 0, 0};
    axis[static_cast<int>(random.below(3))] = 1;
    const double off = style == 2 ? 0 : random.log_uniform(1e-8, 1e-2);
    const double angle = 1.5707963267948966 * random.below(4) + off;
    const D3 tilt = random.direction();
    return lockstone::normalized(quat_of(axis, angle) * quat_of(tilt, off));
}

/// The offset at which the surfaces touch along a direction, or miss by a little.
inline D3 touching_offset(RandomReal& random, const ConvexScene& s, const lockstone::Quat& turn) {
    const DoubleCore a(s.a), b(s.b, pose_of(turn, {0, 0, 0}));
    D3 n = random.direction();
    if (random.below(2) == 0) n = a.axes[random.below(3)] * (random.below(2) == 0 ? 1 : -1);
    const double gaps[] = {0, 0, 1e-7, -1e-7, 1e-4, -1e-4, 0.01, -0.01};
    const double touch = a.support(n) + b.support(n * -1.0) + a.radius + b.radius + gaps[random.below(8)];
    D3 offset = n * touch;
    if (random.below(3) == 0) { // beside each other along another axis: shared edges and corners
        const D3 m = a.axes[random.below(3)];
        offset = offset + m * (random.uniform(-1, 1) < 0 ? a.support(m) : b.support(m)) - n * dot(n, m);
    }
    return offset;
}

inline ConvexScene random_scene(RandomReal& random, const HullPool& pool, ConvexKind a, ConvexKind b) {
    const double size = random.log_uniform(0.02, 4), other = size * random.log_uniform(0.1, 10);
    ConvexScene s{};
    s.a = random_solid(random, pool, a, size);
    s.b = random_solid(random, pool, b, other);
    s.is_ordinary = true;
    const double reaches = DoubleCore(s.a).reach() + DoubleCore(s.b).reach();
    const lockstone::Quat turn = lockstone::normalized(random.rotation(0, 3.14159));
    const D3 offset = random.vector(0, 1.1 * reaches);
    s.pose = pose_of(turn, offset);
    return s;
}

/// Aligned and nearly aligned poses: touching, coincident, deep, of sizes from 5 mm to 800 m, and far from the origin.
inline ConvexScene designed_scene(RandomReal& random, const HullPool& pool, ConvexKind a, ConvexKind b) {
    ConvexScene s{};
    s.is_ordinary = random.below(3) != 0;
    const double size = s.is_ordinary ? random.log_uniform(0.05, 4) : random.log_uniform(0.005, 800);
    const double other = s.is_ordinary ? size * random.log_uniform(0.1, 10) : random.log_uniform(0.005, 800);
    s.a = random_solid(random, pool, a, size);
    s.b = random_solid(random, pool, b, random.below(6) == 0 ? size : std::min(other, 800.0));
    if (s.b.geometry.scale.x > s.a.geometry.scale.x && core_kind(b) != ShapeKind::hull) std::swap(s.a, s.b);
    const lockstone::Quat turn = awkward_rotation(random);
    const std::uint32_t style = random.below(4);
    D3 offset{0, 0, 0}; // style 0: centres coincide
    if (style == 1) offset = random.vector(0, 0.3 * DoubleCore(s.a).reach());
    if (style >= 2) offset = touching_offset(random, s, turn);
    s.pose = pose_of(turn, offset);
    if (random.below(4) == 0) { // this scene 10,000 km from the origin of the world
        using lockstone::Real;
        const lockstone::Vec3 far{Real(10'000'000), Real(-9'000'000), as_fixed<Real>(0.3)};
        const lockstone::Vec3 between{as_fixed<Real>(offset.x), as_fixed<Real>(offset.y),
                                      as_fixed<Real>(offset.z)};
        s.pose = lockstone::collide::relative_pose({far, lockstone::Quat::identity()}, {far + between, turn});
    }
    return s;
}

} // namespace oracle
