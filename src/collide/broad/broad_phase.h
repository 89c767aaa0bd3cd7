// Finds the pairs of proxies whose bounds overlap.
//
// A cache, never state: what it returns depends on the proxies' bounds and kinds alone, not on the order or number of
// calls that set them, so it can be thrown away, rebuilt or left as it is at any tick.
#pragma once

#include "base/assert.h"
#include "base/paths.h"
#include "collide/broad/tree.h"
#include "collide/swept_box.h"
#include "lockstone/tasks.h"

#include <cstdint>
#include <functional>
#include <vector>

namespace lockstone::collide {

/// Two proxies, a < b.
struct ProxyPair {
    std::uint32_t a, b;

    friend constexpr auto operator<=>(const ProxyPair&, const ProxyPair&) = default;
};

/// Which pairs are left out wherever the two are.
struct PairFilter {
    /// Asked of two proxies when their leaves come to overlap, by several workers, and remembered; empty: all may meet
    std::function<bool(ProxyPair)> may_meet;
    bool is_new = false; ///< it may say otherwise than in the last call: what was remembered is asked again

    bool allows(ProxyPair pair) const { return !may_meet || may_meet(pair); }
};

inline constexpr Bound leaf_margin_default = decimal<Bound>("0.1"); ///< [m] while bounds are not shifted

class BroadPhase {
  public:
    /// Proxies are numbers below `proxy_capacity` (asserted); memory for them is taken here, as by `reserve`. `margin` is
    /// how far the leaves of moving proxies reach beyond their bounds: larger means fewer tree updates and more pairs to
    /// filter.
    explicit BroadPhase(std::uint32_t proxy_capacity, Bound margin = leaf_margin_default);

    /// Proxies may be numbers below `proxy_capacity` from now on, if that is more than before.
    void grow(std::uint32_t proxy_capacity);
    /// Takes memory for trees and pairs of so many proxies ahead of the calls that need it.
    void reserve(std::uint32_t proxies);

    /// Inserts or moves a proxy, or changes its kind. Costs next to nothing while the bounds stay within the leaf. `motion`: how far
    /// it will go by the next call, as far as is known; zero: as far as since the last one.
    void set(std::uint32_t proxy, const Bounds& exact, bool is_static, const Vector3<Bound>& motion = {}) {
        if (is_static || !move_within(proxy, exact)) set_leaf(proxy, exact, is_static, motion);
    }
    /// Moves a proxy that is there, is not static and stays within its leaf. False: it is otherwise, and nothing was done.
    bool move_within(std::uint32_t proxy, const Bounds& exact) {
        LOCKSTONE_ASSERT(proxy < entries.size(), "proxy ", proxy, ", capacity ", entries.size());
        Entry& entry = entries[proxy];
        if (!entry.present || entry.is_static || !collide::contains(entry.leaf_bounds, exact)) return false;
        exact_bounds[proxy] = exact;
        return true;
    }
    /// Does nothing for a proxy that is not there.
    void remove(std::uint32_t proxy);
    bool contains(std::uint32_t proxy) const { return proxy < entries.size() && entries[proxy].present; }
    void clear();

    /// All pairs, not both static, whose exact bounds overlap (touching counts) and that `filter` allows, sorted by (a, b).
    /// Costs what moved out of its leaf since the last call, and a test for each pair of overlapping leaves. False, and
    /// nothing found, when more than `leaf_pairs_max` leaves overlap: then the next call finds all pairs anew.
    bool find_pairs(std::vector<ProxyPair>& out, std::size_t leaf_pairs_max = SIZE_MAX,
                    const PairFilter& filter = {}, Tasks* tasks = nullptr);
    /// For crowds, in which the pairs are too many to be listed: the first `count_max` of all pairs that
    /// `is_wanted`. The trees have to be up to date (asserted), as they are after `find_pairs`.
    void find_first_pairs(std::vector<ProxyPair>& out, std::size_t count_max,
                          const std::function<bool(ProxyPair)>& is_wanted);

    /// All proxies whose exact bounds overlap, sorted.
    void query(const Bounds& bounds, std::vector<std::uint32_t>& out);
    /// All proxies whose exact bounds a moving box may meet, sorted.
    void query(const SweptBox& box, std::vector<std::uint32_t>& out);

