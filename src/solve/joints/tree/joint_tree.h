// The locks of joints that make a tree, solved at once: block elimination from the leaves to the root.
// source: Baraff, Linear-Time Dynamics using Lagrange Multipliers, SIGGRAPH 1996
//
//   node       a body that impulses move; the world and kinematic bodies are no nodes
//   edge       a joint between two nodes that closes no loop; a joint to the world hangs on its node
//   root       the node of the first joint to the world, which is eliminated last; else the heaviest body
//   M          mass of a body times the unit matrix, as it is in gyration-scaled form
//   J          rows of the locks, Jacobian entries of axes that are locked left out
//   lambda     impulse change m p' [kg m/s], m = mA mB / (mA + mB)
//   softness   G = epsilon of D by rows; epsilon k / m, k = J . r, of a joint to the world below the root
//
//   for all at once   M dv = J^T lambda,   J dv + G lambda = - speed - bias - G (m p')  (no bias, no p' when relaxing)
//   body i            H_i = M_i + sum over joints below of J^T D^-1 J,  f_i = sum of J^T D^-1 g
//   joint above it    D = J_i H_i^-1 J_i^T + G,  g = - speed - ... - J_i H_i^-1 f_i
//   back              lambda = D^-1 (g - J_parent dv_parent),  dv_i = H_i^-1 (f_i + J_i^T lambda)
//
// Where loads are light, solving joint after joint from the impulses of the last tick does, at a sixth of the work: joints of a short chain that
// hangs are open by about a millimetre. A tree is solved at once in two cases. It hangs on the world at two places: solved joint after joint,
// what is taut between them would sag. Or some body carries many times its own mass, its own and that of the bodies which hang on it counted, away from the root.
//
//   it hangs on the world                     more than 4 times; with 16, a flail that falls onto its limit gains a hundred times its energy, and a
//                                             wheel that turns on a rod is carried around too slowly
//   it hangs on nothing                       more than 5 times: the abdomen of a ragdoll carries 4.3 times its mass
//   all its joints are braked, without limits more than 16 times: by springs, motors or friction
//   fewer than 200 substeps a second          more than 4 times: a figure that lands sinks into its ankles before its feet have stopped it
//
// The right side is computed from the rows, and impulses act through the rows, as with all joints: a factor that is a little off costs a
// little accuracy, never momentum. H is a sum of positive terms, so nothing cancels. Where a body is lighter than 2^-24 of what hangs on it,
// the factor has too few bits: such a tree is solved joint after joint.
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
    bool passes; ///< joints below it need its speed
    Scaled mass;
    SymmetricBlock h;
    BlockFactor factor;
    std::int64_t f[6];     ///< 2^-exponent of H, speed units; then L^-1 of it
    std::int64_t speed[6]; ///< change
};

/// A joint of a tree, between a node, its child, and the next node towards the root, its parent.
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
    std::vector<std::uint32_t> loops;   ///< by component: joints that close a loop
    std::vector<std::uint32_t> anchors; ///< by component: joints to the world
    /// By component: 1 where some joint has limits, or no spring, motor or friction
    std::vector<std::uint32_t> loose;
    std::vector<std::uint32_t> above_of; ///< by node: link to its parent + 1
    std::vector<std::uint32_t> above;    ///< by body: link to its parent + 1
    std::vector<Real> carried;           ///< by body: its mass and all that hangs on it
    std::vector<std::uint32_t> queue;    ///< bodies of a tree
};

/// By these, StepConstants::tree_load counts for trees that hang on nothing, and for those of braked joints; from so many substeps a second on.
inline constexpr Real free_tree_loads = Real(5) / Real(4), braked_tree_loads = Real(4);
inline constexpr std::int64_t light_tree_rate = 200;

/// A net is not solved as a tree: where more than one joint of four closes a loop, the joints outside of the tree decide how it stretches.
inline constexpr std::uint32_t tree_loop_part = 4;

/// Finds the trees of the tick's locks. Trees of one joint, of light loads and of nets are left to the ordinary passes.
void plan_trees(JointTick& tick, const BodyColumns& columns, const StepConstants& step,
                const SolverBodies& bodies);
/// Factorises the trees that changed. A tree that cannot be factorised is solved joint after joint until it changes again.
void factorise_trees(JointTick& tick, const SolverBodies& bodies, Tasks* tasks);
/// Impulses for one tree. Writes only to its joints and to the bodies that it moves, which are in no other tree.
void solve_tree(JointTick& tick, const JointTree& tree, SolverBodies& bodies, bool bias);

} // namespace lockstone::solve
