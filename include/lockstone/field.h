// Force fields, fluids and explosions.
//
//   Region pool{.kind = RegionKind::box, .pose = {{0_r, -2_r, 0_r}, Quat::identity()},
//               .half_extent = {9_r, 2_r, 9_r}};
//   world.create_field(water(pool));
//   world.create_field(wind({6_r, 0_r, 0_r}));                     everywhere, 6 m/s along x
//   world.explode({.center = {0_r, 1_r, 0_r}, .radius = 8_r, .impulse = 400_r});
//
// Acceleration fields (point gravity, spring, uniform) add up. A body is in a region if its centre of mass
// lies in it.
//
// Fluids act on shapes. A shape is in a region if its centre of volume lies in it, with one exception: the
// top of a box region (local +y) is the surface of the fluid and cuts shapes.
//   buoyancy   weight of the displaced fluid, against gravity and the acceleration fields there. It acts at
//              the centre of the submerged volume
//   drag       force (drag_linear + drag_quadratic v) v A, with v the speed relative to the stream and A the
//              submerged part of the area that the shape exposes to the stream. It acts at the centre of that
//              area, so it turns bodies
//   turning    damping of the angular velocity by drag_angular A / mass [1/s]
// Where fluids overlap, the one with the highest priority acts on the part of a shape that is in it, and
// lower ones on the rest; fluids of equal priority add up. So wind acts on the part above the water.
#pragma once

#include "lockstone/row.h"

#include <cstdint>

