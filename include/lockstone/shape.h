// Geometry and mass properties of shapes.
//
//   Geometry crate = box(0.5_r, 0.5_r, 0.5_r);                  half extents [m]
//   if (std::string why = validate(crate); !why.empty()) ...    names field, value and range
//   MassProperties m = mass_properties(crate, 600_r);           density [kg/m^3]
#pragma once

#include "lockstone/math/vec.h"

#include <cstdint>
#include <span>
#include <string>
#include <type_traits>

namespace lockstone {

/// Kind of a geometry. The shape with the greater kind is shape A of a manifold.
enum class ShapeKind : std::uint32_t {
    sphere,       ///< radius
    capsule,      ///< segment with a radius
    cylinder,     ///< along y
    cone,         ///< along y
    box,          ///< half extents
    hull,         ///< convex hull; asset
    compound,     ///< convex parts; asset
    height_field, ///< grid of heights; asset
    mesh,         ///< triangles; asset
    plane,        ///< half-space
};
const char* name_of(ShapeKind kind); ///< "height_field"; "unknown" for any other value. Static string.

/// Id of an asset: a hash of its content (lockstone/asset.h). Zero: none.
struct AssetId {
    std::uint64_t value = 0; ///< the hash

    constexpr explicit operator bool() const { return value != 0; } ///< True if not zero.
    friend constexpr bool operator==(AssetId, AssetId) = default;   ///< Equal content.
    friend constexpr auto operator<=>(AssetId, AssetId) = default;  ///< By value.
};

/// Geometry::scale of 1 on all axes.
inline constexpr LengthVec3 scale_one{Length::from_raw(1 << 24), Length::from_raw(1 << 24),
                                      Length::from_raw(1 << 24)};

/// Geometry of a shape: a state row of 40 bytes. The origin is the centre of a primitive, and the origin of
/// an asset's points.
///   sphere        radius
///   capsule       radius; half_extent.y: half the distance of the cap centres, along local y
///   cylinder      half_extent.x = half_extent.z: radius; half_extent.y: half the height, along local y
///   cone          half_extent.x = half_extent.z: radius of the base at y = -half_extent.y; apex at
///                 y = +half_extent.y
///   box           half_extent
///   hull          asset
///   compound      asset: convex parts with poses
///   height_field  asset; static or kinematic bodies only
///   mesh          asset; static or kinematic bodies only
///   plane         half-space below local y = 0, normal +y, unlimited; static bodies only
/// `radius` of a cylinder, cone, box or hull rounds it: the shape grows by this distance on all sides.
/// `scale` multiplies the sizes and cannot mirror:
///   primitives       1, 2, 4 or 8, equal on all axes; multiplies half_extent and radius. Other than 1 for
///                    static bodies only: sizes up to 800 m
///   hull             1/128 .. 100 for each axis; radius is not scaled. The result, with its rounding, must
///                    be within 100 m of the origin on each axis and at least 5 mm thick
///   mesh, height f.  1/128 .. 100 for each axis; the result must be within 8000 m of the origin
///   compound, plane  1
struct Geometry {
    ShapeKind kind;               ///< selects the fields below
    Length radius;                ///< radius or rounding [m]; 0 where the kind has none
    LengthVec3 half_extent;       ///< [m]; zero for kinds without it
    LengthVec3 scale = scale_one; ///< factor of each axis [1]
    AssetId asset{};              ///< hull, compound, height field, mesh; else zero

