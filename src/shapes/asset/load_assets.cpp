// Reads a file of assets into a library.
#include "lockstone/asset.h"

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace lockstone {

Result<AssetId> load_assets(const std::string& path, AssetLibrary& library) {
    std::error_code none;
    if (std::filesystem::is_directory(path, none)) return Error{path + ": is a directory, not an asset"};
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    AssetBytes bytes;
    std::array<char, 65536> chunk;
    while (file.read(chunk.data(), chunk.size()), file.gcount() > 0) {
        const auto read = std::as_bytes(std::span(chunk)).first(static_cast<std::size_t>(file.gcount()));
        bytes.insert(bytes.end(), read.begin(), read.end());
    }
    if (!file.is_open() || file.bad()) return Error{path + ": cannot read: " + std::strerror(errno)};
    const Result<AssetId> id = library.add(bytes);
    return id ? id : Result<AssetId>(Error{path + ": " + id.error().message});
}

} // namespace lockstone
