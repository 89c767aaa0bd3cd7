// A binary tree of bounds with one leaf per proxy, changed leaf by leaf or rebuilt as a whole.
//
// Its shape depends on history and on nothing else may that show: callers filter what it yields by exact bounds and
// sort it.
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

    /// A leaf where it makes the tree grow least.
    NodeId insert(const Bounds& bounds, std::uint32_t proxy);
    void remove(NodeId leaf);
    void clear();
    /// A balanced tree of these leaves in place of what there was; reorders `leaves`. Ids of leaves change: see
    /// `for_each_leaf`. For n leaves it costs about as much as n / 16 insertions and removals.
    void rebuild(std::vector<Leaf>& leaves);
    /// Whether its nodes have spread by no more than a quarter since rebuild(): then leaves may move where they are.
    bool is_tight() const { return area_max > 0 && area <= area_max; }
    /// Other bounds of a leaf, and of the nodes above it. Costs about a twentieth of removing and inserting it.
    void move(NodeId leaf, const Bounds& bounds);
    /// Whether no leaf has come or gone since rebuild(): then set_leaf() and refit() may take the place of many moves.
    bool can_refit() const { return is_ordered; }
    /// Other bounds of a leaf; refit() is to follow.
    void set_leaf(NodeId leaf, const Bounds& bounds);
    /// The nodes above all leaves, in place. For n leaves it costs about as much as n / 8 moves.
    void refit();
    /// A tree of them that has any shape, and neighbours that lie anywhere: for tests.
    void rebuild_at_random(std::vector<Leaf>& leaves, Random& random);

    NodeId root() const { return top; }
    const Node& node(NodeId id) const { return nodes[static_cast<std::size_t>(id)]; }

    std::uint32_t leaf_count() const { return leaf_total; }

    /// Calls visit(id, node) for every leaf, in no order.
    template <class Visit> void for_each_leaf(Visit&& visit) const {
        for (std::size_t i = 0; i < nodes.size(); ++i)
            if (nodes[i].is_leaf() && nodes[i].parent != free_mark) visit(static_cast<NodeId>(i), nodes[i]);
    }
    /// Calls visit(proxy) for every leaf where may_meet(bounds) holds of it and of all nodes above, in the tree's order.
    /// `open` is the caller's memory: several may ask at once, each with its own.
    template <class MayMeet, class Visit>
    void query_if(MayMeet&& may_meet, std::vector<NodeId>& open, Visit&& visit) const;

  private:
    static constexpr NodeId free_mark = -2;

    struct Range { // of leaves, whose subtree belongs under `parent`
        std::uint32_t begin, end;
        NodeId parent;
        int side;
    };

    Node& at(NodeId id) { return nodes[static_cast<std::size_t>(id)]; }
    NodeId take_node();
    void free_node(NodeId id);
    NodeId best_sibling(const Bounds& bounds) const;
    /// Recomputes bounds from `id` to the top, rotating where that makes the tree tighter.
    void refit_up(NodeId id);
    void merge_children(NodeId id);
    void set_bounds(Node& n, const Bounds& bounds); ///< of a node that is no leaf
    void merge_all();                               ///< where each node comes before its children
    void rotate(NodeId id);
    void swap_with_grandchild(NodeId id, int side, int grandchild);
    /// split(first, last) may reorder the leaves from `first` to before `last`, and returns where the second child begins.
    template <class Split> void rebuild_by(std::vector<Leaf>& leaves, Split&& split);

    std::vector<Node> nodes;
    NodeId top = none, free_list = none; // a free node has the mark as parent, and the next one as child[1]
    std::uint32_t leaf_total = 0;
    bool is_ordered = false; ///< each node comes before its children
    std::int64_t area = 0,
                 area_max = 0; ///< half the surfaces of all nodes above leaves, in units of 2^22 square steps
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
