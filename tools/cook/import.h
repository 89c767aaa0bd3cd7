// Reads model files with assimp in a separate process. If a file crashes the importer, or makes it use too much memory
// or time, the result is an error sentence.
#pragma once

#include "cook/soup.h"
#include "lockstone/result.h"

namespace lockstone::cook {

inline constexpr std::uint64_t import_triangles_max = mesh_triangles_max;
inline constexpr std::uint64_t import_vertices_max = 3 * import_triangles_max;
inline constexpr double import_coordinate_max = 1e9; ///< in the unit of the file, before --scale

/// The limits of the importing process. A file that needs more is an error.
struct ImportLimits {
    std::uint32_t seconds = 120;
    /// [bytes] of address space; not limited in builds with sanitizers.
    std::uint64_t memory = std::uint64_t{4} << 30;
};

/// All meshes of the file in one soup, in the unit of the file. Formats: glTF, OBJ, FBX, STL, PLY and others of assimp.
/// Lines and points are left out; polygons are cut into triangles. The error names the file and the reason.
Result<Soup> import_model(const std::string& path, const ImportLimits& limits = {});

} // namespace lockstone::cook
