// The broad phase keeps pairs of overlapping leaves between calls. A call queries the trees only for leaves
// that changed, then filters all pairs by exact bounds. Descending two trees at once visits three times as many
// nodes: most pairs of nodes with a changed leaf below them overlap elsewhere.
//
// source: van den Bergen, Efficient Collision Detection of Complex Deformable Models using AABB Trees, 1997 (fat leaves)
#include "collide/broad/broad_phase.h"

#include "base/assert.h"
#include "base/parallel.h"
#include "base/room.h"

#include <algorithm>

namespace lockstone::collide {

using base::Path;

/// Work per chunk that a worker takes: pairs of leaves, and leaves that changed.
static constexpr std::uint32_t overlaps_per_chunk = 1024, fresh_per_chunk = 16;

/// The least number of fresh leaves that never move for which the other leaves search.
static constexpr std::uint32_t still_leaves_least = 64;

/// The trees are copied after one query for this many leaves, and a few more.
static constexpr std::uint32_t leaves_per_query = 64, queries_min = 4;

BroadPhase::BroadPhase(std::uint32_t proxy_capacity, Bound leaf_margin) : margin(leaf_margin) {
    grow(proxy_capacity);
    reserve(proxy_capacity);
    open.reserve(256);
}

void BroadPhase::grow(std::uint32_t proxy_capacity) {
    if (proxy_capacity <= entries.size()) return;
    entries.reserve(proxy_capacity); // exactly this much: the caller already grows in steps
    entries.resize(proxy_capacity, absent);
    exact_bounds.reserve(proxy_capacity);
    exact_bounds.resize(proxy_capacity);
}

void BroadPhase::reserve(std::uint32_t proxies) {
    moving.reserve(proxies), fixed.reserve(proxies);
    moved.reserve(proxies), changed.reserve(proxies), leaves.reserve(proxies), searchers.reserve(proxies);
    for (std::vector<ProxyPair>* pairs : {&leaf_pairs, &barred, &found, &merged})
        pairs->reserve(std::size_t{8} * proxies);
}

/// The bounds with the margin, extended ahead by eight times the motion (at most twelve margins): a body that
/// moves on in its direction leaves its leaf less often. Four times the motion costs more in all falling
/// scenes.
Bounds BroadPhase::moving_leaf(const Vector3<Bound>& motion, const Bounds& exact) const {
    Bounds leaf = expand(exact, margin);
    const Bound limit = margin * 12;
    for (int i = 0; i < 3; ++i) {
        const Bound ahead = clamp(motion[i] * 8, -limit, limit);
        if (ahead < Bound{})
            leaf.lower[i] += ahead;
        else
            leaf.upper[i] += ahead;
    }
    return leaf;
}

void BroadPhase::set_leaf(std::uint32_t proxy, const Bounds& exact, bool is_static,
                          const Vector3<Bound>& motion) {
    LOCKSTONE_ASSERT(proxy < entries.size(), "proxy ", proxy, ", capacity ", entries.size());
    Entry& entry = entries[proxy];
    const Bounds before = entry.present ? exact_bounds[proxy] : exact;
    exact_bounds[proxy] = exact;
    if (entry.present && entry.is_static && is_static && entry.leaf_bounds == exact) return;
    entry.present = true;
    entry.is_static = is_static;
    const bool is_known = motion != Vector3<Bound>{};
    entry.leaf_bounds = is_static || entry.never_moves
                            ? exact
                            : moving_leaf(is_known ? motion : exact.lower - before.lower, exact);
    note_move(proxy);
}

void BroadPhase::remove(std::uint32_t proxy) {
    if (!contains(proxy)) return;
    entries[proxy].present = false;
    note_move(proxy);
}

void BroadPhase::clear() {
    for (Entry& entry : entries) entry = absent;
    moving.clear();
    fixed.clear();
    drop_wide_tree();
    moved.clear();
    changed.clear();
    leaf_pairs.clear();
    barred.clear();
    gave_up = false;
}

bool BroadPhase::may_stay(const Entry& entry) const {
    if (entry.leaf == BoundsTree::none || !entry.present || entry.is_static != entry.in_fixed) return false;
    const BoundsTree& tree = tree_of(entry.in_fixed);
    return tree.is_tight() && overlap(tree.node(entry.leaf).bounds, entry.leaf_bounds);
}

void BroadPhase::update_trees() {
    if (moved.empty()) return;
    drop_wide_tree();
    std::uint32_t staying[2] = {0, 0}, changes[2] = {0, 0};
    for (std::uint32_t proxy : moved) {
        Entry& entry = entries[proxy];
        entry.stays = may_stay(entry);
        if (entry.stays) {
            ++staying[entry.in_fixed];
            continue;
        }
        if (entry.leaf != BoundsTree::none) ++changes[entry.in_fixed];
        if (entry.present) ++changes[entry.is_static];
    }
    const bool anew[2] = {changes[0] * 8 > moving.leaf_count(), changes[1] * 8 > fixed.leaf_count()};
    for (bool is_fixed : {false, true})
        if (!anew[is_fixed] && staying[is_fixed] != 0) move_leaves(is_fixed, staying[is_fixed]);
    for (std::uint32_t proxy : moved) {
        Entry& entry = entries[proxy];
        if (entry.leaf == BoundsTree::none || (entry.stays && !anew[entry.in_fixed])) continue;
        if (!anew[entry.in_fixed]) tree_of(entry.in_fixed).remove(entry.leaf);
        entry.leaf = BoundsTree::none;
    }
    for (bool is_fixed : {false, true}) {
        if (anew[is_fixed] || changes[is_fixed] != 0)
            paths.take(anew[is_fixed], Path::tree_updated, Path::tree_rebuilt);
        if (anew[is_fixed])
            rebuild(is_fixed);
        else if (changes[is_fixed] != 0)
            insert_moved(is_fixed);
    }
    for (std::uint32_t proxy : moved) entries[proxy].moved = false;
    moved.clear();
}

void BroadPhase::move_leaves(bool is_fixed, std::uint32_t count) {
    BoundsTree& tree = tree_of(is_fixed);
    const bool all_at_once = tree.can_refit() && count > tree.leaf_count() / 8;
    paths.take(all_at_once, Path::leaves_moved_one_by_one, Path::leaves_refit_at_once);
    for (std::uint32_t proxy : moved) {
        const Entry& entry = entries[proxy];
        if (!entry.stays || entry.in_fixed != is_fixed) continue;
        if (all_at_once)
            tree.set_leaf(entry.leaf, entry.leaf_bounds);
        else
            tree.move(entry.leaf, entry.leaf_bounds);
    }
    if (all_at_once) tree.refit();
}

void BroadPhase::rebuild(bool is_fixed) {
    BoundsTree& tree = tree_of(is_fixed);
    leaves.clear();
    base::make_room(leaves, tree.leaf_count() + moved.size());
    tree.for_each_leaf([&](BoundsTree::NodeId, const BoundsTree::Node& leaf) {
        const Entry& entry = entries[leaf.proxy()];
        if (!entry.moved) leaves.push_back({leaf.bounds, leaf.proxy()});
    });
    for (std::uint32_t proxy : moved)
        if (const Entry& entry = entries[proxy]; entry.present && entry.is_static == is_fixed)
            leaves.push_back({entry.leaf_bounds, proxy});
    tree.rebuild(leaves);
    note_leaves(is_fixed);
}

void BroadPhase::note_leaves(bool is_fixed) {
    tree_of(is_fixed).for_each_leaf([&](BoundsTree::NodeId id, const BoundsTree::Node& leaf) {
        entries[leaf.proxy()].leaf = id;
        entries[leaf.proxy()].in_fixed = is_fixed;
    });
}

void BroadPhase::insert_moved(bool is_fixed) {
    for (std::uint32_t proxy : moved) {
        Entry& entry = entries[proxy];
        if (!entry.present || entry.is_static != is_fixed || entry.leaf != BoundsTree::none) continue;
        entry.leaf = tree_of(is_fixed).insert(entry.leaf_bounds, proxy);
        entry.in_fixed = is_fixed;
    }
}

bool BroadPhase::find_pairs(std::vector<ProxyPair>& out, std::size_t leaf_pairs_max, const PairFilter& filter,
                            Tasks* tasks) {
    const bool is_other = filter.is_new || is_filtered != bool(filter.may_meet);
    is_filtered = bool(filter.may_meet);
    if (gave_up)
        for (std::uint32_t proxy = 0; proxy < entries.size(); ++proxy)
            if (entries[proxy].present) note_move(proxy);
    paths.take(is_other, Path::pair_filter_kept, Path::pair_filter_new);
    paths.take(!changed.empty(), Path::leaf_pairs_kept, Path::leaf_pairs_found);
    if (!changed.empty() || is_other) {
        update_trees();
        gave_up = !find_leaf_pairs(leaf_pairs_max, filter, is_other, tasks);
        paths.take(gave_up, Path::pairs_listed, Path::pairs_in_crowd);
        if (gave_up) {
            out.clear();
            return false;
        }
        for (std::uint32_t proxy : changed) entries[proxy].fresh = false;
        changed.clear();
    }
    keep_overlaps(out, tasks);
    return true;
}

/// Copies the pairs of `leaf_pairs` whose exact bounds overlap, which about half of them do. The loop writes
/// every pair and advances only past those that overlap: a branch would be unpredictable.
void BroadPhase::keep_overlaps(std::vector<ProxyPair>& out, Tasks* tasks) {
    if (merged.size() < leaf_pairs.size()) merged.resize(leaf_pairs.size());
    const Bounds* const exact = exact_bounds.data();
    const std::uint32_t count = static_cast<std::uint32_t>(leaf_pairs.size()),
                        chunk = tasks != nullptr ? overlaps_per_chunk : std::max(count, 1u);
    paths.take(base::is_shared(tasks, count, overlaps_per_chunk), Path::overlaps_by_one,
               Path::overlaps_by_workers);
    kept_of_chunk.resize((count + chunk - 1) / chunk);
    base::for_all_chunks(tasks, count, chunk, [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
        ProxyPair* kept = merged.data() + first;
        const ProxyPair* const end = leaf_pairs.data() + last;
        for (const ProxyPair* pair = leaf_pairs.data() + first; pair != end;) {
            const std::uint32_t a = pair->a;
            const Bounds bounds = exact[a];
            do {
                *kept = *pair;
                kept += overlap(bounds, exact[pair->b]) ? 1 : 0;
            } while (++pair != end && pair->a == a);
        }
        kept_of_chunk[first / chunk] = static_cast<std::uint32_t>(kept - merged.data()) - first;
    });
    std::size_t sum = 0;
    for (const std::uint32_t kept : kept_of_chunk) sum += kept;
    base::make_room(out, sum);
    out.clear();
    for (std::size_t i = 0; i < kept_of_chunk.size(); ++i)
        out.insert(out.end(), merged.data() + i * chunk, merged.data() + i * chunk + kept_of_chunk[i]);
}

bool BroadPhase::find_leaf_pairs(std::size_t leaf_pairs_max, const PairFilter& filter, bool is_other,
                                 Tasks* tasks) {
    found.clear();
    std::erase_if(barred, [&](ProxyPair pair) { return is_fresh(pair); });
    if (is_other) ask_again(filter);
    bool are_few = find_fresh_pairs(leaf_pairs_max, filter, tasks);
    if (are_few) {
        merge_found();
        are_few = leaf_pairs.size() + barred.size() <= leaf_pairs_max;
    }
    if (!are_few) leaf_pairs.clear(), barred.clear();
    return are_few;
}

void BroadPhase::ask_again(const PairFilter& filter) {
    std::erase_if(barred, [&](ProxyPair pair) {
        if (!filter.allows(pair)) return false;
        found.push_back(pair);
        return true;
    });
    std::erase_if(leaf_pairs, [&](ProxyPair pair) {
        if (is_fresh(pair) || filter.allows(pair)) return false;
        barred.push_back(pair);
        return true;
    });
}

void BroadPhase::find_first_pairs(std::vector<ProxyPair>& out, std::size_t count_max,
                                  const std::function<bool(ProxyPair)>& is_wanted) {
    LOCKSTONE_ASSERT(moved.empty(), moved.size(), " proxies that the trees do not know yet");
    out.clear();
    for (std::uint32_t a = 0; a < entries.size() && out.size() < count_max; ++a) {
        if (!entries[a].present) continue;
        const Bounds& bounds = exact_bounds[a];
        const auto meets = [&](const Bounds& other) { return overlap(other, bounds); };
        const std::ptrdiff_t before = std::ssize(out);
        const auto add = [&](std::uint32_t b) {
            if (b > a && !never_meet(a, b) && meets(exact_bounds[b]) && is_wanted({a, b}))
                out.push_back({a, b});
        };
        moving.query_if(meets, open, add);
        if (!entries[a].is_static) fixed.query_if(meets, open, add);
        std::sort(out.begin() + before, out.end());
    }
    out.resize(std::min(out.size(), count_max));
}

namespace {

ProxyPair ordered(std::uint32_t x, std::uint32_t y) { return x < y ? ProxyPair{x, y} : ProxyPair{y, x}; }

} // namespace

void BroadPhase::change_kind(std::uint32_t proxy) {
    Entry& entry = entries[proxy];
    entry.never_moves = !entry.never_moves;
    if (entry.present) make_fresh(proxy);
}

/// A level of a game consists of many leaves that never move, and few others. When many of them are fresh, it costs
/// less when the others search.
std::span<const std::uint32_t> BroadPhase::choose_searchers() {
    std::uint32_t still = 0, others = 0;
    for (const std::uint32_t proxy : changed)
        if (entries[proxy].present && entries[proxy].never_moves) ++still;
    others_search = still >= still_leaves_least && std::size_t{still} * 32 >= entries.size();
    if (!others_search) return changed;
    for (const Entry& entry : entries) others += entry.present && !entry.never_moves ? 1 : 0;
    others_search = others < still;
    if (!others_search) return changed;
    searchers.clear();
    base::make_room(searchers, others);
    for (std::uint32_t proxy = 0; proxy < entries.size(); ++proxy)
        if (entries[proxy].present && !entries[proxy].never_moves) searchers.push_back(proxy);
    return searchers;
}

bool BroadPhase::adds_pair(std::uint32_t proxy, std::uint32_t other) const {
    const Entry &own = entries[proxy], &its = entries[other];
    if (others_search && its.never_moves) return own.fresh || its.fresh; // only the own search finds the pair
    return own.fresh && !(its.fresh && other < proxy);
}

void BroadPhase::find_pairs_of(std::uint32_t proxy, const PairFilter& filter, std::vector<ProxyPair>& allowed,
                               std::vector<ProxyPair>& forbidden,
                               std::vector<BoundsTree::NodeId>& own) const {
    const Entry& entry = entries[proxy];
    if (!entry.present) return;
    const auto meets = [leaf = entry.leaf_bounds](const Bounds& other) { return overlap(other, leaf); };
    const auto add = [&](std::uint32_t other) {
        if (never_meet(proxy, other) || !adds_pair(proxy, other)) return;
        const ProxyPair pair = ordered(proxy, other);
        (filter.allows(pair) ? allowed : forbidden).push_back(pair);
    };
    moving.query_if(meets, own, [&](std::uint32_t other) {
        if (other != proxy) add(other);
    });
    if (!entry.is_static) fixed.query_if(meets, own, add);
}

bool BroadPhase::find_fresh_pairs(std::size_t found_max, const PairFilter& filter, Tasks* tasks) {
    constexpr std::uint32_t chunk = fresh_per_chunk;
    const std::span<const std::uint32_t> searching = choose_searchers();
    const std::uint32_t count = static_cast<std::uint32_t>(searching.size());
    const bool is_shared = base::is_shared(tasks, count, chunk);
    paths.take(is_shared, Path::fresh_pairs_by_one, Path::fresh_pairs_by_workers);
    if (!is_shared) {
        for (std::uint32_t proxy : searching) {
            find_pairs_of(proxy, filter, found, barred, open);
            if (found.size() + barred.size() > found_max) return false;
        }
        return true;
    }
    if (fresh_of_chunk.size() < (count + chunk - 1) / chunk)
        fresh_of_chunk.resize((count + chunk - 1) / chunk);
    base::for_all_chunks(tasks, count, chunk, [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
        FreshPairs& own = fresh_of_chunk[first / chunk];
        own.found.clear(), own.barred.clear();
        for (std::uint32_t i = first; i < last && own.found.size() + own.barred.size() <= found_max; ++i)
            find_pairs_of(searching[i], filter, own.found, own.barred, own.open);
    });
    for (std::uint32_t first = 0; first < count; first += chunk) {
        const FreshPairs& own = fresh_of_chunk[first / chunk];
        found.insert(found.end(), own.found.begin(), own.found.end());
        barred.insert(barred.end(), own.barred.begin(), own.barred.end());
        if (found.size() + barred.size() > found_max) return false;
    }
    return true;
}

void BroadPhase::merge_found() {
    std::sort(found.begin(), found.end());
    const std::size_t most = leaf_pairs.size() + found.size();
    // Both vectors, because they are swapped: else the number of swaps would decide when memory is allocated.
    base::make_room(merged, most), base::make_room(leaf_pairs, most);
    merged.resize(most);
    ProxyPair* end = merged.data();
    auto next = found.begin();
    for (const ProxyPair& pair : leaf_pairs) {
        if (is_fresh(pair)) continue;
        while (next != found.end() && *next < pair) *end++ = *next++;
        *end++ = pair;
    }
    end = std::copy(next, found.end(), end);
    merged.resize(static_cast<std::size_t>(end - merged.data()));
    leaf_pairs.swap(merged);
}

template <class MayMeetNode, class MayMeet>
void BroadPhase::query_if(MayMeetNode&& may_meet_node, MayMeet&& may_meet,
                          std::vector<BoundsTree::NodeId>& own, std::vector<std::uint32_t>& out) const {
    out.clear();
    const auto add = [&](std::uint32_t proxy) {
        if (may_meet(exact_bounds[proxy])) out.push_back(proxy);
    };
    moving.query_if(may_meet_node, own, add);
    fixed.query_if(may_meet_node, own, add);
    std::sort(out.begin(), out.end());
}

void BroadPhase::query(const Bounds& bounds, std::vector<std::uint32_t>& out) {
    update_trees();
    const auto meets = [&](const Bounds& b) { return overlap(b, bounds); };
    query_if(meets, meets, open, out);
}

void BroadPhase::query(const SweptBox& box, std::vector<std::uint32_t>& out) {
    update_trees();
    query_if([&](const Bounds& b) { return box.may_meet_node(b); },
             [&](const Bounds& b) { return box.may_meet(b); }, open, out);
}

void BroadPhase::query(const SweptBox& box, Asker& asker) const {
    LOCKSTONE_ASSERT(moved.empty(), moved.size(), " proxies that the trees do not know yet");
    query_if([&](const Bounds& b) { return box.may_meet_node(b); },
             [&](const Bounds& b) { return box.may_meet(b); }, asker.open, asker.proxies);
}

void BroadPhase::query(const Bounds& bounds, Asker& asker) const {
    LOCKSTONE_ASSERT(moved.empty(), moved.size(), " proxies that the trees do not know yet");
    const auto meets = [&](const Bounds& b) { return overlap(b, bounds); };
    query_if(meets, meets, asker.open, asker.proxies);
}

const WideTree* BroadPhase::prepare_query() {
    LOCKSTONE_ASSERT(moved.empty(), moved.size(), " proxies that the trees do not know yet");
    const std::uint32_t repaid = (moving.leaf_count() + fixed.leaf_count()) / leaves_per_query + queries_min;
    if (prepared <= repaid && ++prepared > repaid) wide_tree.build(moving, fixed);
    return wide_tree.is_empty() ? nullptr : &wide_tree;
}

void BroadPhase::query(const SweptBox& box, const WideTree* wide, Asker& asker) const {
    if (wide == nullptr) return query(box, asker);
    asker.proxies.clear();
    wide->visit(box, asker.open, [&](std::uint32_t proxy) {
        if (box.may_meet(exact_bounds[proxy])) asker.proxies.push_back(proxy);
    });
    std::sort(asker.proxies.begin(), asker.proxies.end());
}

void BroadPhase::query(const Bounds& bounds, const WideTree* wide, Asker& asker) const {
    if (wide == nullptr) return query(bounds, asker);
    asker.proxies.clear();
    wide->visit(bounds, asker.open, [&](std::uint32_t proxy) {
        if (overlap(exact_bounds[proxy], bounds)) asker.proxies.push_back(proxy);
    });
    std::sort(asker.proxies.begin(), asker.proxies.end());
}

void BroadPhase::query_static(const SweptBox& box, Asker& asker) const {
    LOCKSTONE_ASSERT(moved.empty(), moved.size(), " proxies that the trees do not know yet");
    asker.proxies.clear();
    fixed.query_if([&](const Bounds& b) { return box.may_meet_node(b); }, asker.open,
                   [&](std::uint32_t proxy) {
                       if (box.may_meet(exact_bounds[proxy])) asker.proxies.push_back(proxy);
                   });
    std::sort(asker.proxies.begin(), asker.proxies.end());
}

// ---- for tests -------------------------------------------------------------------------------------------------

void BroadPhase::make_fresh(std::uint32_t proxy) {
    if (!entries[proxy].fresh) changed.push_back(proxy);
    entries[proxy].fresh = true;
}

void BroadPhase::take_leaves(bool is_fixed) {
    leaves.clear();
    tree_of(is_fixed).for_each_leaf([&](BoundsTree::NodeId, const BoundsTree::Node& leaf) {
        leaves.push_back({leaf.bounds, leaf.proxy()});
    });
}

void BroadPhase::rebuild_trees(Random& random) {
    update_trees();
    drop_wide_tree();
    for (const bool is_fixed : {false, true}) {
        BoundsTree& tree = tree_of(is_fixed);
        take_leaves(is_fixed);
        for (BoundsTree::Leaf& leaf : leaves) make_fresh(leaf.proxy);
        tree.rebuild_at_random(leaves, random);
        if (random.next_u32() % 2 == 0) { // `leaves` is in random order now
            tree.clear();
            for (const BoundsTree::Leaf& leaf : leaves) tree.insert(leaf.bounds, leaf.proxy);
        }
        note_leaves(is_fixed);
    }
    for (std::size_t i = changed.size(); i > 1; --i)
        std::swap(changed[i - 1], changed[random.next_u32() % i]);
}

void BroadPhase::forget_pairs(Random& random) {
    update_trees();
    drop_wide_tree();
    for (const bool is_fixed : {false, true}) {
        take_leaves(is_fixed);
        for (BoundsTree::Leaf& leaf : leaves)
            if (random.next_u32() % 2 == 0) make_fresh(leaf.proxy);
        tree_of(is_fixed).rebuild_at_random(leaves, random);
        note_leaves(is_fixed);
    }
}

} // namespace lockstone::collide
