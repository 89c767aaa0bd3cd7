// Finds which shapes may collide: overlapping bounds, shapes near planes, and filters.
#include "tick/pairs.h"

#include "base/parallel.h"
#include "base/prefetch.h"
#include "base/room.h"
#include "model/sleep.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace lockstone::sim {

namespace {

/// The columns that the work on every pair reads, looked up once.
struct PairView {
    const Model& w;
    const PlacedShapes& placed;
    const JoinedBodies& joined;
    std::span<const Slot> body_slots;
    std::span<const BodyInfo> info;
    std::span<const Velocity> velocity;
    bool has_filters;
    std::uint32_t shift, tick_rate, awake;

    PairView(const Model& model, const PlacedShapes& shapes_placed, const JoinedBodies& joined_bodies)
        : w(model), placed(shapes_placed), joined(joined_bodies), body_slots(w.state.rows(w.m.body_slot)),
          info(w.state.rows(w.m.body_info)), velocity(w.state.rows(w.m.body_velocity)),
          has_filters(w.state.count(w.m.pair_filters) != 0), shift(w.config().bounds_shift),
          tick_rate(w.config().tick_rate), awake(w.header().bodies_awake) {}
    const ShapeRow& shape(std::uint32_t slot) const {
        return w.state.rows(w.m.shape)[w.state.rows(w.m.shape_slot)[slot].row];
    }
};

/// Returns true if two shapes may collide. Same result as may_meet(), with a fast path for the common kind of pair.
bool may_pair(const PairView& v, collide::ProxyPair pair) {
    const PlacedShapes::Filter &a = v.placed.shape[pair.a].filter, &b = v.placed.shape[pair.b].filter;
    const auto is_dynamic = [&](const PlacedShapes::Filter& shape) {
        return v.info[v.body_slots[shape.body].row].kind == BodyKind::dynamic;
    };
    const bool is_common = !v.has_filters && a.is_plain && b.is_plain && (is_dynamic(a) || is_dynamic(b));
    if (!is_common) return may_meet(v.w, v.shape(pair.a), v.shape(pair.b));
    return a.body != b.body && (a.category & b.mask) != 0 && (b.category & a.mask) != 0 &&
           !v.joined.contain(a.body, b.body);
}

/// The half space below a plane, extended upwards by the margin of contacts.
class Ahead {
    UnitVec3 n;
    Vec3 point;
    int up;           ///< shift from Bound to Real
    bool is_upright;  ///< n is +y: the test needs heights only
    Real height_most; ///< highest y of the half space; used if is_upright

