// Direct solver for the locks of joints that form a tree: block elimination from the leaves to the root.
// source: Baraff, Linear-Time Dynamics using Lagrange Multipliers, SIGGRAPH 1996
//
//   node       a body that impulses move; the world and kinematic bodies are no nodes
//   edge       a joint between two nodes that closes no loop; a joint to the world belongs to its node
//   root       the node of the first joint to the world, eliminated last; without such a joint the heaviest body
//   M          mass of a body times the unit matrix, as it is in gyration-scaled form
//   J          rows of the locks, without the Jacobian entries of locked axes
//   lambda     impulse change m p' [kg m/s], m = mA mB / (mA + mB)
//   softness   G = epsilon times D by rows; epsilon k / m, k = J . r, for a joint to the world below the root
//
//   system            M dv = J^T lambda,   J dv + G lambda = - speed - bias - G (m p')  (relaxation: no bias, no p')
//   body i            H_i = M_i + sum over joints below of J^T D^-1 J,  f_i = sum of J^T D^-1 g
//   joint above it    D = J_i H_i^-1 J_i^T + G,  g = - speed - ... - J_i H_i^-1 f_i
//   back              lambda = D^-1 (g - J_parent dv_parent),  dv_i = H_i^-1 (f_i + J_i^T lambda)
//
// If loads are light, it is enough to solve joint after joint from the impulses of the last tick, at a sixth of the
// cost: joints of a short hanging chain are then open by about a millimetre. A tree is solved directly in two cases.
// Either it is attached to the world at two places, where joint after joint, taut chains between them would sag. Or
// some body carries many times its own mass. The carried mass is the body's own mass plus that of all bodies beyond
// it, as seen from the root.
//
//   attached to the world                      more than 4 times; with 16, a flail that falls onto its limit gains a
//                                              hundred times its energy, and a wheel that turns on a rod is carried
//                                              around too slowly
//   free                                       more than 5 times: the abdomen of a ragdoll carries 4.3 times its mass
//   all joints braked, none has limits         more than 16 times; braked: by springs, motors or friction
//   fewer than 200 substeps a second           more than 4 times: a figure that lands would sink into its ankles
//                                              before its feet have stopped it
//
// The right side is computed from the rows, and impulses act through the rows, as for all joints: an inaccurate
// factor costs accuracy, but never momentum. H is a sum of positive terms, so nothing cancels. If a body is lighter
// than 2^-24 of the mass it carries, the factor has too few bits, and the tree is solved joint after joint.
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
inline constexpr std::uint32_t tree_chunk = 4; ///< trees per chunk of work
inline constexpr int tree_softness_bits = 12;  ///< epsilon = 2^-12 of D
inline constexpr int tree_floor_bits = 20;     ///< G is at least 2^-20 of the inverse mass of the pair alone
inline constexpr int tree_soft_bits = 36;

struct TreeNode {
    std::uint32_t body;
    bool plain;  ///< H is M: no joint below it
    bool passes; ///< joints below it read its speed
    Scaled mass;
    SymmetricBlock h;
    BlockFactor factor;
    std::int64_t f[6];     ///< 2^-exponent of H, speed units; later L^-1 f
    std::int64_t speed[6]; ///< dv
};

/// A joint of a tree. The child is a node; the parent is the next node towards the root.
struct TreeJoint {
    std::uint32_t joint;         ///< entry of JointTick::joints
    std::uint32_t child, parent; ///< nodes; no_tree: the world
    bool child_is_b;
    int rows;
    Scaled mass, inverse_mass;             ///< m
    int exponent;                          ///< exponent of D
    std::int32_t below[6][6], above[6][6]; ///< J of the child and of the parent, 28 fraction bits
    std::int64_t mobility[6];              ///< k [row], 48 fraction bits
    std::int64_t softness[6];              ///< G m [row], tree_soft_bits
    std::int64_t z[6][6];                  ///< Z of condense_columns() with H of the child [row][entry]
    BlockFactor factor;                    ///< factor of D
    std::int64_t solution[6];              ///< D^-1 g, later lambda: 2^-exponent of D^-1
    std::int64_t change[6];                ///< change of p' [row], Speed
};

/// One tree: consecutive entries of JointForest.
struct JointTree {
    std::uint32_t first_node, node_count;   ///< parents before children
    std::uint32_t first_joint, joint_count; ///< of JointForest::joints, in order of elimination
    bool direct;                            ///< its factorisation succeeded
};

/// A joint as the planning reads it.
struct TreeLink {
    std::uint32_t joint, a, b; ///< of JointTick::joints and JointTick::bodies; no_tree: the world
};

struct JointForest {
    std::vector<JointTree> trees;
    std::vector<TreeNode> nodes;
    std::vector<TreeJoint> joints;
    // used only by plan_trees()
    std::vector<TreeLink> links;               ///< joints that close no loop
    std::vector<std::uint32_t> component;      ///< by body: parent in the union-find structure
    std::vector<std::uint32_t> first_of, hung; ///< by body: start of its links in `hung`
    std::vector<std::uint32_t> node_of;        ///< by body: node + 1
    /// By component: number of links, root body, first link to the world + 1
    std::vector<std::uint32_t> size, root, anchor_of;
    std::vector<std::uint32_t> loops;   ///< by component: number of joints that close a loop
    std::vector<std::uint32_t> anchors; ///< by component: number of joints to the world
    /// By component: 1 if some joint has limits, or has no spring, motor or friction
    std::vector<std::uint32_t> loose;
    std::vector<std::uint32_t> above_of; ///< by node: link to its parent + 1, 0: none
    std::vector<std::uint32_t> above;    ///< by body: link to its parent + 1, 0: none
    std::vector<Real> carried;           ///< by body: its mass plus the masses of all bodies below it
    std::vector<std::uint32_t> queue;    ///< bodies of a tree
};

/// Factors of StepConstants::tree_load for free trees and for trees of braked joints. They apply from
/// `light_tree_rate` substeps a second on.
inline constexpr Real free_tree_loads = Real(5) / Real(4), braked_tree_loads = Real(4);
inline constexpr std::int64_t light_tree_rate = 200;

/// Largest share of loop joints, as 1 / tree_loop_part. Above it the component is a net and not solved as a tree: its
/// stretch depends on the joints outside the tree.
inline constexpr std::uint32_t tree_loop_part = 4;

/// Finds the trees of the tick's locks. Trees of one joint, with light loads, or of nets stay in the ordinary passes.
void plan_trees(JointTick& tick, const BodyColumns& columns, const StepConstants& step,
                const SolverBodies& bodies);
/// Factorises the trees whose rows changed. If that fails, a tree is solved joint after joint until its rows change
/// again.
void factorise_trees(JointTick& tick, const SolverBodies& bodies, Tasks* tasks);
/// Solves one tree. Thread-safe: writes only its joints and the bodies that it moves, which belong to no other tree.
void solve_tree(JointTick& tick, const JointTree& tree, SolverBodies& bodies, bool bias);

} // namespace lockstone::solve
