// A binary tree of bounds with one leaf per proxy. Leaves change one by one, or the whole tree is rebuilt.
//
// The shape of the tree depends on history. No result may: callers filter the leaves it visits by exact bounds
// and sort them.
#pragma once

#include "collide/bounds.h"
#include "lockstone/math/random.h"

#include <cstdint>
#include <vector>

namespace lockstone::collide {

class BoundsTree {
  public:
    using NodeId = std::int32_t;
    static constexpr NodeId none = -1;

    /// A leaf has no children: child[0] is `none` and child[1] is its proxy.
    struct Node {
        Bounds bounds;
        NodeId parent;
        NodeId child[2];

        bool is_leaf() const { return child[0] == none; }
        std::uint32_t proxy() const { return static_cast<std::uint32_t>(child[1]); }
    };
    struct Leaf {
        Bounds bounds;
        std::uint32_t proxy;
    };

    BoundsTree();

    void reserve(std::uint32_t leaves);

    /// Inserts a leaf where it adds least surface to the tree.
    NodeId insert(const Bounds& bounds, std::uint32_t proxy);
    void remove(NodeId leaf);
    void clear();
    /// Replaces the whole tree by a new tree of these leaves, and reorders `leaves`. Ids of leaves change:
    /// see `for_each_leaf`. For n leaves it costs about as much as n / 16 insertions and removals.
    void rebuild(std::vector<Leaf>& leaves);
    /// True while the surface of the nodes has grown by at most a quarter since rebuild(): leaves may then keep
    /// their place when they move.
    bool is_tight() const { return area_max > 0 && area <= area_max; }
    /// Changes the bounds of a leaf and of its ancestors. Costs about a twentieth of a removal and an
    /// insertion.
    void move(NodeId leaf, const Bounds& bounds);
    /// True while no leaf was inserted or removed since rebuild(): set_leaf() and refit() may then replace many
    /// moves.
    bool can_refit() const { return is_ordered; }
    /// Changes the bounds of a leaf only; the caller must call refit() afterwards.
    void set_leaf(NodeId leaf, const Bounds& bounds);
    /// Recomputes the bounds of all inner nodes in place. For n leaves it costs about as much as n / 8 moves.
    void refit();
    /// For tests: a tree of these leaves with random shape and random neighbours.
    void rebuild_at_random(std::vector<Leaf>& leaves, Random& random);

    NodeId root() const { return top; }
    const Node& node(NodeId id) const { return nodes[static_cast<std::size_t>(id)]; }

    std::uint32_t leaf_count() const { return leaf_total; }

    /// Calls visit(id, node) for every leaf, in no particular order.
    template <class Visit> void for_each_leaf(Visit&& visit) const {
        for (std::size_t i = 0; i < nodes.size(); ++i)
            if (nodes[i].is_leaf() && nodes[i].parent != free_mark) visit(static_cast<NodeId>(i), nodes[i]);
    }
    /// Calls visit(proxy) for every leaf for which may_meet(bounds) is true, for the leaf and all its
    /// ancestors, in the tree's order. `open` is scratch memory of the caller: concurrent queries are safe,
    /// each with its own.
    template <class MayMeet, class Visit>
    void query_if(MayMeet&& may_meet, std::vector<NodeId>& open, Visit&& visit) const;

  private:
    static constexpr NodeId free_mark = -2;

    struct Range { // a range of leaves whose subtree becomes a child of `parent`
        std::uint32_t begin, end;
        NodeId parent;
        int side;
        Bounds cell; ///< holds the centres of the leaves
    };

    Node& at(NodeId id) { return nodes[static_cast<std::size_t>(id)]; }
    NodeId take_node();
    void free_node(NodeId id);
    NodeId best_sibling(const Bounds& bounds) const;
    /// Recomputes bounds from `id` up to the root, and rotates where that makes the tree tighter.
    void refit_up(NodeId id);
    void merge_children(NodeId id);
    void set_bounds(Node& n, const Bounds& bounds); ///< for inner nodes; keeps `area` up to date
    void merge_all(); ///< recomputes all inner nodes; requires each node to precede its children
    void rotate(NodeId id);
    void swap_with_grandchild(NodeId id, int side, int grandchild);
    /// Builds the tree top down. split(first, last, cells) may reorder the leaves in [first, last), and returns
    /// the start of the second child's leaves. cells[0] and cells[1] are both the cell of these leaves; split()
    /// may shrink them to cells of the first and of the second child's leaves.
    template <class Split> void rebuild_by(std::vector<Leaf>& leaves, Split&& split);

    std::vector<Node> nodes;
    // A free node has `free_mark` as parent, and the next free node as child[1].
    NodeId top = none, free_list = none;
    std::uint32_t leaf_total = 0;
    bool is_ordered = false; ///< each node precedes its children in `nodes`
    std::int64_t area = 0,
                 /// Half the surface of all inner nodes, and its limit in is_tight(), in units of 2^22 square
        /// steps.
        area_max = 0;
    std::vector<Range> ranges; // scratch
};

template <class MayMeet, class Visit>
void BoundsTree::query_if(MayMeet&& may_meet, std::vector<NodeId>& open, Visit&& visit) const {
    open.clear();
    NodeId id = top;
    while (id != none) {
        const Node& n = node(id);
        id = none;
        if (may_meet(n.bounds)) {
            if (n.is_leaf()) {
                visit(n.proxy());
            } else {
                open.push_back(n.child[0]);
                id = n.child[1];
            }
        }
        if (id == none && !open.empty()) {
            id = open.back();
            open.pop_back();
        }
    }
}

} // namespace lockstone::collide
