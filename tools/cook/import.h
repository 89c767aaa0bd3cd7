// Models from files, read by assimp in a process of its own: a file that crashes the importer, or makes it ask for
// endless memory or time, ends as a sentence.
#pragma once

#include "cook/soup.h"
#include "lockstone/result.h"

namespace lockstone::cook {

inline constexpr std::uint64_t import_triangles_max = mesh_triangles_max;
inline constexpr std::uint64_t import_vertices_max = 3 * import_triangles_max;
inline constexpr double import_coordinate_max = 1e9; ///< in the file's unit, before --scale

/// What the importing process may take. A file that needs more is refused.
struct ImportLimits {
    std::uint32_t seconds = 120;
    std::uint64_t memory = std::uint64_t{4} << 30; ///< [bytes] of address space; not under sanitizers
};

/// All meshes of the file in one soup, in the file's own unit: glTF, OBJ, FBX, STL, PLY and what else assimp reads.
/// Lines and points are left out, polygons cut into triangles. The error names the file and the reason.
Result<Soup> import_model(const std::string& path, const ImportLimits& limits = {});

} // namespace lockstone::cook
