// PLY files that hold triangle strips, as those of laser scans do: assimp reads one triangle of each strip.
#pragma once

#include "cook/soup.h"
#include "lockstone/result.h"

#include <istream>
#include <optional>

namespace lockstone::cook {

/// The vertices and the triangles of all strips; a negative index ends a strip, and the next index begins another. Nothing where the file is no PLY
/// file or its header names no strips.
std::optional<Result<Soup>> read_ply_strips(std::istream& in);

} // namespace lockstone::cook
