// Assets in the form that collision reads, and `Solid`: a geometry with pointers to its asset.
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

/// A closed box in the asset's axes.
struct Extent {
    CoordinateVec3 lower, upper;
};
constexpr bool overlap(const Extent& a, const Extent& b) {
    return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y &&
           b.lower.y <= a.upper.y && a.lower.z <= b.upper.z && b.lower.z <= a.upper.z;
}
/// Multiplies each component by its factor and rounds once. Rounding keeps the order, so a scaled box bounds
/// the scaled points.
constexpr CoordinateVec3 scaled_by(CoordinateVec3 p, LengthVec3 factors) {
    return {mul<Coordinate>(p.x, factors.x), mul<Coordinate>(p.y, factors.y),
            mul<Coordinate>(p.z, factors.z)};
}
constexpr Extent scaled_by(const Extent& e, LengthVec3 factors) {
    return {scaled_by(e.lower, factors), scaled_by(e.upper, factors)};
}

struct SupportKernel;

/// A convex polytope. The triangulated surface is exactly convex and closed in integers. `faces` are for
/// contact manifolds: its triangles, merged where they are coplanar to within face_tolerance (hull.h).
struct Hull {
    struct Face {
        UnitVec3 normal; ///< outward
        /// The greatest n . x over the hull: every point of it has n . x <= offset.
        Coordinate offset;
        std::uint16_t first, count; ///< range of its corners in `loops`, counter-clockwise seen from outside
        /// Range of its patch in `patches`: seen along the normal, the outline of the face's corners and of all
        /// corners that are below the face by at most `patch_depth`. Empty when these are only the corners of
        /// the face, as for most faces.
        std::uint32_t patch_first, patch_count;
    };
    struct Edge {
        std::uint8_t from, to;     ///< vertices; `left` is the face with the edge in this direction
        std::uint16_t left, right; ///< faces
    };
    std::vector<LengthVec3> vertices;                   ///< every one is a corner
    std::vector<std::array<std::uint8_t, 3>> triangles; ///< the exact surface
    std::vector<Face> faces;
    std::vector<std::uint16_t> face_of;       ///< by triangle
    std::vector<std::uint8_t> loops, patches; ///< vertex indices
    std::vector<Edge> edges;                  ///< between different faces, each once
    /// For each vertex, plus an end: start of its range in `neighbours`.
    std::vector<std::uint16_t> first_neighbour;
    /// For each vertex the vertices that share an edge of the exact surface with it, ascending; for hill
    /// climbing
    std::vector<std::uint8_t> neighbours;
    /// For each vertex, plus an end: start of its range in `faces_at`.
    std::vector<std::uint16_t> first_face_at;
    /// For each vertex the faces with a triangle at it, even if it is inside their outline; ascending
    std::vector<std::uint16_t> faces_at;
    /// The coordinates of the vertices by axis, padded with the first vertex: support_kernel.h
    std::vector<std::int32_t> lanes;
    LengthVec3 interior;       ///< a point well inside: the rounded centre of mass
    Length inner_radius;       ///< of the largest ball around `interior` inside the hull, rounded down
    MassProperties properties; ///< at density 1 kg/m^3, from exact integrals
    /// [m^3], with 62 significant bits; properties.mass is the same number with 32 fraction bits.
    Scaled volume;
    Extent extent;
};

/// A triangle of a mesh or height field, in the asset's axes at the shape's scale.
struct Triangle {
    CoordinateVec3 corner[3]; ///< counter-clockwise seen from outside
    UnitVec3 normal;
    std::uint32_t index;
    std::uint32_t material;
    /// Edge k runs from corner k to corner k + 1. Bit k is set when the edge is a border, or so convex that
    /// contacts at it may have normals of their own. The other edges are flat or concave; contacts at them have
    /// the triangle's normal. In a two-sided mesh a concave edge is convex from behind, so its bit is set too.
    std::uint32_t sharp;
    UnitVec3 beyond[3]; ///< normal of the triangle across edge k; for a border edge: -`normal`
};

class Mesh;            // mesh.h
class HeightField;     // height_field.h
class BoundsHierarchy; // bounds_hierarchy.h

/// Convex parts and their poses. find() selects parts by extent.
struct Compound;