    /// What one of several that ask at once needs for itself.
    struct Asker {
        std::vector<BoundsTree::NodeId> open;
        std::vector<std::uint32_t> proxies; ///< the answer
    };
    /// As above, which several may ask at once: the trees have to be up to date (asserted).
    void query(const SweptBox& box, Asker& asker) const;
    void query(const Bounds& bounds, Asker& asker) const;
    /// The same of static proxies alone.
    void query_static(const SweptBox& box, Asker& asker) const;
    /// Brings the trees up to date with the proxies that were set.
    void update_trees();

    // ---- for tests: another history of the same proxies; nothing that is asked for later changes ----
    /// Trees of other shapes: each leaf inserted in random order, or wholly at random. All pairs are found anew.
    void rebuild_trees(Random& random);
    /// Forgets the pairs of about half of the proxies, chosen at random.
    void forget_pairs(Random& random);

    /// The paths that calls took since they were last cleared.
    base::Paths paths;

    /// Of a proxy that is there.
    const Bounds& bounds(std::uint32_t proxy) const { return exact_bounds[proxy]; }

  private:
    struct Entry {
        Bounds leaf_bounds;
        BoundsTree::NodeId leaf;
        bool present, is_static;
        bool in_fixed; ///< where `leaf` is
        bool moved;    ///< the tree does not know of its leaf bounds yet
        bool stays;    ///< while trees are updated: in its place there
        bool fresh;    ///< `leaf_pairs` does not know of its leaf yet
    };
    static constexpr Entry absent{Bounds{}, BoundsTree::none, false, false, false, false, false, false};

    /// The proxies of which `may_meet` holds, found by what holds of a tree's nodes.
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
    /// Whether the leaf of a proxy may stay where it is in a tree, and take other bounds there.
    bool may_stay(const Entry& entry) const;
    void move_leaves(bool is_fixed, std::uint32_t count); ///< of those that stay, which are so many
    void rebuild(bool is_fixed);
    void take_leaves(bool is_fixed); ///< of a tree that is up to date
    void note_leaves(bool is_fixed); ///< where they are in a tree that was made anew
    void make_fresh(std::uint32_t proxy);
    void insert_moved(bool is_fixed);
    BoundsTree& tree_of(bool is_fixed) { return is_fixed ? fixed : moving; }
    const BoundsTree& tree_of(bool is_fixed) const { return is_fixed ? fixed : moving; }
    bool is_fresh(ProxyPair pair) const { return entries[pair.a].fresh || entries[pair.b].fresh; }
    /// Those of leaves that changed. False when there are more than `found_max`.
    bool find_fresh_pairs(std::size_t found_max, const PairFilter& filter, Tasks* tasks);
    /// Those of one leaf, added at the ends; `own` is scratch.
    void find_pairs_of(std::uint32_t proxy, const PairFilter& filter, std::vector<ProxyPair>& allowed,
                       std::vector<ProxyPair>& forbidden, std::vector<BoundsTree::NodeId>& own) const;
    bool find_leaf_pairs(std::size_t leaf_pairs_max, const PairFilter& filter, bool is_other, Tasks* tasks);
    void ask_again(const PairFilter& filter); ///< of all pairs but those of fresh leaves
    void merge_found();                       ///< in place of the pairs of fresh leaves
    void keep_overlaps(std::vector<ProxyPair>& out, Tasks* tasks);

    std::vector<Entry> entries;       // by proxy
    std::vector<Bounds> exact_bounds; // likewise: all that is asked of most pairs of leaves in a tick
    BoundsTree moving, fixed;
    Bound margin;
    std::vector<std::uint32_t> moved;   // since the trees were updated
    std::vector<std::uint32_t> changed; // since the pairs were found
    std::vector<ProxyPair> leaf_pairs;  // whose leaves overlap, sorted: a superset of the answer
    std::vector<ProxyPair> barred;      // likewise of those that may not meet, in no order
    bool is_filtered = false;           // the last call had a filter
    bool gave_up = false;               // the pairs of leaves were too many, and are not known
    // scratch
    std::vector<ProxyPair> found, merged;
    std::vector<BoundsTree::NodeId> open;
    std::vector<BoundsTree::Leaf> leaves;
    /// Of some leaves that changed, as a worker finds them.
    struct FreshPairs {
        std::vector<ProxyPair> found, barred;
        std::vector<BoundsTree::NodeId> open;
    };
    std::vector<FreshPairs> fresh_of_chunk;
    std::vector<std::uint32_t> kept_of_chunk; // pairs of `merged`, while they are shared out
};

} // namespace lockstone::collide
