// Scaled and mirrored copies of assets.
//
// A part of a compound has its points at R p + t. With the factors F = |F| D, where D has their signs, these become
// F R p + F t = |F| (D R D) (D p) + F t. D R D is a rotation. D p is the part mirrored in its own frame: a primitive
// again. If |F| is uniform, or the part's axes are those of the compound, |F| (D R D) = (D R D) G with a diagonal G.
#include "base/text.h"
#include "lockstone/math/decimal.h"
#include "shapes/asset/asset_file.h"
#include "shapes/mesh/height_field.h"
#include "shapes/mesh/mesh.h"

#include <algorithm>
#include <map>

namespace lockstone {
namespace shapes {
namespace {

constexpr Real copy_factor_min = 0.001_r, copy_factor_max = Real(1000);
/// Axes of a part count as those of the compound if they are off by at most this angle [rad].
constexpr Unit axis_tolerance = Unit::from_raw(8);

bool is_uniform(Vec3 f) { return abs(f.x) == abs(f.y) && abs(f.y) == abs(f.z); }

bool is_mirror(Vec3 f) { return ((f.x < Real{}) != (f.y < Real{})) != (f.z < Real{}); }

template <FixedPoint T> Vector3<T> stretched(Vector3<T> p, Vec3 f) {
    return {mul<T>(p.x, f.x), mul<T>(p.y, f.y), mul<T>(p.z, f.z)};
}

/// Negates the components whose factor is negative.
template <FixedPoint T> Vector3<T> with_signs(Vector3<T> v, Vec3 f) {
    for (int i = 0; i < 3; ++i)
        if (f[i] < Real{}) v[i] = -v[i];
    return v;
}

/// D R D. Its axis is D a, turned round if D is a mirror.
Quat mirrored(Quat q, Vec3 f) {
    UnitVec3 axis = with_signs(UnitVec3{q.x, q.y, q.z}, f);
    if (is_mirror(f)) axis = -axis;
    return {axis.x, axis.y, axis.z, q.w};
}

/// Finds G: the absolute factor along each axis of a part. False if an axis is not one of the compound's, and the
/// factors are not uniform.
bool find_own_factors(Quat rotation, Vec3 factor, Vec3& own) {
    own = abs(factor);
    if (is_uniform(factor)) return true;
    const Rotation axes = to_rotation(rotation);
    const UnitVec3 column[3] = {abs(axes.x), abs(axes.y), abs(axes.z)};
    for (int i = 0; i < 3; ++i) {
        int along = 0, across = 0;
        for (int k = 0; k < 3; ++k) {
            if (column[i][k] >= unit_one - axis_tolerance) own[i] = abs(factor[k]), ++along;
            if (column[i][k] <= axis_tolerance) ++across;
        }
        if (along != 1 || across != 2) return false;
    }
    return true;
}

/// Scales a primitive part. Returns the reason if the result is not a primitive, or an empty string.
std::string stretch_primitive(CompoundPart& part, Vec3 factor) {
    Geometry& g = part.geometry;
    const std::string_view kind = name_of(g.kind);
    Vec3 own{};
    if (!find_own_factors(part.local.rotation, factor, own))
        return base::join("it is a rotated ", kind, ", the absolute factors must be equal");
    if (is_uniform(own)) {
        g = scaled(g, own.x);
    } else {
        if (g.kind == ShapeKind::sphere || g.kind == ShapeKind::capsule)
            return base::join("it is a ", kind, ", the absolute factors must be equal");
        if (g.radius != Length{})
            return base::join("it is a ", kind, " rounded by ", to_string(g.radius),
                              " m, the absolute factors must be equal");
        if (g.kind != ShapeKind::box && own.x != own.z)
            return base::join("it is a ", kind, ", the absolute factors across its axis are ",
                              to_string(own.x), " and ", to_string(own.z), ", they must be equal");
        g.half_extent = stretched(g.half_extent, own);
    }
    part.local.position = stretched(part.local.position, factor);
    part.local.rotation = mirrored(part.local.rotation, factor);
    // A mirrored cone points down: half a turn about x is the same, and a rotation.
    if (g.kind == ShapeKind::cone && factor.y < Real{})
        part.local.rotation = part.local.rotation * Quat{unit_one, Unit{}, Unit{}, Unit{}};
    return {};
}

Result<AssetBytes> stretched_hull(const Hull& hull, Quat rotation, Vec3 factor) {
    const Rotation axes = to_rotation(rotation);
    std::vector<LengthVec3> points;
    for (const LengthVec3& v : hull.vertices) {
        const Vec3 turned = lockstone::mul<Real>(axes, to<Real>(v));
        points.push_back({mul<Length>(turned.x, factor.x), mul<Length>(turned.y, factor.y),
                          mul<Length>(turned.z, factor.z)});
    }
    return bake_hull(points);
}

/// The hulls of a scaled compound, each once.
class StretchedHulls {
  public:
    /// Scales a hull part. Returns the reason if the result is not a valid hull, or an empty string. Hulls of factors
    /// that are not uniform are baked with their rotation.
    std::string stretch(CompoundPart& part, const Hull& hull, Vec3 factor) {
        Geometry& g = part.geometry;
        const bool uniform = is_uniform(factor);
        if (!uniform && g.radius != Length{})
            return base::join("it is a hull rounded by ", to_string(g.radius),
                              " m, the absolute factors must be equal");
        const Quat baked = uniform ? Quat::identity() : part.local.rotation;
        AssetId& id = known[{g.asset, {baked.x.raw, baked.y.raw, baked.z.raw, baked.w.raw}}];
        if (!id) {
            Result<AssetBytes> bytes = stretched_hull(hull, baked, factor);
            if (!bytes) return join_hull(g.asset, bytes.error().message);
            id = id_of(*bytes);
            if (std::ranges::none_of(assets, [&](const AssetBytes& a) { return id_of(a) == id; }))
                assets.push_back(std::move(*bytes));
        }
        g.asset = id;
        g.radius = mul<Length>(g.radius, abs(factor.x));
        part.local.position = stretched(part.local.position, factor);
        part.local.rotation = uniform ? mirrored(part.local.rotation, factor) : Quat::identity();
        return {};
    }
    std::vector<AssetBytes> take() && { return std::move(assets); }

