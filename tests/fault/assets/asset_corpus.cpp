// The fuzzer's findings again, and mutations of them: any bytes are refused with a sentence or make an asset that holds.
#include "fuzz/asset_samples.h"
#include "lockstone/math/random.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

using namespace lockstone;

namespace {

std::vector<AssetBytes> corpus() {
    std::vector<std::filesystem::path> paths;
    for (const auto& entry :
         std::filesystem::directory_iterator(std::string(LOCKSTONE_SOURCE_DIR) + "/tests/fuzz/corpus/asset"))
        paths.push_back(entry.path());
    std::ranges::sort(paths);
    std::vector<AssetBytes> all;
    for (const auto& path : paths) {
        std::ifstream file(path, std::ios::binary);
        const std::string text{std::istreambuf_iterator<char>(file), {}};
        const auto bytes = std::as_bytes(std::span(text));
        all.emplace_back(bytes.begin(), bytes.end());
    }
    return all;
}

/// One to four edits: a flipped bit, an interesting number, a block moved or doubled, a cut.
void mutate(AssetBytes& bytes, Random& random) {
    constexpr std::uint32_t numbers[] = {0, 1, 0xffffffff, 0x7fffffff, 0x80000000, 255, 256, 0x1000000, 4};
    for (std::uint32_t edits = 1 + random.below(4); edits > 0 && bytes.size() > 8; --edits) {
        const std::uint32_t size = static_cast<std::uint32_t>(bytes.size()), at = random.below(size - 4);
        const std::uint32_t other = random.below(size - 4);
        switch (random.below(5)) {
        case 0:
            bytes[at] ^= static_cast<std::byte>(1 << random.below(8));
            break;
        case 1:
            base::store_little_endian(numbers[random.below(9)], bytes.data() + at);
            break;
        case 2:
            std::copy_n(bytes.begin() + at, 4, bytes.begin() + other);
            break;
        case 3:
            bytes[at] = static_cast<std::byte>(random.below(256));
            break;
        default:
            bytes.resize(8 + random.below(2 * size));
        }
    }
}

} // namespace

TEST_CASE("the corpus holds every sample, and all of it is refused or holds") {
    const AssetLibrary library = fuzz::library_with_hull();
    const std::vector<AssetBytes> all = corpus();
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

TEST_CASE("ten thousand mutations are refused or hold") {
    const AssetLibrary library = fuzz::library_with_hull();
    const std::vector<AssetBytes> all = corpus();
    Random random = Random::seeded(2026);
    std::size_t accepted = 0;
    const int rounds = std::getenv("LOCKSTONE_LONG") != nullptr ? 200'000 : 10'000;
    for (int i = 0; i < rounds; ++i) {
        AssetBytes bytes = all[random.below(static_cast<std::uint32_t>(all.size()))];
        mutate(bytes, random);
        fuzz::seal(bytes);
        bool loaded = false;
        const std::string complaint = fuzz::check(bytes, library, loaded);
        REQUIRE_MESSAGE(complaint == "", "mutation ", i, ": ", complaint);
        accepted += loaded ? 1 : 0;
    }
    CHECK(accepted > static_cast<std::size_t>(rounds) / 100);
    CHECK(accepted < static_cast<std::size_t>(rounds));
}

TEST_CASE("planted: the check notices an asset whose bytes are not its content's") {
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
