// Which shapes may meet: bounds that overlap, planes that are reached, and the filters.
#include "tick/pairs.h"

#include "base/parallel.h"
#include "base/room.h"
#include "model/sleep.h"

#include <algorithm>
#include <bit>

namespace lockstone::sim {

namespace {

/// The half space below a plane, and what contacts look ahead of it.
class Ahead {
    UnitVec3 n;
    Vec3 point;
    int up;           ///< from Bound to Real
    bool is_upright;  ///< n is +y: heights are all that counts
    Real height_most; ///< then

  public:
    Ahead(UnitVec3 normal, Vec3 at, std::uint32_t shift)
        : n(normal), point(at), up(static_cast<int>(16 + shift)),
          is_upright(n == UnitVec3{Unit{}, unit_one, Unit{}}), height_most(at.y + to<Real>(margin_base)) {}
    /// Whether bounds reach into it.
    bool is_reached(const collide::Bounds& bounds) const {
        const auto metres = [&](Bound b) { return Real::from_raw(std::int64_t{b.raw} << up); };
        if (is_upright) return metres(bounds.lower.y) <= height_most;
        const auto lowest = [](Unit along, Bound lower, Bound upper) {
            return along.raw > 0 ? lower : upper;
        };
        const Vec3 corner{metres(lowest(n.x, bounds.lower.x, bounds.upper.x)),
                          metres(lowest(n.y, bounds.lower.y, bounds.upper.y)),
                          metres(lowest(n.z, bounds.lower.z, bounds.upper.z))};
        return dot<Real>(n, corner - point) <= to<Real>(margin_base);
    }
};

/// The pairs of a plane, by slot: sorted, as rows are not.
void add_in_order(std::uint32_t plane, PairScratch& s) {
    for (std::uint32_t word = 0; word < s.at_plane.size(); ++word)
        for (std::uint64_t bits = s.at_plane[word]; bits != 0; bits &= bits - 1) {
            const std::uint32_t slot = 64 * word + static_cast<std::uint32_t>(std::countr_zero(bits));
            s.plane_pairs.push_back({std::min(plane, slot), std::max(plane, slot)});
        }
}

void find_plane_pairs(const Model& w, const PlacedShapes& placed, PairScratch& s) {
    const std::uint32_t shift = w.state.rows(w.m.config)[0].bounds_shift;
    s.plane_pairs.clear();
    if (placed.planes.empty()) return;
    base::make_room(s.plane_pairs, w.header().bodies_awake); // most shapes are near no plane, or one
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    const std::span<const BodyInfo> info = w.state.rows(w.m.body_info);
    const std::size_t words = (slots.size() + 63) / 64;
    base::make_room(s.at_plane, words);
    for (std::uint32_t plane : placed.planes) {
        // A plane that a command has just put there meets all bodies, others those that are awake.
        const bool is_fresh = is_awake(w, w.row_of(shapes[slots[plane].row].body));
        const std::uint32_t rows = is_fresh ? w.state.count(w.m.bodies) : w.header().bodies_awake;
        const Transform& at_plane = placed.shape[plane].pose;
        s.at_plane.assign(words, 0);
        const Ahead ahead(to_rotation(at_plane.rotation).y, at_plane.position, shift);
        for (std::uint32_t row = 0; row < rows; ++row)
            for (std::uint32_t at = info[row].first_shape; at != 0;) {
                const std::uint32_t slot = at - 1;
                const ShapeRow& shape = shapes[slots[slot].row];
                at = shape.next_shape;
                if (placed.shape[slot].filter.kind == ShapeKind::plane) continue;
                if (ahead.is_reached(placed.broad_phase.bounds(slot)))
                    s.at_plane[slot / 64] |= std::uint64_t{1} << slot % 64;
            }
        add_in_order(plane, s);
    }
    if (s.plane_pairs.empty()) return;
    if (!std::is_sorted(s.plane_pairs.begin(), s.plane_pairs.end())) // of several planes
        std::sort(s.plane_pairs.begin(), s.plane_pairs.end());
    base::make_room(s.merged_pairs, s.pairs.size() + s.plane_pairs.size());
    s.merged_pairs.resize(s.pairs.size() + s.plane_pairs.size());
    std::merge(s.pairs.begin(), s.pairs.end(), s.plane_pairs.begin(), s.plane_pairs.end(),
               s.merged_pairs.begin());
    s.pairs.swap(s.merged_pairs);
}

constexpr std::uint32_t filtered_per_chunk = 128;

/// How far ahead the contacts of two shapes reach: as far as they near each other in a tick. What moves along with the
/// other, however fast, meets nothing sooner than what rests.
Length pair_margin(const Model& w, const PlacedShapes::Shape& a, std::uint32_t body_a,
                   const PlacedShapes::Shape& b, std::uint32_t body_b) {
    const Length widest = a.margin + b.margin, least = margin_base + margin_base;
    if (widest == least) return least;
    const std::span<const Velocity> velocity = w.state.rows(w.m.body_velocity);
    return min(widest, least + ahead_of(velocity[body_b].linear - velocity[body_a].linear,
                                        w.state.rows(w.m.config)[0].tick_rate));
}

/// Whether bounds that reach ahead by each shape's own margin still overlap when the pair's margin is `spare` less than
/// both together. Rounded so that none is missed.
bool still_overlap(const collide::Bounds& a, const collide::Bounds& b, Length spare, std::uint32_t shift) {
    if (spare == Length{}) return true;
    const int drop = Length::fraction_bits - Bound::fraction_bits + static_cast<int>(shift);
    const std::int64_t by = spare.raw >> drop;
    bool out = true;
    for (int i = 0; i < 3; ++i)
        out = out && std::int64_t{a.lower[i].raw} + by <= b.upper[i].raw &&
              std::int64_t{b.lower[i].raw} + by <= a.upper[i].raw;
    return out;
}

/// The columns that every pair looks at, found once for many.
struct PairView {
    const Model& w;
    const PlacedShapes& placed;
    const JoinedBodies& joined;
    std::span<const Slot> body_slots;
    std::span<const BodyInfo> info;
    bool has_filters;
    std::uint32_t shift, awake;

