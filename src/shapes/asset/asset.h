// Assets as collision reads them, and `Solid`: a geometry with its asset at hand.
#pragma once

#include "lockstone/asset.h"
#include "shapes/scaled.h"

#include <array>
#include <cstdint>
#include <map>
#include <utility>
#include <variant>
#include <vector>

namespace lockstone::shapes {

/// Closed box of asset-local coordinates.
struct Extent {
    CoordinateVec3 lower, upper;
};
constexpr bool overlap(const Extent& a, const Extent& b) {
    return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y &&
           b.lower.y <= a.upper.y && a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}
/// Each component times its factor, rounded once: rounding keeps the order, so a scaled box bounds the scaled points.
constexpr CoordinateVec3 scaled_by(CoordinateVec3 p, LengthVec3 factors) {
    return {mul<Coordinate>(p.x, factors.x), mul<Coordinate>(p.y, factors.y),
            mul<Coordinate>(p.z, factors.z)};
}
constexpr Extent scaled_by(const Extent& e, LengthVec3 factors) {
    return {scaled_by(e.lower, factors), scaled_by(e.upper, factors)};
}

struct SupportKernel;

/// A convex polytope. The triangulated surface is exactly convex and closed in integers; `faces` are its triangles
/// merged where they are coplanar to within a stated tolerance, for contact manifolds.
struct Hull {
    struct Face {
        UnitVec3 normal;            ///< outward
        Coordinate offset;          ///< the greatest n . x of the hull: all of it is at n . x <= offset
        std::uint16_t first, count; ///< its corners in `loops`, counter-clockwise seen from outside
        /// Its patch in `patches`: seen along the normal, the outline of all corners that are below the face by no more than `patch_depth`. Empty where
        /// these are the corners of the face, as those of most faces are.
        std::uint32_t patch_first, patch_count;
    };
    struct Edge {
        std::uint8_t from, to;     ///< vertices; `left` is the face that has the edge in this direction
        std::uint16_t left, right; ///< faces
    };
    std::vector<LengthVec3> vertices;                   ///< every one a corner
    std::vector<std::array<std::uint8_t, 3>> triangles; ///< the exact surface
    std::vector<Face> faces;
    std::vector<std::uint16_t> face_of;         ///< by triangle
    std::vector<std::uint8_t> loops, patches;   ///< vertex indices
    std::vector<Edge> edges;                    ///< between different faces, each once
    std::vector<std::uint16_t> first_neighbour; ///< by vertex, vertices + 1 entries: range in `neighbours`
    /// Vertices that share an edge of the exact surface, ascending: for hill climbing
    std::vector<std::uint8_t> neighbours;
    std::vector<std::uint16_t> first_face_at; ///< by vertex, vertices + 1 entries: range in `faces_at`
    /// The faces that have it as a corner, also within their outline; ascending
    std::vector<std::uint16_t> faces_at;
    /// The vertices side by side, filled up with the first: support_kernel.h
    std::vector<std::int32_t> lanes;
    LengthVec3 interior;       ///< a point well inside: the centre of mass, rounded
    Length inner_radius;       ///< of a ball about `interior` within the hull
    MassProperties properties; ///< at density 1 kg/m^3, by exact integrals
    Scaled volume;             ///< [m^3], to 62 bits where properties.mass has 32 fraction bits
    Extent extent;
};

/// A triangle of a mesh or height field, in the asset's axes at the shape's scale.
struct Triangle {
    CoordinateVec3 corner[3]; ///< counter-clockwise seen from outside
    UnitVec3 normal;
    std::uint32_t index;
    std::uint32_t material;
    /// Edge k runs from corner k to corner k + 1. Bit k: the edge is a border, or convex enough to be felt; the others
    /// are flat or concave, and a contact on them has the triangle's normal. In a two-sided mesh a concave edge is
    /// convex from behind, so its bit is set too.
    std::uint32_t sharp;
    UnitVec3 beyond[3]; ///< normal of the triangle across edge k; of a border edge: the reverse of `normal`
};

class Mesh;            // mesh.h
class HeightField;     // height_field.h
class BoundsHierarchy; // bounds_hierarchy.h

/// Convex parts with places. Parts of a compound are found by extent.
struct Compound;

class Asset {
  public:
    Asset(AssetId id, AssetBytes bytes, ShapeKind kind);
    ~Asset();
    AssetId id;
    AssetBytes bytes;
    ShapeKind kind;                   ///< hull, compound, height_field or mesh
    std::unique_ptr<const Hull> hull; ///< by kind, one of the four is set
    std::unique_ptr<const Compound> compound;
    std::unique_ptr<const HeightField> height_field;
    std::unique_ptr<const Mesh> mesh;
};

/// What collision sees of a shape. Pointers stay good while the library and the cache that made it live.
struct Solid {
    Geometry geometry;
    const Hull* hull = nullptr; ///< at the geometry's scale
    const Compound* compound = nullptr;
    const HeightField* height_field = nullptr;
    const Mesh* mesh = nullptr;
    const SupportKernel* kernel = nullptr; ///< of hulls; null: corner by corner, to the same bits
};

struct Compound {
    Compound();
    ~Compound();
    struct Part {
        Solid solid;
        Transform local;
        Extent extent; ///< in the compound's axes, rounding included
    };
    std::vector<Part> parts;
    Extent extent{};
    Vec3 core_center{}; ///< of the part with the largest inner radius
    Length inner_radius{};
    /// Appends the indices of the parts whose extents overlap, ascending.
    void find(const Extent& where, std::vector<std::uint32_t>& out) const;
    std::vector<std::uint32_t> order; ///< of more than eight parts: neighbours in space are neighbours in it
    std::unique_ptr<const BoundsHierarchy> hierarchy; ///< over them in that order; null for up to eight
};

/// Turns geometries into solids; keeps hulls that had to be scaled. A cache: it never changes what comes out.
class SolidCache {
  public:
    explicit SolidCache(std::shared_ptr<const AssetLibrary> library);
    /// Checks the geometry against its asset too (`validate` checks what can be told without). The error names the id.
    Result<Solid> resolve(const Geometry& geometry);
    const std::shared_ptr<const AssetLibrary>& library() const { return assets; }
    /// What the solids that are resolved from now on name.
    void use(const SupportKernel* support) { kernel = support; }

