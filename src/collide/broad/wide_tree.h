// A copy of the trees of the broad phase for many queries between two changes: eight boxes side by side in each node,
// in steps of 16 bits. A compiler tests all eight at once.
//
// The boxes are rounded outward, so a query visits all leaves that the trees would give it, and a few more. Callers
// filter them by exact bounds.
//
// source: Wald et al., Getting Rid of Packets, 2008 (nodes of many children, collapsed from a binary tree)
#pragma once

#include "collide/broad/tree.h"
#include "collide/swept_box.h"

#include <bit>
#include <cstdint>
#include <vector>

namespace lockstone::collide {

class WideTree {
  public:
    /// Copies the leaves of two trees.
    void build(const BoundsTree& first, const BoundsTree& second);
    void clear() { groups.clear(); }
    /// Empty after clear(), and after build() when the leaves are too small for the steps, which depend on the size of
    /// the whole.
    bool is_empty() const { return groups.empty(); }

    /// Calls visit(proxy) for all leaves that a box overlaps, and for a few others, in no particular order. `open` is
    /// scratch memory.
    template <class Visit>
    void visit(const Bounds& bounds, std::vector<BoundsTree::NodeId>& open, Visit&& visit) const {
        const Box box = box_of(bounds);
        walk([&box](const Group& group) { return overlaps(group, box); }, open, visit);
    }
    /// As above, for leaves that a moving box meets.
    template <class Visit>
    void visit(const SweptBox& swept, std::vector<BoundsTree::NodeId>& open, Visit&& visit_leaf) const {
        Path path;
        if (!find_path(swept, path)) return visit(swept.bounds(), open, visit_leaf);
        walk([&path](const Group& group) { return meets(group, path); }, open, visit_leaf);
    }

  private:
    static constexpr std::uint32_t width = 8;
    using NodeId = BoundsTree::NodeId;

    /// Eight boxes, in steps of 2^shift from `origin`, rounded down. A child is a group, or ~proxy of a leaf.
    struct alignas(64) Group {
        std::int16_t lower[3][width], upper[3][width];
        std::int32_t child[width];
    };
    struct Box {
        std::int16_t lower[3], upper[3];
    };
    /// One number in all lanes.
    struct Lanes {
        Lanes& operator=(std::int64_t x) {
            for (std::int16_t& lane : of) lane = static_cast<std::int16_t>(x);
            return *this;
        }
        alignas(16) std::int16_t of[width];
    };
    /// The path of a moving box, as a function of its place along the axis on which it moves furthest.
    struct Path {
        int axis[3];                 ///< first the axis on which it moves furthest
        Lanes begin, end, size;      ///< along this axis
        Lanes slope_15[2];           ///< of the other axes
        Lanes lowest[2], highest[2]; ///< of the box on the other axes, where its place on the first axis is 0
    };
    /// A node of a binary tree.
    struct Source {
        const BoundsTree* tree;
        NodeId id;
        const BoundsTree::Node& node() const { return tree->node(id); }
    };
    struct Waiting { // the node will become a group: child `slot` of `group`
        Source from;
        std::uint32_t group, slot;
    };

    template <class HitsOf, class Visit>
    void walk(HitsOf&& hits_of, std::vector<NodeId>& open, Visit&& visit) const {
        open.clear();
        NodeId id = 0;
        while (true) {
            const Group& group = groups[static_cast<std::size_t>(id)];
            for (std::uint32_t hits = hits_of(group); hits != 0; hits &= hits - 1) {
                const std::int32_t child = group.child[std::countr_zero(hits)];
                if (child < 0)
                    visit(static_cast<std::uint32_t>(~child));
                else
                    open.push_back(child);
            }
            if (open.empty()) return;
            id = open.back();
            open.pop_back();
        }
    }
    /// Chooses the steps. Returns false when there are no leaves.
    bool start(const BoundsTree& first, const BoundsTree& second);
    void add_group(Source (&from)[width], std::uint32_t count);
    std::int64_t steps_of(Bound x, int axis) const { return (std::int64_t{x.raw} - origin[axis]) >> shift; }
    Box box_of(const Bounds& bounds) const;
    /// Returns false for a box that is large or at the border of the range.
    bool find_path(const SweptBox& swept, Path& path) const;

    /// Returns bit k when box k overlaps.
    [[gnu::noinline]] static std::uint32_t overlaps(const Group& group, const Box& box);
    [[gnu::noinline]] static std::uint32_t meets(const Group& group, const Path& path);

    std::vector<Group> groups; ///< the first one is the root
    std::int64_t origin[3] = {};
    int shift = 0;
    std::uint64_t leaf_count = 0, leaf_steps = 0; ///< the sum of the longest sides of the leaves
    std::vector<Waiting> waiting;                 // scratch
};

} // namespace lockstone::collide