  public:
    Ahead(UnitVec3 normal, Vec3 at, std::uint32_t shift)
        : n(normal), point(at), up(static_cast<int>(16 + shift)),
          is_upright(n == UnitVec3{Unit{}, unit_one, Unit{}}), height_most(at.y + to<Real>(margin_base)) {}
    /// Returns true if bounds reach into the half space. A bound at the border of the range also covers everything
    /// beyond it.
    bool is_reached(const collide::Bounds& bounds) const {
        const auto metres = [&](Bound b) { return Real::from_raw(std::int64_t{b.raw} << up); };
        if (is_upright) return bounds.lower.y == Bound::min() || metres(bounds.lower.y) <= height_most;
        const auto lowest = [](Unit along, Bound lower, Bound upper) {
            return along.raw > 0 ? lower : upper;
        };
        const auto is_endless = [](Unit along, Bound lower, Bound upper) {
            return (along.raw > 0 && lower == Bound::min()) || (along.raw < 0 && upper == Bound::max());
        };
        if (is_endless(n.x, bounds.lower.x, bounds.upper.x) ||
            is_endless(n.y, bounds.lower.y, bounds.upper.y) ||
            is_endless(n.z, bounds.lower.z, bounds.upper.z))
            return true;
        const Vec3 corner{metres(lowest(n.x, bounds.lower.x, bounds.upper.x)),
                          metres(lowest(n.y, bounds.lower.y, bounds.upper.y)),
                          metres(lowest(n.z, bounds.lower.z, bounds.upper.z))};
        return dot<Real>(n, corner - point) <= to<Real>(margin_base);
    }
};

/// Appends the pairs of a plane in order of slots. (Rows are not in that order.)
void add_in_order(std::uint32_t plane, PairScratch& s) {
    for (std::uint32_t word = 0; word < s.at_plane.size(); ++word)
        for (std::uint64_t bits = s.at_plane[word]; bits != 0; bits &= bits - 1) {
            const std::uint32_t slot = 64 * word + static_cast<std::uint32_t>(std::countr_zero(bits));
            s.plane_pairs.push_back({std::min(plane, slot), std::max(plane, slot)});
        }
}

void find_plane_pairs(const PairView& v, PairScratch& s) {
    const Model& w = v.w;
    const PlacedShapes& placed = v.placed;
    s.plane_pairs.clear();
    if (placed.planes.empty()) return;
    base::make_room(s.plane_pairs, w.header().bodies_awake); // most shapes are near at most one plane
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    const std::span<const Slot> slots = w.state.rows(w.m.shape_slot);
    const std::span<const BodyInfo> info = w.state.rows(w.m.body_info);
    const std::size_t words = (slots.size() + 63) / 64;
    base::make_room(s.at_plane, words);
    for (std::uint32_t plane : placed.planes) {
        // A plane that a command has just created or moved is compared with all bodies, any other plane with the
        // awake bodies.
        const bool is_fresh = is_awake(w, w.row_of(shapes[slots[plane].row].body));
        const std::uint32_t rows = is_fresh ? w.state.count(w.m.bodies) : w.header().bodies_awake;
        const Transform& at_plane = placed.shape[plane].pose;
        s.at_plane.assign(words, 0);
        const Ahead ahead(to_rotation(at_plane.rotation).y, at_plane.position, v.shift);
        constexpr std::uint32_t soon = 8;
        for (std::uint32_t row = 0; row < rows; ++row) {
            if (row + soon < rows && info[row + soon].first_shape != 0)
                base::prefetch(placed.shape[info[row + soon].first_shape - 1]);
            for (std::uint32_t at = info[row].first_shape; at != 0;) {
                const std::uint32_t slot = at - 1;
                const ShapeRow& shape = shapes[slots[slot].row];
                at = shape.next_shape;
                if (placed.shape[slot].filter.kind == ShapeKind::plane) continue;
                if (ahead.is_reached(placed.broad_phase.bounds(slot)) && may_pair(v, {plane, slot}))
                    s.at_plane[slot / 64] |= std::uint64_t{1} << slot % 64;
            }
        }
        add_in_order(plane, s);
    }
    if (s.plane_pairs.empty()) return;
    if (!std::is_sorted(s.plane_pairs.begin(), s.plane_pairs.end())) // pairs of several planes
        std::sort(s.plane_pairs.begin(), s.plane_pairs.end());
    base::make_room(s.merged_pairs, s.pairs.size() + s.plane_pairs.size());
    s.merged_pairs.resize(s.pairs.size() + s.plane_pairs.size());
    std::merge(s.pairs.begin(), s.pairs.end(), s.plane_pairs.begin(), s.plane_pairs.end(),
               s.merged_pairs.begin());
    s.pairs.swap(s.merged_pairs);
}

constexpr std::uint32_t filtered_per_chunk = 128;

/// The distance within which two shapes get contacts: the distance by which they may approach in a tick. Only
/// relative velocity counts: a body that moves along with the other body, however fast, needs no larger margin than a
/// resting body.
Length pair_margin(const PairView& v, Length widest, std::uint32_t body_a, const PlacedShapes::Shape& a,
                   std::uint32_t body_b, const PlacedShapes::Shape& b) {
    const Velocity &of_a = v.velocity[body_a], &of_b = v.velocity[body_b];
    return min(widest, margin_least + ahead_of(of_b.linear - of_a.linear, v.tick_rate) +
                           turn_ahead_of(a, of_a.angular, v.tick_rate) +
                           turn_ahead_of(b, of_b.angular, v.tick_rate));
}

/// Each of the bounds is extended by its shape's own margin. Returns true if they still overlap when the margin of
/// the pair is by `spare` less than the sum of both margins. Rounds so that no pair is lost. A bound at the border of
/// the range also covers everything beyond it.
bool still_overlap(const collide::Bounds& a, const collide::Bounds& b, Length spare, std::uint32_t shift) {
    if (spare == Length{}) return true;
    const int drop = Length::fraction_bits - Bound::fraction_bits + static_cast<int>(shift);
    const std::int64_t by = spare.raw >> drop;
    const auto reaches = [by](Bound upper, Bound lower) {
        return std::int64_t{lower.raw} + by <= upper.raw || upper == Bound::max() || lower == Bound::min();
    };
    bool out = true;
    for (int i = 0; i < 3; ++i)
        out = out && reaches(b.upper[i], a.lower[i]) && reaches(a.upper[i], b.lower[i]);
    return out;
}

/// Returns true if one body was created asleep and the other neither is dynamic nor moves. Such a pair wakes nothing,
/// so the bodies of a level can be created in any order.
bool leaves_asleep(const PairView& v, std::uint32_t body_a, std::uint32_t body_b) {
    const auto leaves = [&](std::uint32_t other, std::uint32_t sleeper) {
        return v.info[sleeper].kind == BodyKind::dynamic && v.info[other].kind != BodyKind::dynamic &&
               v.velocity[other] == Velocity{} && was_never_awake(v.w, sleeper);
    };
    return body_a >= v.awake ? leaves(body_b, body_a) : body_b >= v.awake && leaves(body_a, body_b);
}

/// Finds the key of a pair that may collide; the key is null if both bodies rest or are farther apart than the
/// margin. Writes straight into `out`: a copy of the whole key would stall on fields that were just written one by
/// one.
void find_key(const PairView& v, collide::ProxyPair pair, PairScratch::Key& out) {
    const PlacedShapes::Shape &a = v.placed.shape[pair.a], &b = v.placed.shape[pair.b];
    const std::uint32_t body_a = v.body_slots[a.filter.body].row, body_b = v.body_slots[b.filter.body].row;
    out.key.a = {};
    const bool rests_a = body_a >= v.awake, rests_b = body_b >= v.awake;
    if (rests_a || rests_b)
        if ((rests_a && rests_b) || leaves_asleep(v, body_a, body_b)) return;
    out.margin = a.margin + b.margin;
    if (out.margin != margin_least) {
        const Length widest = out.margin;
        out.margin = pair_margin(v, widest, body_a, a, body_b, b);
        const bool has_plane = a.filter.kind == ShapeKind::plane || b.filter.kind == ShapeKind::plane;
        if (!has_plane && !still_overlap(a.bounds, b.bounds, widest - out.margin, v.shift)) return;
    }
    out.key.a = {pair.a + 1, a.filter.generation}, out.key.b = {pair.b + 1, b.filter.generation};
}

void find_keys(const PairView& view, PairScratch& s, Tasks* tasks) {
    std::vector<PairScratch::Key>& keys = s.keys;
    const std::uint32_t count = static_cast<std::uint32_t>(s.pairs.size());
    base::make_room(keys, count);
    keys.resize(count);
    s.near_counts.resize((count + filtered_per_chunk - 1) / filtered_per_chunk);
    s.paths.take(base::is_shared(tasks, count, filtered_per_chunk), base::Path::keys_by_one,
                 base::Path::keys_by_workers);
    base::for_all_chunks(tasks, count, filtered_per_chunk,
                         [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                             std::uint32_t near = 0;
                             for (std::uint32_t i = first; i < last; ++i) {
                                 find_key(view, s.pairs[i], keys[i]);
                                 near += keys[i].key.a ? 1u : 0u;
                             }
                             s.near_counts[first / filtered_per_chunk] = near;
                         });
}

/// The largest number of near pairs in a tick. Beyond it the last pairs in pair order are dropped; a table of
/// contacts_max rows would drop most of them anyway.
std::size_t near_max(const Model& w) {
    return 1024 + std::size_t{2} * w.state.rows_max(w.m.contacts.contacts);
}

/// The largest number of pairs of overlapping leaves in the list; it affects speed and memory only.
std::size_t leaf_pairs_max(const Model& w) { return 8 * near_max(w); }

/// Returns true if may_pair() may give another result for a pair than before, that is, if any column that it reads
/// has changed.
bool are_filters_new(const Model& w, PairScratch& s) {
    bool are_new = false;
    std::uint32_t before = 0; // row count of the last column at the previous call
    for (const std::uint32_t column :
         {w.m.shape.index, w.m.shape_traits.row.index, w.m.body_info.index, w.m.pair_filter.index}) {
        before = w.state.take_changes(column, s.filters_of, s.changed);
        are_new |= !s.changed.empty();
    }
    return are_new || before != w.state.count(w.m.pair_filters);
}

/// Finds the pairs that may collide and whose bounds overlap, in order. Finds all pairs, or in a crowd one more than
/// near_max().
void find_overlaps(const PairView& view, collide::BroadPhase& broad_phase, bool filters_new, PairScratch& s,
                   Tasks* tasks) {
    const auto may = [&view](collide::ProxyPair pair) { return may_pair(view, pair); };
    if (broad_phase.find_pairs(s.pairs, leaf_pairs_max(view.w), {may, filters_new}, tasks)) return;
    broad_phase.find_first_pairs(s.pairs, near_max(view.w) + 1, [&](collide::ProxyPair pair) {
        if (!may_pair(view, pair)) return false;
        PairScratch::Key found;
        find_key(view, pair, found);
        return bool(found.key.a);
    });
}

std::uint64_t place_of(const ContactKey& k) { return std::uint64_t{k.a.index} << 32 | k.b.index; }

/// Iterates over rows in pair order, from a key on. After the last row `place` is greater than that of every key.
template <class Row, class KeyOf> class Walk {
    std::span<const Row> rows;
    KeyOf key_of;

  public:
    std::uint32_t at;
    std::uint64_t place;

    Walk(std::span<const Row> sorted, std::uint64_t from, KeyOf key) : rows(sorted), key_of(key) {
        const auto is_before = [&](const Row& row, std::uint64_t p) { return place_of(key_of(row)) < p; };
        at = from == 0 ? 0
                       : static_cast<std::uint32_t>(
                             std::lower_bound(rows.begin(), rows.end(), from, is_before) - rows.begin());
        place = find_place();
    }
    void next() { ++at, place = find_place(); }

  private:
    std::uint64_t find_place() const { return at < rows.size() ? place_of(key_of(rows[at])) : UINT64_MAX; }
};

/// Returns true if two keys with equal indices also have equal generations.
bool is_same(const ContactKey& x, const ContactKey& y) {
    return x.a.generation == y.a.generation && x.b.generation == y.b.generation;
}

/// Adds the pair of a row to `ended` if it touched.
void retire(const ContactList& old, std::uint32_t row, std::vector<ContactResult>& ended) {
    const ContactMemory& memory = old.memories[row];
    if (!touched(memory)) return;
    ContactResult& result = ended.emplace_back();
    result.key = old.keys[row], result.flags = memory.flags, result.was_touching = true;
}

/// The place at which the old rows of the keys from `first` on begin; UINT64_MAX if there are no such keys.
std::uint64_t first_place(std::span<const PairScratch::Key> keys, std::uint32_t first) {
    if (first == 0) return 0;
    while (first < keys.size() && !keys[first].key.a) ++first;
    return first < keys.size() ? place_of(keys[first].key) : UINT64_MAX;
}

/// Lists the pairs of keys [first, last) that are not null, with their rows of the contact table and the hints of the
/// last tick. Lists at most `out.size()` pairs. Appends to `ended` the pairs that touched and are no longer near.
void list_some(PlacedShapes& placed, const ContactList& table, const PairScratch& s, std::uint32_t first,
               std::uint32_t last, std::span<NearPair> out, std::vector<ContactResult>& ended) {
    const std::span<const ContactKey> old_keys = table.keys;
    const std::span<const NearPair> hints = s.before;
    const std::uint64_t begin = first_place(s.keys, first),
                        end = last < s.keys.size() ? first_place(s.keys, last) : UINT64_MAX;
    Walk old(old_keys, begin, [](const ContactKey& key) -> const ContactKey& { return key; });
    Walk hint(hints, begin, [](const NearPair& near) -> const ContactKey& { return near.key; });
    std::size_t listed = 0;
    for (std::uint32_t i = first; i < last && listed < out.size(); ++i) {
        const PairScratch::Key& pair = s.keys[i];
        if (!pair.key.a) continue;
        const std::uint64_t place = place_of(pair.key);
        for (; old.place < place; old.next()) retire(table, old.at, ended);
        while (hint.place < place) hint.next();
        make_axes(placed.shape[pair.key.a.index - 1]);
        make_axes(placed.shape[pair.key.b.index - 1]);
        NearPair& near = out[listed++]; // filled in place, like the keys
        near.key = pair.key, near.margin = pair.margin, near.old_first = old.at, near.old_count = 0;
        for (; old.place == place; old.next()) {
            if (is_same(old_keys[old.at], pair.key))
                ++near.old_count;
            else
                retire(table, old.at, ended), near.old_first = old.at + 1;
        }
        const bool has_hint = hint.place == place && is_same(hints[hint.at].key, pair.key);
        near.apart = has_hint ? hints[hint.at].apart : UnitVec3{};
    }
    for (; old.place < end; old.next()) retire(table, old.at, ended);
}

/// Lists the near pairs, at most `most`.
void list_near(PlacedShapes& placed, const ContactList& table, std::size_t most, PairScratch& s,
               NearPairs& out, Tasks* tasks) {
    constexpr std::uint32_t listed_per_chunk = 4 * filtered_per_chunk;
    const auto count = static_cast<std::uint32_t>(s.keys.size());
    out.list.swap(s.before);
    out.ended.clear();
    base::make_room(out.ended, table.keys.size());
    std::size_t near = 0;
    for (std::uint32_t& of_chunk : s.near_counts)
        near += std::exchange(of_chunk, static_cast<std::uint32_t>(near));
    out.is_cut = near > most;
    base::make_room(out.list, std::min(near, most));
    out.list.resize(std::min(near, most)); // list_some() overwrites the pairs that are still in it
    const bool is_shared = !out.is_cut && base::is_shared(tasks, count, listed_per_chunk);
    s.paths.take(out.is_cut, base::Path::near_all, base::Path::near_cut);
    s.paths.take(is_shared, base::Path::near_by_one, base::Path::near_by_workers);
    if (!is_shared) return list_some(placed, table, s, 0, count, out.list, out.ended);
    s.ended.resize(std::max<std::size_t>(s.ended.size(), count / listed_per_chunk + 1));
    base::for_all_chunks(
        tasks, count, listed_per_chunk, [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
            std::vector<ContactResult>& ended = s.ended[first / listed_per_chunk];
            ended.clear();
            const std::uint32_t from = s.near_counts[first / filtered_per_chunk];
            list_some(placed, table, s, first, last, std::span(out.list).subspan(from), ended);
        });
    for (std::uint32_t first = 0; first < count; first += listed_per_chunk)
        for (const ContactResult& result : s.ended[first / listed_per_chunk]) out.ended.push_back(result);
}

} // namespace

