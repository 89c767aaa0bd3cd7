#include "cook/height_field.h"

#include "lockstone/math/convert.h"

namespace lockstone::cook {
namespace {

constexpr std::uint8_t hole = 255;

Result<std::uint32_t> samples_along(double size, double spacing) {
    const double cells = std::max(1.0, std::ceil(size / spacing - 1e-6));
    if (cells + 1 > height_field_samples_max)
        return Error{"a spacing of " + std::to_string(spacing) + " m needs " + std::to_string(cells + 1) +
                     " samples a side, the limit is " + std::to_string(height_field_samples_max)};
    return static_cast<std::uint32_t>(cells) + 1;
}

} // namespace

Result<Heights> sample_heights(const Soup& model, const Surface& surface, double spacing) {
    const Box box = bounds_of(model.vertices);
    const Length step = quantize<Length>(spacing);
    if (step <= Length{}) return Error{"a spacing of " + std::to_string(spacing) + " m is too small"};
    const Result<std::uint32_t> columns = samples_along(box.size().x, to_double(step));
    const Result<std::uint32_t> rows = samples_along(box.size().z, to_double(step));
    if (!columns) return columns.error();
    if (!rows) return rows.error();
    if (box.size().y > 2 * to_double(shape_size_max))
        return Error{"heights lie within 200 m of each other, the model is " + std::to_string(box.size().y) +
                     " m high (--scale shrinks it)"};
    Heights out{*columns, *rows, step, {box.lower.x, 0, box.lower.z}, {}, {}};
    // Within 100 m of 0 the heights keep their values; beyond that they are relative to the middle.
    if (std::max(std::abs(box.lower.y), std::abs(box.upper.y)) > to_double(shape_size_max))
        out.origin.y = 0.5 * (box.lower.y + box.upper.y);
    std::vector<bool> seen;
    for (std::uint32_t row = 0; row < out.rows; ++row)
        for (std::uint32_t column = 0; column < out.columns; ++column) {
            const double x = std::min(box.lower.x + to_double(step) * column, box.upper.x);
            const double z = std::min(box.lower.z + to_double(step) * row, box.upper.z);
            double height = out.origin.y;
            seen.push_back(surface.top(x, z, height));
            out.heights.push_back(quantize<Length>(height - out.origin.y));
        }
    bool any_hole = false;
    for (std::uint32_t row = 0; row + 1 < out.rows; ++row)
        for (std::uint32_t column = 0; column + 1 < out.columns; ++column) {
            const std::size_t at = std::size_t{row} * out.columns + column;
            const bool whole =
                seen[at] && seen[at + 1] && seen[at + out.columns] && seen[at + out.columns + 1];
            any_hole = any_hole || !whole;
            out.cells.push_back(whole ? 0 : hole);
        }
    if (!any_hole) out.cells.clear();
    return out;
}

} // namespace lockstone::cook
