// Contacts side by side in lanes, as the solver walks over them. See contact_solver.h for the symbols.
//
//   quantity                              fraction bits   range
//   v, u of bodies                        47              2^16 m/s
//   speeds, impulses p, Q, biases         19              4096 m/s; impulses of a point within 512
//   rows D                                28              8; components within 4
//   gaps                                  27              16 m
//   arms, shares of mass, scales          30              2; arms within 1
//   kappa                                 28              8; within 4
//   S, the response to Q; the softness X   25              64; within 52
//   S^-1 and the inverse for friction     18              8192
//   H, from (level, tilts) to points      26              32; within 16
#pragma once

#include "lockstone/math/decimal.h"
#include "solve/bodies/solver_body.h"
#include "solve/contacts/contact.h"

namespace lockstone::solve {

inline constexpr int speed_bits = 19, gap_bits = 27, unit_bits = 30, kappa_bits = 28, response_bits = 25,
                     inverse_bits = 18, fit_bits = 26;
inline constexpr std::int32_t impulse_limit = (1 << 28) - 1; ///< 512 m/s, of a point
inline constexpr std::uint32_t none = 0xffffffffu;

/// One point of N contacts. The points that a lane lacks are far apart and have no kappa.
template <unsigned N> struct PointLanes {
    std::int32_t arm[2][N];  ///< (a, b), Unit
    std::int32_t gap0[N];    ///< when the tick began
    std::int32_t gap[N];     ///< now
    std::int32_t impulse[N]; ///< p
    std::int32_t impact[N];  ///< what of it stopped the bodies in this substep
    std::int32_t fit[3][N];  ///< column of H; zero for points that are not members
    std::int32_t kappa[N];   ///< 1 / (arm^T S arm)
    std::int32_t reach[N];   ///< Unit: distance from the centre in arms
};

/// N contacts, of which no two share a body that can move.
template <unsigned N> struct ContactPack {
    std::uint32_t body_a[N], body_b[N]; ///< entries of SolverBodies
    /// Bit per lane: impulses move the body; others are read, never written
    std::uint32_t movable_a, movable_b;
    std::uint32_t locked;                ///< not 0: one of the bodies has a locked axis
    std::uint32_t impacts;               ///< not 0: an impact of a point is not 0
    std::uint32_t hit;                   ///< bit per lane: stopped its bodies in this tick
    std::uint32_t bounce, bounce_count;  ///< its entries of the table of bounces that may bounce yet
    std::int32_t point_count;            ///< most of any lane
    std::int32_t d[3][3][N];             ///< normal and tangents
    std::int32_t share_a[N], share_b[N]; ///< alpha, beta
    std::int32_t normal_a[3][3][N], normal_b[3][3][N]; ///< angular rows: level, tilts
    std::int32_t slide_a[3][3][N], slide_b[3][3][N];   ///< angular rows: tangents, twist
    std::int32_t response[6][N];                       ///< S by rows of the lower triangle
    std::int32_t slide_inverse[6][N];
    std::int32_t bias_rate[N], mass_scale[N], impulse_scale[N]; ///< speed_bits, Unit, Unit
    std::int32_t push[N];     ///< minus the greatest speed that pushes overlap out, speed_bits
    std::int32_t friction[N]; ///< row_bits
    /// Speed of the surface of b against that of a along the tangents, added to that of the bodies
    std::int32_t surface[2][N];
    std::int32_t slide[3][N]; ///< impulses along the tangents, and of the twist
    std::int32_t several[N];  ///< -1: more than one point
    std::int32_t bounces[N];  ///< -1: has restitution
    /// Bit per lane: impulses that stop the bodies in a substep are kept in the next one
    std::uint32_t keeps;
    std::int32_t size[N]; ///< Length: the arms' unit
    PointLanes<N> points[4];
    // Of packs with more than one point alone; packs of single points do not touch these
    std::int32_t inverse[6][N];      ///< S^-1 as S; zero in directions that nothing answers to
    std::int32_t soft_inverse[6][N]; ///< (S + X)^-1 likewise
    std::int32_t softness[4][N];     ///< X: level; tilts by rows of the lower triangle
};

/// What a pack is prepared from, by lane: its contacts and how their bodies turn. Lanes without a contact have one without points, and what
/// does not move turns by nothing.
struct PackSource {
    static constexpr unsigned lanes_max = 8;
    const Contact* contacts[lanes_max];
    const BodyInertia *a[lanes_max], *b[lanes_max];
    std::int32_t arms_of_b[lanes_max]; ///< -1: arms are measured from b, which moves
    std::int32_t ease[lanes_max];      ///< how much of its impulse a soft contact yields, Unit
    bool has_locks;                    ///< one of the bodies has a locked axis, of moving or of turning
};

/// So many packs are prepared at once, at most.
inline constexpr unsigned prepared_at_once = 4;

/// Points at most this much farther apart than the nearest, and those that carry, are members [m].
inline constexpr std::int32_t member_gap = decimal<Separation>("0.001").raw;
/// A point that parts faster than this has bounced; it does not start from the impulse that made it bounce [m/s].
inline constexpr std::int32_t leaving_speed = decimal<Speed>("0.25").raw;
/// A direction that answers less than that to an impulse is left out: it is locked.
inline constexpr std::int64_t least_response = std::int64_t{1} << (response_bits - 2);

/// Of a body [m/s], 47 fraction bits: what the contact impulses of the tick so far give to it, the start of the next substep.
struct WarmStart {
    std::int64_t v[3], u[3];
};

/// What a contact that bounces keeps of a tick, besides its lane.
struct Bounce {
    std::uint32_t pack, lane;
    std::int32_t restitution; ///< Unit
    std::int32_t approach[4]; ///< normal speed of the points before they were hit in this tick
    std::int32_t impulse_max[4];
    std::int64_t taken; ///< twice the energy that its points took in this tick, per m_ref: speed squared
};

/// Brakes the turning of the two bodies of a contact against each other.
struct Rolling {
    std::uint32_t pack, lane;
    std::int32_t xa[3][3], xb[3][3]; ///< [axis][component], row_bits
    std::int32_t kappa[3];           ///< kappa_bits
    std::int32_t bound;              ///< row_bits: most |p| per normal impulse
    std::int32_t impulse[3];         ///< p
};

/// One pass over packs: which instruction set does it is chosen when the program starts.
struct PassSettings {
    std::int32_t substeps_per_second;
    std::int32_t gap_max;          ///< beyond it the speed that closes a gap within a substep has no meaning
    std::int32_t bounce_speed_min; ///< what comes in slower does not bounce, speed_bits
    bool soft;                     ///< overlap is pushed out softly; without, what the push left is relaxed
};

struct PassData {
    solve::SolverBody* bodies;
    WarmStart* warm;
    /// By body: its velocity when the substep began, before forces act in it, and what joints' warm start and hits of this substep gave.
    WarmStart* arrival;
    Bounce* bounces;
    std::uint32_t packs = 0; ///< how many there are
    bool asks_ahead = false; ///< they do not fit into the cache
};

/// The passes of one instruction set over packs [first, last) of its lane width.
struct ContactKernel {
    unsigned lanes;
    /// Rows, effective masses, inverses and first impulses of packs whose heads are filled: at most prepared_at_once.
    void (*prepare)(void* packs, const PackSource* sources, unsigned count, const solve::SolverBody* bodies);
    void (*warm_start)(void* packs, std::uint32_t first, std::uint32_t last, const PassData& data);
    /// At which speed each point that was not hit yet comes in, of the bounces that packs count.
    void (*measure_approaches)(const void* packs, std::uint32_t count, const PassData& data);
    void (*solve)(void* packs, std::uint32_t first, std::uint32_t last, const PassData& data,
                  const PassSettings& settings);
};

/// The first tangent of a normal at the pole of solve::tangents_of().
void tangent_at_pole(const std::int32_t (&normal)[3], std::int32_t (&tangent)[3]);
/// The axis (fx, fy) leads to the farthest member. Where a point that is no member is farther, the axis is made as long as the way (ox, oy)
/// to that point; where all members are at one spot it takes the direction of that way too. Arguments are squares of lengths.
void stretch_axis(std::int64_t member, std::int64_t farthest, std::int32_t ox, std::int32_t oy,
                  std::int32_t& fx, std::int32_t& fy);
/// Removes the impulses that stopped bodies in this substep: from the pack, and from what its bodies start the next substep with.
template <unsigned N> void forget_impacts(ContactPack<N>& pack, WarmStart* warm);
/// Measures at which speed each point that was not hit yet comes in. This is done in every substep: a ball that bounced with the speed
/// that it had when the tick began would lose what it gained since then, a twentieth of its height in each bounce.
template <unsigned N>
void measure_approach(const ContactPack<N>& pack, Bounce* bounces, const solve::SolverBody* bodies);
/// Keeps the speeds at which the points of a pack that were not hit yet come in.
template <unsigned N>
void keep_approach(const ContactPack<N>& pack, Bounce* bounces, const std::int32_t (&speed)[4][N]);
/// After the normals of a pack that bounces: the energy that its points took. Speeds are those without bias. What will not bounce in this tick
/// is counted no more.
template <unsigned N>
void note_bounce(ContactPack<N>& pack, Bounce* bounces, std::int32_t speed_min,
                 const std::int32_t (&speed_before)[4][N], const std::int32_t (&speed_after)[4][N],
                 const std::int32_t (&impulse_before)[4][N]);

} // namespace lockstone::solve
