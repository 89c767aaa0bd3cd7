// Shapes and their masses: what a body is made of.
//
//   Geometry crate = box(0.5_r, 0.5_r, 0.5_r);                  half extents [m]
//   if (std::string why = validate(crate); !why.empty()) ...    names the field, the value and the range
//   MassProperties m = mass_properties(crate, 600_r);           density [kg/m^3]
#pragma once

#include "lockstone/math/vec.h"

#include <cstdint>
#include <span>
#include <string>
#include <type_traits>

namespace lockstone {

/// The order is the canonical order of a pair: the greater kind is shape A of a manifold.
enum class ShapeKind : std::uint32_t {
    sphere,
    capsule,
    cylinder,
    cone,
    box,
    hull,
    compound,
    height_field,
    mesh,
    plane,
};
const char* name_of(ShapeKind kind); ///< "height_field"

/// Names an asset by its content (see lockstone/asset.h); zero is none.
struct AssetId {
    std::uint64_t value = 0;

    constexpr explicit operator bool() const { return value != 0; }
    friend constexpr bool operator==(AssetId, AssetId) = default;
    friend constexpr auto operator<=>(AssetId, AssetId) = default;
};

inline constexpr LengthVec3 scale_one{Length::from_raw(1 << 24), Length::from_raw(1 << 24),
                                      Length::from_raw(1 << 24)};

/// One plain row: 40 bytes, no padding. Primitives are centred on their own origin; the points of an asset are where
/// it has them.
///   sphere        radius
///   capsule       radius; half_extent.y is half the segment between the two cap centres, along local y
///   cylinder      half_extent.x = half_extent.z its radius, half_extent.y half its height, along local y
///   cone          half_extent.x = half_extent.z the radius of its base at local y = -half_extent.y; apex at +half_extent.y
///   box           half_extent
///   hull          asset
///   compound      asset: convex parts, each with a place
///   height_field  asset; static or kinematic bodies only
///   mesh          asset; static or kinematic bodies only
///   plane         the half-space below local y = 0, normal +y, without bounds; static bodies only
/// `radius` of a cylinder, cone, box or hull rounds it: every point nearer than that to the described shape belongs to it.
/// `scale` multiplies the sizes, and never mirrors:
///   primitives                s = 1, 2, 4 or 8, the same on all axes, times half_extent and radius. Other than 1 on static
///                             bodies only, whose half extents and radii so reach 800 m
///   hull, mesh, height field  a factor for each of the asset's axes, 1/128 .. 100; radius is not multiplied. What comes of it
///                             lies within 100 m of its origin on each axis (hull, rounding included) or 8000 m (mesh, height
///                             field), and a hull is still at least 5 mm thick
///   compound, plane           1
struct Geometry {
    ShapeKind kind;
    Length radius;          ///< [m]
    LengthVec3 half_extent; ///< [m]; zero for kinds that do not name it
    LengthVec3 scale = scale_one;
    AssetId asset{};

    friend constexpr bool operator==(const Geometry&, const Geometry&) = default;
};
static_assert(sizeof(Geometry) == 40 && std::has_unique_object_representations_v<Geometry>);

/// The range of every radius and half extent, and of half_extent.y + radius of a capsule, before scale [m].
inline constexpr Length shape_size_min = decimal<Length>("0.0025");
inline constexpr Length shape_size_max = decimal<Length>("100");

// A size is rounded to Length and clamped to 128 m; `validate` then tells what is out of range.
constexpr Geometry sphere(Real radius) { return {ShapeKind::sphere, to<Length>(radius), LengthVec3{}}; }
constexpr Geometry capsule(Real radius, Real half_height) {
    return {ShapeKind::capsule, to<Length>(radius), {Length{}, to<Length>(half_height), Length{}}};
}
constexpr Geometry cylinder(Real radius, Real half_height) {
    const Length r = to<Length>(radius);
    return {ShapeKind::cylinder, Length{}, {r, to<Length>(half_height), r}};
}
constexpr Geometry cone(Real base_radius, Real half_height) {
    const Length r = to<Length>(base_radius);
    return {ShapeKind::cone, Length{}, {r, to<Length>(half_height), r}};
}
constexpr Geometry box(Vec3 half_extent) { return {ShapeKind::box, Length{}, to<Length>(half_extent)}; }
constexpr Geometry box(Real hx, Real hy, Real hz) { return box(Vec3{hx, hy, hz}); }
constexpr Geometry plane() { return {ShapeKind::plane, Length{}, LengthVec3{}}; }
/// Of a hull, compound, mesh or height field; `kind` is that of the asset (AssetLibrary::geometry fills it in).
constexpr Geometry instance(ShapeKind kind, AssetId asset, LengthVec3 scale = scale_one) {
    return {kind, Length{}, LengthVec3{}, scale, asset};
}
/// The same shape with its edges and corners rounded by `radius` [m]: it grows by that much.
constexpr Geometry rounded(Geometry geometry, Real radius) {
    geometry.radius = to<Length>(radius);
    return geometry;
}
/// The same shape, `factor` times as large in all directions; see Geometry::scale for what is allowed.
constexpr Geometry scaled(Geometry geometry, Real factor) {
    const Length f = to<Length>(factor);
    geometry.scale = {f, f, f};
    return geometry;
}

/// Empty when the geometry is good, else a sentence that names the field, its value and its range.
std::string validate(const Geometry& geometry);

/// Squared gyration radii, inertia / mass [m^2]: range 524288, step 5.7e-14, so that a 5 mm cube (4.2e-6) keeps
/// a relative accuracy of 1.4e-8 where Real would leave 3e-5.
using I20F44 = Fixed<std::int64_t, 44>;

/// The solver needs inertia only as inertia / mass, whose range does not depend on density.
struct MassProperties {
    Real mass;                        ///< [kg]
    Vec3 center;                      ///< centre of mass in the shape's or the body's axes [m]
    Matrix3<I20F44> gyration_squared; ///< inertia about `center` / mass, symmetric, in the same axes [m^2]
};

/// Closed forms, each entry rounded once; mass is clamped to Real. Density in kg/m^3. Rounded boxes, cylinders and cones
/// too, to 2^-58, a cone's rounding to 2^-31.
/// A plane and what names an asset have no mass here: mass and gyration are 0 (an asset's is shapes::mass_properties). So are
/// those of what validate refuses, and with a density below zero.
MassProperties mass_properties(const Geometry& geometry, Real density);

/// One shape of a body: its own properties, and where it sits in the body's axes.
struct MassPart {
    MassProperties properties;
    Transform local;
};

/// The properties of a rigid body made of parts (overlaps count twice), by the parallel axis theorem.
/// Relative error of gyration about 1e-7 for parts within 1 m, from the 1e-9 of a rotation's entries.
/// No parts, or no mass in all of them: all zero.
MassProperties combine(std::span<const MassPart> parts);

/// The gyration radii about the principal axes: gyration_squared = R diag(radii^2) R^T with R = to_rotation(axes).
struct PrincipalGyration {
    Vec3 radii; ///< [m], never negative
    Quat axes;  ///< in the axes of the properties; the order is that of `diagonalize`
};
PrincipalGyration principal_gyration(const MassProperties& properties);

} // namespace lockstone
