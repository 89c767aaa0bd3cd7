// Contacts side by side in lanes, in the form in which the passes read and write them. See contact_solver.h for the
// symbols.
//
//   quantity                              fraction bits   range
//   v, u of bodies                        47              2^16 m/s
//   speeds, impulses p, Q, biases         19              4096 m/s; impulses of a point within 512
//   rows D                                28              8; components within 4
//   gaps                                  27              16 m
//   arms, shares of mass, scales          30              2; arms within 1
//   kappa                                 28              8; within 4
//   S, the response to Q; the softness X  25              64; within 52
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

/// One point of N contacts. A point that the contact of a lane lacks has the largest gap and no kappa.
template <unsigned N> struct PointLanes {
    std::int32_t arm[2][N];  ///< (a, b), Unit
    std::int32_t gap0[N];    ///< at the start of the tick
    std::int32_t gap[N];     ///< at present
    std::int32_t impulse[N]; ///< p
    std::int32_t impact[N];  ///< the part of it that stopped the bodies in this substep
    std::int32_t fit[3][N];  ///< column of H; zero for points that are not members
    std::int32_t kappa[N];   ///< 1 / (arm^T S arm)
    std::int32_t reach[N];   ///< Unit: distance from the centre in arms
};

/// N contacts. No two of them share a body that impulses can move.
template <unsigned N> struct ContactPack {
    std::uint32_t body_a[N], body_b[N]; ///< entries of SolverBodies
    /// Bit per lane: impulses move the body. Other bodies are read and never written
    std::uint32_t movable_a, movable_b;
    std::uint32_t locked;       ///< not 0: one of the bodies has a locked axis
    std::uint32_t impacts;      ///< not 0: an impact of some point is not 0
    std::uint32_t hit;          ///< bit per lane: the contact stopped its bodies in this tick
    std::uint32_t bounce_count; ///< lanes that have restitution
    /// Bit per lane: the contact bounces, and its points hit each other in this substep
    std::uint32_t struck;
    std::int32_t point_count;                          ///< largest of any lane
    std::int32_t d[3][3][N];                           ///< normal and tangents
    std::int32_t share_a[N], share_b[N];               ///< alpha, beta
    std::int32_t normal_a[3][3][N], normal_b[3][3][N]; ///< angular rows: level, tilts
    std::int32_t slide_a[3][3][N], slide_b[3][3][N];   ///< angular rows: tangents, twist
    std::int32_t response[6][N];                       ///< S by rows of the lower triangle
    std::int32_t slide_inverse[6][N];
    std::int32_t bias_rate[N], mass_scale[N], impulse_scale[N]; ///< speed_bits, Unit, Unit
    std::int32_t push[N];     ///< minus the greatest speed that pushes overlap out, speed_bits
    std::int32_t friction[N]; ///< row_bits
    /// Speed of the surface of b relative to that of a along the tangents, added to the speed of the bodies
    std::int32_t surface[2][N];
    std::int32_t slide[3][N]; ///< impulses along the tangents, and of the twist
    std::int32_t several[N];  ///< -1: more than one point
    std::int32_t bounces[N];  ///< -1: has restitution
    /// Bit per lane: impulses that stop the bodies in a substep are kept in the next one
    std::uint32_t keeps;
    std::int32_t size[N]; ///< Length: the unit of the arms
    PointLanes<N> points[4];
    // Only packs with more than one point use these members; packs of single points do not read them
    std::int32_t inverse[6][N];      ///< S^-1, stored as S; zero in directions without response
    std::int32_t soft_inverse[6][N]; ///< (S + X)^-1, stored as S
    std::int32_t softness[4][N];     ///< X: level; tilts by rows of the lower triangle
};

/// The inputs of preparing a pack, by lane: its contacts and the inertia of their bodies. A lane without a contact has
/// a contact without points, and a body that does not move has zero inverse inertia.
struct PackSource {
    static constexpr unsigned lanes_max = 8;
    const Contact* contacts[lanes_max];
    const BodyInertia *a[lanes_max], *b[lanes_max];
    std::int32_t arms_of_b[lanes_max]; ///< -1: arms are measured from b, which moves
    std::int32_t ease[lanes_max];      ///< the share of its impulse that a soft contact gives up, Unit
    bool has_locks;                    ///< one of the bodies has a locked axis, linear or angular
};

