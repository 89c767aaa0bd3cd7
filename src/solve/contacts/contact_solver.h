// Contact constraints: one per touching shape pair, up to four points.
//
//   row          D = (-d, xA ; d, xB)      d: normal or tangent, from A to B, none for a turn; x = -/+ K^-1 (r x d)
//   speed        D . (vA, uA, vB, uB)      closing is negative
//   impulse      p = lambda / m_ref        velocity units; m_ref the reduced mass of the two bodies
//   shares       alpha = m_ref / mA, beta = m_ref / mB; alpha + beta = 1 where both bodies move
//   points       lie at arms (a, b) from the members' centre, in units of the farthest point's distance
//   normal rows  D_0, the level: along the normal at the centre; D_1 and D_2, the tilts: turns about two axes across
//                the normal. The row of a point is D_0 + a D_1 + b D_2
//   Q            sum over points of p (1, a, b): the impulses of all points together
//   S            D M^-1 D^T of the normal rows times m_ref: the change of the three speeds by Q
//   members      points that touch or carry. H fits (level, tilts) to them: it turns errors of points into speeds of
//                rows, and a change of Q into the smallest impulses of points that give this change
//   softness     X = gamma H H^T, gamma the mean 1 / kappa times impulse_scale / mass_scale; none when relaxing and for
//                a hit
//   block        Q' = Q - (S + X)^-1 (D v + H bias + X Q),  p = H^T Q'
//   sweep        where a member would pull, or a point that is no member is hit: each point in turn, forwards and
//                backwards, twice: p_k' = max(p_k - kappa_k (mass_scale (s + bias_k)) - impulse_scale p_k, 0), with s
//                from S and the impulses of all other points
//   friction     two tangents at the centre and the twist (the turn about the normal), solved at once; (t1, t2) within
//                the cone of the sum of the normal impulses, the twist within their sum weighted by the points'
//                distances
//   gap          g = g0 + D . motion since the tick began
//   warm start   rows are constant within a tick, so the velocity that all impulses give a body is the sum of the
//                velocities that the passes gave it. This sum is kept by body, and a substep starts from it without a
//                pass over contacts
//
// A solver that solves the points of a contact in turn tilts and yaws a box that lies flat, each time in the same
// direction: stacks drift and walls sway. Only the sweeps solve points in turn, within a contact, and there they
// converge.
// source: soft steps as in Catto, Solver2D (2024); the mass-free, gyration-scaled rows and the block are this library's own.
#pragma once

#include "solve/bodies/solver_body.h"
#include "solve/contacts/contact.h"

#include "lockstone/simd.h"

#include <memory>
#include <string>

namespace lockstone::solve {

/// All contacts of a tick in solving order. Contacts that move the same body are solved in this order with any number
/// of workers and lanes, so all modes give the same bits.
class ContactSolver {
  public:
    ContactSolver(); ///< uses the best lanes of the machine
    ~ContactSolver();
    /// Chooses the instruction set. Returns false and changes nothing where the machine does not have it.
    bool use(Simd level);
    Simd level() const;

    /// Orders the contacts, packs and prepares them. `memory` holds the warm-start impulses. `alone`: in this tick only
    /// contacts, constant pushes and damping change velocities.
    void prepare(std::span<const solve::ContactHead> heads, std::span<const solve::Contact> contacts,
                 std::span<const solve::ContactMemory> memory, const solve::MassView& mass,
                 const solve::StepConstants& step, const solve::SolverBodies& bodies,
                 std::span<const Transform> poses, bool alone, Tasks* tasks = nullptr);
    /// After prepare(): true if solve_substeps() or solve_islands() can do the rest of the tick. False where bodies are
    /// followed, bounce or roll, or touch a body that moves but that impulses do not move.
    bool has_all_passes() const;
    /// All passes of a tick, and the motion of bodies between them. Call it after the velocities of the first substep
    /// are integrated. The bits are those of the passes one by one.
    void solve_substeps(const solve::StepConstants& step, solve::SolverBodies& bodies,
                        Tasks* tasks = nullptr);
    /// After prepare(): true if solve_islands() has to do the rest of the tick in place of solve_substeps(). This is so
    /// in a large world of islands: some islands at a time pass through all steps while they are in a processor's
    /// cache.
    bool has_islands() const;
    /// Prepares packs, integrates velocities, does all passes and the steps between them, and stores. Takes the
    /// arguments of prepare().
    void solve_islands(std::span<const solve::Contact> contacts, std::span<solve::ContactMemory> memory,
                       const solve::MassView& mass, const solve::StepConstants& step,
                       solve::SolverBodies& bodies, Tasks* tasks = nullptr);
    /// Call it before velocities are integrated. It notes velocities: bodies that approach each other faster than 0.25
    /// m/s at this point make a hit, and not a load.
    void begin_substep(const solve::SolverBodies& bodies);
    /// Call it after forces changed the velocities and before the warm start of joints and vehicles: their impulses
    /// count towards the closing speed that separates a hit from a load, and forces do not.
    void leave_forces_out(const solve::SolverBodies& bodies);
    void warm_start(solve::SolverBodies& bodies, Tasks* tasks = nullptr);
    /// Call it after the warm start of all rows. The bodies of elastic contacts whose points hit each other in this
    /// substep get the velocity with which they part. Until end_ways(), which follows the move of bodies, the velocity
    /// of such a body is the mean over the substep: of the old one until the impact and of the new one after it.
    void rebound(const solve::StepConstants& step, solve::SolverBodies& bodies);
    /// Gives the bodies that rebound() changed their velocities at the end of the substep.
    void end_ways(solve::SolverBodies& bodies);
    /// One pass over all rows. With bias, overlap is pushed out softly; without bias, the pass takes out the velocity
    /// that the push left.
    void solve(const solve::StepConstants& step, solve::SolverBodies& bodies, bool bias,
               Tasks* tasks = nullptr);
    /// Writes impulses to `memory` for the next tick.
    void store(std::span<const solve::Contact> contacts, std::span<solve::ContactMemory> memory,
               solve::ClampCounts& clamps, Tasks* tasks = nullptr) const;
    /// Lists the contacts that had elastic impacts in this tick, in the order of contacts.
    void list_impacts(std::vector<solve::ContactImpact>& out) const;

    /// The first contact that the passes of this tick take out of the order, in a sentence; empty if there is none.
    std::string order_fault() const;
    /// Adds the paths since the last call to `to`.
    void take_paths(base::Paths& to);

    void reserve(std::size_t contacts, std::size_t bodies);
    /// Fills all data that prepare() computes in each tick with the byte `with`.
    void poison(std::byte with);

  private:
    struct Inside;
    std::unique_ptr<Inside> inside;
};

} // namespace lockstone::solve
