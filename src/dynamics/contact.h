// Contact constraints: one per touching shape pair, up to four points with a normal and two friction rows each.
//
//   row          D = (-d, xA ; d, xB)      d: normal or tangent, from A to B;  xA = -K_A^-1 (rA x d), xB = K_B^-1 (rB x d)
//   speed        D . (vA, uA, vB, uB)      closing is negative
//   impulse      p = lambda / m_ref        velocity units; m_ref the largest effective mass of the contact's rows
//   ratios       kappa_r = m_r / m_ref     in (0, 1];   ratio_A = m_ref / m_A, ratio_B = m_ref / m_B in [0, 1]
//   step         p' = max(p - kappa (mass_scale speed + bias) - impulse_scale p, 0)
//   separation   s = s0 + d . (shift_B - shift_A) + xA . theta_A + xB . theta_B
//   bounce       a point gives back the part e^2 of the energy it took, and leaves at e times the approach at most
//   rolling      for each world axis e: D = (0, -L K_A^-1 e ; 0, L K_B^-1 e), L a gyration radius; |p| <= coefficient / L times
//                the normal impulse
//   mean row     the normal rows of a contact's points, averaged; takes an impact before the points share out the rest
//   block        at rest the members, points that touch, are solved at once. Normal rows are D_0 + a D_1 + b D_2, D_0 at
//                the members' centre and (a, b) from there in the plane, in units of the block's arm. With the sums
//                Q = (sum p, sum a p, sum b p) of impulses and H the linear fit over the members (H e: level and tilts):
//                    (S + gamma H H^T) w = -(D v + H bias + gamma H p),   Q' = Q + w,   p' = H^T Q'
//                gamma is the softness, 0 when relaxing. Friction: the two tangents at the centre and the twist about n,
//                shared out as normal impulses times a motion of the plane. What leaves its cone, and normal impulses
//                that would pull, are solved point by point instead.
//
// source: soft steps as in Catto, Solver2D (2024); energetic restitution as in Stronge, Impact Mechanics (2000); the
// mass-free, gyration-scaled rows are this library's own.
#pragma once

#include "base/parallel.h"
#include "dynamics/contact_order.h"
#include "dynamics/lanes.h"
#include "dynamics/solver_body.h"

