// Assets: immutable geometry, identified by a hash of its content.
//
//   Result<AssetBytes> bytes = bake_hull(points);            or read from a file that `lockstone cook` wrote
//   AssetLibrary library;
//   AssetId id = library.add(*bytes).value();                checks all bytes
//   auto assets = std::make_shared<const AssetLibrary>(std::move(library));
//   World world = World::create(def, schema, assets).value();
//   world.create_shape(body, {.geometry = instance(ShapeKind::hull, id)});
//
// The state holds the id of an asset and none of its data, so assets do not increase snapshots. The format of
// the bytes is in src/shapes/ASSET.md. Baking uses integers only: equal input gives equal bytes on every
// machine.
#pragma once

#include "lockstone/result.h"
#include "lockstone/shape.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace lockstone {

inline constexpr std::uint32_t hull_vertices_max = 255;         ///< corners of a hull
inline constexpr std::uint32_t mesh_triangles_max = 1u << 24;   ///< triangles of a mesh
inline constexpr std::uint32_t height_field_samples_max = 8192; ///< samples of a side
inline constexpr std::uint32_t compound_parts_max = 65536;      ///< parts of a compound

/// A baked asset.
using AssetBytes = std::vector<std::byte>;

/// Bakes the convex hull of `points` [m]; interior and repeated points are dropped. Errors: fewer than four
/// points, all in one plane, a corner beyond 100 m of the origin on an axis, more than hull_vertices_max
/// corners, or a thickness below 2 * shape_size_min.
Result<AssetBytes> bake_hull(std::span<const LengthVec3> points);

inline constexpr std::uint32_t material_surfaces_max = 256; ///< entries of a surface list

/// Surface of the triangles or cells of one material, in place of that of their shape. The shape's mixing
/// rules apply. Lists must ascend by material. Unlisted materials have the surface of the shape.
struct MaterialSurface {
    std::uint32_t material;    ///< value in MeshDef::materials or HeightFieldDef::cells; 0: without material
    Real friction;             ///< as ShapeDef::friction, 0..4
    Real restitution{};        ///< as ShapeDef::restitution, 0..1
    Real rolling_resistance{}; ///< as ShapeDef::rolling_resistance [m], 0..1
    Vec3 surface_velocity{};   ///< as ShapeDef::surface_velocity [m/s], each component within 100
};

/// Definition of a triangle mesh. The spans are read during bake_mesh() only.
struct MeshDef {
    std::span<const Vec3> vertices; ///< [vertices] position [m], within 8000 of the origin on each axis
    std::span<const std::array<std::uint32_t, 3>> triangles; ///< [triangles] counter-clockwise from outside
    std::span<const std::uint16_t> materials = {};           ///< [triangles] material of each; or empty
    std::span<const MaterialSurface> surfaces = {};          ///< [0..256] surfaces by material
    bool two_sided = false; ///< true: both sides are solid; false: the space behind a triangle is inside
    /// Sine of an angle, 0..1; default 1/32. An edge whose triangles meet at a smaller angle is flat: it
    /// gives no contact normals of its own.
    Unit flat_sine = Unit::from_raw(1 << 25);
};
/// Bakes a mesh. Equal vertices are merged, triangles without area after rounding to 24 fraction bits are
/// dropped, and triangles are sorted in space: QueryHit::feature is the sorted index, QueryHit::part has the
/// index in `triangles`. Errors: a value out of range, or no triangle remains.
Result<AssetBytes> bake_mesh(const MeshDef& def);

/// Definition of a height field. The spans are read during bake_height_field() only.
struct HeightFieldDef {
    std::uint32_t columns, ///< samples along x, 2..8192
        rows;              ///< samples along z, 2..8192
    /// Distance of samples along x and z [m], at least 0.0025; times the larger of columns and rows at most
    /// 8000 m.
    Length spacing;
    std::span<const Length> heights; ///< [rows * columns] height y [m], within 100 of 0
    /// [(rows - 1) * (columns - 1)] 0..254: material, 255: hole; or empty.
    std::span<const std::uint8_t> cells = {};
    std::span<const MaterialSurface> surfaces = {}; ///< [0..256] surfaces by material
    Unit flat_sine = Unit::from_raw(1 << 25);       ///< as MeshDef::flat_sine
};
/// Bakes a height field. The first sample is at x = z = 0. The diagonal from (column, row) to (column + 1,
/// row + 1) splits a cell. The space below is inside: a body below the surface is pushed up. Errors: a value
/// out of range, or a span of a wrong size.
Result<AssetBytes> bake_height_field(const HeightFieldDef& def);

