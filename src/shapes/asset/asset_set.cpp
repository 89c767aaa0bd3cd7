// Several assets in one byte string. An asset comes after those that it refers to, so a compound comes last.
#include "shapes/asset/asset_file.h"

#include <algorithm>

namespace lockstone {
namespace {

using base::join;

// The magic of an asset with S in place of A.
constexpr std::array<std::uint8_t, 8> set_magic{0x89, 'L', 'S', 'S', 0x0d, 0x0a, 0x1a, 0x0a};

} // namespace

namespace shapes {

bool is_asset_set(std::span<const std::byte> bytes) {
    return bytes.size() >= set_magic.size() &&
           std::ranges::equal(bytes.first(set_magic.size()), std::as_bytes(std::span(set_magic)));
}

} // namespace shapes

AssetBytes encode_assets(std::span<const AssetBytes> assets) {
    if (assets.empty()) return {};
    if (assets.size() == 1) return assets.front();
    AssetBytes out;
    base::ByteWriter writer(out);
    writer.bytes(std::as_bytes(std::span(set_magic)));
    writer.u32(static_cast<std::uint32_t>(assets.size()));
    for (const AssetBytes& asset : assets) {
        writer.u64(asset.size());
        writer.bytes(asset);
    }
    return out;
}

Result<AssetId> AssetLibrary::add_set(std::span<const std::byte> bytes) {
    base::ByteReader in(bytes, "asset set");
    in.bytes(set_magic.size(), "magic");
    const std::uint32_t count = in.u32("count");
    if (in.ok() && (count == 0 || count > asset_set_max))
        in.fail_at(set_magic.size(), join("it holds ", count, " assets, it must be 1 to ", asset_set_max));
    std::vector<AssetId> added; // removed again if a later asset is invalid
    AssetId last;
    const auto refuse = [&](Error error) {
        for (const AssetId id : added) assets.erase(id);
        return error;
    };
    for (std::uint32_t i = 0; i < count && in.ok(); ++i) {
        const std::string name = join("asset ", i, " of ", count);
        const auto one = in.bytes(in.u64("length"), name);
        if (!in.ok()) break;
        const bool is_new = !contains(shapes::id_of(one));
        const Result<AssetId> id = add_one(one);
        if (!id) return refuse(Error{join("asset set: ", name, ": ", id.error().message)});
        if (is_new) added.push_back(*id);
        last = *id;
    }
    in.expect_end();
    if (!in.ok()) return refuse(in.error());
    return last;
}

} // namespace lockstone