  private:
    static std::string join_hull(AssetId id, const std::string& why) {
        return base::join("its hull ", base::hex(id.value), ": ", why);
    }
    std::map<std::pair<AssetId, std::array<std::int32_t, 4>>, AssetId> known;
    std::vector<AssetBytes> assets;
};

Result<AssetBytes> stretched_compound(const Compound& compound, Vec3 factor) {
    StretchedHulls hulls;
    std::vector<CompoundPart> parts;
    for (const Compound::Part& from : compound.parts) {
        CompoundPart part{from.solid.geometry, from.local};
        const std::string why = from.solid.hull != nullptr ? hulls.stretch(part, *from.solid.hull, factor)
                                                           : stretch_primitive(part, factor);
        if (!why.empty()) return Error{base::join("part ", parts.size(), ": ", why)};
        parts.push_back(part);
    }
    Result<AssetBytes> baked = bake_compound(parts);
    if (!baked) return baked.error();
    std::vector<AssetBytes> all = std::move(hulls).take();
    all.push_back(std::move(*baked));
    return encode_assets(all);
}

std::vector<MaterialSurface> with_signs(std::vector<MaterialSurface> surfaces, Vec3 factor) {
    for (MaterialSurface& surface : surfaces)
        surface.surface_velocity = with_signs(surface.surface_velocity, factor);
    return surfaces;
}

Result<AssetBytes> stretched_mesh(const Mesh& mesh, Vec3 factor) {
    const MeshContent& content = mesh.raw();
    std::vector<Vec3> vertices;
    for (const MeshVertex& v : content.vertices)
        vertices.push_back(to<Real>(stretched(position_of(v), factor)));
    std::vector<std::array<std::uint32_t, 3>> triangles = content.triangles;
    if (is_mirror(factor))
        for (auto& t : triangles) std::swap(t[1], t[2]);
    std::vector<std::uint32_t> sources;
    for (std::uint32_t i = 0; i < mesh.triangle_count(); ++i) sources.push_back(mesh.source_of(i));
    const std::vector<MaterialSurface> surfaces = with_signs(content.surfaces, factor);
    return bake_mesh_in_order({.vertices = vertices,
                               .triangles = triangles,
                               .materials = content.materials,
                               .surfaces = surfaces,
                               .two_sided = content.two_sided,
                               .flat_sine = content.flat_sine},
                              sources);
}

Result<AssetBytes> stretched_height_field(const HeightField& field, Vec3 factor) {
    if (min(factor.x, min(factor.y, factor.z)) < Real{})
        return Error{
            "a height field has no mirror image, because its first sample is at x = z = 0, its cells "
            "have one diagonal and its inside is below: bake a mesh"};
    if (factor.x != factor.z)
        return Error{base::join("factor.x is ", to_string(factor.x), " and factor.z is ", to_string(factor.z),
                                ", for a height field they must be equal")};
    const HeightGrid& grid = field.size();
    std::vector<Length> heights;
    for (std::uint32_t i = 0; i < field.sample_count(); ++i)
        heights.push_back(mul<Length>(field.sample(i).y, factor.y));
    std::vector<std::uint8_t> cells;
    for (std::byte cell : field.cell_bytes()) cells.push_back(static_cast<std::uint8_t>(cell));
    return bake_height_field({.columns = grid.columns,
                              .rows = grid.rows,
                              .spacing = mul<Length>(grid.spacing, factor.x),
                              .heights = heights,
                              .cells = cells,
                              .surfaces = field.surfaces(),
                              .flat_sine = grid.flat_sine});
}

Result<AssetBytes> stretched_copy(const Asset& asset, Vec3 factor) {
    constexpr const char* names[] = {"factor.x", "factor.y", "factor.z"};
    for (int i = 0; i < 3; ++i)
        if (abs(factor[i]) < copy_factor_min || abs(factor[i]) > copy_factor_max)
            return Error{base::join(names[i], " is ", to_string(factor[i]),
                                    ", its absolute value must be in 0.001 .. 1000")};
    if (asset.hull != nullptr) return stretched_hull(*asset.hull, Quat::identity(), factor);
    if (asset.compound != nullptr) return stretched_compound(*asset.compound, factor);
    if (asset.mesh != nullptr) return stretched_mesh(*asset.mesh, factor);
    return stretched_height_field(*asset.height_field, factor);
}

} // namespace
} // namespace shapes

Result<AssetBytes> bake_scaled(const AssetLibrary& library, AssetId id, Vec3 factor) {
    const shapes::Asset* asset = library.find(id);
    if (asset == nullptr) return Error{base::join("asset ", base::hex(id.value), " is not in the library")};
    Result<AssetBytes> baked = shapes::stretched_copy(*asset, factor);
    if (baked) return baked;
    return Error{base::join("asset ", base::hex(id.value), ", a ", name_of(asset->kind), ", times ",
                            to_string(factor), ": ", baked.error().message)};
}

} // namespace lockstone