    PairView(const Model& model, const PlacedShapes& shapes_placed, const JoinedBodies& joined_bodies)
        : w(model), placed(shapes_placed), joined(joined_bodies), body_slots(w.state.rows(w.m.body_slot)),
          info(w.state.rows(w.m.body_info)), has_filters(w.state.count(w.m.pair_filters) != 0),
          shift(w.state.rows(w.m.config)[0].bounds_shift), awake(w.header().bodies_awake) {}
    const ShapeRow& shape(std::uint32_t slot) const {
        return w.state.rows(w.m.shape)[w.state.rows(w.m.shape_slot)[slot].row];
    }
};

/// Whether one of two bodies was made asleep and the other does not move: a level is made in any order.
bool leaves_asleep(const PairView& v, std::uint32_t body_a, std::uint32_t body_b) {
    const auto leaves = [&](std::uint32_t other, std::uint32_t sleeper) {
        return v.info[sleeper].kind == BodyKind::dynamic && v.info[other].kind != BodyKind::dynamic &&
               v.w.state.rows(v.w.m.body_velocity)[other] == Velocity{} && was_never_awake(v.w, sleeper);
    };
    return body_a >= v.awake ? leaves(body_b, body_a) : body_b >= v.awake && leaves(body_a, body_b);
}

/// Whether two shapes may meet: may_meet(), and what most pairs are without looking further.
bool may_pair(const PairView& v, collide::ProxyPair pair, std::uint32_t body_a, std::uint32_t body_b) {
    const PlacedShapes::Filter &a = v.placed.shape[pair.a].filter, &b = v.placed.shape[pair.b].filter;
    const BodyInfo &info_a = v.info[body_a], &info_b = v.info[body_b];
    const bool is_common = !v.has_filters && a.is_plain && b.is_plain &&
                           (info_a.kind == BodyKind::dynamic || info_b.kind == BodyKind::dynamic);
    if (!is_common) return may_meet(v.w, v.shape(pair.a), v.shape(pair.b));
    return body_a != body_b && (a.category & b.mask) != 0 && (b.category & a.mask) != 0 &&
           !v.joined.contain(a.body, b.body);
}

/// Its key is null when the two do not meet, or both rest, or are farther apart than the margin. Written where it is kept: a copy
/// of the whole would wait for numbers that were just written one by one.
void find_key(const PairView& v, collide::ProxyPair pair, PairScratch::Key& out) {
    const PlacedShapes::Shape &a = v.placed.shape[pair.a], &b = v.placed.shape[pair.b];
    const std::uint32_t body_a = v.body_slots[a.filter.body].row, body_b = v.body_slots[b.filter.body].row;
    out.key.a = {};
    if (body_a >= v.awake && body_b >= v.awake) return;
    const Length margin = pair_margin(v.w, a, body_a, b, body_b);
    const bool has_plane = a.filter.kind == ShapeKind::plane || b.filter.kind == ShapeKind::plane;
    const Length spare = has_plane ? Length{} : a.margin + b.margin - margin;
    if (!still_overlap(a.bounds, b.bounds, spare, v.shift)) return;
    if (!may_pair(v, pair, body_a, body_b) || leaves_asleep(v, body_a, body_b)) return;
    out.key.a = {pair.a + 1, a.filter.generation}, out.key.b = {pair.b + 1, b.filter.generation};
    out.margin = margin;
}

void find_keys(const PairView& view, PairScratch& s, Tasks* tasks) {
    std::vector<PairScratch::Key>& keys = s.keys;
    const std::uint32_t count = static_cast<std::uint32_t>(s.pairs.size());
    base::make_room(keys, count);
    keys.resize(count);
    base::for_chunks(tasks, count, filtered_per_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         for (std::uint32_t i = first; i < last; ++i) find_key(view, s.pairs[i], keys[i]);
                     });
}

/// How many pairs that are near are looked at: beyond, the last in pair order are dropped, as a table of contacts_max rows
/// would drop most of them.
std::size_t near_max(const Model& w) {
    return 1024 + std::size_t{2} * w.state.rows_max(w.m.contacts.contacts);
}

/// How many pairs of overlapping leaves may be listed; it decides on speed and memory only.
std::size_t leaf_pairs_max(const Model& w) { return 8 * near_max(w); }

/// Pairs whose bounds overlap, in order: all of them, or in a crowd as many as are looked at, and one more.
void find_overlaps(const PairView& view, collide::BroadPhase& broad_phase, PairScratch& s) {
    if (broad_phase.find_pairs(s.pairs, leaf_pairs_max(view.w))) return;
    broad_phase.find_first_pairs(s.pairs, near_max(view.w) + 1, [&](collide::ProxyPair pair) {
        PairScratch::Key found;
        find_key(view, pair, found);
        return bool(found.key.a);
    });
}

/// Ends what touched and is no longer near.
void retire(const ContactList& old, std::uint32_t row, std::vector<ContactResult>& ended) {
    const ContactMemory& memory = old.memories[row];
    if (!touched(memory)) return;
    ContactResult& result = ended.emplace_back();
    result.key = old.keys[row], result.flags = memory.flags, result.was_touching = true;
}

} // namespace

