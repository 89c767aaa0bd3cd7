// The broad phase: finds the pairs of proxies whose bounds overlap.
//
// It is a cache and not part of the state. The pairs it returns depend only on the bounds and kinds of the
// proxies, not on the order or number of the calls that set them. It can therefore be discarded, rebuilt or
// kept at any tick.
#pragma once

#include "base/assert.h"
#include "base/paths.h"
#include "collide/broad/tree.h"
#include "collide/broad/wide_tree.h"
#include "collide/swept_box.h"
#include "lockstone/tasks.h"

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace lockstone::collide {

/// Two proxies, a < b.
struct ProxyPair {
    std::uint32_t a, b;

    friend constexpr auto operator<=>(const ProxyPair&, const ProxyPair&) = default;
};

/// Excludes pairs of proxies that never collide, at any positions.
struct PairFilter {
    /// Called, possibly by several workers at once, for two proxies whose leaves begin to overlap. The broad
    /// phase caches the result. Empty: every pair may collide.
    std::function<bool(ProxyPair)> may_meet;
    /// The filter may return other results than in the last call: the broad phase calls it again for all cached
    /// pairs.
    bool is_new = false;

    bool allows(ProxyPair pair) const { return !may_meet || may_meet(pair); }
};

inline constexpr Bound leaf_margin_default = decimal<Bound>("0.1"); ///< [m] while bounds are not shifted

class BroadPhase {
  public:
    /// Proxies are numbers below `proxy_capacity` (asserted). The constructor allocates memory for all of them,
    /// as `reserve` does. `margin`: the leaves of moving proxies extend beyond their bounds by this much. A
    /// larger margin means fewer tree updates and more pairs to filter.
    explicit BroadPhase(std::uint32_t proxy_capacity, Bound margin = leaf_margin_default);

    /// Raises the capacity for proxy numbers to `proxy_capacity`. Does nothing when the capacity is already as
    /// large.
    void grow(std::uint32_t proxy_capacity);
    /// Allocates memory for the trees and pairs of this many proxies, before the calls that need it.
    void reserve(std::uint32_t proxies);

    /// Inserts or moves a proxy, or changes its kind. Cheap while the bounds stay within the leaf. `motion`:
    /// the expected displacement until the next call; zero: the displacement since the last call is used
    /// instead.
    void set(std::uint32_t proxy, const Bounds& exact, bool is_static, const Vector3<Bound>& motion = {}) {
        if (is_static || !move_within(proxy, exact)) set_leaf(proxy, exact, is_static, motion);
    }
    /// Moves a proxy that is present, is not static and stays within its leaf. Returns false and changes
    /// nothing otherwise.
    bool move_within(std::uint32_t proxy, const Bounds& exact) {
        LOCKSTONE_ASSERT(proxy < entries.size(), "proxy ", proxy, ", capacity ", entries.size());
        Entry& entry = entries[proxy];
        if (!entry.present || entry.is_static || !collide::contains(entry.leaf_bounds, exact)) return false;
        exact_bounds[proxy] = exact;
        return true;
    }
    /// Pairs of two proxies that never move are excluded, as are pairs of two static ones. Unlike a static proxy,
    /// one that never moves has pairs with all others. Kept after remove(). Default, also after clear(): false.
    void set_never_moves(std::uint32_t proxy, bool never_moves) {
        if (entries[proxy].never_moves != never_moves) change_kind(proxy);
    }
    /// Does nothing for a proxy that is not present.
    void remove(std::uint32_t proxy);
    bool contains(std::uint32_t proxy) const { return proxy < entries.size() && entries[proxy].present; }
    void clear();

    /// Writes all pairs, not both static and not both never moving, whose exact bounds overlap (touching counts)
    /// and that `filter` allows, sorted by (a, b). The cost grows with the proxies that left their leaf since the
    /// last call, plus one test for each pair of overlapping leaves. Returns false and an empty list when more
    /// than `leaf_pairs_max` pairs of leaves overlap. The next call then searches for all pairs again.
    bool find_pairs(std::vector<ProxyPair>& out, std::size_t leaf_pairs_max = SIZE_MAX,
                    const PairFilter& filter = {}, Tasks* tasks = nullptr);
    /// For crowds with too many pairs for a list: writes the first `count_max` of all pairs for which
    /// `is_wanted` returns true. The trees must be up to date (asserted), as they are after `find_pairs`.
    void find_first_pairs(std::vector<ProxyPair>& out, std::size_t count_max,
                          const std::function<bool(ProxyPair)>& is_wanted);

    /// Writes all proxies whose exact bounds overlap `bounds`, sorted.
    void query(const Bounds& bounds, std::vector<std::uint32_t>& out);
    /// Writes all proxies whose exact bounds the moving box may meet, sorted.
    void query(const SweptBox& box, std::vector<std::uint32_t>& out);

    /// Memory for one of several concurrent queries.
    struct Asker {
        std::vector<BoundsTree::NodeId> open;
        std::vector<std::uint32_t> proxies; ///< the result of the query
    };
    /// As above, but safe for concurrent calls with one `Asker` each. The trees must be up to date (asserted).
    void query(const SweptBox& box, Asker& asker) const;
    void query(const Bounds& bounds, Asker& asker) const;
    /// As above, for static proxies only.
    void query_static(const SweptBox& box, Asker& asker) const;
    /// Applies all calls of `set` and `remove` to the trees.
    void update_trees();
    /// Counts a query that follows. Copies the trees to a wide tree once the queries since their last change repay
    /// this. Returns the copy, or null.
    const WideTree* prepare_query();
    /// As query(), with what prepare_query() returned since the trees were last updated; other calls of
    /// prepare_query() may run at the same time.
    void query(const SweptBox& box, const WideTree* wide, Asker& asker) const;
    void query(const Bounds& bounds, const WideTree* wide, Asker& asker) const;

    // ---- for tests: give the same proxies another history; no later result changes ----
    /// Rebuilds both trees in other shapes: inserts each leaf in random order, or splits at random. The next
    /// call searches for all pairs again.
    void rebuild_trees(Random& random);
    /// Drops the cached pairs of about half of the proxies, chosen at random, and rebuilds both trees at random.
    void forget_pairs(Random& random);

    /// Counts which code paths the calls took since the counters were last cleared.
    base::Paths paths;

    /// The exact bounds of a proxy that is present.
    const Bounds& bounds(std::uint32_t proxy) const { return exact_bounds[proxy]; }

  private:
    struct Entry {
        Bounds leaf_bounds;
        BoundsTree::NodeId leaf;
        bool present, is_static;
        bool in_fixed; ///< the tree that holds `leaf`: `fixed` or `moving`
        bool moved;    ///< the tree does not have its current leaf bounds yet
        bool stays;    ///< while the trees are updated: the leaf keeps its place in its tree
        bool fresh;    ///< dirty flag: `leaf_pairs` does not reflect its leaf yet
        bool never_moves;
    };
    static constexpr Entry absent{Bounds{}, BoundsTree::none, false, false, false, false, false, false,
                                  false};

    /// The trees change: a copy of them is no longer valid.
    void drop_wide_tree() { wide_tree.clear(), prepared = 0; }
    /// Writes the proxies whose exact bounds pass `may_meet`, sorted. Skips the subtrees whose bounds fail
    /// `may_meet_node`.
    template <class MayMeetNode, class MayMeet>
    void query_if(MayMeetNode&& may_meet_node, MayMeet&& may_meet, std::vector<BoundsTree::NodeId>& open,
                  std::vector<std::uint32_t>& out) const;
    void set_leaf(std::uint32_t proxy, const Bounds& exact, bool is_static, const Vector3<Bound>& motion);
    Bounds moving_leaf(const Vector3<Bound>& motion, const Bounds& exact) const;
    void note_move(std::uint32_t proxy) {
        Entry& entry = entries[proxy];
        if (!entry.moved) moved.push_back(proxy);
        if (!entry.fresh) changed.push_back(proxy);
        entry.moved = entry.fresh = true;
    }
    /// True when the proxy's leaf may keep its place in its tree and only take other bounds.
    bool may_stay(const Entry& entry) const;
    /// Writes the bounds of the leaves that keep their place; `count` is their number.
    void move_leaves(bool is_fixed, std::uint32_t count);
    void rebuild(bool is_fixed);
    /// Copies the leaves of an up-to-date tree to `leaves`.
    void take_leaves(bool is_fixed);
    /// Stores the leaf of each proxy after a tree was rebuilt.
    void note_leaves(bool is_fixed);
    void make_fresh(std::uint32_t proxy);
    void insert_moved(bool is_fixed);
    BoundsTree& tree_of(bool is_fixed) { return is_fixed ? fixed : moving; }
    const BoundsTree& tree_of(bool is_fixed) const { return is_fixed ? fixed : moving; }
    bool is_fresh(ProxyPair pair) const { return entries[pair.a].fresh || entries[pair.b].fresh; }
    void change_kind(std::uint32_t proxy);
    bool never_meet(std::uint32_t a, std::uint32_t b) const {
        return entries[a].never_moves && entries[b].never_moves;
    }
    /// The leaves that search for the pairs of all leaves that changed. Sets `others_search`.
    std::span<const std::uint32_t> choose_searchers();
    /// Returns true if the search of `proxy` adds its pair with `other`. Exactly one of the two searches does, for
    /// a pair with a fresh leaf.
    bool adds_pair(std::uint32_t proxy, std::uint32_t other) const;
    /// Finds the pairs of all leaves that changed. Returns false when there are more than `found_max`.
    bool find_fresh_pairs(std::size_t found_max, const PairFilter& filter, Tasks* tasks);
    /// Appends the pairs of one leaf to `allowed` and `forbidden`; `own` is scratch.
    void find_pairs_of(std::uint32_t proxy, const PairFilter& filter, std::vector<ProxyPair>& allowed,
                       std::vector<ProxyPair>& forbidden, std::vector<BoundsTree::NodeId>& own) const;
    bool find_leaf_pairs(std::size_t leaf_pairs_max, const PairFilter& filter, bool is_other, Tasks* tasks);
    /// Runs the filter again for all cached pairs except those of fresh leaves.
    void ask_again(const PairFilter& filter);
    /// Replaces the cached pairs of fresh leaves by the pairs found.
    void merge_found();
    void keep_overlaps(std::vector<ProxyPair>& out, Tasks* tasks);

    std::vector<Entry> entries; // by proxy
    // By proxy, apart from `entries`: most tests of leaf pairs in a tick read only this.
    std::vector<Bounds> exact_bounds;
    BoundsTree moving, fixed;
    Bound margin;
    WideTree wide_tree;                 // a copy of both trees, or empty
    std::uint32_t prepared = 0;         // queries since the trees changed
    std::vector<std::uint32_t> moved;   // since the trees were updated
    std::vector<std::uint32_t> changed; // since the pairs were found
    std::vector<ProxyPair> leaf_pairs;  // pairs of overlapping leaves, sorted: a superset of the result
    std::vector<ProxyPair> barred;      // pairs of overlapping leaves that the filter excludes, unsorted
    bool is_filtered = false;           // the last call had a filter
    bool gave_up = false; // the last call found too many leaf pairs, so the cached pairs are invalid
    // scratch
    std::vector<ProxyPair> found, merged;
    std::vector<std::uint32_t> searchers;
    /// The proxies that never move do not search in this call: all others search for their pairs.
    bool others_search = false;
    std::vector<BoundsTree::NodeId> open;
    std::vector<BoundsTree::Leaf> leaves;
    /// The pairs that one worker finds for a chunk of the changed leaves.
    struct FreshPairs {
        std::vector<ProxyPair> found, barred;
        std::vector<BoundsTree::NodeId> open;
    };
    std::vector<FreshPairs> fresh_of_chunk;
    // For each chunk: how many pairs of `merged` overlap.
    std::vector<std::uint32_t> kept_of_chunk;
};

} // namespace lockstone::collide
