// Which shapes may meet: bounds that overlap, planes that are reached, and the filters.
#include "sim/phases.h"
#include "sim/sleep.h"

#include <algorithm>
#include <bit>
#include <tuple>

namespace lockstone::sim {

namespace {

/// For that many and some more, so that a tick with one more than ever does not allocate.
template <class T> void reserve_ahead(std::vector<T>& list, std::size_t count) {
    list.reserve(std::max<std::size_t>(64, std::bit_ceil(count)));
}

bool is_filtered(const Data& w, BodyId a, BodyId b) {
    const std::span<const PairFilterRow> rows = w.state.rows(w.m.pair_filter);
    if (rows.empty()) return false;
    return std::binary_search(rows.begin(), rows.end(), PairFilterRow{std::min(a, b), std::max(a, b)});
}

/// Whether a joint that does not let its bodies touch holds two bodies together.
bool are_joined(const Data& w, BodyId a, BodyId b) {
    const std::span<const BodyInfo> info = w.state.rows(w.m.body_info);
    const std::span<const Slot> slots = w.state.rows(w.m.joint_slot);
    const std::span<const JointRow> joints = w.state.rows(w.m.joint);
    // Many joints may end at what does not move.
    if (info[w.row_of(a)].kind == BodyKind::static_) std::swap(a, b);
    for (std::uint32_t slot = info[w.row_of(a)].first_joint; slot != 0;) {
        const JointRow& r = joints[slots[slot - 1].row];
        const bool is_a = r.def.body_a == a;
        if (r.def.collide_connected == 0 && (is_a ? r.def.body_b : r.def.body_a) == b) return true;
        slot = is_a ? r.next_a : r.next_b;
    }
    return false;
}

/// Whether bounds reach below the plane through a point.
bool reaches(const collide::Bounds& bounds, UnitVec3 n, Vec3 point, std::uint32_t shift) {
    const auto lowest = [](Unit along, Bound lower, Bound upper) { return along.raw > 0 ? lower : upper; };
    const Vector3<Bound> corner{lowest(n.x, bounds.lower.x, bounds.upper.x),
                                lowest(n.y, bounds.lower.y, bounds.upper.y),
                                lowest(n.z, bounds.lower.z, bounds.upper.z)};
    const auto metres = [shift](Bound b) { return Real::from_raw(std::int64_t{b.raw} << (16 + shift)); };
    const Vec3 p = Vec3{metres(corner.x), metres(corner.y), metres(corner.z)} - point;
    return dot<Real>(n, p) <= to<Real>(margin_base);
}

void find_plane_pairs(Data& w) {
    Scratch& s = w.scratch;
    const std::uint32_t shift = w.state.rows(w.m.config)[0].bounds_shift;
    s.plane_pairs.clear();
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    for (std::uint32_t plane : s.planes) {
        // A plane that a command has just put there meets all bodies, others those that are awake.
        const bool is_fresh = is_awake(w, w.row_of(shapes[slots[plane].row].body));
        const std::uint32_t rows = is_fresh ? w.state.count(w.m.bodies) : w.header().bodies_awake;
        const Transform& at_plane = s.shape[plane].pose;
        const UnitVec3 n = to_rotation(at_plane.rotation).y;
        for (std::uint32_t row = 0; row < rows; ++row)
            for (std::uint32_t at = w.state.rows(w.m.body_info)[row].first_shape; at != 0;) {
                const std::uint32_t slot = at - 1;
                const ShapeRow& shape = shapes[slots[slot].row];
                at = shape.next_shape;
                if (shape.geometry.kind == ShapeKind::plane) continue;
                if (reaches(s.broad_phase.bounds(slot), n, at_plane.position, shift))
                    s.plane_pairs.push_back({std::min(plane, slot), std::max(plane, slot)});
            }
    }
    if (s.plane_pairs.empty()) return;
    std::sort(s.plane_pairs.begin(), s.plane_pairs.end());
    reserve_ahead(s.merged_pairs, s.pairs.size() + s.plane_pairs.size());
    s.merged_pairs.resize(s.pairs.size() + s.plane_pairs.size());
    std::merge(s.pairs.begin(), s.pairs.end(), s.plane_pairs.begin(), s.plane_pairs.end(),
               s.merged_pairs.begin());
    s.pairs.swap(s.merged_pairs);
}

constexpr std::uint32_t pairs_per_chunk = 128;

/// By pair its key; a null one when the two do not meet, or both rest.
void find_keys(Data& w) {
    const Data& seen = w;
    std::vector<ContactKey>& keys = w.scratch.pair_keys;
    const std::uint32_t count = static_cast<std::uint32_t>(w.scratch.pairs.size());
    reserve_ahead(keys, count);
    keys.resize(count);
    base::for_chunks(
        w.tasks, count, pairs_per_chunk, [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
            const std::span<const Slot> slots = seen.state.rows(seen.m.shape_slot);
            const std::span<const ShapeRow> shapes = seen.state.rows(seen.m.shape);
            for (std::uint32_t i = first; i < last; ++i) {
                const collide::ProxyPair pair = seen.scratch.pairs[i];
                const ShapeRow &a = shapes[slots[pair.a].row], &b = shapes[slots[pair.b].row];
                const bool any_awake =
                    is_awake(seen, seen.row_of(a.body)) || is_awake(seen, seen.row_of(b.body));
                keys[i] = any_awake && may_meet(seen, a, b) ? ContactKey{a.id, b.id} : ContactKey{};
            }
        });
}

} // namespace

/// A primitive at a scale of 2 to 8, which is static, and a mesh or height field: one of them a sensor. Triangles take shapes of
/// up to 174 m: beyond, heights over their planes leave 64 bits.
static bool is_too_large(const ShapeRow& primitive, const ShapeRow& terrain) {
    return primitive.geometry.kind <= ShapeKind::box && primitive.geometry.scale != scale_one &&
           (terrain.geometry.kind == ShapeKind::mesh || terrain.geometry.kind == ShapeKind::height_field);
}

bool may_meet(const Data& w, const ShapeRow& a, const ShapeRow& b) {
    if (a.body == b.body || (a.sensor != 0 && b.sensor != 0)) return false;
    if (is_too_large(a, b) || is_too_large(b, a)) return false;
    const std::span<const BodyInfo> info = w.state.rows(w.m.body_info);
    const BodyKind kind_a = info[w.row_of(a.body)].kind, kind_b = info[w.row_of(b.body)].kind;
    const bool any_dynamic = kind_a == BodyKind::dynamic || kind_b == BodyKind::dynamic;
    const bool any_moves = kind_a != BodyKind::static_ || kind_b != BodyKind::static_;
    if (!any_dynamic && !(any_moves && (a.sensor | b.sensor) != 0)) return false;
    if (are_joined(w, a.body, b.body)) return false;
    return filters_allow(w, a, b);
}

bool filters_allow(const Data& w, const ShapeRow& a, const ShapeRow& b) {
    if (a.group != 0 && a.group == b.group) return a.group > 0;
    return (a.category & b.mask) != 0 && (b.category & a.mask) != 0 && !is_filtered(w, a.body, b.body);
}

void find_pairs(Data& w) {
    Scratch& s = w.scratch;
    reserve_ahead(s.plane_pairs, 0);
    s.broad_phase.find_pairs(s.pairs);
    find_plane_pairs(w);
    find_keys(w);
    reserve_ahead(s.old_keys, w.state.rows(w.m.contact_key).size());
    reserve_ahead(s.old_memories, w.state.rows(w.m.contact_key).size());
    s.old_keys.assign(w.state.rows(w.m.contact_key).begin(), w.state.rows(w.m.contact_key).end());
    s.old_memories.assign(w.state.rows(w.m.contact_memory).begin(), w.state.rows(w.m.contact_memory).end());
    const auto order = [](const ContactKey& k) { return std::pair(k.a.index, k.b.index); };

    s.near.clear(), s.ended.clear();
    const std::uint32_t count = static_cast<std::uint32_t>(s.old_keys.size());
    reserve_ahead(s.ended, count);
    reserve_ahead(s.near, s.pair_keys.size());
    std::uint32_t old = 0;
    const auto retire = [&](std::uint32_t i) {
        if (s.old_memories[i].flags & dynamics::contact_touching)
            s.ended.push_back({s.old_keys[i], s.old_memories[i].flags});
    };
    for (const ContactKey& key : s.pair_keys) {
        if (!key.a) continue;
        while (old < count && order(s.old_keys[old]) < order(key)) retire(old++);
        Scratch::Near near{key, old, 0};
        for (; old < count && order(s.old_keys[old]) == order(key); ++old) {
            if (s.old_keys[old] == key)
                ++near.old_count;
            else
                retire(old), near.old_first = old + 1;
        }
        s.near.push_back(near);
    }
    while (old < count) retire(old++);
}

} // namespace lockstone::sim
