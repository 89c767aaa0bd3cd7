// Models that crash or hang the importer: for each one in tests/fuzz/corpus/broken the importer returns a sentence with
// the file and the reason, within the given limits, and the calling process continues.
#include "cook/import.h"

#include <doctest/doctest.h>

#include <filesystem>
#include <fstream>

namespace {

using namespace lockstone;

const std::filesystem::path folder = std::filesystem::path(LOCKSTONE_SOURCE_DIR) / "tests/fuzz/corpus/broken";

/// Returns an empty string if the model was refused, by its name, because the importing process crashed or reached a
/// limit.
std::string uncontained(const std::filesystem::path& model, const cook::ImportLimits& limits) {
    const Result<cook::Soup> soup = cook::import_model(model.string(), limits);
    if (soup) return "was read";
    const std::string& message = soup.error().message;
    if (!message.starts_with(model.string() + ": the importer ")) return "refused otherwise: " + message;
    return {};
}

} // namespace

TEST_CASE("the importer returns an error sentence for a model that crashes or hangs it") {
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
        INFO(entry.path());
        CHECK(uncontained(entry.path(), {.seconds = 2}) == "");
        ++count;
    }
    CHECK(count >= 2); // one that hangs, one that crashes
}

TEST_CASE("planted: a model that is read or rejected for its content does not count as one that breaks the "
          "importer") {
    const std::string text =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n2 0 0\n2 1 0\n3 0 1 2\n";
    const std::filesystem::path path = std::filesystem::temp_directory_path() / "lockstone-mended.ply";
    std::ofstream(path, std::ios::binary) << text;
    CHECK(uncontained(path, {.seconds = 2}) == "was read");
    std::ofstream(path, std::ios::binary) << "ply\nformat nonsense\n";
    CHECK(uncontained(path, {.seconds = 2}).starts_with("refused otherwise: "));
    std::filesystem::remove(path);
}
