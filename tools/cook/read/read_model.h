// The body of the importing process: reads a model with assimp in this process. It may crash and use any amount of
// memory and time; import.h runs it in a separate, limited process.
#pragma once

#include "cook/soup.h"
#include "lockstone/result.h"

#include <span>

namespace lockstone::cook {

/// All meshes of a file in one soup; otherwise the reason of the failure.
Result<Soup> read_model(const std::string& path);

/// Reads a model from bytes; `extension` ("stl") selects the format if the bytes do not show it.
Result<Soup> read_model(std::span<const std::byte> bytes, const std::string& extension);

} // namespace lockstone::cook
