// An axis of a joint together with the point of the same joint.
//
// A limit pushes about the centres of mass. If the point is away from them, the push opens it, and the impulse that
// closes it undoes most of the limit's effect: for a small weight on a long arm all but the fraction k^2 / r^2, with
// radius of gyration k and arm r. Solved row after row, the limit needs many passes to stop the weight, accumulates
// impulse in the meantime, and throws the weight back. The axis therefore applies impulses to the point too:
//
//   d = (1, -A^-1 C)    impulses: of the axis, of the point
//
// A belongs to the rows of the point, and C couples these with the axis. Impulses along d do not change the speed of
// the point, so solving axis and point in sequence gives the solution of both together. If A^-1 is out of date, d is
// another direction, but the result stays valid, because the mobility is computed for that d.
// source: conjugate directions: Golub, Van Loan, Matrix Computations, 11.3
//
// Other joints of the two bodies are not included. If a body is held by points many radii of gyration away,
// warm-started impulses then build up, and an axis that stops the body in one pass makes them grow. The mobility of
// an axis therefore counts as at least a fixed part of its own mobility without the point (least_part_bits of
// pack/joint_pack.h).
#pragma once

#include "solve/joints/joint_motion.h"
#include "solve/joints/joint_work.h"

namespace lockstone::solve {

/// The point of a joint outside packs, if it has one. Packs do the same in lanes: pack/axis_kernel.h
struct JointPoint {
    JointBlock* block = nullptr;
    const Shares* shares = nullptr;
    const SolverBody *a = nullptr, *b = nullptr;
    bool exists() const { return block != nullptr; }
};
JointPoint point_of(JointTick& tick, const JointWork& work, const SolverBodies& bodies);

class AxisWithPoint {
  public:
    /// `axis` must have no linear part; `alone` is its inverse without the point. The point is left out if A^-1 C or
    /// d does not fit into the number format.
    AxisWithPoint(JointPoint point, const Row& axis, const Inverse& alone);
    /// k^-1 along d
    const Inverse& inverse() const { return along; }
    /// Speed along d
    std::int64_t speed(const Motion& m) const { return speed_along(row, Speeds(m)); }
    /// Applies a change of the impulse about the axis to the velocities and to the impulses of the point. Returns how
    /// many point impulses were clamped.
    std::uint64_t push(std::int32_t change, Motion& m) const;

  private:
    bool find(const Row& axis);
    JointPoint point;
    std::int64_t answer[3]; ///< A^-1 C, row_bits
    Row row;                ///< d
    Inverse along;
};

} // namespace lockstone::solve
