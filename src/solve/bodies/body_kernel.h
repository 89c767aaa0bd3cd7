// The motion of bodies in lanes of an instruction set: of bodies that only gravity, contacts and joints move, within
// their limits.
#pragma once

#include "lockstone/math/vec.h"
#include "solve/bodies/followed_body.h"

#include <cstdint>

namespace lockstone::solve {

struct SolverBody;
struct BodyStep;
struct BodyInfo;
struct GyrationForm;
struct Velocity;

/// The steps of a body that a kernel may do.
enum PlainMotion : std::uint8_t {
    plain_velocity = 1, ///< gravity and damping alone change its velocity: no force, torque, lock or field
    plain_pose = 2,     ///< it moves by its velocity alone
    plain_end = 4,      ///< dynamic, turns about all axes and is not followed
    /// the turn of the tick does not change its angular velocity: equal radii about all axes, or not gyroscopic
    plain_round = 8,
    plain_damped = 16, ///< damping changes its velocity
    plain_falls = 32,  ///< gravity alone pushes it, as it does most bodies
    plain_struck = 64, ///< an elastic impact changed its velocity in this tick
};

/// Bodies [first, last) in one substep, or the bodies rows[first, last). v and u are adjacent in a SolverBody, and so
/// are shift and theta: each pair is six numbers here.
struct BodyPass {
    SolverBody* bodies;
    const BodyStep* steps;
    const std::uint8_t* plain; ///< PlainMotion, by body
    const std::uint32_t* rows; ///< null: all bodies in order
    std::uint32_t first, last;
    std::int64_t dv[6]; ///< change of a velocity in the substep, 47 fraction bits
    /// 2^k - 1: a velocity with a component outside [-2^k, 2^k) may be beyond its limit
    std::int64_t most[6];
    std::int64_t substep_time; ///< [s], 30 fraction bits
};

/// K and u of bodies that turn about all axes, at the start of a tick.
struct StartPass {
    SolverBody* bodies;
    BodyStep* steps;
    const BodyInfo* info;
    const GyrationForm* forms;
    const std::uint32_t* form_of; ///< by row of traits: entry of forms + 1
    const Transform* poses;
    const Velocity* velocities;
    std::int64_t tip_most; ///< as BodyPass::most, of a component of u with 19 fraction bits
};

/// Poses and velocities of plain_end bodies, at the end of a tick.
struct EndPass {
    const SolverBody* bodies;
    const BodyStep* steps;
    const std::uint8_t* plain;
    const BodyInfo* info;
    const GyrationForm* forms; ///< as in StartPass
    const std::uint32_t* form_of;
    Transform* poses;
    Velocity* velocities;
    // For bodies that are not plain_round; all [rad], Real.
    /// A longer turn about one of the axes changes the angular velocity
    std::int64_t least_turn;
    /// A longer turn without torque, summed over the three axes, is made in steps
    std::int64_t least_free_turn;
    /// A turn counts as without torque if it is nearer than this to the turn by the body's own spin
    std::int64_t free_turn_noise;
    std::int64_t tick_time; ///< [s], 30 fraction bits
    /// Faster bodies are skipped, see Momentum::spins_above [rad/s], spin_bits
    std::int64_t spin_most;
};

/// Each function writes the bodies that it skipped and did not change to `left`, at most as many as it got, and returns
/// their number. It skips bodies that are not plain, and bodies whose velocity may be beyond its limit.
struct BodyKernel {
    std::uint32_t (*integrate_velocities)(const BodyPass& pass, std::uint32_t* left);
    std::uint32_t (*integrate_poses)(const BodyPass& pass, std::uint32_t* left);
    std::uint32_t (*begin_turning)(const StartPass& pass, const std::uint32_t* rows, std::uint32_t count,
                                   std::uint32_t* left);
    std::uint32_t (*finish)(const EndPass& pass, const std::uint32_t* rows, std::uint32_t count,
                            std::uint32_t* left);
    /// sums += velocities, and sums -= velocities, modulo 2^64: six numbers for each of the first `count` bodies, or of
    /// `rows`.
    void (*add_velocities)(const SolverBody* bodies, std::int64_t* sums, const std::uint32_t* rows,
                           std::uint32_t count);
    void (*take_velocities)(const SolverBody* bodies, std::int64_t* sums, const std::uint32_t* rows,
                            std::uint32_t count);
    FollowKernel followed;
};

} // namespace lockstone::solve
