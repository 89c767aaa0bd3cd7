#include "cook/cook.h"

#include "cook/decompose.h"
#include "cook/deviation.h"
#include "cook/height_field.h"
#include "lockstone/math/convert.h"

#include <numbers>

namespace lockstone::cook {
namespace {

/// What the kinds share: the model in metres, and what was allowed.
struct Source {
    const CookOptions& options;
    Soup soup; ///< welded, y up, in metres
    double deviation_max;
    Surface surface;
};

Unit sine_of_flat(const CookOptions& options, Unit otherwise) {
    if (!options.flat) return otherwise;
    return quantize<Unit>(std::sin(*options.flat * std::numbers::pi / 180));
}

/// What loading made of the last asset, as triangles.
Result<Soup> load_again(const std::vector<AssetBytes>& assets, AssetLibrary& library, Cooked& out) {
    for (const AssetBytes& bytes : assets) {
        const Result<AssetId> id = library.add(std::span<const std::byte>(bytes));
        if (!id) return Error{"the baked bytes do not load: " + id.error().message};
        out.id = *id;
    }
    const Result<Geometry> geometry = library.geometry(out.id);
    if (!geometry) return geometry.error();
    out.kind = geometry->kind;
    Soup soup = to_soup(triangulate(*geometry, library));
    out.vertices = soup.vertices.size();
    out.triangles = soup.triangles.size();
    return soup;
}

/// What loading made of an asset that was just baked.
Result<Soup> keep(Result<AssetBytes> baked, Cooked& out) {
    if (!baked) return baked.error();
    out.assets.push_back(std::move(*baked));
    AssetLibrary library;
    return load_again(out.assets, library, out);
}

Result<Cooked> with_deviation(Cooked out, const Result<Deviation>& found) {
    if (!found) return found.error();
    out.deviation = found->largest();
    return out;
}

std::vector<LengthVec3> quantized(const std::vector<Point>& points) {
    std::vector<LengthVec3> out;
    for (const Point& p : points) out.push_back(quantize<Length>(std::array<double, 3>{p.x, p.y, p.z}));
    return out;
}

/// Lengths clamp: what they cannot hold must be refused before.
Status check_reach(const Soup& soup) {
    for (const Point& p : soup.vertices)
        for (int axis = 0; axis < 3; ++axis)
            if (std::abs(p[axis]) > to_double(shape_size_max))
                return Error{"a hull lies within 100 m of the origin on each axis, the model reaches " +
                             std::to_string(p[axis]) + " m (--scale shrinks it)"};
    return {};
}

Result<Cooked> cook_hull(const Source& source) {
    if (const Status s = check_reach(source.soup); !s) return s.error();
    const Result<Convex> whole = convex_hull(source.soup.vertices);
    if (!whole) return whole.error();
    const Result<Convex> few = reduced(*whole, source.options.corners_max);
    if (!few) return few.error();
    Cooked out;
    const Result<Soup> loaded = keep(bake_hull(quantized(few->surface.vertices)), out);
    if (!loaded) return loaded.error();
    const Result<Convex> result = convex_hull(loaded->vertices);
    if (!result) return result.error();
    out.gap = excess(*result, source.surface, source.options.samples / 10);
    out.parts = 1;
    return with_deviation(std::move(out), deviation_of_hulls(*whole, *result));
}

// ---- convex decomposition -------------------------------------------------------------------------------------

/// Bakes what is thick enough. The hulls' geometries are in `parts`, and as they were loaded in `loaded`.
Status bake_parts(const std::vector<Convex>& wanted, const CookOptions& options, AssetLibrary& library,
                  Cooked& out, std::vector<CompoundPart>& parts, std::vector<Convex>& loaded) {
    std::optional<Error> why;
    for (const Convex& part : wanted) {
        const Result<Convex> few = reduced(part, options.corners_max);
        if (!few) return few.error();
        Result<AssetBytes> bytes = bake_hull(quantized(few->surface.vertices));
        if (!bytes) {
            ++out.parts_dropped;
            why = bytes.error();
            continue;
        }
        const Result<AssetId> id = library.add(std::span<const std::byte>(*bytes));
        if (!id) return Error{"the baked bytes do not load: " + id.error().message};
        const Result<Geometry> geometry = library.geometry(*id);
        if (!geometry) return geometry.error();
        Result<Convex> again = convex_hull(to_soup(triangulate(*geometry, library)).vertices);
        if (!again) return again.error();
        loaded.push_back(std::move(*again));
        parts.push_back({*geometry, Transform::identity()});
        out.assets.push_back(std::move(*bytes));
    }
    if (parts.empty()) return why ? Status(*why) : Status(Error{"the model has no volume"});
    return {};
}

Result<Cooked> cook_parts(const Source& source, double deviation) {
    const DecomposeOptions decompose_options{
        deviation, source.options.parts_max,
        std::max(4 * to_double(shape_size_min), 1e-3 * bounds_of(source.soup.vertices).largest())};
    const Result<std::vector<Convex>> wanted = decompose(source.soup, source.surface, decompose_options);
    if (!wanted) return wanted.error();
    Cooked out;
    AssetLibrary library;
    std::vector<CompoundPart> parts;
    std::vector<Convex> loaded;
    if (const Status s = bake_parts(*wanted, source.options, library, out, parts, loaded); !s)
        return s.error();
    if (parts.size() > 1) {
        Result<AssetBytes> compound = bake_compound(parts);
        if (!compound) return compound.error();
        out.assets.push_back(std::move(*compound));
    }
    const Result<Soup> all = load_again(out.assets, library, out);
    if (!all) return all.error();
    std::size_t triangles = 0;
    for (const CompoundPart& part : parts) triangles += triangulate(part.geometry, library).triangles.size();
    if (triangles != all->triangles.size()) return Error{"the compound does not hold what its parts hold"};
    out.parts = parts.size();
    return with_deviation(std::move(out),
                          deviation_of_solids(source.soup, source.surface, loaded, source.options.samples));
}

/// What the decomposition samples is coarse: when the check finds more deviation, it is asked for less.
Result<Cooked> cook_convex(const Source& source) {
    if (const Status s = check_reach(source.soup); !s) return s.error();
    Result<Cooked> best = cook_parts(source, 0.8 * source.deviation_max);
    for (const double share : {0.5, 0.25}) {
        if (!best || best->deviation <= source.deviation_max || best->parts >= source.options.parts_max)
            break;
        Result<Cooked> next = cook_parts(source, share * source.deviation_max);
        if (next && next->deviation < best->deviation) best = std::move(next);
    }
    return best;
}

// ---- ground ---------------------------------------------------------------------------------------------------

Result<Cooked> cook_mesh(const Source& source) {
    std::vector<Vec3> vertices;
    for (const Point& p : source.soup.vertices)
        vertices.push_back(quantize<Real>(std::array<double, 3>{p.x, p.y, p.z}));
    MeshDef def{.vertices = vertices, .triangles = source.soup.triangles};
    def.two_sided = source.options.two_sided;
    def.flat_sine = sine_of_flat(source.options, def.flat_sine);
    Cooked out;
    const Result<Soup> loaded = keep(bake_mesh(def), out);
    if (!loaded) return loaded.error();
    if (loaded->triangles.empty()) return Error{"every triangle is degenerate"};
    return with_deviation(
        std::move(out), deviation_of_surfaces(source.soup, source.surface, *loaded, source.options.samples));
}

Result<Cooked> cook_heights(const Source& source, double spacing) {
    const Result<Heights> heights = sample_heights(source.soup, source.surface, spacing);
    if (!heights) return heights.error();
    HeightFieldDef def{.columns = heights->columns,
                       .rows = heights->rows,
                       .spacing = heights->spacing,
                       .heights = heights->heights,
                       .cells = heights->cells};
    def.flat_sine = sine_of_flat(source.options, def.flat_sine);
    Cooked out;
    Result<Soup> loaded = keep(bake_height_field(def), out);
    if (!loaded) return loaded.error();
    if (loaded->triangles.empty()) return Error{"nothing of the model is seen from above"};
    out.origin = heights->origin;
    out.spacing = to_double(heights->spacing);
    for (Point& p : loaded->vertices) p = p + heights->origin;
    return with_deviation(std::move(out),
                          deviation_from_above(source.soup, source.surface, *loaded, source.options.samples));
}

/// With no spacing given: from coarse to fine until the deviation is allowed.
Result<Cooked> cook_height_field(const Source& source) {
    if (source.options.spacing) return cook_heights(source, *source.options.spacing);
    constexpr int cells_first = 32, cells_last = 1024;
    const Point size = bounds_of(source.soup.vertices).size();
    std::optional<Result<Cooked>> best;
    for (int cells = cells_first; cells <= cells_last; cells *= 2) {
        Result<Cooked> now = cook_heights(source, std::max(size.x, size.z) / cells);
        if (!now) return now;
        if (!best || now->deviation < (*best)->deviation) best = std::move(now);
        if ((*best)->deviation <= source.deviation_max) break;
    }
    return std::move(*best);
}

Result<Soup> in_metres(const Soup& model, const CookOptions& options) {
    Soup soup = model;
    for (Point& p : soup.vertices) {
        if (options.z_up) p = {p.x, p.z, -p.y};
        p = p * options.scale;
    }
    if (const std::string why = check(soup); !why.empty()) return Error{why};
    soup = compacted(welded(soup));
    if (soup.triangles.empty()) return Error{"it has no triangle with an area"};
    return soup;
}

Result<Cooked> cook_kind(const Source& source) {
    switch (source.options.as) {
    case Wanted::hull:
        return cook_hull(source);
    case Wanted::convex:
        return cook_convex(source);
    case Wanted::mesh:
        return cook_mesh(source);
    case Wanted::height_field:
        break;
    }
    return cook_height_field(source);
}

} // namespace

std::size_t Cooked::bytes() const {
    std::size_t sum = 0;
    for (const AssetBytes& asset : assets) sum += asset.size();
    return sum;
}

Result<Cooked> cook(const Soup& model, const CookOptions& options) {
    Result<Soup> soup = in_metres(model, options);
    if (!soup) return soup.error();
    const double allowed = options.deviation.value_or(0.01 * bounds_of(soup->vertices).largest());
    Surface surface(*soup);
    const Source source{options, std::move(*soup), allowed, std::move(surface)};
    Result<Cooked> cooked = cook_kind(source);
    if (!cooked) return cooked;
    cooked->deviation_max = allowed;
    cooked->source_vertices = source.soup.vertices.size();
    cooked->source_triangles = source.soup.triangles.size();
    return cooked;
}

} // namespace lockstone::cook