/// A part of a compound.
struct CompoundPart {
    Geometry geometry; ///< a primitive, or a hull of scale 1
    Transform local;   ///< pose in the compound's frame [m]
};
/// Bakes a compound of 1..65536 parts within 100 m of the origin; their order remains. Add its hulls to the
/// library before the compound. Errors: a geometry that is not convex, a value out of range.
Result<AssetBytes> bake_compound(std::span<const CompoundPart> parts);

inline constexpr std::uint32_t asset_set_max = compound_parts_max + 1; ///< assets of a set

/// Concatenates assets, as `lockstone cook` does for a file: one asset unchanged, several as a set
/// (src/shapes/ASSET.md). Each asset must follow those that it refers to, so a compound is the last. Empty
/// for none.
AssetBytes encode_assets(std::span<const AssetBytes> assets);

/// Geometry for collision detection.
namespace shapes {
class Asset;
}

/// Assets by id. Only add() changes a library. Several threads may call const members at the same time while
/// no thread calls add().
class AssetLibrary {
  public:
    AssetLibrary();                                   ///< An empty library.
    AssetLibrary(AssetLibrary&&) noexcept;            ///< Moves all assets.
    AssetLibrary& operator=(AssetLibrary&&) noexcept; ///< Replaces all assets.
    ~AssetLibrary();

    /// Adds an asset, or all assets of a set, and returns the id (of the last one). Checks checksum, bounds,
    /// convexity and closedness. Equal bytes are stored once. Errors name the wrong byte; nothing is added
    /// then.
    Result<AssetId> add(std::span<const std::byte> bytes);
    /// Adds the result of a bake function, or returns its error.
    Result<AssetId> add(const Result<AssetBytes>& baked);
    /// Adds an asset or a set.
    Result<AssetId> add(const AssetBytes& bytes) { return add(std::span<const std::byte>(bytes)); }

    bool contains(AssetId id) const;  ///< True if the library has the asset.
    std::vector<AssetId> ids() const; ///< All ids, ascending.
    /// As added; empty: none. Valid as long as the library.
    std::span<const std::byte> bytes(AssetId id) const;
    /// instance() of the asset. Error: no such asset.
    Result<Geometry> geometry(AssetId id, LengthVec3 scale = scale_one) const;
    const shapes::Asset* find(AssetId id) const; ///< The asset for internal use; null: none.

  private:
    Result<AssetId> add_one(std::span<const std::byte> bytes);
    Result<AssetId> add_set(std::span<const std::byte> bytes);
    std::map<AssetId, std::unique_ptr<const shapes::Asset>> assets;
};

/// Bakes a copy of an asset with each point p at (factor.x p.x, factor.y p.y, factor.z p.z): a negative
/// factor mirrors. Absolute factors 0.001..1000. The result goes to AssetLibrary::add(); for a compound with
/// hulls it is a set: its hulls, each once, then the compound.
///   hull          a new hull of the scaled corners
///   mesh          triangles keep their order, outside, material and SurfacePart; those without area after
///                 rounding are dropped. A mirror also mirrors the surface velocities of materials
///   height field  positive factors only, factor.x = factor.z; spacing and heights are rounded to Length
///   compound      poses of parts are scaled and mirrored. If the absolute factors are equal, so are the
///                 parts. If not, hulls are baked with their rotation, and primitives need axes parallel to
///                 those of the compound and no rounding: boxes, and cylinders and cones with equal factors
///                 across their axis
/// Errors name the asset, the factor, the part and the reason: no such asset, a factor out of range, a part
/// that has no exact form, or the error of the bake function of the result.
Result<AssetBytes> bake_scaled(const AssetLibrary& library, AssetId id, Vec3 factor);

/// Adds the assets of a file that `lockstone cook` wrote, one or a set, and returns the id of the last one.
/// Needs a system with files. Errors name the file: it cannot be read, or the error of AssetLibrary::add().
/// The library is then as before.
Result<AssetId> load_assets(const std::string& path, AssetLibrary& library);

/// Triangles of a shape.
struct TriangleSoup {
    std::vector<Vec3> vertices;                          ///< in the shape's frame [m]
    std::vector<std::array<std::uint32_t, 3>> triangles; ///< indices, counter-clockwise from outside
};
/// Triangles of a geometry, for drawing and tests. Curved shapes get `round` steps for each quarter turn,
/// clamped to 1..64. Empty for a plane, an invalid geometry or an unknown asset.
TriangleSoup triangulate(const Geometry& geometry, const AssetLibrary& library, int round = 8);

} // namespace lockstone
