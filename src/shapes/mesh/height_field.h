// A grid of heights. It computes triangles on request and stores none.
#pragma once

#include "base/bytes.h"
#include "shapes/mesh/face.h"

#include <bit>
#include <cstring>

namespace lockstone::shapes {

struct HeightGrid {
    std::uint32_t columns, rows; ///< samples
    Length spacing;
    Unit flat_sine;
};

/// Cell (column, row) has the triangles 2 i and 2 i + 1 with i = row * (columns - 1) + column, on the two sides
/// of the diagonal from its first to its last sample. Triangle 2 i has the edge at the smaller x.
class HeightField {
  public:
    /// `heights` and `cells` (empty: no cells) are parts of the asset's bytes, which must outlive this object.
    HeightField(const HeightGrid& size, std::span<const std::byte> heights, std::span<const std::byte> cells,
                std::vector<MaterialSurface> surfaces);
    const HeightGrid& size() const { return grid; }
    std::span<const std::byte> cell_bytes() const { return cells; }
    std::uint32_t triangle_count() const; ///< two for each cell, cells with holes included
    Face face(std::uint32_t index, LengthVec3 scale) const;
    FaceEdges edges(const Face& face, LengthVec3 scale) const; ///< for a result of face() at the same scale
    void find(const Extent& where, LengthVec3 scale,
              std::vector<std::uint32_t>& out) const; ///< skips holes
    Extent extent() const { return bounds; }          ///< at scale 1
    bool is_hole(std::uint32_t index) const;          ///< of the triangle's cell
    std::uint32_t material_of(std::uint32_t index) const {
        return cells.empty() ? 0 : static_cast<std::uint32_t>(cells[index / 2]);
    }
    std::span<const MaterialSurface> surfaces() const { return surface_list; }
    std::uint32_t sample_count() const { return grid.columns * grid.rows; }
    CoordinateVec3 sample(std::uint32_t index) const;                      ///< row by row, at scale 1
    std::array<std::uint32_t, 3> samples_of(std::uint32_t triangle) const; ///< its corners

    static constexpr std::uint8_t hole = 255;

  private:
    struct Range {
        std::int32_t lower, upper;
    };
    /// A triangle by its cell. Half 0 has the edge at the smaller x.
    struct Place {
        std::uint32_t column, row, half;
    };
    struct Slope {
        std::int64_t x, z; ///< rise from column to column and from row to row, raw Length
    };
    struct Corners {
        CoordinateVec3 at[3];
    };
    std::int32_t height_at(std::size_t index) const {
        const std::byte* at = heights.data() + 4 * index;
        if constexpr (std::endian::native == std::endian::little) { // one load instead of four
            std::int32_t raw = 0;
            std::memcpy(&raw, at, sizeof raw);
            return raw;
        }
        return static_cast<std::int32_t>(base::load_little_endian<std::uint32_t>(at));
    }
    std::int32_t height(std::uint32_t column, std::uint32_t row) const {
        return height_at(std::size_t{row} * grid.columns + column);
    }
    Place place_of(std::uint32_t triangle) const;
    std::array<std::uint32_t, 3> samples_of(const Place& place) const;
    CoordinateVec3 point(std::uint32_t column, std::uint32_t row) const;
    Corners corners_of(const Place& place) const;
    Slope slope_of(const Place& place) const;
    UnitVec3 normal_of(const Place& place, const Slope& slope, LengthVec3 scale) const;
    /// Moves to the triangle across edge k. Returns false at the border and beside holes.
    bool cross_edge(Place& place, std::uint32_t k) const;
    /// True when the triangle across edge k, which must exist, is below this one's plane.
    bool is_convex(const Place& place, const Slope& slope, std::uint32_t k) const;
    void find_tiles();
    static constexpr std::uint32_t tile = 16; ///< cells along each side of a tile

    HeightGrid grid;
    std::span<const std::byte> heights, cells;
    Extent bounds;
    std::vector<MaterialSurface> surface_list;
    std::vector<Range> tiles; ///< height ranges of tile x tile cells, row by row
    std::uint32_t tile_columns = 0;
};

} // namespace lockstone::shapes
