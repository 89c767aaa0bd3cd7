// Damaged assets: flipped bits, missing and added bytes, and false content with a valid checksum.
#include "fuzz/asset_samples.h"
#include "support/effort.h"

#include <doctest/doctest.h>

#include <functional>
#include <set>

using namespace lockstone;
using lockstone::base::join;

namespace {

/// The sentence that refuses the bytes; empty when they are accepted. A library that refuses does not change.
std::string refusal(std::span<const std::byte> bytes) {
    AssetLibrary library = fuzz::library_with_hull();
    const Result<AssetId> id = library.add(bytes);
    if (id) return {};
    return library.ids().size() == 1 ? id.error().message : "the library changed";
}

bool mentions(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

/// Counts the single flipped bits that the library refuses with a sentence about their cause. `before` may undo them.
std::size_t flips_a_byte() { return static_cast<std::size_t>(test::tries(8)); }
template <class Before> std::size_t flips_refused(const AssetBytes& good, Before&& before) {
    std::size_t refused = 0;
    for (std::size_t at = 0; at < good.size(); ++at)
        for (std::size_t i = 0; i < flips_a_byte(); ++i) {
            const std::size_t bit = (at + i) % 8; // if one bit is tried, each byte tries a different one
            AssetBytes bytes = good;
            bytes[at] ^= static_cast<std::byte>(1 << bit);
            before(bytes);
            refused += refusal(bytes).starts_with("asset: ") ? 1u : 0u;
        }
    return refused;
}

void put_u32(AssetBytes& bytes, std::size_t at, std::uint32_t value) {
    base::store_little_endian(value, bytes.data() + at);
}
std::uint32_t u32_at(const AssetBytes& bytes, std::size_t at) {
    return base::load_little_endian<std::uint32_t>(bytes.data() + at);
}

constexpr std::size_t payload = shapes::asset_header_size;

struct Lie {
    const char* sample;
    std::function<void(AssetBytes&)> tell;
    const char* answer;
};

// Long: one row per lie.
const std::vector<Lie>& lies() {
    // The positions are those of src/shapes/ASSET.md.
    static const std::vector<Lie> all = {
        {"hull cube", [](AssetBytes& b) { put_u32(b, 8, 2); },
         "version is 2.0, this library reads 1.0 and 1.1 (at byte 8)"},
        {"hull cube", [](AssetBytes& b) { put_u32(b, 8, 0x20001); }, "version is 1.2"},
        {"hull cube", [](AssetBytes& b) { put_u32(b, 8, 0x10001); },
         "minor version is 1, what it holds is of 0 (at byte 10)"},
        {"moved mesh", [](AssetBytes& b) { put_u32(b, 8, 1); }, "minor version is 0, what it holds is of 1"},
        {"moved mesh", [](AssetBytes& b) { put_u32(b, payload + 108, 0), put_u32(b, payload + 112, 1); },
         "all triangles are their own source"},
        {"moved mesh", [](AssetBytes& b) { put_u32(b, payload + 112, 1 << 24); }, "triangle 1 was 16777216"},
        {"moved mesh", [](AssetBytes& b) { put_u32(b, payload + 116, 0); },
         "0 surfaces, there must be 1 .. 256"},
        {"moved mesh", [](AssetBytes& b) { put_u32(b, payload + 116, 3); }, "material needs 4 bytes"},
        {"moved mesh", [](AssetBytes& b) { put_u32(b, payload + 120, 2); }, "surface 1 is of material 2"},
        {"moved mesh", [](AssetBytes& b) { put_u32(b, payload + 128, 5); }, "surface 0: friction"},
        {"height field with surfaces", [](AssetBytes& b) { put_u32(b, 8, 1); }, "minor version is 0"},
        {"height field with surfaces", [](AssetBytes& b) { put_u32(b, payload + 16, 1); },
         "ends here, but 108 bytes follow"},
        {"hull cube", [](AssetBytes& b) { put_u32(b, 12, 4); }, "kind is 4, it must be 5 (hull)"},
        {"hull cube", [](AssetBytes& b) { put_u32(b, 12, 9); }, "kind is 9"},
        {"hull cube", [](AssetBytes& b) { put_u32(b, 16, 1); }, "reserved is 1"},
        {"hull cube", [](AssetBytes& b) { b[0] = std::byte{0}; }, "this is not an asset"},
        // A hull is stored as its corners, so bytes cannot describe an open or concave one, only points that are no
        // corners.
        {"hull cube", [](AssetBytes& b) { put_u32(b, payload, 7); }, "ends here, but 12 bytes follow"},
        {"hull cube", [](AssetBytes& b) { put_u32(b, payload, 9); }, "corner x needs 4 bytes, only 0 remain"},
        {"hull cube", [](AssetBytes& b) { put_u32(b, payload, 0xffffffff); }, "a hull of 4294967295 corners"},
        {"hull cube", [](AssetBytes& b) { put_u32(b, payload, 3); },
         "a hull of 3 corners, it must have 4 .. 255"},
        {"hull cube",
         [](AssetBytes& b) {
             for (std::size_t k = 0; k < 3; ++k) put_u32(b, payload + 4 + 4 * k, 0);
         },
         "point 0 is not a corner of the hull, or out of order (at byte 24)"},
        {"hull cube", [](AssetBytes& b) { std::swap_ranges(b.begin() + 24, b.begin() + 36, b.begin() + 36); },
         "point 0 is not a corner"},
        {"hull cube", [](AssetBytes& b) { std::copy_n(b.begin() + 24, 12, b.begin() + 36); },
         "is not a corner"},
        {"hull cube",
         [](AssetBytes& b) {
             for (std::size_t i = 0; i < 8; ++i) put_u32(b, payload + 4 + 12 * i, 5);
         },
         "in one plane"},
        {"hull cube",
         [](AssetBytes& b) {
             for (std::size_t i = 0; i < 8; ++i) put_u32(b, payload + 12 + 12 * i, i % 2 == 0 ? 0 : 999);
         },
         "um thick"},
        {"hull cube", [](AssetBytes& b) { put_u32(b, payload + 4, 0x80000000); }, "further than 100 m"},
        {"mesh", [](AssetBytes& b) { put_u32(b, payload, 16); }, "flags are 0x10"},
        {"mesh", [](AssetBytes& b) { put_u32(b, payload, 0); }, "need 128 bytes, 136 follow"},
        {"mesh", [](AssetBytes& b) { put_u32(b, payload + 4, 0x40000001); }, "flat sine is not in 0 .. 1"},
        {"mesh", [](AssetBytes& b) { put_u32(b, payload + 8, 0xffffffff); },
         "4294967295 vertices and 4 triangles need 68719476776 bytes"},
        {"mesh", [](AssetBytes& b) { put_u32(b, payload + 12, 0xffffffff); },
         "a mesh of 4294967295 triangles"},
        {"mesh", [](AssetBytes& b) { put_u32(b, payload + 12, 0); }, "a mesh of 0 triangles"},
        {"mesh", [](AssetBytes& b) { put_u32(b, payload + 16, 0x80000000); },
         "vertex 0 is out of range (at byte 36)"},
        {"mesh", [](AssetBytes& b) { b[payload + 16 + 15] = std::byte{1}; }, "vertex 0 is out of range"},
        {"mesh", [](AssetBytes& b) { b[payload + 16 + 12] = std::byte{100}; }, "vertex 0 is out of range"},
        {"mesh", [](AssetBytes& b) { put_u32(b, payload + 96, 1); },
         "triangle 0 names vertex 1, the next new one is 0 of 5 (at byte 116)"},
        {"mesh", [](AssetBytes& b) { put_u32(b, payload + 136, 0x7fffffff); }, "names vertex 2147483647"},
        {"mesh",
         [](AssetBytes& b) {
             put_u32(b, payload + 100, 0);
             put_u32(b, payload + 104, 1);
         },
         "triangle 0 has no area"},
        {"mesh",
         [](AssetBytes& b) {
             for (std::size_t k = 0; k < 3; ++k)
                 put_u32(b, payload + 96 + 36 + 4 * k, u32_at(b, payload + 96 + 4 * k));
         },
         "vertex 4 of 5 is not used"},
        {"mesh",
         [](AssetBytes& b) {
             for (std::size_t k = 0; k < 8; ++k) b[b.size() - 9 - k] = std::byte{0};
         },
         "all materials are 0"},
        {"height field", [](AssetBytes& b) { put_u32(b, payload, 1); }, "has 1 columns"},
        {"height field", [](AssetBytes& b) { put_u32(b, payload, 8193); },
         "has 8193 columns, it must have 2 .. 8192"},
        {"height field", [](AssetBytes& b) { put_u32(b, payload + 4, 0); }, "has 0 rows"},
        {"height field", [](AssetBytes& b) { put_u32(b, payload + 4, 4); },
         "heights needs 64 bytes, only 48 remain"},
        {"height field", [](AssetBytes& b) { put_u32(b, payload + 4, 2); }, "ends here, but 16 bytes follow"},
        {"height field", [](AssetBytes& b) { put_u32(b, payload + 8, 0); },
         "spacing must be at least 2.5 mm"},
        {"height field", [](AssetBytes& b) { put_u32(b, payload + 12, 0xffffffff); },
         "flat_sine must be in 0 .. 1"},
        {"height field", [](AssetBytes& b) { put_u32(b, payload + 16, 1); },
         "cells needs 6 bytes, only 0 remain"},
        {"height field", [](AssetBytes& b) { put_u32(b, payload + 16, 4); }, "flags are 4"},
        {"height field", [](AssetBytes& b) { put_u32(b, payload + 24, 0x7fffffff); },
         "height 1 is not in -100 m .. 100 m (at byte 44)"},
        {"height field with holes",
         [](AssetBytes& b) {
             for (std::size_t k = 0; k < 6; ++k) b[b.size() - 9 - k] = std::byte{0};
         },
         "all cells are 0"},
        {"compound", [](AssetBytes& b) { put_u32(b, payload, 0); }, "a compound of 0 parts"},
        {"compound", [](AssetBytes& b) { put_u32(b, payload, 65537); }, "a compound of 65537 parts"},
        {"compound", [](AssetBytes& b) { put_u32(b, payload, 65536); },
         "65536 parts need 5242880 bytes, 240 remain"},
        {"compound", [](AssetBytes& b) { put_u32(b, payload + 4, 8); },
         "part 0: it is a mesh, it must be convex (at byte 24)"},
        {"compound", [](AssetBytes& b) { put_u32(b, payload + 4, 77); },
         "part 0: its kind is 77, there is none of that number"},
        {"compound", [](AssetBytes& b) { put_u32(b, payload + 8, 0); }, "part 0: sphere radius is 0 m"},
        {"compound", [](AssetBytes& b) { put_u32(b, payload + 24, 7); }, "part 0: sphere scale is"},
        {"compound", [](AssetBytes& b) { put_u32(b, payload + 36, 1); }, "part 0: sphere names an asset"},
        {"compound", [](AssetBytes& b) { put_u32(b, payload + 48, 0x7fffffff); },
         "part 0: it is further than 100 m"},
        {"compound", [](AssetBytes& b) { put_u32(b, payload + 80, 1); },
         "part 0: its rotation is not a unit quaternion"},
        {"compound", [](AssetBytes& b) { b[payload + 4 + 160 + 32] ^= std::byte{1}; },
         "part 2: there is no hull 0x"},
        {"compound", [](AssetBytes& b) { put_u32(b, payload + 4 + 160 + 20, 1 << 25); },
         "part 2: a hull's scale must be 1"},
    };
    return all;
}

std::vector<fuzz::Sample> all_samples() {
    std::vector<fuzz::Sample> all = fuzz::samples();
    for (const fuzz::Sample& s : fuzz::newer_samples()) all.push_back(s);
    return all;
}

AssetBytes sample(const std::string& name) {
    for (fuzz::Sample& s : all_samples())
        if (s.name == name) return s.bytes;
    FAIL("no sample ", name);
    return {};
}

} // namespace

TEST_CASE("the asset library rejects an asset with any flipped bit") {
    for (const fuzz::Sample& s : all_samples()) {
        REQUIRE(refusal(s.bytes) == "");
        CHECK_MESSAGE(flips_refused(s.bytes, [](AssetBytes&) {}) == s.bytes.size() * flips_a_byte(), s.name);
        // Planted: with a valid checksum a flip of an unimportant bit passes.
        CHECK(flips_refused(s.bytes, [](AssetBytes& b) { fuzz::seal(b); }) < s.bytes.size() * flips_a_byte());
    }
}

TEST_CASE("the asset library rejects truncated and lengthened assets with an old or a new checksum") {
    for (const fuzz::Sample& s : all_samples())
        for (std::size_t size = 0; size < s.bytes.size() + 9; ++size) {
            AssetBytes bytes = s.bytes;
            bytes.resize(size);
            if (size != s.bytes.size()) REQUIRE(refusal(bytes).starts_with("asset: "));
            fuzz::seal(bytes);
            REQUIRE(refusal(bytes).starts_with("asset: ") == (size != s.bytes.size()));
        }
}

TEST_CASE("the asset library rejects false values under a valid checksum with the place and the reason") {
    for (const Lie& lie : lies()) {
        AssetBytes bytes = sample(lie.sample);
        lie.tell(bytes);
        fuzz::seal(bytes);
        const std::string why = refusal(bytes);
        INFO(join(lie.sample, ": expected '", lie.answer, "', got '", why, "'"));
        CHECK(mentions(why, lie.answer));
        CHECK(why.starts_with("asset: "));
    }
    // Planted: the edit writes the value that the sample has.
    AssetBytes same = sample("mesh");
    put_u32(same, payload + 8, 5);
    fuzz::seal(same);
    CHECK(refusal(same) == "");
}

TEST_CASE("the asset library rejects a compound without its hull and accepts it after the hull is added") {
    AssetLibrary library;
    const AssetBytes compound = fuzz::sample_compound();
    CHECK(mentions(library.add(std::span<const std::byte>(compound)).error().message,
                   "part 2: there is no hull 0x"));
    const AssetLibrary other = fuzz::library_with_hull();
    REQUIRE(library.add(other.bytes(other.ids().front())).ok());
    CHECK(library.add(std::span<const std::byte>(compound)).ok());
}

TEST_CASE("the asset functions reject bad definitions with the place and the reason") {
    std::vector<Vec3> vertices = {
        {Real{}, Real{}, Real{}}, {Real(1), Real{}, Real{}}, {Real{}, Real(1), Real{}}};
    std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}};
    std::vector<std::uint16_t> materials = {1, 2};
    MeshDef def{.vertices = vertices, .triangles = triangles, .materials = materials};
    CHECK(bake_mesh(def).error().message == "mesh has 2 materials for 1 triangles");
    def.materials = {};
    triangles[0][2] = 3;
    CHECK(bake_mesh(def).error().message == "mesh triangle 0 names vertex 3, there are 3");
    triangles[0][2] = 1;
    CHECK(bake_mesh(def).error().message == "mesh has no triangle with an area, of 1");
    vertices[1].z = Real(-8001);
    CHECK(bake_mesh(def).error().message == "mesh vertex 1 is further than 8000 m from the origin");
    CHECK(mentions(bake_compound({}).error().message, "a compound of 0 parts"));
    const CompoundPart bad{plane(), Transform::identity()};
    CHECK(mentions(bake_compound(std::span(&bad, 1)).error().message, "part 0: it is a plane"));
    const std::vector<Length> heights(6);
    HeightFieldDef field{.columns = 3, .rows = 3, .spacing = Length(1), .heights = heights};
    CHECK(bake_height_field(field).error().message == "height field has 6 heights for 9 samples");
    const std::vector<std::uint8_t> cells(3);
    field.rows = 2;
    field.cells = cells;
    CHECK(bake_height_field(field).error().message == "height field lists 3 cells of 2");
}
