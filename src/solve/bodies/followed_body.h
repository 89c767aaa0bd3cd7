// Bodies that are followed as they spin, as the kernel of an instruction set has them: four side by side. What is done to them, and why:
// solve/joints/followed_turn.h; the kernel: followed_kernel.h.
#pragma once

#include "lockstone/math/wide.h"
#include "solve/bodies/inertia.h"

namespace lockstone::solve {

struct SolverBody;

/// The turn of a body that is followed, one by one.
struct FollowedTurn {
    BodyInertia now;         ///< K^-1 of where the body is now
    std::int32_t turned[12]; ///< since the tick began, and w: as in TurnedBody
    Quat rotation;           ///< of the body now
    Quat principal;
    Vec3 radii_inv; ///< of gyration [1/m]
    Vec3 own;       ///< radii of a stiff body as it is [m]
    SpeedVec3 spin; ///< when the tick ends
    std::uint32_t body;
    /// For a body whose next turn follows its momentum: twice its energy per mass, and the value that rows use for it, |u|^2 [m^2/s^2], 64
    /// fraction bits
    Wide energy, energy_of_u;
    bool knows_energy; ///< its coming turn is such a one
    bool held;         ///< by a joint
    bool stiff;        ///< turns as if it were larger: u is velocity alone, and precession zero
};

inline constexpr unsigned followed_lanes = 4;
inline constexpr int followed_half_bits = 32;   ///< of turns of half a substep: within 1/4 rad
inline constexpr int followed_fine_bits = 26;   ///< of u where turns are made of it: within 32 m/s
inline constexpr int followed_change_bits = 23; ///< and of its changes: within 256 m/s

/// Four of these. Masks are all ones or zero.
struct alignas(32) FollowedFour {
    template <class T> using Lanes = T[followed_lanes];
    // constant within the tick
    Lanes<std::uint32_t> row; ///< of bodies; the still entry in lanes that are not used
    bool any_held;
    Lanes<std::int64_t> held, stiff;
    /// No number has room: precession and turns are found in Real
    Lanes<std::int64_t> alone;
    Lanes<std::int32_t> start[4], principal[4]; ///< rotation when the tick began, and of the principal axes
    /// Radii along the principal axes and their inverses, mantissas up to 2^30: the third, and what the first and second have more
    Lanes<std::int32_t> radii[3], inverses[3];
    Lanes<std::int32_t> inverse_bits, linear_mask; ///< fraction bits of the inverses; as in BodyInertia
    /// radii^-2 / (2 substeps per second), mantissas up to 2^30: momentum to the turn of half a substep
    Lanes<std::int32_t> half_way[3];
    Lanes<std::int64_t> half_way_drop[3];
    Lanes<std::int64_t> momentum_most;    ///< a longer momentum is left: half of it, squared; half_turn_most
    Lanes<std::int64_t> turn_drop;        ///< of K^-1 u to the turn of half a substep
    Lanes<std::int64_t> speed_raise;      ///< of K w to accumulator_bits
    Lanes<std::int64_t> speed_most;       ///< the tip speed limit, before it is raised
    Lanes<std::int64_t> change_raise;     ///< of to_now and from_now times a change of u to accumulator_bits,
    Lanes<std::int64_t> change_drop;      ///< or this
    Lanes<std::int64_t> change_most;      ///< 4096 m/s before that
    Lanes<std::int32_t> axes[3][3];       ///< principal axes when the tick began, Unit
    Lanes<std::int32_t> k[6], inverse[6]; ///< K and K^-1 then
    // of now
    Lanes<std::int32_t> turn[4];                ///< since the tick began, Unit
    Lanes<std::int32_t> half[3];                ///< turn of half a substep by u [rad], 32 fraction bits
    Lanes<std::int32_t> to_now[9], from_now[9]; ///< K' K^-1 and K K'^-1, by rows
    Lanes<std::int64_t> precession[3];          ///< the part of u that is no momentum [m/s], 47 fraction bits
    Lanes<std::int64_t> u_outside[3], u_inside[3]; ///< between turn_in and turn_out: u before, and K' w
    std::uint32_t left;                            ///< bit by lane: the kernel had no room for it
};

struct FollowPass {
    SolverBody* bodies;
    FollowedFour* fours;
    FollowedTurn* turns;
    std::int64_t tip_most;  ///< [m/s], 47 fraction bits
    std::int32_t half_rate; ///< of half substeps [1/s]
    std::int32_t half_time; ///< its inverse, a mantissa of which turn_drop knows the bits
};

/// Each of FollowedFours [first, last).
struct FollowKernel {
    using Step = void (*)(const FollowPass& pass, std::uint32_t first, std::uint32_t last);
    /// Axes, K and K^-1 when the tick begins; turns of half a substep by u
    Step start;
    /// Turns by u for a substep. Leaves what turns too far as it is
    Step turn;
    /// K' and its matrices from where bodies are, and g. Leaves u of what is stiff or turns too far
    Step answer;
    /// As the functions of followed_turn.h
    Step turn_in, turn_out, note_u, keep_velocity;
    Step end; ///< FollowedTurn::spin. Leaves what spins too fast
};

} // namespace lockstone::solve
