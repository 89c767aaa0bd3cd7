// Reads PLY files with triangle strips, which laser scans use: assimp reads only one triangle of each strip.
#pragma once

#include "cook/soup.h"
#include "lockstone/result.h"

#include <istream>
#include <optional>

namespace lockstone::cook {

/// The vertices and the triangles of all strips. A negative index ends a strip; the next index begins another one.
/// Empty if the file is no PLY file or its header names no strips.
std::optional<Result<Soup>> read_ply_strips(std::istream& in);

} // namespace lockstone::cook
