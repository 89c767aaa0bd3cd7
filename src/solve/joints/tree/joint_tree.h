// The locks of joints that make a tree, solved at once: block elimination from the leaves to the root.
// source: Baraff, Linear-Time Dynamics using Lagrange Multipliers, SIGGRAPH 1996
//
//   node       a body that impulses move; the world and what moves on rails are none
//   edge       a joint between two nodes that closes no loop; a joint to the world hangs on its node
//   root       the node of the first joint to the world, which is eliminated last; else the heaviest body
//   M          mass of a body times the unit matrix: in gyration-scaled form it is that
//   J          rows of the locks, Jacobian entries of axes that are locked left out
//   lambda     impulse change m p' [kg m/s], m = mA mB / (mA + mB)
//   softness   G = epsilon of D by rows; epsilon k / m, k = J . r, of a joint to the world below the root
//
//   for all at once   M dv = J^T lambda,   J dv + G lambda = - speed - bias - G (m p')  (no bias, no p' when relaxing)
//   body i            H_i = M_i + sum over joints below of J^T D^-1 J,  f_i = sum of J^T D^-1 g
//   joint above it    D = J_i H_i^-1 J_i^T + G,  g = - speed - ... - J_i H_i^-1 f_i
//   back              lambda = D^-1 (g - J_parent dv_parent),  dv_i = H_i^-1 (f_i + J_i^T lambda)
//
// Joint after joint, with the impulses of the last tick to start from, is as good where loads are light: a tree is solved at
// once where some body carries (itself and all that hangs on it, away from the root) more than 4 times its own mass, or where
// it hangs on the world at two places: what is taut between them sags, joint after joint. Five links of equal mass are such
// a chain; so is a ragdoll of fourteen parts, by its abdomen, and one of eleven is not until something holds it up by its hand.
//
// The residual is what the rows read, and impulses act through the rows as everywhere: a factor that is a little off
// costs a little of the solution, never momentum. Sums of H only grow, so nothing cancels. A body lighter than
// 2^-24 of what hangs on it is beyond the factor: such a tree is solved joint after joint instead.
#pragma once

#include "solve/bodies/rows.h"
#include "solve/bodies/solver_body.h"
#include "solve/bodies/step.h"
#include "solve/joints/tree/block_matrix.h"

#include <cstdint>
#include <vector>

namespace lockstone::solve {

struct JointTick;

inline constexpr std::uint32_t no_tree = 0xffffffffu;
inline constexpr std::uint32_t tree_chunk = 4; ///< trees per piece of work that workers take
inline constexpr int tree_softness_bits = 12;  ///< epsilon = 2^-12 of D
inline constexpr int tree_floor_bits = 20;     ///< G is at least 2^-20 of what the pair alone would yield
inline constexpr int tree_soft_bits = 36;

struct TreeNode {
    std::uint32_t body;
    bool plain;  ///< H is M: nothing hangs on it
    bool passes; ///< what hangs on it asks for its speed
    Scaled mass;
    SymmetricBlock h;
    BlockFactor factor;
    std::int64_t f[6];     ///< 2^-exponent of H, speed units; then L^-1 of it
    std::int64_t speed[6]; ///< change
};

/// A joint of a tree, between the node that it is above of and the node towards the root.
struct TreeJoint {
    std::uint32_t joint;         ///< of JointTick::joints
    std::uint32_t child, parent; ///< nodes; no_tree for the world
    bool child_is_b;
    int rows;
    Scaled mass, inverse_mass;             ///< m
    int exponent;                          ///< of D
    std::int32_t below[6][6], above[6][6]; ///< J of the child and of the parent, 28 fraction bits
    std::int64_t mobility[6];              ///< k, 48 fraction bits
    std::int64_t softness[6];              ///< G m, tree_soft_bits
    std::int64_t z[6][6];                  ///< of H of the child
    BlockFactor factor;                    ///< of D
    std::int64_t solution[6];              ///< D^-1 g, then lambda: 2^-exponent of D^-1
    std::int64_t change[6];                ///< of p', Speed
};

/// One tree: consecutive entries of JointForest.
struct JointTree {
    std::uint32_t first_node, node_count;   ///< parents before children
    std::uint32_t first_joint, joint_count; ///< of JointForest::joints, in order of elimination
    bool direct;                            ///< its factor is good
};

/// A joint as the planning sees it.
struct TreeLink {
    std::uint32_t joint, a, b; ///< entries of JointTick::bodies; no_tree for the world
};

struct JointForest {
    std::vector<JointTree> trees;
    std::vector<TreeNode> nodes;
    std::vector<TreeJoint> joints;
    // for planning
    std::vector<TreeLink> links;               ///< that close no loop
    std::vector<std::uint32_t> component;      ///< by body: union-find
    std::vector<std::uint32_t> first_of, hung; ///< by body: its links, one after another
    std::vector<std::uint32_t> node_of;        ///< by body: node + 1
    /// By component: links, body, first link to the world + 1
    std::vector<std::uint32_t> size, root, anchor_of;
    std::vector<std::uint32_t> loops;    ///< by component: joints that close a loop
    std::vector<std::uint32_t> anchors;  ///< by component: joints to the world
    std::vector<std::uint32_t> above_of; ///< by node: link to its parent + 1
    std::vector<std::uint32_t> above;    ///< by body: link to its parent + 1
    std::vector<Real> carried;           ///< by body: its mass and all that hangs on it
    std::vector<std::uint32_t> queue;    ///< bodies of a tree
};

/// A net is no tree: with more than one joint of four closing a loop, what is left over decides how it stretches.
inline constexpr std::uint32_t tree_loop_part = 4;

/// Finds the trees of the tick's locks. Trees of one joint, of light loads and of nets are left to the ordinary passes.
void plan_trees(JointTick& tick, const BodyColumns& columns, const StepConstants& step,
                const SolverBodies& bodies);
/// Factorises what changed. A tree that cannot be is solved joint after joint until it changes again.
void factorise_trees(JointTick& tick, const SolverBodies& bodies, Tasks* tasks);
/// Impulses for one tree. Writes only what is of its joints and of the bodies that it moves, which are in no other tree.
void solve_tree(JointTick& tick, const JointTree& tree, SolverBodies& bodies, bool bias);

} // namespace lockstone::solve
