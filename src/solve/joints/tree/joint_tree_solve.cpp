// Factorisation of trees of joints, and their solution. See joint_tree.h for the symbols.
#include "solve/joints/joint_motion.h"
#include "solve/joints/joint_work.h"

#include <algorithm>
#include <cstdlib>

namespace lockstone::solve {

namespace {

// ---- factor -------------------------------------------------------------------------------------------------------

void take_row(TreeJoint& t, int r, const Row& row, const SolverBody& a, const SolverBody& b) {
    const std::int32_t* below = t.child_is_b ? row.jb : row.ja;
    const std::int32_t* above = t.child_is_b ? row.ja : row.jb;
    const SolverBody& child = t.child_is_b ? b : a;
    const SolverBody& parent = t.child_is_b ? a : b;
    for (int i = 0; i < 6; ++i) {
        t.below[r][i] = i < 3 ? static_cast<std::int32_t>(below[i] & child.keep[i]) : below[i];
        t.above[r][i] = i < 3 ? static_cast<std::int32_t>(above[i] & parent.keep[i]) : above[i];
    }
    t.mobility[r] = mobility(row);
}

void take_rows(const JointTick& tick, TreeJoint& t, const SolverBodies& bodies) {
    const JointWork& w = tick.joints[t.joint];
    int r = 0;
    for (std::uint32_t i = 0; i < w.block_count; ++i) {
        const JointBlock& block = tick.blocks[w.first_block + i];
        for (int k = 0; k < block.count; ++k)
            take_row(t, r++, block.row[k], bodies.body[w.a.body], bodies.body[w.b.body]);
    }
}

/// a b, with mantissas of 30 bits
Scaled product(Scaled a, Scaled b) {
    Scaled p = scaled((a.m >> 30) * (b.m >> 30), block_bits);
    p.exponent += a.exponent + b.exponent;
    return p;
}

/// Adds G to D by rows: epsilon of D, but at least a small part of the pair's own value. If the child cannot yield,
/// or is the world, G is epsilon of the pair's value.
void soften(TreeJoint& t, SymmetricBlock& d) {
    Scaled g[6];
    const auto shifted = [](Scaled s, int by) { return Scaled{s.m, s.exponent - by}; };
    const auto size = [](Scaled s) { return s.m == 0 ? -100000 : s.exponent; };
    for (int r = 0; r < t.rows; ++r) {
        const Scaled pair = product(scaled(t.mobility[r], 48), t.inverse_mass);
        Scaled own = scaled(d.m[block_index(r, r)], block_bits);
        own.exponent += d.exponent;
        const bool yields = !d.zero && size(own) > size(pair) - tree_floor_bits;
        g[r] = shifted(yields ? own : pair, tree_softness_bits);
        if (yields && size(pair) - tree_floor_bits > size(g[r])) g[r] = shifted(pair, tree_floor_bits);
        const Scaled soft = product(g[r], t.mass); // softness for p' instead of lambda
        t.softness[r] = block_shift(Wide::from(soft.m), block_bits - soft.exponent - tree_soft_bits);
    }
    add_diagonal(d, g, t.rows);
}

/// If a node carries nothing, its H is a multiple of the unit matrix.
BlockFactor plain_factor(Scaled mass) {
    BlockFactor f{};
    for (std::int64_t& inverse : f.inverse) // m in [1/2, 1)
        inverse = (std::int64_t{1} << 62) / (mass.m >> 30) << (block_bits + block_inverse_bits - 92);
    return f;
}

bool factorise_node(TreeNode& node) {
    if (!node.plain) return factorise(node.h, 6, node.factor);
    node.factor = plain_factor(node.mass);
    return true;
}

bool factorise_tree(JointTick& tick, const JointTree& tree, const SolverBodies& bodies) {
    JointForest& f = tick.forest;
    for (std::uint32_t i = 0; i < tree.node_count; ++i) {
        TreeNode& node = f.nodes[tree.first_node + i];
        node.h = block_of(node.mass, 6);
    }
    for (std::uint32_t i = 0; i < tree.joint_count; ++i) {
        TreeJoint& t = f.joints[tree.first_joint + i];
        take_rows(tick, t, bodies);
        SymmetricBlock d{};
        d.zero = true;
        if (t.child != no_tree) {
            TreeNode& child = f.nodes[t.child];
            if (!factorise_node(child)) return false;
            condense_columns(child.factor, child.h.exponent, t.below, t.rows, t.z, d);
        }
        soften(t, d);
        factorise_raised(d, t.rows, t.factor);
        t.exponent = d.exponent;
        if (t.parent == no_tree) continue;
        SymmetricBlock carried;
        condense_rows(t.factor, d.exponent, t.above, t.rows, carried);
        add(f.nodes[t.parent].h, carried, 6);
    }
    TreeNode& root = f.nodes[tree.first_node];
    return f.above_of[tree.first_node] != 0 || factorise_node(root);
}

// ---- solution -----------------------------------------------------------------------------------------------------

constexpr int speed_up = block_speed_bits - Speed::fraction_bits;

/// Writes - speed - bias - epsilon k p' to `solution`.
void take_residual(const JointTick& tick, TreeJoint& t, const SolverBodies& bodies, bool bias) {
    const JointWork& w = tick.joints[t.joint];
    Motion m = read(bodies.body[w.a.body], bodies.body[w.b.body]);
    clamp_motion(m);
    const Speeds now(m);
    int r = 0;
    for (std::uint32_t i = 0; i < w.block_count; ++i) {
        const JointBlock& block = tick.blocks[w.first_block + i];
        for (int k = 0; k < block.count; ++k, ++r) {
            t.solution[r] = -(std::int64_t{speed_along(block.row[k], now)} << speed_up);
            if (!bias) continue;
            const std::int64_t soft = t.softness[r] * block.impulse[k]; // 31 bits times 30
            t.solution[r] -= (std::int64_t{block.bias[k]} << speed_up) +
                             shift_right_rounded(soft, tree_soft_bits - speed_up);
        }
    }
}

/// Calls take(i, sum) with the sum over all rows of entry i times x, for each i.
template <class T, class F> void combine(const T (*rows)[6], const std::int64_t* x, int count, F&& take) {
    Wide sum[6] = {Wide::from(0), Wide::from(0), Wide::from(0), Wide::from(0), Wide::from(0), Wide::from(0)};
    for (int r = 0; r < count; ++r)
        each<6>([&](int i) { sum[i] = sum[i] + block_product(rows[r][i], x[r]); });
    each<6>([&](int i) { take(i, sum[i]); });
}

std::int64_t bounded(std::int64_t v) { return std::clamp(v, -block_value_max, block_value_max); }

/// One step from the leaves inwards: computes D^-1 g of a joint, and adds its impulse to f of the parent.
void eliminate(JointForest& f, TreeJoint& t) {
    if (t.child != no_tree && f.nodes[t.child].passes) {
        TreeNode& child = f.nodes[t.child];
        solve_lower(child.factor, child.f);
        for (int r = 0; r < t.rows; ++r)
            t.solution[r] =
                bounded(t.solution[r] - block_narrow<block_column_bits>(block_dot(t.z[r], child.f)));
    }
    solve(t.factor, t.rows, t.solution);
    if (t.parent == no_tree) return;
    TreeNode& parent = f.nodes[t.parent];
    const int shift = row_bits + t.exponent + parent.h.exponent;
    combine(t.above, t.solution, t.rows,
            [&](int i, Wide sum) { parent.f[i] = bounded(parent.f[i] + block_shift(sum, shift)); });
}

/// Computes dv of a body from L^-1 f and from the impulses of the joint above it.
void move_node(TreeNode& node, const TreeJoint* above) {
    for (int i = 0; i < 6; ++i)
        node.speed[i] = block_narrow<block_inverse_bits>(block_product(node.f[i], node.factor.inverse[i]));
    if (above != nullptr) {
        const int shift = block_column_bits + above->exponent + node.h.exponent;
        combine(above->z, above->solution, above->rows,
                [&](int i, Wide sum) { node.speed[i] = bounded(node.speed[i] + block_shift(sum, shift)); });
    }
    solve_upper(node.factor, node.speed);
}

/// One step from the root outwards: computes lambda, and the dv of the child.
void substitute(JointForest& f, TreeJoint& t) {
    if (t.parent != no_tree) {
        const TreeNode& parent = f.nodes[t.parent];
        std::int64_t x[6];
        for (int r = 0; r < t.rows; ++r) x[r] = block_narrow<row_bits>(block_dot(t.above[r], parent.speed));
        solve(t.factor, t.rows, x);
        for (int r = 0; r < t.rows; ++r) t.solution[r] = bounded(t.solution[r] - x[r]);
    }
    if (t.child != no_tree && f.nodes[t.child].passes) move_node(f.nodes[t.child], &t);
}

/// Computes the changes of p'. Returns the largest |p'| that results.
std::int64_t take_changes(const JointTick& tick, TreeJoint& t) {
    const JointWork& w = tick.joints[t.joint];
    const int shift =
        block_speed_bits + block_bits - Speed::fraction_bits + t.exponent - t.inverse_mass.exponent;
    std::int64_t most = 0;
    int r = 0;
    for (std::uint32_t i = 0; i < w.block_count; ++i) {
        const JointBlock& block = tick.blocks[w.first_block + i];
        for (int k = 0; k < block.count; ++k, ++r) {
            t.change[r] = block_shift(block_product(t.solution[r], t.inverse_mass.m), shift);
            most = std::max<std::int64_t>(most, std::abs(t.change[r] + block.impulse[k]));
        }
    }
    return most;
}

/// Scales p' + change of all joints of a tree by the same factor, so that the largest becomes joint_impulse_max. The
/// bodies then move as if the joints held them only in part.
void scale_changes(const JointTick& tick, TreeJoint& t, std::int64_t most) {
    const JointWork& w = tick.joints[t.joint];
    int r = 0;
    for (std::uint32_t i = 0; i < w.block_count; ++i) {
        const JointBlock& block = tick.blocks[w.first_block + i];
        for (int k = 0; k < block.count; ++k, ++r) // below 1, times joint_impulse_max
            t.change[r] =
                narrow_rounded(block_product(divide_shifted(t.change[r] + block.impulse[k], most, 62),
                                             joint_impulse_max),
                               62) -
                block.impulse[k];
    }
}

/// Applies the changes. A part of three rows adds 29 bits times 31, three times, to motion_between_max: below 2^63.
void give_changes(JointTick& tick, const TreeJoint& t, SolverBodies& bodies) {
    const JointWork& w = tick.joints[t.joint];
    SolverBody &a = bodies.body[w.a.body], &b = bodies.body[w.b.body];
    Motion m = read(a, b);
    int r = 0;
    for (std::uint32_t i = 0; i < w.block_count; ++i) {
        JointBlock& block = tick.blocks[w.first_block + i];
        std::int32_t change[3];
        for (int k = 0; k < block.count; ++k, ++r) {
            change[k] = static_cast<std::int32_t>(t.change[r]);
            block.impulse[k] += change[k];
        }
        push(block.row, change, block.count, m);
        clamp_motion(m, motion_between_max);
    }
    // Several trees may share bodies that impulses do not move: no tree writes these.
    const bool child_moves = t.child != no_tree, parent_moves = t.parent != no_tree;
    if (t.child_is_b ? parent_moves : child_moves) write(m.a, a);
    if (t.child_is_b ? child_moves : parent_moves) write(m.b, b);
}

void clamp_body(SolverBody& body) {
    for (int i = 0; i < 3; ++i) {
        body.v[i] = std::clamp(body.v[i], -motion_max, motion_max);
        body.u[i] = std::clamp(body.u[i], -motion_max, motion_max);
    }
}

} // namespace

void factorise_trees(JointTick& tick, const SolverBodies& bodies, Tasks* tasks) {
    const auto renew = [&](JointTree& tree) {
        bool changed = false;
        for (std::uint32_t i = 0; i < tree.joint_count; ++i) {
            bool& remade = tick.joints[tick.forest.joints[tree.first_joint + i].joint].remade;
            changed |= remade;
            remade = false;
        }
        if (!changed) return;
        tree.direct = factorise_tree(tick, tree, bodies);
        tick.paths.take(tree.direct, base::Path::tree_solved_in_passes, base::Path::tree_solved_at_once);
        for (std::uint32_t i = 0; !tree.direct && i < tree.joint_count; ++i)
            invert_blocks(tick, tick.joints[tick.forest.joints[tree.first_joint + i].joint]);
    };
    std::vector<JointTree>& trees = tick.forest.trees;
    base::for_chunks(tasks, static_cast<std::uint32_t>(trees.size()), tree_chunk,
                     [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
                         for (std::uint32_t i = first; i < last; ++i) renew(trees[i]);
                     });
}

void solve_tree(JointTick& tick, const JointTree& tree, SolverBodies& bodies, bool bias) {
    JointForest& f = tick.forest;
    const std::span<TreeJoint> joints(f.joints.data() + tree.first_joint, tree.joint_count);
    const std::span<TreeNode> nodes(f.nodes.data() + tree.first_node, tree.node_count);
    for (TreeNode& node : nodes)
        for (std::int64_t& x : node.f) x = 0;
    for (TreeJoint& t : joints) {
        take_residual(tick, t, bodies, bias);
        eliminate(f, t);
    }
    if (f.above_of[tree.first_node] == 0) {
        solve_lower(nodes[0].factor, nodes[0].f);
        move_node(nodes[0], nullptr);
    }
    for (std::size_t i = joints.size(); i-- > 0;) substitute(f, joints[i]);
    std::int64_t most = 0;
    for (TreeJoint& t : joints) most = std::max(most, take_changes(tick, t));
    if (most > joint_impulse_max) {
        for (TreeJoint& t : joints) scale_changes(tick, t, most);
        base::add_count(tick.clamped, 1);
    }
    for (const TreeJoint& t : joints) give_changes(tick, t, bodies);
    for (const TreeNode& node : nodes) clamp_body(bodies.body[node.body]);
}

} // namespace lockstone::solve