  private:
    std::shared_ptr<const AssetLibrary> assets;
    std::map<std::pair<AssetId, std::array<std::int32_t, 3>>, std::unique_ptr<const Hull>> scaled;
    const SupportKernel* kernel = nullptr;
};

/// Mass of a solid, at its scale and with its rounding; see mass_properties(Geometry, Real) for primitives.
/// Meshes, height fields and planes have none.
MassProperties mass_properties(const Solid& solid, Real density);

/// Of a ball about the solid's `core_center` that lies within it, rounding included; zero for meshes, height fields, planes.
Length inner_radius(const Solid& solid);
Vec3 core_center(
    const Solid& solid); ///< in the shape's frame: the origin of primitives, `interior` of a hull
/// In the shape's frame, rounding included. Not for planes.
Extent extent_of(const Solid& solid);
/// How far any of its points is from its origin at most [m]. Not for planes.
Coordinate reach_of(const Solid& solid);

// ---- triangles of meshes and height fields ----

/// Of a solid that has triangles.
std::uint32_t triangle_count(const Solid& solid);
/// Appends the indices of the triangles whose own bounds overlap, ascending. `where` is in the shape's axes at its scale.
void find_triangles(const Solid& solid, const Extent& where, std::vector<std::uint32_t>& out);
Triangle triangle_at(const Solid& solid, std::uint32_t index);
/// Height fields are solid below; meshes when they are not two-sided.
bool is_two_sided(const Solid& solid);

} // namespace lockstone::shapes