void JoinedBodies::reserve(const WorldRows& rows) {
    bits.reserve(rows.bodies), first.reserve(rows.bodies + 1), partners.reserve(2 * rows.joints);
}

void JoinedBodies::find(const Model& w) {
    const std::uint32_t joints = w.state.count(w.m.joints), slots = w.state.count(w.m.body_slots),
                        before = w.state.take_changes(w.m.joint.index, seen, changed);
    if (changed.empty() && before == joints && bits.size() == slots) return;
    const auto for_each_end = [&](auto&& visit) {
        for (const JointRow& joint : w.state.rows(w.m.joint)) {
            if (joint.def.collide_connected != 0 || !joint.def.body_a) continue;
            const std::uint32_t a = joint.def.body_a.index - 1, b = joint.def.body_b.index - 1;
            visit(a, b), visit(b, a);
        }
    };
    base::make_room(bits, slots), base::make_room(first, slots + 1), base::make_room(partners, 2 * joints);
    bits.assign(slots, 0), first.assign(slots + 1, 0);
    for_each_end([&](std::uint32_t own, std::uint32_t other) {
        bits[own] |= std::uint64_t{1} << other % 64;
        ++first[own];
    });
    for (std::uint32_t slot = 1; slot <= slots; ++slot) first[slot] += first[slot - 1];
    partners.resize(first[slots]);
    // From where those of a slot end down to where they begin.
    for_each_end([&](std::uint32_t own, std::uint32_t other) { partners[--first[own]] = other; });
}

/// Many joints may end at one body: the one with fewer is asked.
bool JoinedBodies::has_partner(std::uint32_t a, std::uint32_t b) const {
    if (first[a + 1] - first[a] > first[b + 1] - first[b]) std::swap(a, b);
    const auto begin = partners.begin();
    return std::find(begin + first[a], begin + first[a + 1], b) != begin + first[a + 1];
}

void find_pairs(const Model& w, PlacedShapes& placed, const ContactList& table, PairScratch& s,
                NearPairs& out, Tasks* tasks) {
    s.joined.find(w);
    const PairView view(w, placed, s.joined);
    find_overlaps(view, placed.broad_phase, s);
    find_plane_pairs(w, placed, s);
    find_keys(view, s, tasks);
    const auto order = [](const ContactKey& k) { return std::uint64_t{k.a.index} << 32 | k.b.index; };

    out.list.swap(s.before);
    out.list.clear(), out.ended.clear();
    out.is_cut = false;
    const std::span<const ContactKey> old_keys = table.keys;
    const std::uint32_t count = static_cast<std::uint32_t>(old_keys.size());
    base::make_room(out.ended, count);
    base::make_room(out.list, std::min(s.keys.size(), near_max(w)));
    std::uint32_t old = 0;
    std::size_t hint = 0;
    const std::size_t most = near_max(w);
    for (const PairScratch::Key& pair : s.keys) {
        if (!pair.key.a) continue;
        if (out.list.size() == most) {
            out.is_cut = true;
            break;
        }
        const std::uint64_t place = order(pair.key);
        while (old < count && order(old_keys[old]) < place) retire(table, old++, out.ended);
        while (hint < s.before.size() && order(s.before[hint].key) < place) ++hint;
        make_axes(placed.shape[pair.key.a.index - 1]), make_axes(placed.shape[pair.key.b.index - 1]);
        NearPair& near = out.list.emplace_back(); // filled in there, as keys are
        near.key = pair.key, near.margin = pair.margin, near.old_first = old;
        for (; old < count && order(old_keys[old]) == place; ++old) {
            if (old_keys[old] == pair.key)
                ++near.old_count;
            else
                retire(table, old, out.ended), near.old_first = old + 1;
        }
        if (hint < s.before.size() && s.before[hint].key == pair.key) near.apart = s.before[hint].apart;
    }
    while (old < count) retire(table, old++, out.ended);
}

} // namespace lockstone::sim