class Asset {
  public:
    Asset(AssetId id, AssetBytes bytes, ShapeKind kind);
    ~Asset();
    AssetId id;
    AssetBytes bytes;
    ShapeKind kind;                   ///< hull, compound, height_field or mesh
    std::unique_ptr<const Hull> hull; ///< one of the four pointers is set, according to `kind`
    std::unique_ptr<const Compound> compound;
    std::unique_ptr<const HeightField> height_field;
    std::unique_ptr<const Mesh> mesh;
};

/// A shape in the form that collision reads. The pointers stay valid while the library and the cache that made
/// it exist.
struct Solid {
    Geometry geometry;
    const Hull* hull = nullptr; ///< at the geometry's scale
    const Compound* compound = nullptr;
    const HeightField* height_field = nullptr;
    const Mesh* mesh = nullptr;
    const SupportKernel* kernel = nullptr; ///< for hulls; null: scalar code with equal results
};

struct Compound {
    Compound();
    ~Compound();
    struct Part {
        Solid solid;
        Transform local;
        Extent extent; ///< in the compound's axes, grown by the rounding errors
    };
    std::vector<Part> parts;
    Extent extent{};
    Vec3 core_center{}; ///< core_center of the part with the largest inner radius
    Length inner_radius{};
    /// Appends the indices of the parts whose extents overlap `where`, ascending.
    void find(const Extent& where, std::vector<std::uint32_t>& out) const;
    /// For more than eight parts: their indices in an order that keeps neighbours in space together.
    std::vector<std::uint32_t> order;
    std::unique_ptr<const BoundsHierarchy> hierarchy; ///< over the parts in that order; null for up to eight
};

/// The `scale` of a valid primitive: 1, 2, 4 or 8.
constexpr std::int32_t factor_of(const Geometry& primitive) {
    return primitive.scale.x.raw >> Length::fraction_bits;
}
/// The solid of a primitive without its `scale`.
constexpr Solid at_scale_one(Solid primitive) {
    primitive.geometry.scale = scale_one;
    return primitive;
}

/// Turns geometries into solids, and keeps the hulls that it had to scale. A cache: it has no effect on
/// results.
class SolidCache {
  public:
    explicit SolidCache(std::shared_ptr<const AssetLibrary> library);
    /// Returns the solid of a valid geometry. Errors: `validate` fails, the asset is missing or of another
    /// kind, the hull is not valid at its scale, or the shape reaches too far. Errors about the asset name its id.
    Result<Solid> resolve(const Geometry& geometry);
    const std::shared_ptr<const AssetLibrary>& library() const { return assets; }
    /// Sets the kernel of all solids that resolve() returns from now on; null: none.
    void use(const SupportKernel* support) { kernel = support; }

  private:
    std::shared_ptr<const AssetLibrary> assets;
    std::map<std::pair<AssetId, std::array<std::int32_t, 3>>, std::unique_ptr<const Hull>> scaled;
    const SupportKernel* kernel = nullptr;
};

/// Mass of a solid, at its scale and with its rounding; see mass_properties(Geometry, Real) for primitives.
/// Meshes, height fields and planes have none.
MassProperties mass_properties(const Solid& solid, Real density);

/// Radius of a ball around the solid's `core_center` that is inside the solid, its rounding included [m]. Zero
/// for meshes, height fields and planes.
Length inner_radius(const Solid& solid);
/// In the shape's frame: the origin of primitives, `interior` of a hull, and for a compound that of the part with the
/// largest inner radius.
Vec3 core_center(const Solid& solid);
/// The bounds in the shape's frame, rounding included. Not for planes.
Extent extent_of(const Solid& solid);
/// An upper bound of the distance of its points from its origin [m]. Not for planes.
Coordinate reach_of(const Solid& solid);

// ---- triangles of meshes and height fields ----

/// Number of triangles, holes of height fields included. The solid must be a mesh or height field, here and
/// below.
std::uint32_t triangle_count(const Solid& solid);
/// Appends the indices of the triangles whose own bounds overlap `where`, ascending. `where` is in the shape's
/// axes, at its scale. Skips holes.
void find_triangles(const Solid& solid, const Extent& where, std::vector<std::uint32_t>& out);
Triangle triangle_at(const Solid& solid, std::uint32_t index);
/// False for height fields, which are solid below, and for one-sided meshes.
bool is_two_sided(const Solid& solid);

} // namespace lockstone::shapes