namespace lockstone::dynamics {

/// A contact as the narrow phase leaves it, in world axes; levers are from each body's centre of mass.
struct ContactPoint {
    LengthVec3 lever_a, lever_b; ///< [m]
    Separation separation;       ///< [m]
};
struct Contact {
    std::uint32_t body_a, body_b; ///< rows of the body columns
    std::uint32_t memory;         ///< row of the contact columns; its points are these points
    std::uint32_t count;
    UnitVec3 normal;            ///< a to b
    Jacobian friction;          ///< combined coefficient
    Unit restitution;           ///< combined
    Unit rolling;               ///< combined rolling resistance [m]
    SpeedVec3 surface_velocity; ///< of b's surface against a's, world axes [m/s]
    std::array<ContactPoint, 4> points;
};

/// The two tangents of a normal: the same for the same normal, and nearly the same for nearly the same. Friction is
/// remembered along them; a frame that turned by a right angle when a floor tilts by a rounding would throw it aside.
struct Tangents {
    UnitVec3 first, second;
};
Tangents tangents_of(UnitVec3 normal);

/// One point of N contacts.
template <unsigned N> struct PointPack {
    Int32<N> xa[3][3], xb[3][3]; ///< [row][axis], Jacobian
    Int32<N> kappa[3];           ///< Unit
    Int32<N> kappa_soft;         ///< Unit: kappa * mass_scale of the normal row
    Int32<N> ratio_a, ratio_b;   ///< Unit
    Int32<N> impulse[3];         ///< p, Speed: normal, tangent 1, tangent 2
    Int32<N> impact;             ///< what of impulse[0] stopped the bodies in this substep, Speed
    Int32<N> impulse_max;        ///< of the normal row over all substeps
    Int32<N> separation;         ///< s0, Separation
    Int32<N> approach;           ///< normal speed before it was hit in this tick, Speed
    Int64<N> taken; ///< energy the normal row took in this tick, per half effective mass: Speed squared
};

/// The average of the normal rows of N contacts. Points solved one after another turn a box that lands flat: the first
/// takes the whole impact at one corner, and friction makes a slide of the turn. The mean row takes it at their centre.
template <unsigned N> struct MeanRow {
    Int32<N> xa[3], xb[3]; ///< Jacobian
    Int32<N> share[4];     ///< Unit: impulse of each point per mean speed; 0 where a contact has one point
    Int32<N> count_inv;    ///< Unit: 1 / points of the lane
};

/// The members of N contacts as a block; see the table above. Points one after another tilt and yaw a box that lies flat,
/// each time the same way: stacks drift and walls begin to sway.
template <unsigned N> struct BlockRows {
    Int32<N> xa[3][3], xb[3][3];           ///< D_0, D_1, D_2, Jacobian
    Int32<N> slide_a[3][3], slide_b[3][3]; ///< both tangents at the centre, and the twist
    Int32<N> arm[2][4];                    ///< a, b of each point, Unit
    Int32<N> fit[3][4];                    ///< H, 26 fraction bits; zero for points that are not members
    Int32<N> soft[6], rigid[6],
        slide[6];         ///< inverse of the 3x3 matrices by rows of the lower triangle, 20 fraction bits
    Int32<N> response[6]; ///< S likewise, 24 fraction bits
    Int32<N> gamma;       ///< 20 fraction bits
    Int32<N> count;       ///< of members; 0: there is no block
    Int32<N> members;     ///< bit per point
};
inline constexpr int fit_bits = 26, block_inverse_entry_bits = 20, response_bits = 24;

/// Brakes the turning of two bodies against each other; see the table above.
template <unsigned N> struct RollingRows {
    Int32<N> xa[3][3], xb[3][3]; ///< [axis][component], Jacobian
    Int32<N> kappa[3];           ///< Unit
    Int32<N> ratio_a, ratio_b;   ///< Unit
    Int32<N> share[4];           ///< Jacobian: bound of |p| per normal impulse of each point
    Int32<N> impulse[3];         ///< p, Speed
};

/// N contacts of one stage: no two of them share a body that can move.
template <unsigned N> struct ContactPack {
    std::uint32_t body_a[N], body_b[N]; ///< entries of SolverBodies
    std::uint32_t contact[N];           ///< index in the tick's contacts; no_contact for an empty lane
    std::uint32_t moves_a, moves_b; ///< bit per lane: impulses move the body; others are read, never written
    std::int32_t point_count;       ///< most of any lane; the points a lane lacks are zero
    Int32<N> d[3][3];               ///< [row][axis], Jacobian
    Int32<N> friction;              ///< Jacobian format
    Int32<N> restitution;           ///< Unit
    Int32<N> bias_rate, impulse_scale; ///< Speed, Unit
    Int32<N> surface[2];               ///< Speed: what the friction rows take for rest is this much off
    std::uint32_t rolling;             ///< index of its RollingRows, no_contact: none
    MeanRow<N> mean;
    BlockRows<N> block;
    PointPack<N> points[4];
};
inline constexpr std::uint32_t no_contact = 0xffffffffu;

/// Packs per piece of work that workers take.
inline constexpr std::uint32_t pack_chunk = 16;

/// The velocities of the two bodies of N contacts, gathered once and scattered once.
template <unsigned N> struct Pair { Int64<N> va[3], ua[3], vb[3], ub[3]; };

/// All contacts of a tick in solving order, at a lane width of N. Stage by stage: within one, packs share nothing that
/// is written, so workers take them in any order.
template <unsigned N> class ContactSolver {
  public:
    /// Orders the contacts, packs and prepares them. `memory` holds the warm-start impulses.
    void prepare(std::span<const Contact> contacts, std::span<const ContactMemory> memory,
                 std::span<const BodyMass> mass, const StepConstants& step, const SolverBodies& bodies,
                 Tasks* tasks = nullptr);
    void warm_start(SolverBodies& bodies, Tasks* tasks = nullptr);
    /// One pass over all rows. With bias, overlap is pushed out softly; without, what the push left is relaxed.
    void solve(const StepConstants& step, SolverBodies& bodies, bool bias, Tasks* tasks = nullptr);
    void apply_restitution(const StepConstants& step, SolverBodies& bodies, Tasks* tasks = nullptr);
    /// Writes impulses to `memory` for the next tick.
    void store(std::span<const Contact> contacts, std::span<ContactMemory> memory, ClampCounts& clamps,
               Tasks* tasks = nullptr) const;

    std::size_t pack_count() const { return packs.size(); }
    void reserve(std::size_t contacts, std::size_t bodies);
    /// Fills what prepare() makes anew with a byte.
    void poison(std::byte with);

  private:
    void place_packs(std::span<const Contact> contacts); ///< which contacts each pack has
    void solve_pack(const StepConstants& step, SolverBodies& bodies, bool bias, ContactPack<N>& pack);
    void solve_rolling(const ContactPack<N>& pack, Pair<N>& pair);
    template <class Visit> void for_each_pack(Tasks* tasks, Visit&& visit);

    std::vector<ContactPack<N>> packs;
    std::vector<std::uint32_t> stage_begin; ///< first pack of each stage, and the end
    std::vector<RollingRows<N>> rolling;
    ContactOrder order;
};

extern template class ContactSolver<1>;
extern template class ContactSolver<4>;

} // namespace lockstone::dynamics
