// The point part of joints that no tree solves: the three rows that hold an anchor of A to one of B.
//
//   C = s, axes of the world; J = 2^-e (-1, -K_A^-1 [rA] ; 1, K_B^-1 [rB]), [r] e = r x e
//
// The generic rows of joint_rows.h say the same. Here the linear part is one number, nothing is looped over that is zero,
// and the error follows the motion by the rows themselves, so that rows stay while the bodies have hardly turned.
#pragma once

#include "dynamics/joint_motion.h"

namespace lockstone::dynamics {

struct JointTick;
struct JointWork;

/// What one body of the joint reads and answers.
struct PointSide {
    std::int32_t x[3][3]; ///< turning arms by rows, 28 fraction bits
    std::int32_t pull;    ///< 2^-e times the share, 28 fraction bits
    std::int32_t share;   ///< mantissa, 30 fraction bits
    std::int32_t shift;   ///< v += (r p) / 2^shift
};

struct PointPart {
    PointSide a, b;
    std::int32_t one; ///< 2^-e, 28 fraction bits
    Inverse inverse;
    std::int32_t impulse[3]; ///< p', Speed
    std::int64_t error[3];   ///< 2^-e C, less J . (shift, theta) of when the rows were made; Separation
    std::int32_t ahead[3];   ///< of the bias: along the arc, Speed
    std::int32_t push_max;   ///< of the bias: by the error, Speed
    std::int32_t exponent;   ///< e
    std::int64_t sum[3];     ///< of p' over the substeps so far
};

/// Whether the rows of a joint's point part may be these: bodies that impulses move may move along and turn about all axes.
bool fits_point(const JointWork& work, const SolverBodies& bodies);
/// Takes the last block of a joint, its point part, out of its blocks.
void take_point(JointTick& tick, JointWork& work);
struct JointPlace;
/// Rows where the bodies are now.
void make_point(PointPart& part, const JointWork& work, const JointPlace& place, const StepConstants& step,
                const SolverBodies& bodies);
/// One pass. Counts impulses that meet their bound.
void solve_point(PointPart& part, Motion& m, const SolverBody& a, const SolverBody& b,
                 const StepConstants& step, bool bias, std::uint64_t& clamped);
/// The impulse that the part has.
void push_point(const PointPart& part, const std::int32_t p[3], Motion& m);

} // namespace lockstone::dynamics
