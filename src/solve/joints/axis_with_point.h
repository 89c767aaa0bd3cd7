// An axis of a joint together with the point of the same joint.
//
// A limit pushes about the centres of mass. Where the point is off them, it opens, and is closed by an impulse that undoes most of what the
// limit did: of a small weight on a long arm all but a part k^2 / r^2, with k its radius of gyration and r the arm. Row after row the limit
// so takes many passes to stop the weight, gathers impulse until it has, and throws it back. So the axis takes the point along:
//
//   d = (1, -A^-1 C)    impulses: of the axis, of the point
//
// with A of the rows of the point and C between these and the axis. The speed of the point does not answer to impulses along d, so that
// axis and point, one after the other, are solved as both at once are. An A^-1 that stays behind makes another direction of it, no
// wrong one: the mobility is that of the direction. source: conjugate directions: Golub, Van Loan, Matrix Computations, 11.3
//
// What other joints of the two bodies hold is not taken along. Impulses that are started warm from the last substep then build up where a body
// is held by points far off it, many radii of gyration away, and an axis that stops it at once makes them grow: so no axis counts on
// less than a part of its own mobility (least_part_bits of pack/joint_pack.h).
#pragma once

#include "solve/joints/joint_motion.h"
#include "solve/joints/joint_work.h"

namespace lockstone::solve {

/// The point of a joint of no pack, if it has one. Packs do the same in lanes: pack/axis_kernel.h
struct JointPoint {
    JointBlock* block = nullptr;
    const Shares* shares = nullptr;
    const SolverBody *a = nullptr, *b = nullptr;
    bool exists() const { return block != nullptr; }
};
JointPoint point_of(JointTick& tick, const JointWork& work, const SolverBodies& bodies);

class AxisWithPoint {
  public:
    /// `axis` only turns; `alone` is its inverse without the point. The point may have no room for the answer: then it is left out.
    AxisWithPoint(JointPoint point, const Row& axis, const Inverse& alone);
    /// k^-1 along d.
    const Inverse& inverse() const { return along; }
    /// Along d.
    std::int64_t speed(const Motion& m) const { return speed_along(row, Speeds(m)); }
    /// A change of the impulse about the axis: to the velocities, and to the impulses of the point. Returns how many of these met their bound.
    std::uint64_t push(std::int32_t change, Motion& m) const;

  private:
    bool find(const Row& axis);
    JointPoint point;
    std::int64_t answer[3]; ///< A^-1 C, row_bits
    Row row;                ///< of d
    Inverse along;
};

} // namespace lockstone::solve
