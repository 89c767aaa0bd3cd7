// The point part of joints that no tree solves: the three rows that hold an anchor of A to one of B, and where packs of them
// stand in the order of solving. See joint_pack.h.
#pragma once

#include "solve/bodies/step.h"
#include "solve/joints/pack/joint_pack.h"

namespace lockstone::solve {

struct JointTick;
struct JointWork;
struct JointBlock;
struct JointAxisPart;

/// Stages of all joints. The point part of those that fit comes into a pack, and with it a block that only turns.
void plan_packs(JointTick& tick, const StepConstants& step, const SolverBodies& bodies,
                std::uint32_t workers);
/// K^-1 of the body of a side, with the fraction bits that it had.
void give_gyration(PackSide& side, std::uint32_t lane, const BodyInertia& body);
/// Of a hinge, what stays while its plan is kept: frames in the axes of their bodies, where its limits are.
void plan_hinge(JointTick& tick, const JointWork& work);
/// Its frames alone: those of what nothing moves may be others.
void set_hinge_frames(JointTick& tick, const JointWork& work);
/// `limits`: those that the pack looks at, if any; nearer than `least` they are in reach.
void set_reach(TurnPack& turn, const JointWork& work, const JointAxisPart* limits, Real least);
/// Its rows are the block's from now on.
void leave_hinge(JointBlock& block, TurnPack& turn, std::uint32_t lane);
/// The axis about which a row of it turns B.
Vec3 hinge_axis(const TurnPack& turn, std::size_t row, std::uint32_t lane);
/// Where entries of its rows have grown to 2.
void enlarge_exponent(JointPack& pack, const JointWork& work, const StepConstants& step);
/// The inverses that lanes have left, of the rows as they are.
void invert_left(JointPack& pack, TurnPack* turns, std::uint32_t lane);
/// Rows, inverse, impulses and biases of a block into its lane.
void put_turn(const JointBlock& block, TurnPack& pack, std::uint32_t lane);
void put_bias(const JointBlock& block, TurnPack& pack, std::uint32_t lane);
/// Impulses and their sums out of a lane, where sums start again from zero.
void take_impulses(JointBlock& block, TurnPack& pack, std::uint32_t lane);
void set_inverse(PackInverse& to, std::uint32_t lane, const Inverse& inverse);
/// Of locks: error to push speed, as packs read it.
std::int32_t pack_rate(const StepConstants& step);

} // namespace lockstone::solve
