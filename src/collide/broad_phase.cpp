// Pairs of overlapping leaves are kept from call to call; a call finds anew only the pairs of leaves that changed, by
// descending two trees (or one tree twice) at once, then filters all pairs by exact bounds.
//
// source: van den Bergen, Efficient Collision Detection of Complex Deformable Models using AABB Trees, 1997 (fat
// leaves, simultaneous descent)
#include "collide/broad_phase.h"

#include "base/assert.h"

#include <algorithm>

namespace lockstone::collide {

BroadPhase::BroadPhase(std::uint32_t proxy_capacity, Bound leaf_margin)
    : entries(proxy_capacity, Entry{Bounds{}, BoundsTree::none, false, false}), moving(proxy_capacity),
      fixed(proxy_capacity), margin(leaf_margin) {
    changed.reserve(proxy_capacity);
    for (std::vector<ProxyPair>* pairs : {&leaf_pairs, &found, &merged}) pairs->reserve(std::size_t{8} * proxy_capacity);
    stack.reserve(256);
}

void BroadPhase::set(std::uint32_t proxy, const Bounds& exact, bool is_static) {
    LOCKSTONE_ASSERT(proxy < entries.size(), "proxy ", proxy, ", capacity ", entries.size());
    Entry& entry = entries[proxy];
    if (entry.leaf != BoundsTree::none) {
        const BoundsTree& tree = entry.is_static ? fixed : moving;
        const Bounds& leaf = tree.node(entry.leaf).bounds;
        if (entry.is_static == is_static && (is_static ? leaf == exact : collide::contains(leaf, exact))) {
            entry.exact = exact;
            return;
        }
        remove(proxy);
    }
    insert_leaf(proxy, exact, is_static);
}

void BroadPhase::insert_leaf(std::uint32_t proxy, const Bounds& exact, bool is_static) {
    Entry& entry = entries[proxy];
    BoundsTree& tree = is_static ? fixed : moving;
    entry.leaf = tree.insert(is_static ? exact : expand(exact, margin), proxy);
    entry.exact = exact;
    entry.is_static = is_static;
    if (!entry.fresh) changed.push_back(proxy);
    entry.fresh = true;
}

void BroadPhase::remove(std::uint32_t proxy) {
    if (!contains(proxy)) return;
    Entry& entry = entries[proxy];
    (entry.is_static ? fixed : moving).remove(entry.leaf);
    entry.leaf = BoundsTree::none;
    if (!entry.fresh) changed.push_back(proxy);
    entry.fresh = true;
}

void BroadPhase::clear() {
    for (Entry& entry : entries) entry.leaf = BoundsTree::none, entry.fresh = false;
    moving.clear();
    fixed.clear();
    changed.clear();
    leaf_pairs.clear();
}

void BroadPhase::find_pairs(std::vector<ProxyPair>& out) {
    if (!changed.empty()) {
        forget_pairs_of_fresh_leaves();
        found.clear();
        find_fresh_pairs_within(moving);
        find_fresh_pairs_between(moving, fixed);
        merge_found();
        moving.clear_fresh();
        fixed.clear_fresh();
        for (std::uint32_t proxy : changed) entries[proxy].fresh = false;
        changed.clear();
    }
    out.clear();
    for (const ProxyPair& pair : leaf_pairs)
        if (overlap(entries[pair.a].exact, entries[pair.b].exact)) out.push_back(pair);
}

void BroadPhase::forget_pairs_of_fresh_leaves() {
    std::erase_if(leaf_pairs, [&](const ProxyPair& p) { return entries[p.a].fresh || entries[p.b].fresh; });
}

namespace {

ProxyPair ordered(std::uint32_t x, std::uint32_t y) { return x < y ? ProxyPair{x, y} : ProxyPair{y, x}; }

} // namespace

/// A stack entry (n, n) stands for all pairs below n, (a, b) for those of one leaf below each.
void BroadPhase::find_fresh_pairs_within(const BoundsTree& tree) {
    stack.clear();
    if (tree.root() != BoundsTree::none) stack.push_back({tree.root(), tree.root()});
    while (!stack.empty()) {
        const NodePair top = stack.back();
        stack.pop_back();
        const BoundsTree::Node &a = tree.node(top.a), &b = tree.node(top.b);
        if (!a.fresh && !b.fresh) continue;
        if (top.a == top.b) {
            if (a.is_leaf()) continue;
            stack.push_back({a.child[0], a.child[0]});
            stack.push_back({a.child[1], a.child[1]});
            stack.push_back({a.child[0], a.child[1]});
            continue;
        }
        if (!overlap(a.bounds, b.bounds)) continue;
        if (a.is_leaf() && b.is_leaf()) {
            found.push_back(ordered(a.proxy(), b.proxy()));
        } else if (b.is_leaf() || (!a.is_leaf() && half_area(a.bounds) >= half_area(b.bounds))) {
            stack.push_back({a.child[0], top.b});
            stack.push_back({a.child[1], top.b});
        } else {
            stack.push_back({top.a, b.child[0]});
            stack.push_back({top.a, b.child[1]});
        }
    }
}

void BroadPhase::find_fresh_pairs_between(const BoundsTree& tree_a, const BoundsTree& tree_b) {
    stack.clear();
    if (tree_a.root() != BoundsTree::none && tree_b.root() != BoundsTree::none)
        stack.push_back({tree_a.root(), tree_b.root()});
    while (!stack.empty()) {
        const NodePair top = stack.back();
        stack.pop_back();
        const BoundsTree::Node &a = tree_a.node(top.a), &b = tree_b.node(top.b);
        if ((!a.fresh && !b.fresh) || !overlap(a.bounds, b.bounds)) continue;
        if (a.is_leaf() && b.is_leaf()) {
            found.push_back(ordered(a.proxy(), b.proxy()));
        } else if (b.is_leaf() || (!a.is_leaf() && half_area(a.bounds) >= half_area(b.bounds))) {
            stack.push_back({a.child[0], top.b});
            stack.push_back({a.child[1], top.b});
        } else {
            stack.push_back({top.a, b.child[0]});
            stack.push_back({top.a, b.child[1]});
        }
    }
}

void BroadPhase::merge_found() {
    std::sort(found.begin(), found.end());
    merged.resize(leaf_pairs.size() + found.size());
    std::merge(leaf_pairs.begin(), leaf_pairs.end(), found.begin(), found.end(), merged.begin());
    leaf_pairs.swap(merged);
}

void BroadPhase::query(const Bounds& bounds, std::vector<std::uint32_t>& out) const {
    out.clear();
    const auto add = [&](std::uint32_t proxy) {
        if (overlap(entries[proxy].exact, bounds)) out.push_back(proxy);
    };
    moving.query(bounds, add);
    fixed.query(bounds, add);
    std::sort(out.begin(), out.end());
}

} // namespace lockstone::collide
