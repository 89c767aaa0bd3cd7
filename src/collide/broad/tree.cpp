// source: Catto, Dynamic Bounding Volume Hierarchies, GDC 2019 (greedy sibling by surface area, rotations on the way
// up); Kopta et al., Fast, Effective BVH Updates for Animated Scenes, I3D 2012 (rotations).
#include "collide/broad/tree.h"

#include "base/room.h"

#include <algorithm>

namespace lockstone::collide {

BoundsTree::BoundsTree() { ranges.reserve(64); }

void BoundsTree::reserve(std::uint32_t leaves) { nodes.reserve(std::size_t{2} * leaves); }

BoundsTree::NodeId BoundsTree::take_node() {
    if (free_list == none) {
        nodes.push_back({});
        return static_cast<NodeId>(nodes.size() - 1);
    }
    const NodeId id = free_list;
    free_list = at(id).child[1];
    return id;
}

void BoundsTree::free_node(NodeId id) {
    at(id).parent = free_mark;
    at(id).child[0] = none;
    at(id).child[1] = free_list;
    free_list = id;
}

void BoundsTree::clear() {
    nodes.clear();
    top = free_list = none;
    leaf_total = 0;
    is_ordered = false;
    area = area_max = 0;
}

static std::int64_t area_of(const Bounds& bounds) { return half_area(bounds) >> 18; }

BoundsTree::NodeId BoundsTree::insert(const Bounds& bounds, std::uint32_t proxy) {
    ++leaf_total;
    is_ordered = false;
    const NodeId leaf = take_node();
    at(leaf) = {bounds, none, {none, static_cast<NodeId>(proxy)}};
    if (top == none) {
        top = leaf;
        return leaf;
    }
    const NodeId sibling = best_sibling(bounds);
    const NodeId parent = take_node();
    const NodeId above = at(sibling).parent;
    at(parent) = {merge(bounds, at(sibling).bounds), above, {sibling, leaf}};
    area += area_of(at(parent).bounds);
    at(sibling).parent = at(leaf).parent = parent;
    if (above == none)
        top = parent;
    else
        at(above).child[at(above).child[1] == sibling ? 1 : 0] = parent;
    refit_up(above);
    return leaf;
}

void BoundsTree::remove(NodeId leaf) {
    --leaf_total;
    is_ordered = false;
    const NodeId parent = at(leaf).parent;
    free_node(leaf);
    if (parent == none) {
        top = none;
        return;
    }
    const NodeId sibling = at(parent).child[at(parent).child[0] == leaf ? 1 : 0];
    const NodeId above = at(parent).parent;
    area -= area_of(at(parent).bounds);
    free_node(parent);
    at(sibling).parent = above;
    if (above == none)
        top = sibling;
    else
        at(above).child[at(above).child[1] == parent ? 1 : 0] = sibling;
    refit_up(above);
}

/// Descends to where the new leaf adds least surface. Stops at a node when a new parent above it costs less
/// than the least that either child could add.
BoundsTree::NodeId BoundsTree::best_sibling(const Bounds& bounds) const {
    NodeId id = top;
    while (!node(id).is_leaf()) {
        const Node& n = node(id);
        const std::int64_t merged = half_area(merge(n.bounds, bounds));
        // Growth of each node from here to the root.
        const std::int64_t inherited = merged - half_area(n.bounds);
        std::int64_t cost[2];
        for (int side = 0; side < 2; ++side) {
            const Node& child = node(n.child[side]);
            const std::int64_t grown = half_area(merge(child.bounds, bounds));
            cost[side] = inherited + grown - (child.is_leaf() ? 0 : half_area(child.bounds));
        }
        if (merged < cost[0] && merged < cost[1]) break;
        id = n.child[cost[1] < cost[0] ? 1 : 0];
    }
    return id;
}

void BoundsTree::set_bounds(Node& n, const Bounds& bounds) {
    area += area_of(bounds) - area_of(n.bounds);
    n.bounds = bounds;
}

void BoundsTree::merge_children(NodeId id) {
    Node& n = at(id);
    set_bounds(n, merge(at(n.child[0]).bounds, at(n.child[1]).bounds));
}

void BoundsTree::move(NodeId leaf, const Bounds& bounds) {
    set_leaf(leaf, bounds);
    for (NodeId id = at(leaf).parent; id != none; id = at(id).parent) {
        Node& n = at(id);
        const Bounds merged = merge(at(n.child[0]).bounds, at(n.child[1]).bounds);
        if (merged == n.bounds) return;
        set_bounds(n, merged);
    }
}

void BoundsTree::refit_up(NodeId id) {
    for (; id != none; id = at(id).parent) {
        rotate(id);
        merge_children(id);
    }
}

/// Swaps a child with a grandchild below the other child, where that reduces the other child's surface most.
/// The node itself keeps its leaves, so only one node's surface changes.
void BoundsTree::rotate(NodeId id) {
    const Node& n = at(id);
    std::int64_t best_gain = 0;
    int best_side = 0, best_grandchild = -1;
    for (int side = 0; side < 2; ++side) { // the child that goes down
        const Node& other = at(n.child[1 - side]);
        if (other.is_leaf()) continue;
        const Bounds& down = at(n.child[side]).bounds;
        const std::int64_t before = half_area(other.bounds);
        for (int k = 0; k < 2; ++k) { // the grandchild that goes up
            const std::int64_t gain = before - half_area(merge(down, at(other.child[1 - k]).bounds));
            if (gain > best_gain) best_gain = gain, best_side = side, best_grandchild = k;
        }
    }
    if (best_grandchild >= 0) swap_with_grandchild(id, best_side, best_grandchild);
}

void BoundsTree::swap_with_grandchild(NodeId id, int side, int grandchild) {
    Node& n = at(id);
    const NodeId down = n.child[side], other = n.child[1 - side];
    Node& o = at(other);
    const NodeId rising = o.child[grandchild];
    n.child[side] = rising;
    at(rising).parent = id;
    o.child[grandchild] = down;
    at(down).parent = other;
    merge_children(other);
}

namespace {

/// The centre of a leaf along an axis, to one step.
Bound center_of(const BoundsTree::Leaf& leaf, int axis) {
    return Bound::from_raw((leaf.bounds.lower[axis].raw >> 1) + (leaf.bounds.upper[axis].raw >> 1));
}

/// The box around the centres.
Bounds cell_of(const BoundsTree::Leaf* begin, const BoundsTree::Leaf* end) {
    Bounds cell{};
    for (const BoundsTree::Leaf* leaf = begin; leaf != end; ++leaf)
        for (int axis = 0; axis < 3; ++axis) {
            const Bound at = center_of(*leaf, axis);
            cell.lower[axis] = leaf == begin ? at : min(cell.lower[axis], at);
            cell.upper[axis] = leaf == begin ? at : max(cell.upper[axis], at);
        }
    return cell;
}

std::int64_t width_of(const Bounds& cell, int axis) {
    return std::int64_t{cell.upper[axis].raw} - cell.lower[axis].raw;
}

int widest_axis(const Bounds& cell) {
    int widest = 0;
    for (int axis = 1; axis < 3; ++axis)
        if (width_of(cell, axis) > width_of(cell, widest)) widest = axis;
    return widest;
}

} // namespace

void BoundsTree::merge_all() {
    area = 0;
    for (std::size_t i = nodes.size(); i-- > 0;) {
        Node& n = nodes[i];
        if (n.is_leaf()) continue;
        n.bounds = merge(at(n.child[0]).bounds, at(n.child[1]).bounds);
        area += area_of(n.bounds);
    }
}

void BoundsTree::set_leaf(NodeId leaf, const Bounds& bounds) { at(leaf).bounds = bounds; }

void BoundsTree::refit() { merge_all(); }

/// Creates each node before its children.
template <class Split> void BoundsTree::rebuild_by(std::vector<Leaf>& leaves, Split&& split) {
    clear();
    leaf_total = static_cast<std::uint32_t>(leaves.size());
    base::make_room(nodes, 2 * leaves.size());
    ranges.clear();
    if (!leaves.empty())
        ranges.push_back({0, leaf_total, none, 0, cell_of(leaves.data(), leaves.data() + leaf_total)});
    while (!ranges.empty()) {
        const Range r = ranges.back();
        ranges.pop_back();
        const NodeId id = take_node();
        if (r.parent == none)
            top = id;
        else
            at(r.parent).child[r.side] = id;
        Leaf* const begin = leaves.data() + r.begin;
        Leaf* const end = leaves.data() + r.end;
        if (end - begin == 1) {
            at(id) = {begin->bounds, r.parent, {none, static_cast<NodeId>(begin->proxy)}};
            continue;
        }
        at(id).parent = r.parent;
        at(id).child[0] = id; // marks an inner node; its children overwrite this
        Bounds cells[2] = {r.cell, r.cell};
        const std::uint32_t middle = static_cast<std::uint32_t>(split(begin, end, cells) - leaves.data());
        ranges.push_back({r.begin, middle, id, 0, cells[0]});
        ranges.push_back({middle, r.end, id, 1, cells[1]});
    }
    merge_all();
    is_ordered = true;
    area_max = area + area / 4;
}

/// Splits the cell in the middle of its widest axis, which costs one pass over the leaves. If a side would get less
/// than an eighth of the leaves, first shrinks the cell; if that does not help, splits at the median.
void BoundsTree::rebuild(std::vector<Leaf>& leaves) {
    rebuild_by(leaves, [](Leaf* begin, Leaf* end, Bounds(&cells)[2]) {
        const std::ptrdiff_t count = end - begin;
        if (count == 2) return begin + 1;
        for (const bool is_tight : {false, true}) {
            if (is_tight) cells[0] = cells[1] = cell_of(begin, end);
            const int axis = widest_axis(cells[0]);
            const Bound middle = Bound::from_raw(
                static_cast<std::int32_t>(cells[0].lower[axis].raw + width_of(cells[0], axis) / 2));
            Leaf* const border =
                std::partition(begin, end, [&](const Leaf& leaf) { return center_of(leaf, axis) <= middle; });
            if (std::min(border - begin, end - border) <= count / 8) continue;
            cells[0].upper[axis] = cells[1].lower[axis] = middle;
            return border;
        }
        Leaf* const median = begin + count / 2;
        std::nth_element(begin, median, end, [axis = widest_axis(cells[0])](const Leaf& a, const Leaf& b) {
            return center_of(a, axis) < center_of(b, axis);
        });
        return median;
    });
}

void BoundsTree::rebuild_at_random(std::vector<Leaf>& leaves, Random& random) {
    for (std::size_t i = leaves.size(); i > 1; --i) std::swap(leaves[i - 1], leaves[random.next_u32() % i]);
    rebuild_by(leaves, [&](Leaf* begin, Leaf* end, Bounds(&)[2]) {
        return begin + 1 + random.next_u32() % static_cast<std::uint32_t>(end - begin - 1);
    });
}

} // namespace lockstone::collide