namespace lockstone {

/// Form of a region.
enum class RegionKind : std::uint32_t {
    everywhere, ///< the whole world
    box,        ///< a box with any rotation
    sphere      ///< a ball
};

/// A part of space.
struct Region {
    RegionKind kind = RegionKind::everywhere; ///< form
    std::uint32_t reserved = 0;               ///< 0
    Transform pose = Transform::identity();   ///< of the centre, world [m], within 1e9 on each axis
    Vec3 half_extent{};                       ///< box: half extents [m]; sphere: x is the radius; 0.001..1e6
};

/// Effect of a force field.
enum class FieldKind : std::uint32_t {
    point_gravity, ///< acceleration strength / r^2 towards the centre; strength = G M [m^3/s^2]
    spring,        ///< acceleration strength * r towards the centre; strength = omega^2 [1/s^2]
    uniform,       ///< constant acceleration
    fluid,         ///< buoyancy and drag: water, wind, mud
};

/// Definition of a force field. It acts in its region on dynamic bodies with BodyDef::enable_fields.
struct FieldDef {
    FieldKind kind = FieldKind::point_gravity; ///< selects the fields below that apply
    /// Categories of shapes that the field acts on. An acceleration field acts on a body if one of its shapes
    /// has such a category; with all bits set, on bodies without shapes too.
    std::uint32_t mask = 0xffffffffu;
    Vec3 center{};              ///< point gravity, spring: world [m], within 1e9 on each axis
    Real strength{};            ///< point gravity, spring: see FieldKind, within 1e8
    Real softening{};           ///< point gravity: r^2 + softening^2 replaces r^2 [m], 0..30000
    Vec3 acceleration{};        ///< uniform: [m/s^2], each component within 1000
    Vec3 velocity{};            ///< fluid: stream [m/s], at most 500 long
    Real density{};             ///< fluid: for buoyancy [kg/m^3], 0..1e5
    Real drag_linear{};         ///< fluid: [kg/(m^2 s)], 0..1e6
    Real drag_quadratic{};      ///< fluid: half of density times drag coefficient [kg/m^3], 0..1e6
    Real drag_angular{};        ///< fluid: [kg/(m^2 s)], 0..1e6
    std::int32_t priority = 0;  ///< fluid: the highest wins where fluids overlap
    std::uint32_t reserved = 0; ///< 0
    Region region{};            ///< where it acts; default: everywhere
};

/// Fresh water with priority 1. The quadratic drag is that of a cube (coefficient 1); the linear drag
/// approximates losses by waves.
constexpr FieldDef water(const Region& region) {
    FieldDef d;
    d.kind = FieldKind::fluid;
    d.density = Real(1000);
    d.drag_linear = d.drag_angular = Real(300);
    d.drag_quadratic = Real(500);
    d.priority = 1;
    d.region = region;
    return d;
}
/// Air that moves at `velocity` [m/s], without buoyancy, priority 0. A zero velocity gives air resistance
/// only.
constexpr FieldDef wind(Vec3 velocity, const Region& region = {}) {
    FieldDef d;
    d.kind = FieldKind::fluid;
    d.velocity = velocity;
    d.drag_quadratic = 0.6_r;
    d.region = region;
    return d;
}

/// The part of a body below the surfaces of fluids; World::submersion().
struct Submersion {
    Unit fraction; ///< of the volume of the body's shapes, 0..1
    Vec3 center;   ///< centre of that part, world [m]; the body's centre of mass where the fraction is 0
    Real volume;   ///< of that part [m^3], at most 2.1e9
};

/// Strength of an explosion over the distance.
enum class Falloff : std::uint32_t {
    none,           ///< constant up to the radius
    linear,         ///< falls to zero at the radius, by the distance of the shape's bounding box
    inverse_square, ///< constant within the core, then (core / r)^2 up to the radius
};

/// Definition of an explosion. It acts on each convex part of a shape whose bounding box is within the
/// radius: with impulse times the area exposed to the centre, at most pi radius^2, at the centre of that area
/// and away from the explosion. r is the distance to the part's centre of volume; a part with r = 0 is not
/// moved. Shapes do not shield each other. Sensors, static and kinematic bodies are not affected.
struct ExplosionDef {
    Vec3 center{};                             ///< world [m], within 1e9 on each axis
    Real radius = Real(1);                     ///< maximum distance [m], 0.001..30000
    Real impulse{};                            ///< impulse / area [N s/m^2], within 1e8; negative: implosion
    Real core = Real(1);                       ///< of Falloff::inverse_square [m], 0.001..30000
    Falloff falloff = Falloff::inverse_square; ///< strength over the distance
    std::uint32_t mask = 0xffffffffu;          ///< categories of affected shapes
};

/// Field list with ranges; see lockstone/row.h.
///@{
template <class V> constexpr void describe(Region& r, V&& v) {
    field(v, "kind", r.kind, in(0, 2));
    field(v, "reserved", r.reserved, always_zero);
    field(v, "pose", r.pose, PoseIn{Real(1000000000)});
    v("half_extent", r.half_extent);
}
template <class V> constexpr void describe(FieldDef& d, V&& v) {
    field(v, "kind", d.kind, in(0, 3));
    v("mask", d.mask);
    field(v, "center", d.center, EachIn{Real(1000000000), "m"});
    field(v, "strength", d.strength, in(-100000000_r, 100000000_r));
    field(v, "softening", d.softening, in(0_r, 30000_r, " m"));
    field(v, "acceleration", d.acceleration, EachIn{Real(1000), "m/s^2"});
    field(v, "velocity", d.velocity, LongAtMost{Real(500), "500 m/s"});
    field(v, "density", d.density, in(0_r, 100000_r, " kg/m^3"));
    field(v, "drag_linear", d.drag_linear, in(0_r, 1000000_r, " kg/(m^2 s)"));
    field(v, "drag_quadratic", d.drag_quadratic, in(0_r, 1000000_r, " kg/m^3"));
    field(v, "drag_angular", d.drag_angular, in(0_r, 1000000_r, " kg/(m^2 s)"));
    v("priority", d.priority);
    field(v, "reserved", d.reserved, always_zero);
    v("region", d.region);
}
template <class V> constexpr void describe(ExplosionDef& d, V&& v) {
    field(v, "center", d.center, EachIn{Real(1000000000), "m"});
    field(v, "radius", d.radius, in(0.001_r, 30000_r, " m"));
    field(v, "impulse", d.impulse, in(-100000000_r, 100000000_r, " N s/m^2"));
    field(v, "core", d.core, in(0.001_r, 30000_r, " m"));
    field(v, "falloff", d.falloff, in(0, 2));
    v("mask", d.mask);
}
///@}

} // namespace lockstone
