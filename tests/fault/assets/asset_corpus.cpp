// The fuzzer's kept inputs, and mutations of them: the library refuses bytes with an error sentence, or makes a valid
// asset of them.
#include "fuzz/asset_samples.h"
#include "fuzz/corpus.h"

#include <doctest/doctest.h>

using namespace lockstone;

TEST_CASE(
    "the asset corpus holds every sample and the library rejects each file or makes a valid asset of it") {
    const AssetLibrary library = fuzz::library_with_hull();
    const std::vector<AssetBytes> all = fuzz::corpus("asset", {});
    for (const fuzz::Sample& s : fuzz::samples())
        CHECK_MESSAGE(std::ranges::find(all, s.bytes) != all.end(), s.name);
    std::size_t accepted = 0;
    for (AssetBytes bytes : all) {
        fuzz::seal(bytes);
        bool loaded = false;
        REQUIRE(fuzz::check(bytes, library, loaded) == "");
        accepted += loaded ? 1 : 0;
    }
    CHECK(accepted >= fuzz::samples().size());
}

TEST_CASE("the asset library rejects each of ten thousand mutations or makes a valid asset of it") {
    const AssetLibrary library = fuzz::library_with_hull();
    const std::vector<AssetBytes> all = fuzz::corpus("asset", {});
    Random random = Random::seeded(2026);
    std::size_t accepted = 0;
    const std::size_t rounds = fuzz::rounds(10'000);
    for (std::size_t i = 0; i < rounds; ++i) {
        AssetBytes bytes = fuzz::mutated(all, random);
        fuzz::seal(bytes);
        bool loaded = false;
        const std::string complaint = fuzz::check(bytes, library, loaded);
        REQUIRE_MESSAGE(complaint == "", "mutation ", i, ": ", complaint);
        accepted += loaded ? 1 : 0;
    }
    CHECK(accepted > rounds / 100);
    CHECK(accepted < rounds);
}

TEST_CASE("planted: the check finds an asset whose bytes differ from its content") {
    const AssetLibrary library = fuzz::library_with_hull();
    for (const fuzz::Sample& s : fuzz::samples()) {
        auto asset = shapes::parse_asset(s.bytes, library);
        REQUIRE(asset.ok());
        CHECK(shapes::rebuilt(**asset) == s.bytes);
        AssetBytes other = s.bytes;
        other[other.size() - 9] ^= std::byte{1};
        CHECK(shapes::rebuilt(**asset) != other);
    }
}
