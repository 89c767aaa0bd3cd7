// The kept inputs of a fuzzer, its seeds, which are rewritten on request, and mutations of them.
#pragma once

#include "fuzz/edits.h"
#include "lockstone/math/random.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace fuzz {

/// Returns the files of tests/fuzz/corpus/FOLDER, sorted by name, because the order of a directory is undefined.
/// LOCKSTONE_WRITE_CORPUS=1 writes the seeds there first.
inline std::vector<Buffer> corpus(const std::string& folder, const std::vector<Seed>& seeds) {
    namespace fs = std::filesystem;
    const fs::path path = fs::path(LOCKSTONE_SOURCE_DIR) / "tests/fuzz/corpus" / folder;
    if (std::getenv("LOCKSTONE_WRITE_CORPUS") != nullptr) {
        fs::create_directories(path);
        for (const Seed& seed : seeds)
            std::ofstream(path / seed.name, std::ios::binary)
                .write(reinterpret_cast<const char*>(seed.bytes.data()),
                       static_cast<std::streamsize>(seed.bytes.size()));
    }
    std::vector<fs::path> files;
    for (const auto& entry : fs::directory_iterator(path)) files.push_back(entry.path());
    std::ranges::sort(files);
    std::vector<Buffer> all;
    for (const fs::path& file : files) {
        std::ifstream in(file, std::ios::binary);
        const std::string text{std::istreambuf_iterator<char>(in), {}};
        const auto bytes = std::as_bytes(std::span(text));
        all.emplace_back(bytes.begin(), bytes.end());
    }
    return all;
}

/// One of them with a few bytes changed, cut, duplicated or appended.
inline Buffer mutated(const std::vector<Buffer>& all, lockstone::Random& random) {
    Buffer bytes = all[random.below(static_cast<std::uint32_t>(all.size()))];
    for (std::uint32_t edits = 1 + random.below(4); edits > 0 && !bytes.empty(); --edits) {
        const std::size_t at = random.below(static_cast<std::uint32_t>(bytes.size()));
        switch (random.below(5)) {
        case 0:
            bytes[at] ^= static_cast<std::byte>(1u << random.below(8));
            break;
        case 1:
            bytes[at] = static_cast<std::byte>(random.below(256));
            break;
        case 2:
            bytes.resize(at + 1);
            break;
        case 3:
            bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(at), bytes[at]);
            break;
        default:
            for (std::uint32_t more = 1 + random.below(12); more > 0; --more)
                bytes.push_back(static_cast<std::byte>(random.below(256)));
        }
    }
    return bytes;
}

inline std::size_t rounds(std::size_t usual) {
    return std::getenv("LOCKSTONE_LONG") != nullptr ? 20 * usual : usual;
}

} // namespace fuzz
