// The motion of bodies by an instruction set: of those that gravity, contacts and joints alone move, within their limits.
#pragma once

#include <cstdint>

namespace lockstone::solve {

struct SolverBody;

/// Which steps of a body a kernel may take.
enum PlainMotion : std::uint8_t {
    plain_velocity = 1, ///< gravity alone changes it: no force, torque, damping, lock or field
    plain_pose = 2,     ///< it moves, by its velocity alone, and is not followed; followed_turn.h
};

/// Bodies [first, last) of one substep. v and u lie one after the other in a SolverBody, and so do shift and theta: each six
/// numbers here.
struct BodyPass {
    SolverBody* bodies;
    const std::uint8_t* plain; ///< PlainMotion, by body
    std::uint32_t first, last;
    std::int64_t dv[6]; ///< what the substep adds, 47 fraction bits
    /// 2^k - 1: a velocity with a component outside [-2^k, 2^k) may be beyond its limit
    std::int64_t most[6];
    std::int64_t substep_time; ///< [s], 30 fraction bits
};

/// Each writes the bodies that it left as they were to `left`, last - first at most, and returns how many: those that are
/// not plain, and those whose velocity may be beyond its limit.
struct BodyKernel {
    std::uint32_t (*integrate_velocities)(const BodyPass& pass, std::uint32_t* left);
    std::uint32_t (*integrate_poses)(const BodyPass& pass, std::uint32_t* left);
    /// sums += velocities, and sums -= velocities, modulo 2^64: six numbers of each of `count` bodies.
    void (*add_velocities)(const SolverBody* bodies, std::int64_t* sums, std::uint32_t count);
    void (*take_velocities)(const SolverBody* bodies, std::int64_t* sums, std::uint32_t count);
};

} // namespace lockstone::solve
