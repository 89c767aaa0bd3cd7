// What a tick keeps of its joints: bodies as they stand, blocks of locks, axes with springs, motors and limits.
#pragma once

#include "dynamics/joint.h"
#include "dynamics/joint_parts.h"
#include "dynamics/joint_tree.h"

#include <vector>

namespace lockstone::dynamics {

/// A body that joints hold, where it is in this substep.
struct JointBody {
    std::uint32_t body;
    bool stirred; ///< moved or turned since the rows of its joints were made
    Vec3 position;
    Quat rotation;
    Rotation axes;
    Vec3 w;
    Vec3 velocity;
    std::int32_t shift[3], theta[3]; ///< of the SolverBody, when this was made
    Vec3 moved;                      ///< by the last update [m]
    std::int32_t turned[3];          ///< by the last update, of theta
};

/// Up to three locks solved together.
struct JointBlock {
    Row row[3];
    Inverse inverse;
    RowKind kind[3];
    std::uint8_t slot[3]; ///< axis of JointAxisImpulses
    std::uint8_t count;
    std::int32_t exponent;
    std::int32_t impulse[3]; ///< p', Speed
    std::int32_t bias[3];    ///< Speed
    Real at[3];              ///< position that is kept
    Real sum[3];             ///< of the impulses of the substeps so far, unscaled
    Vec3 direction[3];
    bool is_force[3];
};

enum JointFeature : std::uint8_t {
    has_spring = 1,
    has_motor = 2,
    has_lower = 4,
    has_upper = 8,
    is_swing = 16
};

/// One axis: up to four impulses along the same row.
struct JointAxisPart {
    Row row;
    Inverse inverse;
    RowKind kind;
    std::uint8_t slot;
    std::uint8_t features; ///< JointFeature
    std::int32_t exponent;
    // spring: rate [1/s] and softness; its bound, in unscaled impulse
    Real rate, target;
    Unit mass_scale, impulse_scale;
    Real spring_max, motor_max, motor_speed;
    Real lower_at, upper_at;
    // as scaled by the last update
    std::int32_t spring_bias, spring_bound, motor_bias, motor_bound;
    std::int32_t lower_bias, lower_relax, upper_bias, upper_relax;
    std::int32_t spring, motor, lower, upper; ///< p', Speed
    JointAxisImpulses warm;                   ///< of the last tick, unscaled
    Real sum;
    Vec3 direction;
    bool is_force;
};

/// One side of a joint, constant within the tick.
struct JointWorkSide {
    std::uint32_t body;  ///< entry of SolverBodies
    bool world;          ///< stands still: the frame is in the world
    std::uint32_t cache; ///< entry of JointTick::bodies
    LengthVec3 lever;    ///< of the frame's origin from the centre of mass, in the body's axes
    Vec3 anchor;         ///< of a frame in the world
    Quat frame;          ///< in the body's axes, or in the world
};

struct JointWork {
    const JointDef* def;
    JointWorkSide a, b;
    Shares shares;
    Real mass; ///< mA mB / (mA + mB) [kg]
    std::uint32_t memory;
    std::uint32_t first_block, first_axis;
    std::uint32_t tree; ///< that solves its locks; no_tree: they are solved by themselves
    std::uint8_t block_count, axis_count;
    bool needs_twist, needs_target, needs_orientation, needs_travel, needs_slip, made;
    bool remade; ///< since trees were factorised
    Real twist, travel;
};

/// All joints of a tick in solving order.
struct JointTick {
    std::vector<JointWork> joints;
    std::vector<JointBlock> blocks;
    std::vector<JointAxisPart> axes;
    std::vector<JointBody> bodies;
    JointForest forest;
    std::vector<std::uint32_t> cache_of; ///< by body: entry of `bodies` + 1
    std::span<const Transform> pose;
    std::uint64_t clamped; ///< impulses that met joint_impulse_max
    bool first;            ///< no substep is in the sums yet
};

/// Parts of one joint by its table of axes; appends to blocks and axes.
void assemble(JointTick& tick, JointWork& work, const StepConstants& step, const JointMemory& memory);
void start_body(JointBody& now, const Transform& pose, const SolverBodies& bodies);
void place_body(JointBody& now, const Transform& pose, const SolverBodies& bodies);
/// Rows, responses, inverses and targets of a joint's parts. Writes nothing that is another joint's.
void make_rows(JointTick& tick, JointWork& work, const StepConstants& step, const SolverBodies& bodies);
/// Inverses of a joint's blocks, which make_rows() leaves out where a tree solves them.
void invert_blocks(JointTick& tick, const JointWork& work);

} // namespace lockstone::dynamics
