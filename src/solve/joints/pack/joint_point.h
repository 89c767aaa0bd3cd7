// The point part of joints that no tree solves: three rows that hold an anchor of A to one of B, and the packs of
// these parts in the order of solving. See joint_pack.h.
#pragma once

#include "solve/bodies/step.h"
#include "solve/joints/pack/joint_pack.h"

namespace lockstone::solve {

struct JointTick;
struct JointWork;
struct JointBlock;
struct JointAxisPart;

/// Finds the stages of all joints, and puts the points that fit into packs, together with a block without linear
/// part.
void plan_packs(JointTick& tick, const StepConstants& step, const SolverBodies& bodies,
                std::uint32_t workers);
/// Copies K^-1 of a body to a lane of a side. Its fraction bits do not change.
void give_gyration(PackSide& side, std::uint32_t lane, const BodyInertia& body);
/// Writes the data of a hinge that stays the same while its plan is kept: frames in body axes, and its limits.
void plan_hinge(JointTick& tick, const JointWork& work);
/// Writes only the frames of a hinge. Frames in world axes may change while the plan is kept.
void set_hinge_frames(JointTick& tick, const JointWork& work);
/// Sets the range in which limits cannot be reached. `limits`: the axis that the pack checks, or nullptr; `least`:
/// distance below which limits are within reach [rad].
void set_reach(TurnPack& turn, const JointWork& work, const JointAxisPart* limits, Real least);
/// Makes the block responsible for the rows of a hinge from now on.
void leave_hinge(JointBlock& block, TurnPack& turn, std::uint32_t lane);
/// Axis about which a row of a hinge turns B.
Vec3 hinge_axis(const TurnPack& turn, std::size_t row, std::uint32_t lane);
/// Raises the exponent by 1. Call if an entry of the rows is 2 or more.
void enlarge_exponent(JointPack& pack, const JointWork& work, const StepConstants& step);
/// Computes the inverses that lanes could not compute.
void invert_left(JointPack& pack, TurnPack* turns, std::uint32_t lane);
/// Copies rows, inverse, impulses and biases of a block to its lane. put_bias() copies only biases.
void put_turn(const JointBlock& block, TurnPack& pack, std::uint32_t lane);
void put_bias(const JointBlock& block, TurnPack& pack, std::uint32_t lane);
/// Copies impulses from a lane, adds its sums to those of the block, and sets the sums of the lane to zero.
void take_impulses(JointBlock& block, TurnPack& pack, std::uint32_t lane);
void set_inverse(PackInverse& to, std::uint32_t lane, const Inverse& inverse);
/// The factor from error to push speed of locks, in the format of packs.
std::int32_t pack_rate(const StepConstants& step);

} // namespace lockstone::solve
