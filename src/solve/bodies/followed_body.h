// Followed bodies, in the form that the kernel of an instruction set reads: four side by side. See
// solve/joints/followed_turn.h for the method and its reasons, and followed_kernel.h for the kernel.
#pragma once

#include "lockstone/math/wide.h"
#include "solve/bodies/inertia.h"

namespace lockstone::solve {

struct SolverBody;

/// The turn of one followed body, for code outside of kernels.
struct FollowedTurn {
    BodyInertia now; ///< K^-1 for the present rotation of the body
    /// the rotation since the tick began as a matrix by rows, and w: as in TurnedBody
    std::int32_t turned[12];
    Quat rotation; ///< present rotation of the body
    Quat principal;
    Vec3 radii_inv; ///< of gyration [1/m]
    Vec3 own;       ///< of a stiff body: its radii without stiffening [m]
    SpeedVec3 spin; ///< at the end of the tick
    std::uint32_t body;
    /// For a body whose next turn follows its momentum: twice its energy per mass, and the value that rows use for it,
    /// |u|^2 [m^2/s^2], 64 fraction bits
    Wide energy, energy_of_u;
    /// Before and after elastic impacts: twice its energy per mass, and |u|^2
    Wide impact_energy, impact_energy_of_u;
    /// Before a pass over contacts: its velocities (SolverBody::v, u), and twice its energy per mass
    std::int64_t pass_v[3], pass_u[3];
    Wide pass_energy;
    bool meets_still;  ///< every body that it touches is still and has a still surface
    bool knows_energy; ///< its next turn follows its momentum
    bool held;         ///< by a joint
    bool stiff;        ///< turns as if it were larger: u is velocity alone, and precession is zero
};

inline constexpr unsigned followed_lanes = 4;
inline constexpr int followed_half_bits = 32;   ///< of turns of half a substep: within 1/4 rad
inline constexpr int followed_fine_bits = 26;   ///< of u from which turns are made: within 32 m/s
inline constexpr int followed_change_bits = 23; ///< of changes of u: within 256 m/s
/// 4096 m/s, 47 fraction bits: limit of |g|. Every function that changes g clamps it, so that clamping it again changes
/// nothing: a kernel skips its lanes together, if no lane has a change, and instruction sets differ in lanes.
inline constexpr std::int64_t precession_most = std::int64_t{4096} << 47;

/// Four followed bodies. Masks are all ones or zero.
struct alignas(32) FollowedFour {
    template <class T> using Lanes = T[followed_lanes];
    // constant within the tick
    Lanes<std::uint32_t> row; ///< of bodies; the still entry in unused lanes
    bool any_held;
    Lanes<std::int64_t> held, stiff;
    /// A number of the body has no room in lanes: its precession and turns are computed in Real
    Lanes<std::int64_t> alone;
    /// rotation at the start of the tick, and of the principal axes
    Lanes<std::int32_t> start[4], principal[4];
    /// Radii along the principal axes and their inverses, mantissas up to 2^30: the third one, then the first and the
    /// second minus the third
    Lanes<std::int32_t> radii[3], inverses[3];
    /// fraction bits of the inverses; BodyInertia::linear_mask
    Lanes<std::int32_t> inverse_bits, linear_mask;
    /// radii^-2 / (2 substeps per second), mantissas up to 2^30: factor from momentum to the turn of half a substep
    Lanes<std::int32_t> half_way[3];
    Lanes<std::int64_t> half_way_drop[3];
    /// the kernel skips a longer momentum: the square of half of it; from half_turn_most
    Lanes<std::int64_t> momentum_most;
    Lanes<std::int64_t> turn_drop;   ///< shift from K^-1 u to the turn of half a substep
    Lanes<std::int64_t> speed_raise; ///< shift from K w to accumulator_bits
    Lanes<std::int64_t> speed_most;  ///< the tip speed limit, before that shift
    /// left shift of the product of to_now or from_now and a change of u, to accumulator_bits
    Lanes<std::int64_t> change_raise;
    Lanes<std::int64_t> change_drop;      ///< right shift of the same product
    Lanes<std::int64_t> change_most;      ///< 4096 m/s before that shift
    Lanes<std::int32_t> axes[3][3];       ///< principal axes at the start of the tick, Unit
    Lanes<std::int32_t> k[6], inverse[6]; ///< K and K^-1 at the start of the tick
    // of the present rotation
    Lanes<std::int32_t> turn[4];                ///< since the tick began, Unit
    Lanes<std::int32_t> half[3];                ///< turn of half a substep by u [rad], 32 fraction bits
    Lanes<std::int32_t> to_now[9], from_now[9]; ///< K' K^-1 and K K'^-1, by rows
    Lanes<std::int64_t> precession[3]; ///< g, the part of u that is no momentum [m/s], 47 fraction bits
    /// between turn_in and turn_out: u before turn_in, and K' w
    Lanes<std::int64_t> u_outside[3], u_inside[3];
    std::uint32_t left; ///< bit by lane: the kernel skipped the body, since its numbers have no room
};

struct FollowPass {
    SolverBody* bodies;
    FollowedFour* fours;
    FollowedTurn* turns;
    std::int64_t tip_most;  ///< [m/s], 47 fraction bits
    std::int32_t half_rate; ///< of half substeps [1/s]
    std::int32_t half_time; ///< 1 / half_rate, as a mantissa; turn_drop includes its fraction bits
};

/// Each step handles FollowedFours [first, last). It sets FollowedFour::left for the bodies that it skips.
struct FollowKernel {
    using Step = void (*)(const FollowPass& pass, std::uint32_t first, std::uint32_t last);
    /// Principal axes, K and K^-1 at the start of the tick, and turns of half a substep by u
    Step start;
    /// Turns bodies by u for a substep. Skips bodies that turn too far
    Step turn;
    /// Computes K' and its matrices for the present rotations, and g. Keeps u of stiff bodies and of bodies that turn
    /// too far
    Step answer;
    /// The functions of followed_turn.h with these names
    Step turn_in, turn_out, note_u, keep_velocity;
    Step end; ///< FollowedTurn::spin. Skips bodies that spin too fast
};

} // namespace lockstone::solve
