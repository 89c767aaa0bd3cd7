// Joint constraints: parts of one to three rows, made anew from the bodies' poses where these have turned (joint_work.h).
//
//   row          J = (dA, xA ; dB, xB)  d: direction along which the row acts on a body; x = K^-1 (its turning arm)
//                                       all of a part's J is scaled by 2^-e: its largest entry is in [1, 2)
//   speed        J . (vA, uA, vB, uB)
//   error        C: what the row keeps at zero [m] or [rad], scaled by 2^-e as well; C0 + J . (shift, theta) between
//   response     r = share_A (dA, xA), share_B (dB, xB);  share_A = mB / (mA + mB), share_B = mA / (mA + mB)
//   inverse      of k = J . r per pair of rows of a part
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
// A substep: velocities, warm start, solve with bias, poses, rows from the new poses, relax, backwards.
// The bias looks ahead along the arc: a lever r that turns with w ends w x (w x r) h^2 / 2 beside its tangent, and the
// solve with bias counts that in; relaxing along the new lever takes the radial speed out again. At 10 rad/s and 480
// substeps/s a pendulum so loses 0.03 % of its energy in a second instead of 0.6 %, and is 0.07 mm off its pivot
// instead of 0.85 mm. source: RATTLE, Andersen 1983; soft solve and relaxation: Catto, Solver2D, 2024.
//
// Locks of trees are solved at once, see joint_tree.h. Those of joints alone and of loops let go of a twentieth of their
// impulse in the solve with bias and are rigid in the relaxation: rigid throughout, they gain energy while they swing,
// for one pass is not the exact solution and nothing takes the difference out. Springs give their impulse in the solve
// with bias only; motors, friction and limits act in both.
#pragma once

#include "solve/bodies/solver_body.h"

#include <array>
#include <memory>
#include <span>
#include <string>

namespace lockstone::solve {

/// A living joint as the tick hands it over. Frames are in another cache line than what is asked of it in every tick.
struct alignas(64) Joint {
    const JointDef* def;
    /// Rows of the body columns; SolverBodies::still() for the world and for what rests
    std::uint32_t body_a, body_b;
    std::uint32_t memory; ///< row of the memory column
    /// Forces that leave the body's inertia as it is, as length_above(); 0: not found. joint_stiffness.h
    std::uint64_t weak_a, weak_b;
    Transform frame_a, frame_b; ///< as in the definition; where the body is still(), in the world
};

struct JointTick;   ///< joint_work.h
struct JointKernel; ///< joint_pack.h

class JointSolver {
  public:
    explicit JointSolver(const JointKernel& lanes);
    ~JointSolver();
    JointSolver(JointSolver&&) noexcept;
    JointSolver& operator=(JointSolver&&) noexcept;
    /// False, and nothing changes, without lanes.
    bool use(const JointKernel* lanes) { return lanes != nullptr && (kernel = lanes, true); }

    /// Once a tick, before the substeps. `joints` in solving order; all spans are kept until store(). `same`: joints, masses and
    /// what bodies are free to do, and `step`, are those of the last call. It saves the plan, and changes nothing else.
    void prepare(std::span<const Joint> joints, std::span<const JointMemory> memory,
                 const BodyColumns& columns, const StepConstants& step, const SolverBodies& bodies,
                 Tasks* tasks = nullptr, bool same = false);
    /// Rows and errors from where the bodies are now: before the first substep and after each move.
    void update(const StepConstants& step, const SolverBodies& bodies, Tasks* tasks = nullptr);
    void warm_start(const StepConstants& step, SolverBodies& bodies, Tasks* tasks = nullptr);
    /// One pass over all joints: springs and motors, limits, locks; then the locks of trees, which workers share.
    void solve(const StepConstants& step, SolverBodies& bodies, bool bias, Tasks* tasks = nullptr);
    /// After the substeps: closes points that are further off than 6 mm, by moving bodies; no speed and no impulse changes.
    void close(const StepConstants& step, SolverBodies& bodies);
    /// Impulses, unwrapped angles and reactions for the next tick and for readers: of points in packs, and of all others.
    void store_points(std::span<JointMemory> memory, Tasks* tasks = nullptr) const;
    void store(std::span<JointMemory> memory, const SolverBodies& bodies, ClampCounts& clamps,
               Tasks* tasks = nullptr) const;

    /// The first joint that the passes of this tick take out of the order, in a sentence; empty: there is none.
    std::string order_fault() const;
    /// The paths since the last call, which it adds to `to`.
    void take_paths(base::Paths& to);

    void reserve(std::size_t joints);
    /// Fills what prepare() makes anew with a byte.
    void poison(std::byte with);

  private:
    std::unique_ptr<JointTick> work;
    const JointKernel* kernel;
};

/// Coordinates of a joint between two poses: along and about the axes of A's frame; see JointState.
/// `twist` is the last unwrapped angle about x; the new one is the nearest to it.
std::array<Real, joint_axis_count> joint_coordinates(const JointDef& def, const Transform& frame_a,
                                                     const Transform& frame_b, Real twist);

} // namespace lockstone::solve
