// Joint constraints. A joint consists of parts with one to three rows; rows are computed from the poses of the two
// bodies, and computed again after these have turned (joint_work.h).
//
//   row          J = (dA, xA ; dB, xB)  d: direction along which the row acts on a body; x = K^-1 (its turning arm)
//                                       all of a part's J is scaled by 2^-e: its largest entry is in [1, 2)
//   speed        J . (vA, uA, vB, uB)
//   error        C: the quantity that the row keeps at zero [m] or [rad], scaled by 2^-e as well;
//                                       between two computations of the row C = C0 + J . (shift, theta)
//   response     r = share_A (dA, xA), share_B (dB, xB);  share_A = mB / (mA + mB), share_B = mA / (mA + mB)
//   inverse      of k = J . r, for each pair of rows of a part
//   impulse      p = lambda (1/mA + 1/mB), velocity units, scaled by 2^e;  v += r p
//   step         p' = p - k^-1 mass_scale (speed + bias) - impulse_scale p, then clamped to the row's bounds
//   bias         C rate + (h / 2) C'' of free motion, below
//
//   part         rows                                      C                            arms about B (A: - the same)
//   point        3: axes e of the world                    e . s,  s = pB - pA          rB x e; A: rA x e
//   along        1 to 3: axes e of frame A                 e . s                        rB x e; A: (rA + s) x e
//   orientation  3: axes e of the world                    2 vec(qB qA^-1)              e
//   plane        1, 2: xB in the x-z, x-y plane of A       -xB . zA, xB . yA            zA x xB, xB x yA
//   twist        1: about x, whole turns counted           2 atan2 of qA^-1 qB          (xA + xB) / (1 + xA . xB)
//   angle        1: of xB about y or z of A                atan2(-xB . zA, xB . xA)     xB x (gradient)
//   target       3: axes e of frame A                      log(qA^-1 qB target^-1)      e
//   swing        1: between the x axes                     their angle                  xA x xB / |xA x xB|
//   line         1: along s / |s|                          |s|                          as point
//   pulley       1: along both ropes                       |rope A| + ratio |rope B|    r x rope, times the ratio
//   gear         1: about xA and xB                        turn A + ratio turn B        ratio xB; A: + xA
//   rack         1: about xA and along xB                  turn A - ratio way B         - ratio rB x xB; A: + xA
//
// A substep runs in this order: velocities, warm start, solve with bias, poses, rows from the new poses, relaxation
// in reverse order.
//
// The bias looks ahead along the arc. A lever r that turns with w ends w x (w x r) h^2 / 2 beside its tangent; the
// solve with bias includes that offset, and the relaxation along the new lever removes the radial speed again. At 10
// rad/s and 480 substeps/s a pendulum then loses 0.03 % of its energy in a second instead of 0.6 %, and is 0.07 mm
// off its pivot instead of 0.85 mm.
// source: RATTLE, Andersen 1983; soft solve and relaxation: Catto, Solver2D, 2024.
//
// Locks of trees are solved by a direct solver (joint_tree.h). Locks of single joints and of loops release a
// twentieth of their impulse in the solve with bias, and are rigid in the relaxation. If both passes were rigid,
// joints would gain energy while they swing: one pass is not the exact solution, and no later step removes the
// difference. Springs apply their impulse in the solve with bias only; motors, friction and limits act in both
// passes.
#pragma once

#include "solve/bodies/solver_body.h"

#include <array>
#include <memory>
#include <span>
#include <string>

namespace lockstone::solve {

/// A joint as the tick passes it to the solver. The frames are outside the cache line that every tick reads.
struct alignas(64) Joint {
    const JointDef* def;
    /// Rows of the body columns; SolverBodies::still() for the world and for bodies at rest
    std::uint32_t body_a, body_b;
    std::uint32_t memory; ///< row of the memory column
    /// Joint forces up to this length (see length_above()) leave the body's inertia unchanged. 0: not computed. See
    /// joint_stiffness.h.
    std::uint64_t weak_a, weak_b;
    Transform frame_a, frame_b; ///< as in the definition; in world axes if the body is still()
};

struct JointTick;   ///< joint_work.h
struct JointKernel; ///< joint_pack.h

class JointSolver {
  public:
    explicit JointSolver(const JointKernel& lanes);
    ~JointSolver();
    JointSolver(JointSolver&&) noexcept;
    JointSolver& operator=(JointSolver&&) noexcept;
    /// Selects another kernel. Returns false, without a change, if `lanes` is nullptr.
    bool use(const JointKernel* lanes) { return lanes != nullptr && (kernel = lanes, true); }

    /// Call once a tick, before the substeps. `joints` must be in solving order. All spans must stay valid until
    /// store(). `same`: true if the joints, the masses, the degrees of freedom of the bodies and `step` equal those
    /// of the last call. This only saves the planning; results are the same.
    void prepare(std::span<const Joint> joints, std::span<const JointMemory> memory,
                 const BodyColumns& columns, const StepConstants& step, const SolverBodies& bodies,
                 Tasks* tasks = nullptr, bool same = false);
    /// Computes rows and errors from the present state of the bodies. Call before the first substep and after each
    /// move.
    void update(const StepConstants& step, const SolverBodies& bodies, Tasks* tasks = nullptr);
    void warm_start(const StepConstants& step, SolverBodies& bodies, Tasks* tasks = nullptr);
    /// One pass over all joints: springs and motors, limits, locks, and then the locks of trees. Workers share the
    /// trees.
    void solve(const StepConstants& step, SolverBodies& bodies, bool bias, Tasks* tasks = nullptr);
    /// Call after the substeps. Closes points that an impact opened by more than 6 mm (joint_close.cpp), by moving
    /// bodies. Velocities and impulses stay unchanged.
    void close(const StepConstants& step, SolverBodies& bodies);
    /// Writes impulses, unwrapped angles and reactions for the next tick and for readers. store_points() writes the
    /// joints that are only a point in a pack, store() all other joints.
    void store_points(std::span<JointMemory> memory, Tasks* tasks = nullptr) const;
    void store(std::span<JointMemory> memory, const SolverBodies& bodies, ClampCounts& clamps,
               Tasks* tasks = nullptr) const;

    /// Describes the first joint whose place in the plan breaks the solving order, in a sentence. Empty: the plan is
    /// correct.
    std::string order_fault() const;
    /// Adds the execution paths since the last call to `to`.
    void take_paths(base::Paths& to);

    void reserve(std::size_t joints);
    /// Fills all working data that prepare() writes with a byte, to expose reads of stale data.
    void poison(std::byte with);

  private:
    std::unique_ptr<JointTick> work;
    const JointKernel* kernel;
};

/// Coordinates of a joint between two poses: along and about the axes of A's frame, see JointState. `twist` is the
/// last unwrapped angle about x; the result is the equivalent angle nearest to it.
std::array<Real, joint_axis_count> joint_coordinates(const JointDef& def, const Transform& frame_a,
                                                     const Transform& frame_b, Real twist);

} // namespace lockstone::solve
