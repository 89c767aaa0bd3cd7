// Finds the trees among the joints of a tick.
#include "solve/joints/tree/joint_tree.h"

#include "solve/joints/joint_work.h"

#include <algorithm>

namespace lockstone::solve {

namespace {

/// Union-find over the bodies. The representative is the body that comes first in JointTick::bodies.
std::uint32_t component_of(JointForest& f, std::uint32_t body) {
    while (f.component[body] != body) {
        f.component[body] = f.component[f.component[body]];
        body = f.component[body];
    }
    return body;
}

std::uint32_t node_side(const JointWorkSide& side, const SolverBodies& bodies) {
    return !side.world && bodies.step[side.body].movable ? side.cache : no_tree;
}

/// Builds a spanning forest in solving order: a joint between two bodies that earlier joints connect closes a loop.
void find_links(JointTick& tick, const SolverBodies& bodies) {
    JointForest& f = tick.forest;
    const auto count = static_cast<std::uint32_t>(tick.bodies.size());
    f.links.clear();
    f.component.resize(count);
    for (std::uint32_t i = 0; i < count; ++i) f.component[i] = i;
    f.anchor_of.assign(count, 0), f.loops.assign(count, 0);
    f.first_of.assign(count + 1, 0);
    for (std::uint32_t k = 0; k < tick.joints.size(); ++k) {
        JointWork& w = tick.joints[k];
        w.tree = no_tree;
        if (w.block_count == 0 && !w.point) continue;
        const std::uint32_t a = node_side(w.a, bodies), b = node_side(w.b, bodies);
        if (a == b) continue;
        if (a != no_tree && b != no_tree) {
            const std::uint32_t ca = component_of(f, a), cb = component_of(f, b);
            const std::uint32_t one = std::min(ca, cb), other = std::max(ca, cb);
            if (ca == cb) {
                ++f.loops[one];
                continue;
            }
            f.component[other] = one;
            f.loops[one] += f.loops[other];
        }
        f.links.push_back({k, a, b});
        if (a != no_tree) ++f.first_of[a];
        if (b != no_tree) ++f.first_of[b];
    }
}

/// Lists the links of each body in solving order: those of body i are hung[first_of[i]] to hung[first_of[i + 1] - 1].
void hang_links(JointForest& f) {
    std::uint32_t sum = 0;
    for (std::uint32_t& first : f.first_of) {
        sum += first;
        first = sum;
    }
    f.hung.resize(sum);
    for (std::size_t i = f.links.size(); i-- > 0;)
        for (const std::uint32_t body : {f.links[i].a, f.links[i].b})
            if (body != no_tree) f.hung[--f.first_of[body]] = static_cast<std::uint32_t>(i);
}

void add_node(JointTick& tick, std::uint32_t body, std::uint32_t link_above, const BodyColumns& columns) {
    JointForest& f = tick.forest;
    f.nodes.push_back({});
    f.above_of.push_back(link_above);
    f.node_of[body] = static_cast<std::uint32_t>(f.nodes.size());
    TreeNode& node = f.nodes.back();
    node.body = tick.bodies[body].body;
    node.plain = true;
    node.mass = scaled(columns.mass[node.body].mass.raw, Real::fraction_bits);
}

void add_joint(JointTick& tick, std::uint32_t link, std::uint32_t child, std::uint32_t parent) {
    JointForest& f = tick.forest;
    f.joints.push_back({});
    TreeJoint& t = f.joints.back();
    t.joint = f.links[link].joint;
    t.child = child, t.parent = parent;
    JointWork& w = tick.joints[t.joint];
    w.tree = static_cast<std::uint32_t>(f.trees.size());
    const std::uint32_t b = w.b.world ? no_tree : f.node_of[w.b.cache];
    t.child_is_b = child != no_tree ? b == child + 1 : b != parent + 1;
    t.rows = w.point ? 3 : 0;
    for (std::uint32_t i = 0; i < w.block_count; ++i) t.rows += tick.blocks[w.first_block + i].count;
    t.mass = scaled(w.mass.raw, Real::fraction_bits);
    // 2^62 / [2^31, 2^32) = (2^30, 2^31]
    t.inverse_mass = scaled((std::int64_t{1} << 62) / (t.mass.m >> (block_bits - 32)), 30);
    t.inverse_mass.exponent -= t.mass.exponent;
    if (parent == no_tree) return;
    TreeNode& node = f.nodes[parent];
    node.plain = false, node.passes = true;
}

std::span<const std::uint32_t> links_of(const JointForest& f, std::uint32_t body) {
    return std::span<const std::uint32_t>(f.hung).subspan(f.first_of[body],
                                                          f.first_of[body + 1] - f.first_of[body]);
}
std::uint32_t other_end(const TreeLink& link, std::uint32_t body) { return link.a == body ? link.b : link.a; }

/// Lists the bodies of a tree from the root outwards, and the link to the parent of each.
void walk_tree(JointForest& f, std::uint32_t root) {
    f.queue.assign(1, root);
    f.above[root] = f.anchor_of[component_of(f, root)];
    for (std::size_t i = 0; i < f.queue.size(); ++i) {
        const std::uint32_t body = f.queue[i];
        for (const std::uint32_t link : links_of(f, body)) {
            const std::uint32_t other = other_end(f.links[link], body);
            if (other == no_tree || link + 1 == f.above[body]) continue;
            f.above[other] = link + 1;
            f.queue.push_back(other);
        }
    }
}

bool has_limits(const JointTick& tick, const JointWork& w) {
    for (std::uint32_t i = 0; i < w.axis_count; ++i)
        if ((tick.axes[w.first_axis + i].features & (has_lower | has_upper)) != 0) return true;
    return false;
}
/// True if the joint has a spring, a motor or friction.
bool is_braked(const JointTick& tick, const JointWork& w) {
    for (std::uint32_t i = 0; i < w.axis_count; ++i)
        if ((tick.axes[w.first_axis + i].features & (has_spring | has_motor)) != 0) return true;
    return false;
}

/// True if some body of the tree carries many times its own mass: one pass joint after joint is then far from the
/// solution. `carried` must contain masses before the call, and contains sums of them after it.
template <class Mass> bool is_heavy(JointForest& f, Real load, Mass&& mass) {
    for (std::size_t i = f.queue.size(); i-- > 0;) {
        const std::uint32_t body = f.queue[i], above = f.above[body];
        if (above == 0) continue;
        if (f.carried[body] > mass(body) * load) return true;
        const std::uint32_t parent = other_end(f.links[above - 1], body);
        if (parent != no_tree) f.carried[parent] += f.carried[body];
    }
    return false;
}

/// How many times its own mass a body must carry for a direct solution of the tree.
Real load_of(const JointForest& f, std::uint32_t c, const StepConstants& step) {
    if (step.substeps_per_second < light_tree_rate) return step.tree_load;
    if (f.loose[c] == 0) return step.tree_load * braked_tree_loads;
    return f.anchors[c] == 0 ? step.tree_load * free_tree_loads : step.tree_load;
}

/// Adds nodes from the root outwards, then joints from the leaves inwards.
void add_tree(JointTick& tick, const BodyColumns& columns) {
    JointForest& f = tick.forest;
    JointTree tree{};
    tree.first_node = static_cast<std::uint32_t>(f.nodes.size());
    tree.first_joint = static_cast<std::uint32_t>(f.joints.size());
    for (const std::uint32_t body : f.queue) add_node(tick, body, f.above[body], columns);
    tree.node_count = static_cast<std::uint32_t>(f.queue.size());
    for (std::uint32_t i = tree.node_count; i-- > 0;) {
        const std::uint32_t body = f.queue[i], node = tree.first_node + i, above = f.above[body];
        for (const std::uint32_t link : links_of(f, body))
            if (link + 1 != above && (f.links[link].a == no_tree || f.links[link].b == no_tree))
                add_joint(tick, link, no_tree, node);
        if (above == 0) continue;
        const std::uint32_t other = other_end(f.links[above - 1], body);
        add_joint(tick, above - 1, node, other == no_tree ? no_tree : f.node_of[other] - 1);
    }
    tree.joint_count = static_cast<std::uint32_t>(f.joints.size()) - tree.first_joint;
    f.trees.push_back(tree);
}

} // namespace

void plan_trees(JointTick& tick, const BodyColumns& columns, const StepConstants& step,
                const SolverBodies& bodies) {
    JointForest& f = tick.forest;
    f.trees.clear(), f.nodes.clear(), f.joints.clear(), f.above_of.clear();
    find_links(tick, bodies);
    hang_links(f);
    const auto count = static_cast<std::uint32_t>(tick.bodies.size());
    f.node_of.assign(count, 0);
    f.size.assign(count, 0), f.root.assign(count, no_tree);
    f.above.assign(count, 0), f.carried.resize(count), f.anchors.assign(count, 0), f.loose.assign(count, 0);
    for (std::size_t i = 0; i < f.links.size(); ++i) {
        const TreeLink& l = f.links[i];
        const std::uint32_t c = component_of(f, l.a != no_tree ? l.a : l.b);
        ++f.size[c];
        const JointWork& w = tick.joints[l.joint];
        if (has_limits(tick, w) || !is_braked(tick, w)) f.loose[c] = 1;
        if (l.a != no_tree && l.b != no_tree) continue;
        if (++f.anchors[c] > 1) continue;
        f.anchor_of[c] = static_cast<std::uint32_t>(i + 1);
        f.root[c] = l.a != no_tree ? l.a : l.b;
    }
    const auto mass = [&](std::uint32_t body) { return columns.mass[tick.bodies[body].body].mass; };
    for (std::uint32_t body = 0; body < count; ++body) f.carried[body] = mass(body);
    for (std::uint32_t body = 0; body < count; ++body) {
        const std::uint32_t c = component_of(f, body);
        if (f.anchor_of[c] != 0) continue;
        if (f.root[c] == no_tree || f.carried[body] > f.carried[f.root[c]]) f.root[c] = body;
    }
    for (std::uint32_t c = 0; c < count; ++c) { // in the order of their first joints
        const bool is_net = f.loops[c] * tree_loop_part > f.size[c] + f.loops[c];
        if (f.component[c] != c || f.size[c] < 2 || is_net) continue;
        walk_tree(f, f.root[c]);
        if (f.anchors[c] > 1 || is_heavy(f, load_of(f, c, step), mass)) add_tree(tick, columns);
    }
}

} // namespace lockstone::solve
