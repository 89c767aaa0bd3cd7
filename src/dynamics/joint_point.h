// The point part of joints that no tree solves: the three rows that hold an anchor of A to one of B, and where packs of them
// stand in the order of solving. See joint_pack.h.
#pragma once

#include "dynamics/joint_pack.h"
#include "dynamics/step.h"

namespace lockstone::dynamics {

struct JointTick;
struct JointWork;
struct JointBlock;
struct JointPlace;

/// Stages of all joints. The point part of those that fit comes into a pack, and with it a block that only turns.
void plan_packs(JointTick& tick, const StepConstants& step, const SolverBodies& bodies);
/// Rows where the bodies are now, into the joint's lane.
void make_point(JointPack& pack, const JointWork& work, const JointPlace& place, const StepConstants& step,
                const SolverBodies& bodies);
/// Rows, inverse, impulses and biases of a block into its lane.
void put_turn(const JointBlock& block, TurnPack& pack, std::uint32_t lane);
void put_bias(const JointBlock& block, TurnPack& pack, std::uint32_t lane);
/// Impulses and their sums out of a lane, where sums start again from zero.
void take_impulses(JointBlock& block, TurnPack& pack, std::uint32_t lane);
void set_inverse(PackInverse& to, std::uint32_t lane, const Inverse& inverse);
/// Of locks: error to push speed, as packs read it.
std::int32_t pack_rate(const StepConstants& step);

} // namespace lockstone::dynamics
