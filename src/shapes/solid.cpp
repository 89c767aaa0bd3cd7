// SolidCache, and the mass, extent and inner radius of a solid.
#include "base/text.h"
#include "lockstone/math/math.h"
#include "shapes/asset/asset.h"
#include "shapes/hull/hull.h"
#include "shapes/mass.h"
#include "shapes/mesh/height_field.h"
#include "shapes/mesh/mesh.h"

#include <algorithm>

namespace lockstone::shapes {
namespace {

using base::hex;
using base::join;

/// Limit for meshes and height fields at their scale [m].
constexpr Coordinate terrain_reach_max = Coordinate(8000);

Coordinate furthest_of(const Extent& e) {
    const CoordinateVec3 reach = max(abs(e.lower), abs(e.upper));
    return max(reach.x, max(reach.y, reach.z));
}

Extent grown(const Extent& e, Coordinate by) {
    const CoordinateVec3 all{by, by, by};
    return {e.lower - all, e.upper + all};
}

/// Half the extent of a primitive, with rounding and scale.
CoordinateVec3 reach_of(const Geometry& g) {
    const Length r = g.radius;
    LengthVec3 reach = g.half_extent + LengthVec3{r, r, r};
    if (g.kind == ShapeKind::sphere) reach = {r, r, r};
    if (g.kind == ShapeKind::capsule) reach = {r, g.half_extent.y + r, r};
    return to<Coordinate>(reach) * Coordinate(factor_of(g));
}

/// Distance of the middle of a cone's axis from its slant, rounded down.
Coordinate cone_core_radius(const LengthVec3& half) {
    const Coordinate r = to<Coordinate>(half.x), h = to<Coordinate>(half.y);
    const Coordinate slant = length(CoordinateVec3{r, h + h, Coordinate{}});
    return Coordinate::from_raw(
        divide_shifted(narrow_rounded(Wide::product(r.raw, h.raw), 24), slant.raw, 24) - 2);
}

Error missing(AssetId id) { return {join("asset ", hex(id.value), " is not in the library")}; }

Result<Hull> make_scaled(const Hull& hull, LengthVec3 factors) {
    std::vector<LengthVec3> points;
    for (const LengthVec3& v : hull.vertices)
        points.push_back({v.x * factors.x, v.y * factors.y, v.z * factors.z});
    return make_hull(points);
}

} // namespace

SolidCache::SolidCache(std::shared_ptr<const AssetLibrary> library) : assets(std::move(library)) {}

Result<Solid> SolidCache::resolve(const Geometry& g) {
    if (std::string why = validate(g); !why.empty()) return Error{std::move(why)};
    Solid solid{.geometry = g};
    if (!g.asset) return solid;
    const Asset* asset = assets == nullptr ? nullptr : assets->find(g.asset);
    if (asset == nullptr) return missing(g.asset);
    if (asset->kind != g.kind)
        return Error{join("asset ", hex(g.asset.value), " is a ", name_of(asset->kind),
                          ", the shape's kind is ", name_of(g.kind))};
    solid.hull = asset->hull.get();
    solid.kernel = kernel;
    solid.compound = asset->compound.get();
    solid.height_field = asset->height_field.get();
    solid.mesh = asset->mesh.get();
    if (solid.hull != nullptr && g.scale != scale_one) {
        std::unique_ptr<const Hull>& own = scaled[{g.asset, {g.scale.x.raw, g.scale.y.raw, g.scale.z.raw}}];
        if (own == nullptr) {
            Result<Hull> made = make_scaled(*solid.hull, g.scale);
            if (!made)
                return Error{join("asset ", hex(g.asset.value), " at its scale: ", made.error().message)};
            own = std::make_unique<const Hull>(std::move(*made));
        }
        solid.hull = own.get();
    }
    const Coordinate reach = furthest_of(extent_of(solid));
    const Coordinate limit = solid.hull != nullptr       ? to<Coordinate>(shape_size_max)
                             : solid.compound != nullptr ? Coordinate::max()
                                                         : terrain_reach_max;
    if (reach > limit)
        return Error{join("asset ", hex(g.asset.value), " at its scale and radius reaches ",
                          floor_to_int(reach), " m from its origin, it may reach ", floor_to_int(limit),
                          " m")};
    return solid;
}

MassProperties mass_properties(const Solid& solid, Real density) {
    if (solid.hull != nullptr) {
        const Hull& hull = *solid.hull;
        if (solid.geometry.radius <= Length{})
            return {unscaled<Real>(hull.volume * lockstone::shapes::scaled(density)), hull.properties.center,
                    hull.properties.gyration_squared};
        const SurfaceMass m = integrate_rounded(hull, solid.geometry.radius);
        return {unscaled<Real>(m.volume * lockstone::shapes::scaled(density)), m.center, m.gyration_squared};
    }
    if (solid.compound != nullptr) {
        std::vector<MassPart> parts;
        for (const Compound::Part& part : solid.compound->parts)
            parts.push_back({mass_properties(part.solid, density), part.local});
        return combine(parts);
    }
    return mass_of_primitive(solid.geometry, density);
}

Length inner_radius(const Solid& solid) {
    const Geometry& g = solid.geometry;
    const auto grown_by_radius = [&](Coordinate core) {
        return to<Length>((core + to<Coordinate>(g.radius)) * factor_of(g));
    };
    const LengthVec3& half = g.half_extent;
    switch (g.kind) {
    case ShapeKind::sphere:
    case ShapeKind::capsule:
        return grown_by_radius(Coordinate{});
    case ShapeKind::cylinder:
    case ShapeKind::box:
        return grown_by_radius(to<Coordinate>(min(half.x, min(half.y, half.z))));
    case ShapeKind::cone:
        return grown_by_radius(cone_core_radius(half));
    case ShapeKind::hull:
        return solid.hull->inner_radius + g.radius;
    case ShapeKind::compound:
        return solid.compound->inner_radius;
    default:
        return Length{};
    }
}

Vec3 core_center(const Solid& solid) {
    if (solid.hull != nullptr) return to<Real>(solid.hull->interior);
    if (solid.compound != nullptr) return solid.compound->core_center;
    return Vec3{};
}

Extent extent_of(const Solid& solid) {
    const Geometry& g = solid.geometry;
    if (solid.hull != nullptr) return grown(solid.hull->extent, to<Coordinate>(g.radius));
    if (solid.compound != nullptr) return solid.compound->extent;
    if (solid.height_field != nullptr) return scaled_by(solid.height_field->extent(), g.scale);
    if (solid.mesh != nullptr) return scaled_by(solid.mesh->extent(), g.scale);
    const CoordinateVec3 reach = reach_of(g);
    return {-reach, reach};
}

Coordinate reach_of(const Solid& solid) {
    const Extent e = extent_of(solid);
    return length(max(abs(e.lower), abs(e.upper)));
}

} // namespace lockstone::shapes
