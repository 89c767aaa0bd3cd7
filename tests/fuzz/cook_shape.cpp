// Fuzz target: arbitrary bytes as a model, for the bakers of hull, mesh and height field. It leaves out decomposition
// and measuring, which take most of the time and write no bytes; fuzz_cook runs both. The inputs are those of
// fuzz_cook.
#include "cook/convex.h"
#include "cook/height_field.h"
#include "cook_input.h"
#include "lockstone/math/convert.h"

#include <cstdio>
#include <cstdlib>

namespace {

using namespace lockstone;
using namespace lockstone::cook;

Result<AssetBytes> bake_hull_of(const Soup& soup, const CookOptions& options) {
    const Result<Convex> whole = convex_hull(soup.vertices);
    if (!whole) return whole.error();
    const Result<Convex> few = reduced(*whole, options.corners_max.value_or(64));
    if (!few) return few.error();
    std::vector<LengthVec3> points;
    for (const Point& p : few->surface.vertices)
        points.push_back(quantize<Length>(std::array<double, 3>{p.x, p.y, p.z}));
    return bake_hull(points);
}

Result<AssetBytes> bake_mesh_of(const Soup& soup, const CookOptions& options) {
    std::vector<Vec3> vertices;
    for (const Point& p : soup.vertices)
        vertices.push_back(quantize<Real>(std::array<double, 3>{p.x, p.y, p.z}));
    return bake_mesh({.vertices = vertices, .triangles = soup.triangles, .two_sided = options.two_sided});
}

Result<AssetBytes> bake_heights_of(const Soup& soup, const CookOptions& options) {
    const Result<Heights> h = sample_heights(soup, Surface(soup), *options.spacing);
    if (!h) return h.error();
    return bake_height_field({.columns = h->columns,
                              .rows = h->rows,
                              .spacing = h->spacing,
                              .heights = h->heights,
                              .cells = h->cells});
}

Result<AssetBytes> bake_as_wanted(const Soup& soup, const CookOptions& options) {
    switch (options.as) {
    case Wanted::mesh:
        return bake_mesh_of(soup, options);
    case Wanted::height_field:
        return bake_heights_of(soup, options);
    default:
        return bake_hull_of(soup, options);
    }
}

/// Returns a sentence for an error without a message, or for bytes that do not load and bake to equal bytes. Else an
/// empty string.
std::string complaint(const fuzz::CookInput& input) {
    if (!check(input.model).empty()) return {};
    const Soup soup = compacted(welded(input.model));
    if (soup.triangles.empty()) return {};
    const Result<AssetBytes> bytes = bake_as_wanted(soup, input.options);
    if (!bytes) return bytes.error().message.empty() ? "an error without a sentence" : "";
    AssetLibrary library;
    const Result<AssetId> id = library.add(std::span<const std::byte>(*bytes));
    if (!id) return "bytes that do not load: " + id.error().message;
    const Result<Geometry> geometry = library.geometry(*id);
    if (!geometry) return geometry.error().message;
    return check(to_soup(triangulate(*geometry, library)));
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string wrong = complaint(fuzz::read_cook_input({data, size}));
    if (wrong.empty()) return 0;
    std::fprintf(stderr, "cook shape: %s\n", wrong.c_str());
    std::abort();
}