void JoinedBodies::reserve(const WorldRows& rows) {
    bits.reserve(rows.bodies);
    for (std::vector<std::uint32_t>* list : {&first, &first_before}) list->reserve(rows.bodies + 1);
    for (std::vector<std::uint32_t>* list : {&partners, &partners_before}) list->reserve(2 * rows.joints);
}

bool JoinedBodies::find(const Model& w) {
    const std::uint32_t joints = w.state.count(w.m.joints), slots = w.state.count(w.m.body_slots),
                        before = w.state.take_changes(w.m.joint.index, seen, changed);
    if (changed.empty() && before == joints && !first.empty()) {
        if (bits.size() == slots) return false;
        // Bodies that came or went since then have no joint.
        base::make_room(bits, slots), base::make_room(first, slots + 1);
        bits.resize(slots, 0), first.resize(slots + 1, static_cast<std::uint32_t>(partners.size()));
        return false;
    }
    const auto for_each_end = [&](auto&& visit) {
        for (const JointRow& joint : w.state.rows(w.m.joint)) {
            if (joint.def.collide_connected != 0 || !joint.def.body_a) continue;
            const std::uint32_t a = joint.def.body_a.index - 1, b = joint.def.body_b.index - 1;
            visit(a, b), visit(b, a);
        }
    };
    first.swap(first_before), partners.swap(partners_before);
    base::make_room(bits, slots), base::make_room(first, slots + 1), base::make_room(partners, 2 * joints);
    bits.assign(slots, 0), first.assign(slots + 1, 0);
    for_each_end([&](std::uint32_t own, std::uint32_t other) {
        bits[own] |= std::uint64_t{1} << other % 64;
        ++first[own];
    });
    for (std::uint32_t slot = 1; slot <= slots; ++slot) first[slot] += first[slot - 1];
    partners.resize(first[slots]);
    // Fills the list of each slot backwards, from its end to its begin.
    for_each_end([&](std::uint32_t own, std::uint32_t other) { partners[--first[own]] = other; });
    return first != first_before || partners != partners_before;
}

/// Many joints may end at one body, so the function searches the shorter of the two lists.
bool JoinedBodies::has_partner(std::uint32_t a, std::uint32_t b) const {
    if (first[a + 1] - first[a] > first[b + 1] - first[b]) std::swap(a, b);
    const auto begin = partners.begin();
    return std::find(begin + first[a], begin + first[a + 1], b) != begin + first[a + 1];
}

void find_pairs(const Model& w, PlacedShapes& placed, const ContactList& table, PairScratch& s,
                NearPairs& out, Tasks* tasks) {
    const bool joints_new = s.joined.find(w), filters_new = are_filters_new(w, s) || joints_new;
    const PairView view(w, placed, s.joined);
    find_overlaps(view, placed.broad_phase, filters_new, s, tasks);
    find_plane_pairs(view, s);
    find_keys(view, s, tasks);
    list_near(placed, table, near_max(w), s, out, tasks);
}

} // namespace lockstone::sim
