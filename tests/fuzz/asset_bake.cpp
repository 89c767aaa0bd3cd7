// Fuzz target: arbitrary numbers as input of bake_hull, bake_mesh, bake_height_field and bake_compound. Every result
// must load, and baking a loaded asset again must give equal bytes.
//
//   built like tests/fuzz/asset_load.cpp
#include "fuzz/checks/asset_check.h"

#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

using namespace lockstone;

/// Reads numbers from the input; zeros after its end.
class Numbers {
  public:
    explicit Numbers(std::span<const std::uint8_t> from) : bytes(from) {}
    template <class N> N next() {
        N value{};
        const std::size_t size = bytes.size() < sizeof(N) ? bytes.size() : sizeof(N);
        if (size > 0) std::memcpy(&value, bytes.data(), size);
        bytes = bytes.subspan(size);
        return value;
    }
    /// A 16-bit value at one of four magnitudes, so that neighbours in a plane are as likely as far points.
    std::int64_t place(int bits) {
        const std::int64_t small = next<std::int16_t>();
        return small * (std::int64_t{1} << (next<std::uint8_t>() % 4 * bits / 3));
    }
    Length length() { return Length::from_raw(saturate_to_int32(place(16))); }
    Real real() { return Real::from_raw(place(30)); }
    bool empty() const { return bytes.empty(); }

  private:
    std::span<const std::uint8_t> bytes;
};

Result<AssetBytes> bake_some_hull(Numbers& in) {
    std::vector<LengthVec3> points;
    while (!in.empty() && points.size() < 300) {
        const Length x = in.length(), y = in.length(), z = in.length();
        points.push_back({x, y, z});
    }
    return bake_hull(points);
}

Result<AssetBytes> bake_some_mesh(Numbers& in) {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    std::vector<std::uint16_t> materials;
    MeshDef def;
    def.two_sided = in.next<std::uint8_t>() % 2 != 0;
    def.flat_sine = Unit::from_raw(in.next<std::int32_t>());
    const std::uint32_t count = in.next<std::uint8_t>() % 32;
    for (std::uint32_t i = 0; i < count; ++i) {
        const Real x = in.real(), y = in.real(), z = in.real();
        vertices.push_back({x, y, z});
    }
    while (!in.empty()) {
        const std::uint32_t a = in.next<std::uint8_t>() % 32, b = in.next<std::uint8_t>() % 32,
                            c = in.next<std::uint8_t>() % 32;
        triangles.push_back({a, b, c});
        materials.push_back(in.next<std::uint8_t>());
    }
    def.vertices = vertices;
    def.triangles = triangles;
    if (materials.size() % 2 == 0) def.materials = materials;
    return bake_mesh(def);
}

Result<AssetBytes> bake_some_height_field(Numbers& in) {
    HeightFieldDef def{};
    def.columns = in.next<std::uint8_t>() % 20;
    def.rows = in.next<std::uint8_t>() % 20;
    def.spacing = in.length();
    std::vector<Length> heights(std::size_t{def.columns} * def.rows);
    for (Length& h : heights) h = in.length();
    std::vector<std::uint8_t> cells;
    while (!in.empty()) cells.push_back(in.next<std::uint8_t>());
    def.heights = heights;
    def.cells = cells;
    return bake_height_field(def);
}

Result<AssetBytes> bake_some_compound(Numbers& in, const AssetLibrary& library) {
    std::vector<CompoundPart> parts;
    while (!in.empty() && parts.size() < 40) {
        CompoundPart part{};
        part.geometry.kind = static_cast<ShapeKind>(in.next<std::uint8_t>() % 8);
        part.geometry.radius = in.length();
        for (int k = 0; k < 3; ++k) part.geometry.half_extent[k] = in.length();
        if (part.geometry.kind == ShapeKind::hull)
            part.geometry = library.geometry(library.ids().front()).value();
        const Real x = in.real(), y = in.real(), z = in.real();
        part.local = {{x, y, z}, Quat::identity()};
        parts.push_back(part);
    }
    return bake_compound(parts);
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const AssetLibrary library = fuzz::library_with_hull();
    if (size == 0) return 0;
    Numbers in(std::span(data, size).subspan(1));
    const Result<AssetBytes> baked = data[0] % 4 == 0   ? bake_some_hull(in)
                                     : data[0] % 4 == 1 ? bake_some_mesh(in)
                                     : data[0] % 4 == 2 ? bake_some_height_field(in)
                                                        : bake_some_compound(in, library);
    if (!baked) return 0;
    bool loaded = false;
    std::string complaint = fuzz::check(*baked, library, loaded);
    if (!loaded)
        complaint = "baked bytes were refused: " + shapes::parse_asset(*baked, library).error().message;
    if (complaint.empty()) return 0;
    std::fprintf(stderr, "%s\n", complaint.c_str());
    std::abort();
}
