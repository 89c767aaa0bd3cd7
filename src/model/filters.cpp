// Filters: which bodies and shapes may collide.
#include "model/model.h"

#include <algorithm>

namespace lockstone::sim {

static bool is_filtered(const Model& w, BodyId a, BodyId b) {
    const std::span<const PairFilterRow> rows = w.state.rows(w.m.pair_filter);
    if (rows.empty()) return false;
    return std::binary_search(rows.begin(), rows.end(), PairFilterRow{std::min(a, b), std::max(a, b)});
}

bool are_joined(const Model& w, BodyId a, BodyId b) {
    const std::span<const BodyInfo> info = w.state.rows(w.m.body_info);
    const std::span<const Slot> slots = w.state.rows(w.m.joint_slot);
    const std::span<const JointRow> joints = w.state.rows(w.m.joint);
    // A body that does not move may have many joints, so the function walks the list of the other body.
    std::uint32_t row = w.row_of(a);
    if (info[row].kind == BodyKind::static_) std::swap(a, b), row = w.row_of(a);
    for (std::uint32_t slot = info[row].first_joint; slot != 0;) {
        const JointRow& r = joints[slots[slot - 1].row];
        const bool is_a = r.def.body_a == a;
        if (r.def.collide_connected == 0 && (is_a ? r.def.body_b : r.def.body_a) == b) return true;
        slot = is_a ? r.next_a : r.next_b;
    }
    return false;
}

/// Returns true for a pair of a primitive at a scale of 2 to 8, which is static, and a mesh or height field. In such
/// a pair one shape is a sensor. Tests against triangles support shapes of up to 174 m; for larger ones, heights over
/// the planes of triangles exceed 64 bits.
static bool is_too_large(const ShapeTraits& primitive, const ShapeTraits& terrain) {
    return primitive.geometry.kind <= ShapeKind::box && primitive.geometry.scale != scale_one &&
           (terrain.geometry.kind == ShapeKind::mesh || terrain.geometry.kind == ShapeKind::height_field);
}

bool may_meet(const Model& w, const ShapeRow& a, const ShapeRow& b) {
    const ShapeTraits &is_a = w.traits_of(a), &is_b = w.traits_of(b);
    if (a.body == b.body || (is_a.sensor != 0 && is_b.sensor != 0)) return false;
    if (is_too_large(is_a, is_b) || is_too_large(is_b, is_a)) return false;
    const std::span<const BodyInfo> info = w.state.rows(w.m.body_info);
    const BodyKind kind_a = info[w.row_of(a.body)].kind, kind_b = info[w.row_of(b.body)].kind;
    const bool any_dynamic = kind_a == BodyKind::dynamic || kind_b == BodyKind::dynamic;
    const bool any_moves = kind_a != BodyKind::static_ || kind_b != BodyKind::static_;
    if (!any_dynamic && !(any_moves && (is_a.sensor | is_b.sensor) != 0)) return false;
    if (are_joined(w, a.body, b.body)) return false;
    return filters_allow(w, a, b);
}

bool filters_allow(const Model& w, const ShapeRow& a, const ShapeRow& b) {
    const ShapeTraits &is_a = w.traits_of(a), &is_b = w.traits_of(b);
    if (is_a.group != 0 && is_a.group == is_b.group) return is_a.group > 0;
    return (is_a.category & is_b.mask) != 0 && (is_b.category & is_a.mask) != 0 &&
           !is_filtered(w, a.body, b.body);
}

} // namespace lockstone::sim
