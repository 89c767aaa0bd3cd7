// From a model's triangles to the bytes of assets: measured, quantised once, baked, loaded again, compared.
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
    std::optional<double> deviation{}; ///< allowed [m]; none: by the shares below
    std::uint32_t parts_max = 32;      ///< of a convex decomposition, 1..compound_parts_max
    /// Corners of each hull, 4..hull_vertices_max; none: 64, and a single hull takes more where the aim needs them.
    std::optional<std::uint32_t> corners_max{};
    bool two_sided = false; ///< mesh
    bool flip = false;      ///< triangles face the other way
    /// mesh, height field: edges flatter than this are not felt [degrees, 0..90]
    std::optional<double> flat{};
    /// Height field: between samples [m]; none: as coarse as the deviation allows
    std::optional<double> spacing{};
    std::size_t samples = 5'000; ///< points between vertices that the deviation check asks
    bool z_up = false;           ///< the model's z axis points up, not y
};

/// Where no deviation is given: what cooking aims for, and what is good still of hulls and of convex parts, as shares of the model's largest extent.
inline constexpr double deviation_share_aimed = 0.01, deviation_share_max = 0.2;

struct Cooked {
    std::vector<AssetBytes> assets; ///< each after those it names; the last is what was asked for
    AssetId id;                     ///< of the last
    ShapeKind kind = ShapeKind::hull;
    std::size_t source_vertices = 0, source_triangles = 0;
    std::size_t vertices = 0, triangles = 0, parts = 0; ///< parts: hulls
    std::size_t parts_dropped = 0; ///< too thin to be hulls; the deviation includes that they are missing
    double deviation = 0, deviation_aimed = 0, deviation_max = 0; ///< found, aimed for, allowed [m]
    double gap = 0;     ///< hull: how far it reaches beyond the model, where that is concave [m]
    Point origin;       ///< height field: where its first sample is in the model's axes [m]
    double spacing = 0; ///< height field [m]
    double volume = 0;  ///< hulls: the sum of theirs [m^3]
    /// Oddities of the model or the asset, a sentence each with the flag that helps.
    std::vector<std::string> notes;

    bool good() const { return deviation <= deviation_max; }
    std::size_t bytes() const;
};

/// The deviation is measured on the bytes after AssetLibrary has loaded and proved them. Of a hull it is that from the
/// model's own convex hull; of the others that from the model. Errors are about the model and name the reason.
Result<Cooked> cook(const Soup& model, const CookOptions& options);

} // namespace lockstone::cook
