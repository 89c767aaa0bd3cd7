// The corpus of the cook fuzzer and thousands of mutations of it, equal in every run: each is refused with an error
// sentence or becomes assets that load.
#include "support/effort.h"

#include "cook/import.h"
#include "cook/read/read_model.h"
#include "fuzz/cook_input.h"
#include "lockstone/math/random.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

using namespace lockstone;

namespace {

using Data = std::vector<std::uint8_t>;

/// Sorted by name, because the order of a directory is undefined.
std::vector<Data> corpus(const char* of = "cook") {
    std::vector<std::filesystem::path> paths;
    for (const auto& entry :
         std::filesystem::directory_iterator(std::string(LOCKSTONE_SOURCE_DIR "/tests/fuzz/corpus/") + of))
        paths.push_back(entry.path());
    std::sort(paths.begin(), paths.end());
    std::vector<Data> all;
    for (const auto& path : paths) {
        std::ifstream file(path, std::ios::binary);
        all.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    }
    return all;
}

std::size_t pick(Random& random, std::size_t count) {
    return static_cast<std::size_t>(random.range(0, static_cast<std::int32_t>(count) - 1));
}

/// A few bytes changed, removed, duplicated, or copied from another input.
Data mutated(Data data, const std::vector<Data>& all, Random& random) {
    for (std::int32_t changes = random.range(1, 4); changes > 0 && !data.empty(); --changes) {
        const std::size_t at = pick(random, data.size());
        const auto place = data.begin() + static_cast<std::ptrdiff_t>(at);
        switch (random.range(0, 5)) {
        case 0:
            data[at] = static_cast<std::uint8_t>(random.next_u32());
            break;
        case 1:
            data[at] ^= static_cast<std::uint8_t>(1u << random.range(0, 7));
            break;
        case 2:
            data.erase(place);
            break;
        case 3:
            data.insert(place, data[at]);
            break;
        case 4:
            data.resize(at);
            break;
        default: {
            const Data& other = all[pick(random, all.size())];
            for (std::size_t i = at; i < std::min({data.size(), other.size(), at + 12}); ++i)
                data[i] = other[i];
        }
        }
    }
    return data;
}

} // namespace

TEST_CASE("the cooker returns an error sentence or assets that load for corpus models and their mutations") {
    const std::vector<Data> all = corpus();
    REQUIRE(all.size() > 20);
    for (const Data& data : all) CHECK(fuzz::check_cook(data) == "");
    Random random = Random::seeded(2026);
    const int runs = test::is_long_run() ? 40'000 : test::tries(1'000);
    int good = 0;
    for (int run = 0; run < runs; ++run) {
        const Data data = mutated(all[pick(random, all.size())], all, random);
        const std::string wrong = fuzz::check_cook(data);
        if (!wrong.empty()) FAIL_CHECK("run ", run, ": ", wrong);
        const fuzz::CookInput input = fuzz::read_cook_input(data);
        good += input.model.triangles.size() > 4 ? 1 : 0;
    }
    CHECK(good > runs / 3); // mutations leave enough valid models
}

TEST_CASE("the seed files of the import fuzzer are valid models and read alike from memory and from files") {
    const std::vector<Data> all = corpus("cook_import");
    CHECK(all.size() >= 9);
    const std::filesystem::path folder = std::filesystem::temp_directory_path();
    for (const Data& data : all) {
        const std::string extension = fuzz::import_extensions[data[0] % fuzz::import_extensions.size()];
        const auto bytes = std::as_bytes(std::span(data)).subspan(1);
        const Result<cook::Soup> model = cook::read_model(bytes, extension);
        INFO(extension, ": ", model.ok() ? "" : model.error().message);
        REQUIRE(model.ok());
        CHECK(cook::welded(*model).triangles.size() >= 4);
        const std::filesystem::path path = folder / ("lockstone-corpus." + extension);
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        const Result<cook::Soup> again = cook::import_model(path.string());
        std::filesystem::remove(path);
        REQUIRE(again.ok());
        CHECK(again->vertices == model->vertices);
        CHECK(again->triangles == model->triangles);
    }
}

TEST_CASE("planted: the corpus check finds an asset that does not load") {
    // The check of check_cook, on a set whose last asset is damaged.
    const fuzz::CookInput input = fuzz::read_cook_input(corpus().front());
    Result<cook::Cooked> made = cook::cook(input.model, {});
    REQUIRE(made.ok());
    made->assets.back().back() ^= std::byte{1};
    AssetLibrary library;
    CHECK_FALSE(library.add(encode_assets(made->assets)).ok());
}
