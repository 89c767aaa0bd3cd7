#include "shapes/mesh/height_field.h"

#include "lockstone/math/math.h"
#include "shapes/mesh/triangle.h"

#include <algorithm>

namespace lockstone::shapes {
namespace {

/// floor(n / d) and ceil(n / d) for d > 0.
std::int64_t floor_divide(std::int64_t n, std::int64_t d) { return n / d - (n % d < 0 ? 1 : 0); }
std::int64_t ceil_divide(std::int64_t n, std::int64_t d) { return n / d + (n % d > 0 ? 1 : 0); }

} // namespace

HeightField::HeightField(const HeightGrid& size, std::span<const std::byte> height_bytes,
                         std::span<const std::byte> cell_bytes, std::vector<MaterialSurface> surfaces)
    : grid(size), heights(height_bytes), cells(cell_bytes), surface_list(std::move(surfaces)) {
    find_tiles();
}

void HeightField::find_tiles() {
    tile_columns = (grid.columns - 1 + tile - 1) / tile;
    const std::uint32_t tile_rows = (grid.rows - 1 + tile - 1) / tile;
    tiles.reserve(std::size_t{tile_columns} * tile_rows);
    Range all{height(0, 0), height(0, 0)};
    for (std::uint32_t r = 0; r < tile_rows; ++r)
        for (std::uint32_t c = 0; c < tile_columns; ++c) {
            Range range{height(c * tile, r * tile), height(c * tile, r * tile)};
            for (std::uint32_t y = r * tile; y <= std::min(r * tile + tile, grid.rows - 1); ++y)
                for (std::uint32_t x = c * tile; x <= std::min(c * tile + tile, grid.columns - 1); ++x) {
                    range.lower = std::min(range.lower, height(x, y));
                    range.upper = std::max(range.upper, height(x, y));
                }
            tiles.push_back(range);
            all = {std::min(all.lower, range.lower), std::max(all.upper, range.upper)};
        }
    const auto side = [this](std::uint32_t samples) {
        return Coordinate::from_raw((std::int64_t{samples} - 1) * grid.spacing.raw);
    };
    bounds = {{Coordinate{}, Coordinate::from_raw(all.lower), Coordinate{}},
              {side(grid.columns), Coordinate::from_raw(all.upper), side(grid.rows)}};
}

std::uint32_t HeightField::triangle_count() const { return 2 * (grid.columns - 1) * (grid.rows - 1); }

bool HeightField::is_hole(std::uint32_t index) const {
    return !cells.empty() && cells[index / 2] == std::byte{hole};
}

CoordinateVec3 HeightField::point(std::uint32_t column, std::uint32_t row) const {
    return {Coordinate::from_raw(std::int64_t{column} * grid.spacing.raw),
            Coordinate::from_raw(height(column, row)),
            Coordinate::from_raw(std::int64_t{row} * grid.spacing.raw)};
}
CoordinateVec3 HeightField::sample(std::uint32_t index) const {
    return point(index % grid.columns, index / grid.columns);
}

HeightField::Place HeightField::place_of(std::uint32_t triangle) const {
    const std::uint32_t cell = triangle / 2, row = cell / (grid.columns - 1);
    return {cell - row * (grid.columns - 1), row, triangle % 2};
}
std::array<std::uint32_t, 3> HeightField::samples_of(const Place& place) const {
    const std::uint32_t first = place.row * grid.columns + place.column, last = first + grid.columns + 1;
    if (place.half == 0) return {first, last - 1, last};
    return {first, last, first + 1};
}
std::array<std::uint32_t, 3> HeightField::samples_of(std::uint32_t triangle) const {
    return samples_of(place_of(triangle));
}
HeightField::Corners HeightField::corners_of(const Place& place) const {
    const CoordinateVec3 first = point(place.column, place.row),
                         last = point(place.column + 1, place.row + 1);
    if (place.half == 0) return {{first, point(place.column, place.row + 1), last}};
    return {{first, last, point(place.column + 1, place.row)}};
}

bool HeightField::cross_edge(Place& place, std::uint32_t k) const {
    const bool to_lower = (place.half == 0 && k == 0) || (place.half == 1 && k == 2);
    const bool diagonal = k == (place.half == 0 ? 2u : 0u);
    if (!diagonal) {
        std::uint32_t& along = k == place.half ? place.column : place.row;
        const std::uint32_t cells_along = (&along == &place.column ? grid.columns : grid.rows) - 1;
        if (to_lower ? along == 0 : along + 1 == cells_along) return false;
        along += to_lower ? 0xffffffffu : 1u; // less or more by one
    }
    place.half ^= 1u;
    return cells.empty() ||
           cells[std::size_t{place.row} * (grid.columns - 1) + place.column] != std::byte{hole};
}

HeightField::Slope HeightField::slope_of(const Place& place) const {
    const auto [a, b, c] = samples_of(place);
    const std::int64_t first = height_at(a), second = height_at(b), third = height_at(c);
    if (place.half == 0) return {third - second, second - first};
    return {third - first, second - third};
}

UnitVec3 HeightField::normal_of(const Place& place, const Slope& slope, LengthVec3 scale) const {
    if (scale != scale_one) return triangle_normal(corners_of(place).at, scale);
    return normalized(
        Vec3{Real::from_raw(-slope.x), Real::from_raw(grid.spacing.raw), Real::from_raw(-slope.z)});
}

bool HeightField::is_convex(const Place& place, const Slope& slope, std::uint32_t k) const {
    // The neighbour's third sample, in columns and rows from the cell's first sample.
    constexpr std::int32_t columns[2][3] = {{-1, 1, 1}, {0, 2, 0}}, rows[2][3] = {{0, 2, 0}, {1, 1, -1}};
    const std::int32_t c = columns[place.half][k], r = rows[place.half][k];
    const std::int64_t first = std::int64_t{place.row} * grid.columns + place.column;
    const std::int64_t other = first + r * std::int64_t{grid.columns} + c;
    const std::int64_t rise =
        std::int64_t{height_at(static_cast<std::size_t>(other))} - height_at(static_cast<std::size_t>(first));
    return rise < slope.x * c + slope.z * r;
}

Face HeightField::face(std::uint32_t index, LengthVec3 scale) const {
    const Place own = place_of(index);
    const Corners corners = corners_of(own);
    Face out;
    for (int k = 0; k < 3; ++k)
        out.corner[k] = scale == scale_one ? corners.at[k] : scaled_by(corners.at[k], scale);
    out.normal = normal_of(own, slope_of(own), scale);
    out.index = index;
    return out;
}

FaceEdges HeightField::edges(const Face& face, LengthVec3 scale) const {
    const Place own = place_of(face.index);
    const Slope slope = slope_of(own);
    FaceEdges out;
    out.sharp = 0;
    for (std::uint32_t k = 0; k < 3; ++k) {
        Place other = own;
        const bool border = !cross_edge(other, k);
        out.beyond[k] = border ? -face.normal : normal_of(other, slope_of(other), scale);
        if (border || (is_convex(own, slope, k) && !is_flat(face.normal, out.beyond[k], grid.flat_sine)))
            out.sharp |= 1u << k;
    }
    return out;
}

void HeightField::find(const Extent& where, LengthVec3 scale, std::vector<std::uint32_t>& out) const {
    const Extent box = at_scale_one(where, scale);
    if (!overlap(bounds, box)) return;
    // Cell c covers c to c + 1 spacings, ends included.
    const auto first_cell = [this](Coordinate low) {
        return static_cast<std::uint32_t>(
            std::max<std::int64_t>(ceil_divide(low.raw, grid.spacing.raw) - 1, 0));
    };
    const auto last_cell = [this](Coordinate high, std::uint32_t samples) {
        return static_cast<std::uint32_t>(
            std::min<std::int64_t>(floor_divide(high.raw, grid.spacing.raw), samples - 2));
    };
    const std::uint32_t c0 = first_cell(box.lower.x), c1 = last_cell(box.upper.x, grid.columns);
    const std::uint32_t r0 = first_cell(box.lower.z), r1 = last_cell(box.upper.z, grid.rows);
    const std::int64_t low = box.lower.y.raw, high = box.upper.y.raw;
    const auto touches = [&](std::int32_t a, std::int32_t b, std::int32_t c) {
        return std::max(a, std::max(b, c)) >= low && std::min(a, std::min(b, c)) <= high;
    };
    for (std::uint32_t r = r0; r <= r1; ++r)
        for (std::uint32_t c = c0; c <= c1; ++c) {
            const Range& around = tiles[std::size_t{r / tile} * tile_columns + c / tile];
            if (around.lower > high || around.upper < low) {
                c = c / tile * tile + tile - 1; // skip the rest of the tile in this row
                continue;
            }
            const std::uint32_t index = 2 * (r * (grid.columns - 1) + c);
            if (is_hole(index)) continue;
            const std::int32_t first = height(c, r), last = height(c + 1, r + 1);
            if (touches(first, height(c, r + 1), last)) out.push_back(index);
            if (touches(first, last, height(c + 1, r))) out.push_back(index + 1);
        }
}

} // namespace lockstone::shapes
