#include "cook/cook.h"

#include "cook/decompose.h"
#include "cook/deviation.h"
#include "cook/height_field.h"
#include "cook/soundness.h"
#include "lockstone/math/convert.h"

#include <cstdio>
#include <numbers>

namespace lockstone::cook {
namespace {

/// The input of every kind of asset: the model in metres and the allowed deviation.
struct Source {
    const CookOptions& options;
    Soup soup; ///< welded, y up, in metres
    Soundness soundness;
    double deviation_aimed, deviation_max;
    Surface surface;
};

Unit sine_of_flat(const CookOptions& options, Unit otherwise) {
    if (!options.flat) return otherwise;
    return quantize<Unit>(std::sin(*options.flat * std::numbers::pi / 180));
}

/// Loads the assets and returns the triangles of the last one.
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

/// Adds an asset that was just baked, loads all assets, and returns the triangles of the last one.
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

/// Lengths saturate, so a model that does not fit is an error before the conversion.
Status check_reach(const Soup& soup) {
    for (const Point& p : soup.vertices)
        for (int axis = 0; axis < 3; ++axis)
            if (std::abs(p[axis]) > to_double(shape_size_max))
                return Error{"a hull lies within 100 m of the origin on each axis, the model reaches " +
                             std::to_string(p[axis]) + " m (--scale shrinks it)"};
    return {};
}

constexpr std::uint32_t corners_first = 64;

/// The error of an asset that cannot be baked, with the flags that help.
Error with_flags(const Error& why, const char* flags) { return Error{why.message + " (" + flags + ")"}; }
constexpr const char* flags_of_thin = "--scale enlarges it; --as mesh --two-sided keeps a thin model";

Result<Cooked> cook_hull_of(const Source& source, const Convex& whole, std::uint32_t corners_max) {
    const Result<Convex> few = reduced(whole, corners_max);
    if (!few) return few.error();
    Cooked out;
    Result<AssetBytes> baked = bake_hull(quantized(few->surface.vertices));
    if (!baked) return with_flags(baked.error(), flags_of_thin);
    const Result<Soup> loaded = keep(std::move(baked), out);
    if (!loaded) return loaded.error();
    const Result<Convex> result = convex_hull(loaded->vertices);
    if (!result) return result.error();
    out.gap = excess(*result, source.surface, source.options.samples / 10);
    out.parts = 1;
    out.volume = result->volume;
    return with_deviation(std::move(out), deviation_of_hulls(whole, *result));
}

/// Makes a hull. Adds corners until the deviation is small enough, unless the options fix the number of corners.
Result<Cooked> cook_hull(const Source& source) {
    if (const Status s = check_reach(source.soup); !s) return s.error();
    const Result<Convex> whole = convex_hull(source.soup.vertices);
    if (!whole) return whole.error();
    if (source.options.corners_max) return cook_hull_of(source, *whole, *source.options.corners_max);
    Result<Cooked> best = cook_hull_of(source, *whole, corners_first);
    for (const std::uint32_t corners : {2 * corners_first, hull_vertices_max}) {
        if (best && best->deviation <= source.deviation_aimed) break;
        Result<Cooked> next = cook_hull_of(source, *whole, corners);
        if (!best || (next && next->deviation < best->deviation)) best = std::move(next);
    }
    return best;
}

// ---- convex decomposition -------------------------------------------------------------------------------------

/// Bakes the parts that are thick enough. The baked geometries go to `parts`, and the hulls as loaded again to
/// `loaded`.
Status bake_parts(const std::vector<Convex>& wanted, const CookOptions& options, AssetLibrary& library,
                  Cooked& out, std::vector<CompoundPart>& parts, std::vector<Convex>& loaded) {
    std::optional<Error> why;
    for (const Convex& part : wanted) {
        const Result<Convex> few = reduced(part, options.corners_max.value_or(corners_first));
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
        out.volume += again->volume;
        loaded.push_back(std::move(*again));
        parts.push_back({*geometry, Transform::identity()});
        out.assets.push_back(std::move(*bytes));
    }
    if (!parts.empty()) return {};
    return with_flags(why.value_or(Error{"the model has no volume"}), flags_of_thin);
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

/// The decomposition samples the surface coarsely. If the exact check finds too large a deviation, the decomposition
/// runs again with a smaller limit.
Result<Cooked> cook_convex(const Source& source) {
    if (const Status s = check_reach(source.soup); !s) return s.error();
    if (Result<Cooked> one = cook_hull(source); one && one->deviation + one->gap <= source.deviation_aimed)
        return one;
    Result<Cooked> best = cook_parts(source, 0.8 * source.deviation_aimed);
    constexpr std::size_t triangles_repeated = 20'000;
    for (const double share : {0.5, 0.25}) {
        // Decompositions of many parts or triangles take long, and repeating them improves little.
        if (!best || best->deviation <= source.deviation_aimed ||
            source.soup.triangles.size() > triangles_repeated ||
            2 * (best->parts + best->parts_dropped) > source.options.parts_max)
            break;
        Result<Cooked> next = cook_parts(source, share * source.deviation_aimed);
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
    Result<AssetBytes> baked = bake_mesh(def);
    if (!baked) return with_flags(baked.error(), "--scale makes it smaller or larger");
    const Result<Soup> loaded = keep(std::move(baked), out);
    if (!loaded) return loaded.error();
    if (loaded->triangles.empty()) return Error{"every triangle is degenerate (--scale enlarges it)"};
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
    if (loaded->triangles.empty())
        return Error{"no cell of the height field lies below triangles of the model with all its corners "
                     "(--z-up turns a model whose z axis points up; "
                     "a smaller --spacing follows a narrow one; --as mesh keeps upright triangles)"};
    out.origin = heights->origin;
    out.spacing = to_double(heights->spacing);
    for (Point& p : loaded->vertices) p = p + heights->origin;
    return with_deviation(std::move(out),
                          deviation_from_above(source.soup, source.surface, *loaded, source.options.samples));
}

/// Makes a height field. Without a given spacing it goes from coarse to fine until the deviation is small enough.
Result<Cooked> cook_height_field(const Source& source) {
    if (source.options.spacing) return cook_heights(source, *source.options.spacing);
    constexpr int cells_first = 32, cells_last = 1024;
    const Point size = bounds_of(source.soup.vertices).size();
    std::optional<Result<Cooked>> best;
    for (int cells = cells_first; cells <= cells_last; cells *= 2) {
        Result<Cooked> now = cook_heights(source, std::max(size.x, size.z) / cells);
        if (!now) return now;
        if (!best || now->deviation < (*best)->deviation) best = std::move(now);
        if ((*best)->deviation <= source.deviation_aimed) break;
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
    if (options.flip)
        for (Indices& t : soup.triangles) std::swap(t[1], t[2]);
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

// ---- notes about odd models -----------------------------------------------------------------------------------

std::string in_text(const char* format, double a, double b = 0) {
    char text[300];
    std::snprintf(text, sizeof text, format, a, b);
    return text;
}

void note_surface(const Source& source, Cooked& made) {
    const Soundness& found = source.soundness;
    if (source.options.two_sided) return;
    if (found.edges_disputed > 0)
        made.notes.push_back(in_text("at %.0f edges triangles face opposite ways, and bodies fall through "
                                     "those that face down (--two-sided makes "
                                     "walls of all triangles)",
                                     static_cast<double>(found.edges_disputed)));
    else if (found.closed() && found.volume < 0)
        made.notes.emplace_back("the surface is inside out: its triangles face inwards, and what touches it "
                                "is pushed in (--flip turns them)");
}

void note_hulls(const Source& source, Cooked& made) {
    constexpr double density = 1000, mass_min = 0.001; // [kg/m^3], [kg]
    if (density * made.volume < mass_min)
        made.notes.push_back(in_text("at 1000 kg/m^3 it has %.2g g; a body of it has 1 g, the least mass of "
                                     "bodies (--scale enlarges it)",
                                     1000 * density * made.volume));
    if (!source.options.deviation && made.deviation > made.deviation_aimed)
        made.notes.push_back(in_text("it deviates by %.2g %% of the model's size, the aim is %.2g %% "
                                     "(--parts and --vertices follow the model closer, "
                                     "--deviation bounds it)",
                                     100 * made.deviation / made.deviation_aimed * deviation_share_aimed,
                                     100 * deviation_share_aimed));
    if (source.options.as == Wanted::convex && made.deviation > made.deviation_aimed &&
        !source.soundness.closed())
        made.notes.push_back(in_text("the surface is open at %.0f edges, so its inside is a guess (--as mesh "
                                     "--two-sided keeps a surface)",
                                     static_cast<double>(source.soundness.edges_open)));
}

void add_notes(const Source& source, Cooked& made) {
    if (made.kind == ShapeKind::mesh) note_surface(source, made);
    if (made.parts > 0) note_hulls(source, made);
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
    const bool is_of_hulls = options.as == Wanted::hull || options.as == Wanted::convex;
    const double extent = bounds_of(soup->vertices).largest();
    const double aimed = options.deviation.value_or(deviation_share_aimed * extent);
    const double allowed = options.deviation || !is_of_hulls ? aimed : deviation_share_max * extent;
    Surface surface(*soup);
    const Soundness soundness = soundness_of(*soup);
    const Source source{options, std::move(*soup), soundness, aimed, allowed, std::move(surface)};
    Result<Cooked> cooked = cook_kind(source);
    if (!cooked) return cooked;
    cooked->deviation_aimed = aimed;
    cooked->deviation_max = allowed;
    cooked->source_vertices = source.soup.vertices.size();
    cooked->source_triangles = source.soup.triangles.size();
    add_notes(source, *cooked);
    return cooked;
}

} // namespace lockstone::cook
