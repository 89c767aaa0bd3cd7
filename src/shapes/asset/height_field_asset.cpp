// Reads and writes the bytes of a height field. The heights stay in the asset's bytes.
#include "shapes/asset/asset_file.h"
#include "shapes/mesh/height_field.h"
#include "shapes/mesh/surfaces.h"

#include <algorithm>

namespace lockstone {
namespace shapes {
namespace {

using base::join;

/// Returns the error in the sizes, or an empty string.
std::string complaint(const HeightGrid& g) {
    for (const auto& [name, count] : {std::pair("columns", g.columns), std::pair("rows", g.rows)})
        if (count < 2 || count > height_field_samples_max)
            return join("height field has ", count, " ", name, ", it must have 2 .. ",
                        height_field_samples_max);
    const std::int64_t reach = std::int64_t{std::max(g.columns, g.rows)} * g.spacing.raw;
    if (g.spacing < shape_size_min || reach > std::int64_t{8000} << Length::fraction_bits)
        return "height field spacing must be at least 2.5 mm, and spacing times the greater number of "
               "samples at most 8000 m";
    if (g.flat_sine < Unit{} || g.flat_sine > unit_one) return "height field flat_sine must be in 0 .. 1";
    return {};
}

constexpr std::uint32_t field_cells = 1, field_surfaces = 2;

constexpr bool is_height(Length h) { return h >= -shape_size_max && h <= shape_size_max; }

} // namespace

void write_height_field(base::ByteWriter& out, const HeightFieldDef& def) {
    const bool any_cell = std::ranges::any_of(def.cells, [](std::uint8_t c) { return c != 0; });
    out.u32(def.columns);
    out.u32(def.rows);
    out.i32(def.spacing.raw);
    out.i32(def.flat_sine.raw);
    out.u32((any_cell ? field_cells : 0) | (def.surfaces.empty() ? 0 : field_surfaces));
    for (Length h : def.heights) out.i32(h.raw);
    if (any_cell) out.bytes(std::as_bytes(def.cells));
    if (!def.surfaces.empty()) write_surfaces(out, def.surfaces);
}

std::unique_ptr<const HeightField> read_height_field(base::ByteReader& in) {
    const std::size_t start = in.offset();
    HeightGrid grid{};
    grid.columns = in.u32("columns");
    grid.rows = in.u32("rows");
    grid.spacing = Length::from_raw(in.i32("spacing"));
    grid.flat_sine = Unit::from_raw(in.i32("flat sine"));
    const std::uint32_t flags = in.u32("flags"), has_cells = flags & field_cells;
    if (in.ok() && flags > 3)
        in.fail_at(start + 16, join("flags are ", flags, ", only bits 0 and 1 may be set"));
    if (std::string why = complaint(grid); in.ok() && !why.empty()) in.fail_at(start, why);
    if (!in.ok()) return nullptr;
    const std::uint64_t samples = std::uint64_t{grid.columns} * grid.rows;
    const std::uint64_t cell_count = has_cells != 0 ? std::uint64_t{grid.columns - 1} * (grid.rows - 1) : 0;
    const std::size_t heights_at = in.offset();
    const auto heights = in.bytes(samples * 4, "heights");
    const auto cells = in.bytes(cell_count, "cells");
    for (std::size_t at = 0; in.ok() && at < heights.size(); at += 4) {
        const auto raw =
            static_cast<std::int32_t>(base::load_little_endian<std::uint32_t>(heights.data() + at));
        if (!is_height(Length::from_raw(raw)))
            in.fail_at(heights_at + at, join("height ", at / 4, " is not in -100 m .. 100 m"));
    }
    if (in.ok() && has_cells != 0 &&
        std::ranges::all_of(cells, [](std::byte b) { return b == std::byte{0}; }))
        in.fail_at(start + 16, "all cells are 0, then none may be listed");
    std::vector<MaterialSurface> surfaces;
    if (in.ok() && (flags & field_surfaces) != 0) surfaces = read_surfaces(in);
    if (!in.ok()) return nullptr;
    return std::make_unique<const HeightField>(grid, heights, cells, std::move(surfaces));
}

} // namespace shapes

Result<AssetBytes> bake_height_field(const HeightFieldDef& def) {
    if (std::string why = shapes::complaint({def.columns, def.rows, def.spacing, def.flat_sine});
        !why.empty())
        return Error{std::move(why)};
    const std::size_t samples = std::size_t{def.columns} * def.rows;
    const std::size_t cells = std::size_t{def.columns - 1} * (def.rows - 1);
    if (def.heights.size() != samples)
        return Error{
            base::join("height field has ", def.heights.size(), " heights for ", samples, " samples")};
    if (!def.cells.empty() && def.cells.size() != cells)
        return Error{base::join("height field lists ", def.cells.size(), " cells of ", cells)};
    for (std::size_t i = 0; i < samples; ++i)
        if (!shapes::is_height(def.heights[i]))
            return Error{base::join("height field height ", i, " is not in -100 m .. 100 m")};
    if (std::string why = shapes::complaint_of_surfaces(def.surfaces); !why.empty())
        return Error{"height field: " + why};
    shapes::AssetWriter writer(ShapeKind::height_field, def.surfaces.empty() ? 0 : 1);
    shapes::write_height_field(writer.out(), def);
    return std::move(writer).finish();
}

} // namespace lockstone
