// Lists the acceleration fields of a tick for the integrator.
#include "play/fluids/fluids.h"

#include <algorithm>

namespace lockstone::sim {

void list_fields(const Model& w, FieldsOfTick& out) {
    out.pulls.clear(), out.categories.clear();
    for (const FieldRow& row : w.state.rows(w.m.field))
        if (row.def.kind != FieldKind::fluid) out.pulls.push_back(row);
    // Rows move when fields are destroyed. The order of ids does not change.
    std::sort(out.pulls.begin(), out.pulls.end(),
              [](const FieldRow& a, const FieldRow& b) { return a.id < b.id; });
    const auto looks = [](const FieldRow& row) { return row.def.mask != solve::every_category; };
    if (std::none_of(out.pulls.begin(), out.pulls.end(), looks)) return;
    out.categories.resize(w.header().bodies_awake);
    for (const ShapeRow& shape : w.state.rows(w.m.shape)) {
        const std::uint32_t row = w.row_of(shape.body);
        if (row < out.categories.size()) out.categories[row] |= w.traits_of(shape).category;
    }
}

} // namespace lockstone::sim
