// Contact constraints: one per touching shape pair, up to four points.
//
//   row          D = (-d, xA ; d, xB)      d: normal or tangent, from A to B, none for a turn; x = -/+ K^-1 (r x d)
//   speed        D . (vA, uA, vB, uB)      closing is negative
//   impulse      p = lambda / m_ref        velocity units; m_ref the reduced mass of the two bodies
//   shares       alpha = m_ref / mA, beta = m_ref / mB; alpha + beta = 1 where both bodies move
//   points       lie at arms (a, b) from the members' centre, in units of the farthest point's distance
//   normal rows  D_0 level at the centre, D_1 and D_2 tilts: a point's row is D_0 + a D_1 + b D_2
//   Q            sum over points of p (1, a, b): what all of them push
//   S            D M^-1 D^T of the normal rows times m_ref: how the three speeds answer to Q
//   members      points that touch or carry. H fits (level, tilts) to them: errors of points to speeds of rows, and the
//                change of Q to impulses of points, which are the smallest that give it
//   softness     X = gamma H H^T, gamma the mean 1 / kappa times impulse_scale / mass_scale; none when relaxing, and for a hit
//   block        Q' = Q - (S + X)^-1 (D v + H bias + X Q),  p = H^T Q'
//   sweep        where a member would pull, or a point that is none is hit: point after point, forwards and backwards twice,
//                p_k' = max(p_k - kappa_k (mass_scale (s + bias_k)) - impulse_scale p_k, 0), s by S from all others
//   friction     two tangents at the centre and the twist about the normal, solved at once; (t1, t2) within the cone of the
//                sum of the normal impulses, the twist within their sum weighted by the points' distances
//   gap          g = g0 + D . motion since the tick began
//   warm start   rows are constant within a tick, so the velocity that all impulses give a body is the sum of what the passes gave it. This
//                sum is kept by body, and a substep starts from it without a pass over contacts
//
// Points that are solved one after another tilt and yaw a box that lies flat, each time the same way: stacks drift and walls sway. Only
// the sweeps solve points one after another, within a contact, and there they converge.
// source: soft steps as in Catto, Solver2D (2024); the mass-free, gyration-scaled rows and the block are this library's own.
#pragma once

#include "solve/bodies/solver_body.h"
#include "solve/contacts/contact.h"

#include "lockstone/simd.h"

#include <memory>
#include <string>

namespace lockstone::solve {

/// All contacts of a tick in solving order. What moves the same body comes in order, whatever workers and lanes there are: they give the same
/// bits.
class ContactSolver {
  public:
    ContactSolver(); ///< with the best lanes that the machine has
    ~ContactSolver();
    /// False, and nothing changes, where the machine has no such lanes.
    bool use(Simd level);
    Simd level() const;

    /// Orders the contacts, packs and prepares them. `memory` holds the warm-start impulses. `alone`: in this tick nothing but contacts, constant
    /// pushes and damping changes velocities.
    void prepare(std::span<const solve::ContactHead> heads, std::span<const solve::Contact> contacts,
                 std::span<const solve::ContactMemory> memory, const solve::MassView& mass,
                 const solve::StepConstants& step, const solve::SolverBodies& bodies,
                 std::span<const Transform> poses, bool alone, Tasks* tasks = nullptr);
    /// After prepare(): whether solve_substeps() can do all that follows. Not where bodies are followed, bounce or roll, or touch what is driven.
    bool has_all_passes() const;
    /// All passes of a tick, and what moves bodies between them, once the velocities of the first substep are integrated. The bits are those of
    /// the passes one by one.
    void solve_substeps(const solve::StepConstants& step, solve::SolverBodies& bodies,
                        Tasks* tasks = nullptr);
    /// After prepare(): whether solve_islands() is to do all that follows in place of it: of a large world of islands, some of them at a time, while they
    /// are in a processor's cache.
    bool has_islands() const;
    /// Prepares packs, integrates velocities, does all passes and what comes between them, and stores. Takes what prepare() took.
    void solve_islands(std::span<const solve::Contact> contacts, std::span<solve::ContactMemory> memory,
                       const solve::MassView& mass, const solve::StepConstants& step,
                       solve::SolverBodies& bodies, Tasks* tasks = nullptr);
    /// Before velocities are integrated: what comes together faster than 0.25 m/s now is a hit, not a load.
    void begin_substep(const solve::SolverBodies& bodies);
    /// After begin_substep, and before the warm start of joints: their impulses count towards the closing speed that separates a hit from a load.
    void leave_forces_out(const solve::SolverBodies& bodies);
    void warm_start(solve::SolverBodies& bodies, Tasks* tasks = nullptr);
    /// One pass over all rows. With bias, overlap is pushed out softly; without, what the push left is relaxed.
    void solve(const solve::StepConstants& step, solve::SolverBodies& bodies, bool bias,
               Tasks* tasks = nullptr);
    /// Whether apply_restitution() has anything to do.
    bool has_bounces() const;
    void apply_restitution(const solve::StepConstants& step, solve::SolverBodies& bodies);
    /// Writes impulses to `memory` for the next tick.
    void store(std::span<const solve::Contact> contacts, std::span<solve::ContactMemory> memory,
               solve::ClampCounts& clamps, Tasks* tasks = nullptr) const;

    /// The first contact that the passes of this tick take out of the order, in a sentence; empty: there is none.
    std::string order_fault() const;
    /// The paths since the last call, which it adds to `to`.
    void take_paths(base::Paths& to);

    void reserve(std::size_t contacts, std::size_t bodies);
    /// Fills what prepare() makes anew with a byte.
    void poison(std::byte with);

  private:
    struct Inside;
    std::unique_ptr<Inside> inside;
};

} // namespace lockstone::solve
