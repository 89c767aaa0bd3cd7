// The motion of bodies by an instruction set: of those that gravity, contacts and joints alone move, within their limits.
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

/// Which steps of a body a kernel may take.
enum PlainMotion : std::uint8_t {
    plain_velocity = 1, ///< gravity and damping alone change it: no force, torque, lock or field
    plain_pose = 2,     ///< it moves, by its velocity alone
    plain_end = 4,      ///< dynamic, turns about all axes and is not followed
    plain_round =
        8, ///< no turn of the tick changes its angular velocity: alike about all axes, or not gyroscopic
    plain_damped = 16, ///< it is damped
    plain_falls = 32,  ///< it is pushed by gravity alone, as most are
};

/// Bodies [first, last) of one substep, or those that `rows` has there. v and u lie one after the other in a SolverBody, and so do shift and
/// theta: each six numbers here.
struct BodyPass {
    SolverBody* bodies;
    const BodyStep* steps;
    const std::uint8_t* plain; ///< PlainMotion, by body
    const std::uint32_t* rows; ///< null: all bodies in order
    std::uint32_t first, last;
    std::int64_t dv[6]; ///< what the substep adds, 47 fraction bits
    /// 2^k - 1: a velocity with a component outside [-2^k, 2^k) may be beyond its limit
    std::int64_t most[6];
    std::int64_t substep_time; ///< [s], 30 fraction bits
};

/// K and u of bodies that turn about all axes, when a tick begins.
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

/// Poses and velocities of plain_end bodies, when a tick ends.
struct EndPass {
    const SolverBody* bodies;
    const BodyStep* steps;
    const std::uint8_t* plain;
    const BodyInfo* info;
    const GyrationForm* forms; ///< as of StartPass
    const std::uint32_t* form_of;
    Transform* poses;
    Velocity* velocities;
    // Of bodies that are not round; all [rad], Real.
    /// Along an axis: a longer turn changes the angular velocity
    std::int64_t least_turn;
    /// Of the three axes together: a longer turn without torque is made in steps
    std::int64_t least_free_turn;
    /// A turn without torque is nearer than this to that of the body's own spin
    std::int64_t free_turn_noise;
    std::int64_t tick_time; ///< [s], 30 fraction bits
    /// A faster one is left, as Momentum::spins_above [rad/s], spin_bits
    std::int64_t spin_most;
};

/// Each writes the bodies that it left as they were to `left`, last - first at most, and returns how many: those that are
/// not plain, and those whose velocity may be beyond its limit.
struct BodyKernel {
    std::uint32_t (*integrate_velocities)(const BodyPass& pass, std::uint32_t* left);
    std::uint32_t (*integrate_poses)(const BodyPass& pass, std::uint32_t* left);
    std::uint32_t (*begin_turning)(const StartPass& pass, const std::uint32_t* rows, std::uint32_t count,
                                   std::uint32_t* left);
    std::uint32_t (*finish)(const EndPass& pass, const std::uint32_t* rows, std::uint32_t count,
                            std::uint32_t* left);
    /// sums += velocities, and sums -= velocities, modulo 2^64: six numbers of each of the first `count` bodies, or of `rows`.
    void (*add_velocities)(const SolverBody* bodies, std::int64_t* sums, const std::uint32_t* rows,
                           std::uint32_t count);
    void (*take_velocities)(const SolverBody* bodies, std::int64_t* sums, const std::uint32_t* rows,
                            std::uint32_t count);
    FollowKernel followed;
};

} // namespace lockstone::solve