    /// Equal fields.
    friend constexpr bool operator==(const Geometry&, const Geometry&) = default;
};
static_assert(sizeof(Geometry) == 40 && std::has_unique_object_representations_v<Geometry>);

/// Range of every radius and half extent, and of half_extent.y + radius of a capsule, before scale [m].
///@{
inline constexpr Length shape_size_min = decimal<Length>("0.0025");
inline constexpr Length shape_size_max = decimal<Length>("100");
///@}

/// True if the sizes of a primitive, before `scale`, are within their ranges; validate() then accepts it with
/// a `scale` of 1. False for other kinds.
constexpr bool is_sized(const Geometry& geometry) {
    const auto within = [](Length low, Length size) { return size >= low && size <= shape_size_max; };
    const LengthVec3& half = geometry.half_extent;
    const Length least = shape_size_min, widest = max(half.x, max(half.y, half.z));
    switch (geometry.kind) {
    case ShapeKind::sphere:
        return within(least, geometry.radius);
    case ShapeKind::capsule:
        return within(least, geometry.radius) && within(Length{}, half.y) &&
               within(least, half.y + geometry.radius);
    case ShapeKind::cylinder:
    case ShapeKind::cone:
    case ShapeKind::box:
        return within(least, half.x) && within(least, half.y) && within(least, half.z) &&
               within(Length{}, geometry.radius) && within(least, widest + geometry.radius) &&
               (geometry.kind == ShapeKind::box || half.x == half.z);
    default:
        return false;
    }
}

// These functions round sizes to Length and clamp them to 128 m. validate() checks the ranges.
/// A sphere. Radius [m], 0.0025..100, as all sizes here.
constexpr Geometry sphere(Real radius) { return {ShapeKind::sphere, to<Length>(radius), LengthVec3{}}; }
/// A capsule along y: half_height is half the distance of the cap centres [m].
constexpr Geometry capsule(Real radius, Real half_height) {
    return {ShapeKind::capsule, to<Length>(radius), {Length{}, to<Length>(half_height), Length{}}};
}
/// A cylinder along y [m].
constexpr Geometry cylinder(Real radius, Real half_height) {
    const Length r = to<Length>(radius);
    return {ShapeKind::cylinder, Length{}, {r, to<Length>(half_height), r}};
}
/// A cone along y, apex up [m].
constexpr Geometry cone(Real base_radius, Real half_height) {
    const Length r = to<Length>(base_radius);
    return {ShapeKind::cone, Length{}, {r, to<Length>(half_height), r}};
}
/// A box with these half extents [m].
constexpr Geometry box(Vec3 half_extent) { return {ShapeKind::box, Length{}, to<Length>(half_extent)}; }
/// A box with these half extents [m].
constexpr Geometry box(Real hx, Real hy, Real hz) { return box(Vec3{hx, hy, hz}); }
/// The half-space below local y = 0.
constexpr Geometry plane() { return {ShapeKind::plane, Length{}, LengthVec3{}}; }
/// A hull, compound, mesh or height field. `kind` must be that of the asset; AssetLibrary::geometry() finds
/// it.
constexpr Geometry instance(ShapeKind kind, AssetId asset, LengthVec3 scale = scale_one) {
    return {kind, Length{}, LengthVec3{}, scale, asset};
}
/// The geometry rounded by `radius` [m]: it grows by this distance.
constexpr Geometry rounded(Geometry geometry, Real radius) {
    geometry.radius = to<Length>(radius);
    return geometry;
}
/// The geometry scaled by `factor` on all axes. The sizes of a primitive are multiplied and rounded to
/// Length, and its `scale` remains, if all results are within the ranges of validate(): any such factor is
/// good for any body. Otherwise the factor multiplies `scale` of a primitive: 2, 4 and 8 make static shapes
/// of up to 800 m. The `scale` of other kinds is replaced by the factor. Ranges of `scale`: see Geometry.
constexpr Geometry scaled(Geometry geometry, Real factor) {
    if (geometry.kind > ShapeKind::box) {
        const Length f = to<Length>(factor);
        geometry.scale = {f, f, f};
        return geometry;
    }
    Geometry sized = geometry;
    sized.radius = mul<Length>(geometry.radius, factor);
    sized.half_extent = scale<Length>(geometry.half_extent, factor);
    if (factor > Real{} && is_sized(sized)) return sized;
    geometry.scale = scale<Length>(geometry.scale, factor);
    return geometry;
}

/// Empty if the geometry is valid; else a sentence with the field, its value and its range. Does not look up
/// assets.
std::string validate(const Geometry& geometry);

/// Format of squared gyration radii, inertia / mass [m^2]: range 524288, step 5.7e-14. A 5 mm cube (4.2e-6
/// m^2) has a relative accuracy of 1.4e-8; Real would give 3e-5.
using I20F44 = Fixed<std::int64_t, 44>;

/// Mass properties. Inertia is stored as inertia / mass, whose range does not depend on density.
struct MassProperties {
    Real mass;                        ///< [kg]
    Vec3 center;                      ///< centre of mass in the frame of the shape or body [m]
    Matrix3<I20F44> gyration_squared; ///< inertia about `center` / mass in this frame, symmetric [m^2]
};

/// Mass properties of a primitive with `density` [kg/m^3], in closed form: each entry is rounded once, the
/// mass is clamped to Real. Relative error of rounded boxes and cylinders 2^-58, of rounded cones 2^-31. All
/// zero for planes, assets, geometries that validate() refuses, and negative densities. Source: Eberly, Game
/// Physics, 2nd ed., 2.5.5.
MassProperties mass_properties(const Geometry& geometry, Real density);

/// One shape of a body.
struct MassPart {
    MassProperties properties; ///< in the shape's frame
    Transform local;           ///< the shape's frame in the body's
};

/// Mass properties of a rigid body made of parts, by the parallel axis theorem. Overlaps count twice.
/// Relative error of gyration about 1e-7 for parts within 1 m, from the step 1e-9 of rotation entries. All
/// zero without mass.
MassProperties combine(std::span<const MassPart> parts);

/// Gyration radii about the principal axes: gyration_squared = R diag(radii^2) R^T with R =
/// to_rotation(axes).
struct PrincipalGyration {
    Vec3 radii; ///< [m], at least 0
    Quat axes;  ///< principal axes in the frame of the properties, in the order of diagonalize()
};
/// Computes the principal axes by diagonalize().
PrincipalGyration principal_gyration(const MassProperties& properties);

} // namespace lockstone
