// Assets: geometry that is made once, never changes and is named by its content.
//
//   Result<std::vector<std::byte>> bytes = bake_hull(points);            or read from a file that `lockstone cook` wrote
//   AssetLibrary library;
//   AssetId id = library.add(*bytes).value();                            checks everything; never trusts the bytes
//   World world = World::create(def, schema, std::make_shared<const AssetLibrary>(std::move(library))).value();
//   world.create_shape(body, {.geometry = instance(ShapeKind::hull, id)});
//
// The state holds an asset's id and none of its data: a terrain of a million triangles costs a snapshot nothing.
// The format of the bytes is src/shapes/ASSET.md. Baking is integer arithmetic: the same input gives the same bytes.
#pragma once

#include "lockstone/result.h"
#include "lockstone/shape.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

namespace lockstone {

inline constexpr std::uint32_t hull_vertices_max = 255;
inline constexpr std::uint32_t mesh_triangles_max = 1u << 24;
inline constexpr std::uint32_t height_field_samples_max = 8192; ///< per side
inline constexpr std::uint32_t compound_parts_max = 65536;

using AssetBytes = std::vector<std::byte>;

/// The convex hull of `points`, exact in integers: interior and repeated points are dropped. At least four points that
/// are not in one plane, within 100 m of the origin on each axis; at most hull_vertices_max corners are left, else it is
/// an error. Across each of its triangles the hull must be at least 2 * shape_size_min thick.
Result<AssetBytes> bake_hull(std::span<const LengthVec3> points);

inline constexpr std::uint32_t material_surfaces_max = 256;

/// How triangles or cells of a material touch, in place of what their shape says (see ShapeDef, whose rules of mixing hold).
/// Lists are in ascending order of material; what is not listed is as the shape says.
struct MaterialSurface {
    std::uint32_t material; ///< as in MeshDef::materials and HeightFieldDef::cells; 0 are those without any
    Real friction;          ///< 0..4
    Real restitution{};     ///< 0..1
    Real rolling_resistance{}; ///< [m], 0..1
    Vec3 surface_velocity{};   ///< of a conveyor, in the shape's axes [m/s], each within 100
};

struct MeshDef {
    std::span<const Vec3> vertices; ///< [m], within 8000 m of the origin on each axis
    std::span<const std::array<std::uint32_t, 3>> triangles; ///< counter-clockwise seen from outside
    std::span<const std::uint16_t> materials = {};           ///< one a triangle, or none
    std::span<const MaterialSurface> surfaces = {};
    bool two_sided =
        false; ///< true: every triangle is a wall to both sides; false: what is behind it is inside
    /// An edge whose two triangles meet at less than this is flat: nothing is caught by it [sine, 0..1].
    Unit flat_sine = Unit::from_raw(1 << 25);
};
/// Repeated vertices are welded; triangles that are degenerate after rounding to 24 fraction bits are dropped. Triangles
/// are put in an order in space: a hit's `feature` is the index in that order, its `part` tells that in `triangles` and the
/// material.
Result<AssetBytes> bake_mesh(const MeshDef& def);

struct HeightFieldDef {
    std::uint32_t columns, rows; ///< samples along x and z, 2..height_field_samples_max
    /// Between samples along x and z [m], at least 0.0025; times the greater of columns and rows at most 8000 m.
    Length spacing;
    std::span<const Length> heights; ///< heights[row * columns + column], y [m], within 100 m of 0
    std::span<const std::uint8_t> cells =
        {}; ///< (columns - 1) * (rows - 1): 0..254 material, 255 a hole; or none
    std::span<const MaterialSurface> surfaces = {};
    Unit flat_sine = Unit::from_raw(1 << 25);
};
/// The first sample is at x = z = 0. A cell is cut along the diagonal from (column, row) to (column + 1, row + 1). What
/// is below it is inside: a body that was pushed under the surface comes up again.
Result<AssetBytes> bake_height_field(const HeightFieldDef& def);

struct CompoundPart {
    Geometry geometry; ///< a primitive or a hull
    Transform local;
};
/// Hulls are named by id and must be in the library before the compound is added to it; their scale is 1. Parts lie
/// within 100 m of the origin. The order of the parts stays.
Result<AssetBytes> bake_compound(std::span<const CompoundPart> parts);

inline constexpr std::uint32_t asset_set_max = compound_parts_max + 1; ///< assets of one set

/// Joins assets into one run of bytes, as `lockstone cook` writes them to a file: one asset as it is, several as a set (src/shapes/ASSET.md). Each asset
/// comes after those that it refers to, so a compound comes last. No assets give no bytes.
AssetBytes encode_assets(std::span<const AssetBytes> assets);

namespace shapes {
class Asset;
}

/// Assets by id. Adding is all that changes it; adding the same bytes twice is adding them once.
class AssetLibrary {
  public:
    AssetLibrary();
    AssetLibrary(AssetLibrary&&) noexcept;
    AssetLibrary& operator=(AssetLibrary&&) noexcept;
    ~AssetLibrary();

    /// Adds one asset, or each asset of a set, and returns the id, of a set that of its last asset. Checks checksum, bounds,
    /// convexity and closedness. Errors: name the byte that is wrong; then nothing was added.
    Result<AssetId> add(std::span<const std::byte> bytes);
    /// Bakes and adds.
    Result<AssetId> add(const Result<AssetBytes>& baked);
    Result<AssetId> add(const AssetBytes& bytes) { return add(std::span<const std::byte>(bytes)); }

    bool contains(AssetId id) const;
    std::vector<AssetId> ids() const;                   ///< ascending
    std::span<const std::byte> bytes(AssetId id) const; ///< as added; empty when not there
    /// instance() of the asset, with the kind it has. Error when it is not there.
    Result<Geometry> geometry(AssetId id, LengthVec3 scale = scale_one) const;
    const shapes::Asset* find(AssetId id) const; ///< null when not there; for the layers below

  private:
    Result<AssetId> add_one(std::span<const std::byte> bytes);
    Result<AssetId> add_set(std::span<const std::byte> bytes);
    std::map<AssetId, std::unique_ptr<const shapes::Asset>> assets;
};

/// Triangles of any shape but a plane, for drawing and for tests: round shapes are approximated with `round` steps to
/// the quarter turn, 1 to 64; more or less is taken as that. In the shape's frame, counter-clockwise seen
/// from outside. Empty for a plane, for what `validate` refuses, and for an asset that is not in the library.
struct TriangleSoup {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
};
TriangleSoup triangulate(const Geometry& geometry, const AssetLibrary& library, int round = 8);

} // namespace lockstone
