// Reads a file of assets that `lockstone cook` has written.
//
//   AssetLibrary library;
//   Result<AssetId> chair = load_assets("chair.lsa", library);
//   Result<Geometry> geometry = library.geometry(*chair);
#pragma once

#include "lockstone/asset.h"

#include <string>

namespace lockstone {

/// Adds all assets of the file to the library and returns the id of the last one. On an error, which names the file,
/// the library is unchanged.
Result<AssetId> load_assets(const std::string& path, AssetLibrary& library);

} // namespace lockstone
