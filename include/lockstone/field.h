// Force fields, fluids and explosions: what acts on bodies from afar.
//
//   world.create_field(water({.kind = RegionKind::box, .pose = {{0_r, -2_r, 0_r}, Quat::identity()}, .half_extent = {9_r, 2_r, 9_r}}));
//   world.create_field(wind({6_r, 0_r, 0_r}));                     everywhere, 6 m/s along x
//   world.explode({.center = {0_r, 1_r, 0_r}, .radius = 8_r, .impulse = 400_r});
//
// Fields of acceleration add up; whether a body is in a region is asked of its centre of mass.
//
// Fluids act on shapes, not on bodies. A shape is in a region when its centre of volume is; but the top of a box region, the
// side of its local +y, is a surface that cuts shapes: a box in water 4 m deep ends where the water does.
//   buoyancy   weight of the fluid displaced, at the centre of what is under the surface, against gravity and the
//              fields of acceleration there
//   drag       force (drag_linear + drag_quadratic v) v A on the area A that the shape shows to the stream, times the
//              share of it that is under, at that area's centre: it turns bodies. v: speed through the stream
//   turning    drag_angular A / mass [1/s] brakes turning
// Where fluids overlap, those of the highest priority take a shape's part in them, and what is left is in those of lower
// priority; equal ones add up. So the wind blows on the part that is out of the water.
#pragma once

#include "lockstone/row.h"

#include <cstdint>

namespace lockstone {

enum class RegionKind : std::uint32_t { everywhere, box, sphere };

struct Region {
    RegionKind kind = RegionKind::everywhere;
    std::uint32_t reserved = 0;
    Transform pose = Transform::identity(); ///< of its centre
    Vec3 half_extent{}; ///< of a box, in its axes [m], 0.001..1e6 each; a sphere's radius is x
};

enum class FieldKind : std::uint32_t {
    point_gravity, ///< acceleration strength / r^2 towards the centre, strength = G M [m^3/s^2]
    spring,        ///< acceleration strength * r towards the centre, strength = omega^2 [1/s^2]
    uniform,       ///< the same acceleration everywhere in the region
    fluid,         ///< buoyancy and drag: water, wind, mud
};

/// Acts on dynamic bodies that enable fields, within the region.
struct FieldDef {
    FieldKind kind = FieldKind::point_gravity;
    std::uint32_t mask =
        0xffffffffu;       ///< categories of shapes it acts on; a field of acceleration acts on a body when
                           ///< one of its shapes is of them. All bits: on bodies without shapes too
    Vec3 center{};         ///< [m], of point gravity and spring
    Real strength{};       ///< see FieldKind; within 1e8
    Real softening{};      ///< [m], 0..30000; r^2 + softening^2 replaces r^2 of point gravity
    Vec3 acceleration{};   ///< of a uniform field [m/s^2], each component within 1000
    Vec3 velocity{};       ///< of a fluid's stream [m/s], at most 500 long
    Real density{};        ///< of a fluid, for buoyancy [kg/m^3], 0..1e5
    Real drag_linear{};    ///< [kg/(m^2 s)], 0..1e6
    Real drag_quadratic{}; ///< [kg/m^3], 0..1e6: half of density times drag coefficient
    Real drag_angular{};   ///< [kg/(m^2 s)], 0..1e6
    std::int32_t priority = 0; ///< of a fluid among those that overlap
    std::uint32_t reserved = 0;
    Region region{};
};

/// Fresh water: a cube has a drag coefficient of 1; waves it would make are in the linear terms.
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
/// Air that moves at `velocity` [m/s], or stands still; without its buoyancy.
constexpr FieldDef wind(Vec3 velocity, const Region& region = {}) {
    FieldDef d;
    d.kind = FieldKind::fluid;
    d.velocity = velocity;
    d.drag_quadratic = 0.6_r;
    d.region = region;
    return d;
}

enum class Falloff : std::uint32_t {
    none,           ///< the same up to the radius
    linear,         ///< to nothing at the radius, by the distance of the box around the shape
    inverse_square, ///< (core / r)^2 beyond the core, none beyond the radius
};

/// A blast hits each shape on the area it shows to the centre, away from it, at that area's centre; the area counts
/// up to the blast's own, pi radius^2. r is measured to the shape's centre of volume, and a shape is hit when the box around
/// it comes within the radius; one whose centre is the blast's is not moved. No shape shields another.
struct ExplosionDef {
    Vec3 center{};         ///< [m]
    Real radius = Real(1); ///< [m], 0.001..30000
    Real impulse{};        ///< per area [N s/m^2], within 1e8; negative: an implosion
    Real core = Real(1);   ///< [m], 0.001..30000, of Falloff::inverse_square
    Falloff falloff = Falloff::inverse_square;
    std::uint32_t mask = 0xffffffffu; ///< categories of shapes it hits
};

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

} // namespace lockstone