/// The largest number of packs that are prepared at once.
inline constexpr unsigned prepared_at_once = 4;

/// Members are the points at most this much farther apart than the nearest point, and the points that carry [m].
inline constexpr std::int32_t member_gap = decimal<Separation>("0.001").raw;
/// A point that parts faster than this has bounced, so its warm start leaves out the impulse that made it bounce [m/s].
inline constexpr std::int32_t leaving_speed = decimal<Speed>("0.25").raw;
/// A direction with a smaller response to an impulse is left out: it is locked.
inline constexpr std::int64_t least_response = std::int64_t{1} << (response_bits - 2);

/// The velocity [m/s], 47 fraction bits, that the contact impulses of the tick have given to a body so far; the next
/// substep starts from it.
struct WarmStart {
    std::int64_t v[3], u[3];
};

/// A contact that bounces.
struct Bounce {
    std::uint32_t pack, lane;
    std::int32_t restitution; ///< Unit
    std::int32_t impulse[4];  ///< of its points: the sum of all impacts of the tick, at most impulse_limit
};

/// Rolling resistance of a contact: it brakes the relative turn of its two bodies.
struct Rolling {
    std::uint32_t pack, lane;
    std::int32_t xa[3][3], xb[3][3]; ///< [axis][component], row_bits
    std::int32_t kappa[3];           ///< kappa_bits
    std::int32_t bound;              ///< row_bits: largest |p| per normal impulse
    std::int32_t impulse[3];         ///< p
};

/// The settings of one pass over packs.
struct PassSettings {
    std::int32_t substeps_per_second;
    /// limit of gaps: the speed that closes a larger gap within a substep is out of range
    std::int32_t gap_max;
    std::int32_t bounce_speed_min; ///< a slower impact does not bounce, speed_bits
    /// true: overlap is pushed out softly; false: the pass takes out the velocity that the push left
    bool soft;
};

struct PassData {
    solve::SolverBody* bodies;
    WarmStart* warm;
    /// By body: its velocity when the substep began, before forces changed it, plus the changes by the warm start of
    /// joints and vehicles and by the hits and elastic impacts of this substep.
    WarmStart* arrival;
    std::uint32_t packs = 0; ///< number of packs
    bool asks_ahead = false; ///< the packs do not fit into the cache, so passes prefetch
};

/// The passes of one instruction set over packs [first, last) of its lane width.
struct ContactKernel {
    unsigned lanes;
    /// Computes rows, effective masses, inverses and first impulses of at most prepared_at_once packs whose heads are
    /// filled.
    void (*prepare)(void* packs, const PackSource* sources, unsigned count, const solve::SolverBody* bodies);
    void (*warm_start)(void* packs, std::uint32_t first, std::uint32_t last, const PassData& data);
    /// Sets ContactPack::struck of packs that bounce. Returns false if no point hits.
    bool (*find_hits)(void* packs, std::uint32_t count, const PassData& data, const PassSettings& settings);
    void (*solve)(void* packs, std::uint32_t first, std::uint32_t last, const PassData& data,
                  const PassSettings& settings);
};

/// The first tangent of a normal at the pole of solve::tangents_of().
void tangent_at_pole(const std::int32_t (&normal)[3], std::int32_t (&tangent)[3]);
/// The axis (fx, fy) leads to the farthest member. Where a point that is no member is farther away, the axis gets the
/// length of (ox, oy), the vector to that point. Where all members are at one spot, the axis becomes (ox, oy).
/// `member`, `farthest`: squares of the two lengths.
void stretch_axis(std::int64_t member, std::int64_t farthest, std::int32_t ox, std::int32_t oy,
                  std::int32_t& fx, std::int32_t& fy);
/// Removes the impulses that stopped bodies in this substep from the pack and from the velocities with which its bodies
/// start the next substep.
template <unsigned N> void forget_impacts(ContactPack<N>& pack, WarmStart* warm);
/// Sets ContactPack::struck: the lanes that bounce and have a point that reaches the surface within this substep faster
/// than PassSettings::bounce_speed_min.
template <unsigned N>
void find_hits(ContactPack<N>& pack, const solve::SolverBody* bodies, const PassSettings& settings);

} // namespace lockstone::solve
