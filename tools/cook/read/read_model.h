// What the importing process does: assimp reads a model, here and now. It may crash, and take any memory and time;
// import.h is the way that may not.
#pragma once

#include "cook/soup.h"
#include "lockstone/result.h"

#include <span>

namespace lockstone::cook {

/// All meshes of a file in one soup, or the reason why there is none.
Result<Soup> read_model(const std::string& path);

/// The same from bytes; `extension` ("stl") tells the format where the bytes leave it open.
Result<Soup> read_model(std::span<const std::byte> bytes, const std::string& extension);

} // namespace lockstone::cook
