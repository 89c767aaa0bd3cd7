// Makes assets from the triangles of a model. Each asset is quantised once, baked, loaded again, and compared with the
// model.
#pragma once

#include "cook/soup.h"
#include "lockstone/asset.h"

#include <optional>
#include <vector>

namespace lockstone::cook {

enum class Wanted { hull, convex, mesh, height_field };

struct CookOptions {
    Wanted as = Wanted::hull;
    double scale = 1;                  ///< metres per unit of the model
    std::optional<double> deviation{}; ///< allowed [m]; empty: the shares below
    std::uint32_t parts_max = 32;      ///< of a convex decomposition, 1..compound_parts_max
    /// Corners of each hull, 4..hull_vertices_max; empty: 64, and a single hull takes more if the allowed deviation
    /// needs them.
    std::optional<std::uint32_t> corners_max{};
    bool two_sided = false; ///< mesh: triangles collide on both sides
    bool flip = false;      ///< reverses the triangles
    /// mesh, height field: contacts ignore edges with a smaller angle than this [degrees, 0..90]
    std::optional<double> flat{};
    /// Height field: distance between samples [m]; empty: as large as the deviation allows.
    std::optional<double> spacing{};
    std::size_t samples = 5'000; ///< points between the vertices that the deviation check samples
    bool z_up = false;           ///< the model's z axis points up, not its y axis
};

/// Deviations if none is given, as shares of the model's largest extent: the aim of cooking, and the largest that is
/// still good for hulls and convex parts.
inline constexpr double deviation_share_aimed = 0.01, deviation_share_max = 0.2;

struct Cooked {
    /// Each asset follows those that it refers to; the last one is the result.
    std::vector<AssetBytes> assets;
    AssetId id; ///< of the last asset
    ShapeKind kind = ShapeKind::hull;
    std::size_t source_vertices = 0, source_triangles = 0;
    std::size_t vertices = 0, triangles = 0, parts = 0; ///< parts: hulls
    /// Parts that were too thin to be hulls. The deviation includes the effect of their absence.
    std::size_t parts_dropped = 0;
    double deviation = 0, deviation_aimed = 0, deviation_max = 0; ///< measured, aimed for, allowed [m]
    double gap = 0;     ///< hull: how far it extends beyond a concave model [m]
    Point origin;       ///< height field: the first sample in the model's axes [m]
    double spacing = 0; ///< height field [m]
    double volume = 0;  ///< hulls: the sum of their volumes [m^3]
    /// Problems of the model or the asset; each sentence names the flag that helps.
    std::vector<std::string> notes;

    bool good() const { return deviation <= deviation_max; }
    std::size_t bytes() const;
};

/// Makes an asset. The deviation is measured on the bytes after AssetLibrary has loaded and checked them: for a hull
/// against the model's own convex hull, for the other kinds against the model. Errors concern the model and give the
/// reason.
Result<Cooked> cook(const Soup& model, const CookOptions& options);

} // namespace lockstone::cook
