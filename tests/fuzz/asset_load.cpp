// Fuzz target: arbitrary bytes as an asset.
//
//   clang++ -std=c++20 -O1 -g -fsanitize=fuzzer,address,undefined -Iinclude -Isrc -Itests tests/fuzz/asset_load.cpp
//           src/base/*.cpp src/math/*.cpp src/shapes/*.cpp -lxxhash -o asset_load
//   ./asset_load -max_len=600 corpus tests/fuzz/corpus/asset
#include "fuzz/checks/asset_check.h"

#include <cstdio>
#include <cstdlib>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const lockstone::AssetLibrary library = fuzz::library_with_hull();
    const auto from = std::as_bytes(std::span(data, size));
    lockstone::AssetBytes bytes(from.begin(), from.end());
    fuzz::seal(bytes);
    bool loaded = false;
    const std::string complaint = fuzz::check(bytes, library, loaded);
    if (complaint.empty()) return 0;
    std::fprintf(stderr, "%s\n", complaint.c_str());
    std::abort();
}
