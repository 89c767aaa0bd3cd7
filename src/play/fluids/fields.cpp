// Fields of acceleration, as the integrator takes them.
#include "tick/phases.h"

#include <algorithm>

namespace lockstone::sim {

void list_fields(Data& w) {
    Scratch& s = w.scratch;
    s.pulls.clear(), s.categories.clear();
    for (const FieldRow& row : w.state.rows(w.m.field))
        if (row.def.kind != FieldKind::fluid) s.pulls.push_back(row);
    // Rows move when fields are destroyed; the order of their ids is that of their slots.
    std::sort(s.pulls.begin(), s.pulls.end(),
              [](const FieldRow& a, const FieldRow& b) { return a.id < b.id; });
    const auto looks = [](const FieldRow& row) { return row.def.mask != solve::every_category; };
    if (std::none_of(s.pulls.begin(), s.pulls.end(), looks)) return;
    s.categories.resize(w.header().bodies_awake);
    for (const ShapeRow& shape : w.state.rows(w.m.shape)) {
        const std::uint32_t row = w.row_of(shape.body);
        if (row < s.categories.size()) s.categories[row] |= w.traits_of(shape).category;
    }
}

} // namespace lockstone::sim
