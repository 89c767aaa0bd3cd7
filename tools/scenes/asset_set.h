// Assets in files. A file holds one asset, byte by byte as it was baked; or a set of them in which each stands after
// those that it names, so that the last is what the file is about (a compound after its hulls).
//
//   AssetLibrary library;
//   Result<AssetId> chair = load_assets("chair.lsa", library);
//   Result<Geometry> geometry = library.geometry(*chair);
//
// A set: magic 89 4c 53 53 0d 0a 1a 0a; the number of assets, 4 bytes; then each with its size before it, 8 bytes. All
// little-endian. Assets carry their own checksums, and the library proves each.
#pragma once

#include "lockstone/asset.h"

#include <string>

namespace lockstone {

inline constexpr std::uint32_t asset_set_max = compound_parts_max + 1;

/// One asset as it is, several as a set; none gives no bytes.
AssetBytes encode_assets(std::span<const AssetBytes> assets);

/// Adds all and returns the id of the last. On error some may have been added.
Result<AssetId> decode_assets(std::span<const std::byte> bytes, AssetLibrary& library);

/// The same for a file. The error names it.
Result<AssetId> load_assets(const std::string& path, AssetLibrary& library);

} // namespace lockstone
