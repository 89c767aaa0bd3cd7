// A binary tree of bounds with one leaf per proxy, changed in place.
//
// Its shape depends on history and on nothing else may that show: callers filter what it yields by exact bounds and
// sort it.
#pragma once

#include "collide/bounds.h"

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
        bool fresh; ///< this leaf, or one below, was inserted since the last `clear_fresh`

        bool is_leaf() const { return child[0] == none; }
        std::uint32_t proxy() const { return static_cast<std::uint32_t>(child[1]); }
    };

    explicit BoundsTree(std::uint32_t leaf_capacity);

    NodeId insert(const Bounds& bounds, std::uint32_t proxy);
    void remove(NodeId leaf);
    void clear();
    /// Forgets which leaves are new.
    void clear_fresh();

    NodeId root() const { return top; }
    const Node& node(NodeId id) const { return nodes[static_cast<std::size_t>(id)]; }

    /// Calls visit(proxy) for every leaf that overlaps, in the tree's order.
    template <class Visit> void query(const Bounds& bounds, Visit&& visit) const;

  private:
    Node& at(NodeId id) { return nodes[static_cast<std::size_t>(id)]; }
    NodeId take_node();
    void free_node(NodeId id);
    NodeId best_sibling(const Bounds& bounds) const;
    /// Recomputes bounds and freshness from `id` to the top, rotating where that makes the tree tighter.
    void refit_up(NodeId id);
    void rotate(NodeId id);
    void swap_with_grandchild(NodeId id, int side, int grandchild);

    std::vector<Node> nodes;
    NodeId top = none, free_list = none;
    mutable std::vector<NodeId> stack;
};

template <class Visit> void BoundsTree::query(const Bounds& bounds, Visit&& visit) const {
    stack.clear();
    if (top != none) stack.push_back(top);
    while (!stack.empty()) {
        const Node& n = node(stack.back());
        stack.pop_back();
        if (!overlap(n.bounds, bounds)) continue;
        if (n.is_leaf()) {
            visit(n.proxy());
        } else {
            stack.push_back(n.child[0]);
            stack.push_back(n.child[1]);
        }
    }
}

} // namespace lockstone::collide
