#include "scenes/asset_set.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <system_error>

namespace lockstone {
namespace {

constexpr std::array<unsigned char, 8> magic{0x89, 'L', 'S', 'S', 0x0d, 0x0a, 0x1a, 0x0a};
constexpr std::size_t count_size = 4, length_size = 8;

void put(AssetBytes& out, std::uint64_t value, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) out.push_back(static_cast<std::byte>(value >> (8 * i)));
}

/// Takes a number from the front; `bytes` has at least `size`.
std::uint64_t take(std::span<const std::byte>& bytes, std::size_t size) {
    std::uint64_t value = 0;
    for (std::size_t i = 0; i < size; ++i) value |= std::to_integer<std::uint64_t>(bytes[i]) << (8 * i);
    bytes = bytes.subspan(size);
    return value;
}

bool is_set(std::span<const std::byte> bytes) {
    return bytes.size() >= magic.size() &&
           std::ranges::equal(bytes.first(magic.size()), std::as_bytes(std::span(magic)));
}

Result<AssetId> decode_set(std::span<const std::byte> bytes, AssetLibrary& library) {
    bytes = bytes.subspan(magic.size());
    if (bytes.size() < count_size) return Error{"the asset set ends in its header"};
    const std::uint64_t count = take(bytes, count_size);
    if (count == 0 || count > asset_set_max)
        return Error{"the asset set holds " + std::to_string(count) + " assets, it must be 1 to " +
                     std::to_string(asset_set_max)};
    AssetId last;
    for (std::uint64_t i = 0; i < count; ++i) {
        const std::string name = "asset " + std::to_string(i) + " of " + std::to_string(count);
        const std::uint64_t length = bytes.size() < length_size ? UINT64_MAX : take(bytes, length_size);
        if (length > bytes.size()) return Error{name + " ends beyond the end of the set"};
        const Result<AssetId> id = library.add(bytes.first(static_cast<std::size_t>(length)));
        if (!id) return Error{name + ": " + id.error().message};
        last = *id;
        bytes = bytes.subspan(static_cast<std::size_t>(length));
    }
    if (!bytes.empty())
        return Error{"the asset set goes on for " + std::to_string(bytes.size()) + " bytes after its end"};
    return last;
}

} // namespace

AssetBytes encode_assets(std::span<const AssetBytes> assets) {
    if (assets.empty()) return {};
    if (assets.size() == 1) return assets.front();
    AssetBytes out;
    for (const unsigned char byte : magic) out.push_back(std::byte{byte});
    put(out, assets.size(), count_size);
    for (const AssetBytes& asset : assets) {
        put(out, asset.size(), length_size);
        out.insert(out.end(), asset.begin(), asset.end());
    }
    return out;
}

Result<AssetId> decode_assets(std::span<const std::byte> bytes, AssetLibrary& library) {
    return is_set(bytes) ? decode_set(bytes, library) : library.add(bytes);
}

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
    const Result<AssetId> id = decode_assets(bytes, library);
    return id ? id : Result<AssetId>(Error{path + ": " + id.error().message});
}

} // namespace lockstone
