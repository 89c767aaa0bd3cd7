// Joints in lanes: the point parts that no tree solves, together with rows without linear part between the same
// bodies.
//
//   C = s, axes of the world; J = 2^-e (-1, -K_A^-1 [rA] ; 1, K_B^-1 [rB]), [r] e = r x e
//
// The generic rows of joint_rows.h are equivalent. Here the linear part is a single number, and no loop processes
// zeros. Rows and biases are computed in every substep, from the turns of the bodies since the tick began
// (TurnedBody): by the unit quaternion
//
//   q = (sinc(|h|) h, cos |h|),  h = K^-1 theta / 2    three terms of each series: error below |h|^6 / 720 = 4e-11
//
// for bodies that have turned by at most 1 / 16 rad about each axis. For other bodies and for followed bodies
// (followed_turn.h), q is passed in. The inverse may belong to older rows, made when no body was further than a =
// 2^-9 rad about each axis from its present rotation. Impulses are then off by a part 2 a, which the next pass
// corrects.
//
// If the two axes of a hinge are within 45 degrees, the pack also makes the rows about the axes (lock_y, lock_z of
// joint_parts.h):
//
//   C = - xB . zA, xB . yA    arms zA x xB, xB x yA
//
// It also checks the limits: while the twist t, about an axis that is nearly the same in both bodies, is within
// `reach` of the middle of the range, cos(t - middle) > cos(reach), the limits have no row. sin t = zA . yB and cos t
// = yA . yB differ from 2 atan2 of joint_parts.h by the square of the angle between the axes; is_out_of_reach() has a
// margin for that.
//
// A pack has four lanes for every instruction set (solve/joints); narrower ones process a pack in pieces. Joints of a
// pack share no body that impulses move, and each lane is a separate joint, so every width gives the same bits.
#pragma once

#include "solve/joints/joint_rows.h"

#include <cstddef>
#include <cstdint>

namespace lockstone::solve {

inline constexpr unsigned pack_lanes = 4;

/// The inverses of the parts of a pack, in the format of Inverse.
struct PackInverse {
    std::int32_t m[6][pack_lanes];
    std::int64_t shift[pack_lanes], half[pack_lanes]; ///< half = 2^(shift - 1)
    std::uint32_t odd; ///< bit per lane: shift is outside 1 .. 62, and half is zero
};

/// One side of a pack: its bodies, their point rows and shares.
struct PackSide {
    std::uint32_t place[pack_lanes];  ///< byte offset of the body from the first SolverBody
    std::uint32_t held[pack_lanes];   ///< byte offset of its rotation from JointStartData::rotations
    std::uint32_t moved;              ///< bit per lane: impulses move the body; other bodies are read-only
    bool shifts;                      ///< `shift` of some lane is not zero
    std::int32_t x[3][3][pack_lanes]; ///< turning arms by rows, 28 fraction bits
    std::int32_t pull[pack_lanes];    ///< 2^-e times the share, 28 fraction bits
    std::int32_t share[pack_lanes];   ///< mantissa, 30 fraction bits
    std::int64_t shift[pack_lanes], half[pack_lanes]; ///< v += (r p + half) / 2^shift
    // Input of the arms: the lever when the tick began, the turn of the body since, K^-1.
    std::uint32_t turned[pack_lanes];      ///< byte offset of the body from the first TurnedBody
    std::int32_t own_lever[3][pack_lanes]; ///< in the body's axes, Length
    std::int32_t lever[3][pack_lanes];     ///< world axes, components within 2^28; lever_bits fraction bits
    std::int32_t inverse[6][pack_lanes];   ///< mantissas of K^-1: xx, yy, zz, xy, xz, yz
    std::int64_t lever_bits[pack_lanes];   ///< 22 .. 32
    std::int64_t spin_shift[pack_lanes];   ///< shift from K^-1 u to Speed
    std::int64_t arm_shift[pack_lanes], arm_half[pack_lanes]; ///< shift from K^-1 [r] to x
};

struct JointPack {
    PackSide a, b;
    std::uint32_t count;              ///< lanes in use: the first ones
    std::uint32_t memory[pack_lanes]; ///< row of the joint in the memory column
    std::int64_t mass[pack_lanes];    ///< JointWork::mass, Real
    std::uint8_t whole[pack_lanes];   ///< the joint is only this point
    std::uint32_t turn;               ///< entry of JointTick::turn_packs, if turn_rows > 0
    std::uint32_t turn_rows;          ///< rows without linear part per joint; solved before its point
    std::uint32_t first_axis;         ///< entry of JointTick::axis_packs
    std::uint32_t axis_count;         ///< largest number of single axes of its joints; solved first
    bool hinges;                      ///< the turn_rows are those of hinges
    std::int32_t one[pack_lanes];     ///< 2^-e, 28 fraction bits
    PackInverse inverse;
    std::int32_t impulse[3][pack_lanes];  ///< p', Speed
    std::int32_t bias[3][pack_lanes];     ///< Speed
    std::int32_t bias_before[pack_lanes]; ///< its largest part when the tick began
    /// From A's centre of mass to B's when the tick began; for the world, from or to the anchor. [m], Real
    std::int64_t apart[3][pack_lanes];
    std::int64_t near_shift[pack_lanes], ahead_shift[pack_lanes]; ///< of C and of the arc to 2^-e
    std::uint32_t over; ///< bit per lane: an entry is 2 or more, the rows need a larger e
    /// JointSeen bits that make inverses stale: in this update, and in later updates with the present rows
    std::uint8_t asks[pack_lanes], asks_next[pack_lanes];
    std::int32_t stale[pack_lanes];         ///< all ones: the inverse has to be computed again
    std::uint32_t points_left, hinges_left; ///< bit per lane: stale, but lanes cannot invert it
    std::int32_t push_max[pack_lanes];      ///< limit of the error part of the bias, Speed
    std::int32_t exponent[pack_lanes];      ///< e
    std::int64_t sum[3][pack_lanes];        ///< of p' over the earlier substeps
};

/// The rows of a pack without linear part. `generic` lanes copy them from a JointBlock; in the others the pack makes
/// them.
struct TurnPack {
    std::int32_t ja[3][3][pack_lanes], jb[3][3][pack_lanes]; ///< [row][axis], 28 fraction bits
    PackInverse inverse;
    std::int32_t impulse[3][pack_lanes], bias[3][pack_lanes]; ///< Speed
    std::int64_t sum[3][pack_lanes];                          ///< of p' since the rows were made
    std::int32_t generic[pack_lanes]; ///< all ones: the rows come from a JointBlock; else zero
    // Only for hinges:
    /// y and z of A's frame, x and y of B's, in the axes of their bodies, 30 fraction bits; in world axes if
    /// `world_a` or `world_b` is all ones.
    std::int32_t local_a[2][3][pack_lanes], local_b[2][3][pack_lanes];
    std::int32_t world_a[pack_lanes], world_b[pack_lanes];
    std::int32_t frame_a[2][3][pack_lanes], frame_b[2][3][pack_lanes]; ///< when the tick began, world axes
    std::int32_t axis[2][3][pack_lanes]; ///< axis about which a row turns B, 28 fraction bits
    std::int32_t exponent[pack_lanes];   ///< e of its rows
    std::int64_t shift_a[pack_lanes], shift_b[pack_lanes]; ///< shift from K^-1 axis to the rows
    std::int64_t bias_shift[pack_lanes];                   ///< shift from C rate to 2^-e
    std::int32_t push_max[pack_lanes];                     ///< limit of the bias, Speed
    /// Cosine and sine of the middle of the limits; cosine of half their range, and the largest rise of that cosine
    /// per radian less; cosine of the part of the range in which no limit can be reached. 30 fraction bits
    std::int32_t middle_cos[pack_lanes], middle_sin[pack_lanes], limit_cos[pack_lanes],
        limit_rise[pack_lanes], reach_cos[pack_lanes];
    std::uint8_t apart[pack_lanes];   ///< its axes are too far apart for these rows
    std::uint8_t reaches[pack_lanes]; ///< its limits may be within reach
};

/// A single axis of each joint of a pack, with the data of JointAxisPart that passes read. It has no linear part.
struct AxisPack {
    std::int32_t acts[pack_lanes]; ///< all ones; zero: the lane has no such axis, or it is idle
    std::int32_t has_spring[pack_lanes], has_motor[pack_lanes], has_lower[pack_lanes],
        has_upper[pack_lanes];                         ///< all ones or zero
    std::int32_t ja[3][pack_lanes], jb[3][pack_lanes]; ///< about x y z, 28 fraction bits
    std::int32_t ra[3][pack_lanes], rb[3][pack_lanes]; ///< responses, 28 fraction bits
    std::int32_t inverse[pack_lanes];                  ///< k^-1 = inverse / 2^shift, shift at least 1
    std::int64_t shift[pack_lanes];
    std::int32_t spring[pack_lanes], motor[pack_lanes], lower[pack_lanes], upper[pack_lanes]; ///< p', Speed
    std::int64_t sum[pack_lanes]; ///< all four impulses, over the substeps since the rows were made
    std::int32_t spring_bias[pack_lanes], spring_bound[pack_lanes], motor_bias[pack_lanes],
        motor_bound[pack_lanes]; ///< as in JointAxisPart
    std::int32_t lower_bias[pack_lanes], lower_relax[pack_lanes], upper_bias[pack_lanes],
        upper_relax[pack_lanes];                                    ///< as in JointAxisPart
    std::int32_t mass_scale[pack_lanes], impulse_scale[pack_lanes]; ///< of the spring, Unit
    // Direction d that includes the point (axis_with_point.h), computed with the rows of the point in each substep:
    std::int32_t lead_ja[6][pack_lanes], lead_jb[6][pack_lanes], lead_ra[6][pack_lanes],
        lead_rb[6][pack_lanes];
    std::int32_t lead[pack_lanes]; ///< k^-1 along d = lead / 2^lead_shift
    std::int64_t lead_shift[pack_lanes];
    std::int32_t answer[3][pack_lanes]; ///< impulse of the point per impulse of the axis, 28 fraction bits
};

/// Placement of a body with joints, as packs read it: four rows of four numbers.
struct alignas(64) TurnedBody {
    std::int32_t turn[3][3]; ///< since the tick began: rotation matrix [row][column], Unit
    std::int32_t spin[3];    ///< angular velocity within 2048 rad/s, Speed
    std::int32_t shift[3];   ///< since the tick began [m], Separation
    std::int32_t spare;
};

/// Four bodies with joints: the input of TurnedBody and of JointSeen.
struct HeldBodies {
    std::uint32_t place[pack_lanes];     ///< as in PackSide
    std::int32_t inverse[6][pack_lanes]; ///< K^-1 when the tick began, as in PackSide
    std::int64_t turn_shift[pack_lanes]; ///< shift from K^-1 theta to pack_angle_bits
    std::int64_t spin_shift[pack_lanes]; ///< shift from K^-1 u to Speed
    /// K^-1 theta when a stale flag was set last, pack_angle_bits: seen_strays_far for packs, seen_strays for other
    /// rows
    std::int32_t packed_at[3][pack_lanes], alone_at[3][pack_lanes];
    std::int32_t strays[pack_lanes]; ///< all ones: K^-1 does not fit here; every motion sets the flags
};

/// Motion of a body with joints: flags of JointTick::seen. They decide which rows and inverses are stale.
enum JointSeen : std::uint8_t {
    seen_stirred = 1,    ///< moved or turned since the tick began
    seen_strays = 2,     ///< turned by row_turn_max since last set: rows outside packs are stale
    seen_strays_far = 4, ///< turned by pack_turn_max since last set: inverses of packs are stale
    seen_far = 8,        ///< turned by 2^-given_turn_bits rad since the tick began: too far for theta
    seen_followed = 16,  ///< followed, so its K^-1 changes; followed_turn.h
    seen_wanted = 32     ///< its placement has to be updated
};

/// Input of a pass over packs besides the packs.
struct JointPassData {
    SolverBody* bodies;
    JointPack* packs;
    TurnPack* turns;
    AxisPack* axes; ///< nullptr: passes skip single axes
    HeldBodies* held;
    TurnedBody* turned;                     ///< first the world, then four for each HeldBodies
    std::uint8_t* seen;                     ///< indexed like `turned`
    std::int32_t rate;                      ///< of locks: from error to push speed [1/s], 16 fraction bits
    std::int32_t mass_scale, impulse_scale; ///< Unit
    std::int32_t time;                      ///< length of a substep, Unit [s]
};
/// Input of JointKernel::start: the bodies when the tick begins.
struct JointStartData {
    JointPack* packs;
    TurnPack* turns;
    const BodyStep* steps;
    /// The Quat of the first body with joints; JointBody::radii_bits is behind each Quat.
    const std::byte* rotations;
    std::int64_t push_max; ///< limit of biases [m/s], Real
};
inline constexpr int joint_rate_bits = 16;
/// The mobility of an axis with its point counts as at least 2^-5 of the axis' mobility without it. A flail whose arm
/// is a small weight, 15 radii of gyration from its hinge, gains 60 % of the energy of its fall at its limit with
/// 2^-6, and a tenth with 2^-5. With 2^-4 heavier flails gain energy.
inline constexpr int least_part_bits = 5;
inline constexpr int pack_angle_bits = 32;
inline constexpr int row_turn_bits = 11; ///< row_turn_max = 2^-11 rad; joint_work.h
/// pack_turn_max = 2^-9 rad. With 2^-8 a pendulum that swings by 150 degrees is 0.13 % slow instead of 0.10 %. Points
/// and hinges, which carry the weight, get new rows in every substep anyway.
inline constexpr int pack_turn_bits = 9;
inline constexpr int given_turn_bits = 4; ///< theta represents turns up to 2^-4 rad about an axis

/// The passes of one instruction set over packs [first, last), which must share no body that impulses move.
struct JointKernel {
    /// Computes levers and frames in world axes, K^-1, exponents and dependent data, including those of hinges and
    /// TurnPack::apart. Reads levers and frames in body axes, and the impulses of the last tick from the sums.
    void (*start)(const JointStartData& data, std::uint32_t first, std::uint32_t last);
    /// Computes TurnedBody and JointSeen of HeldBodies [first, last).
    void (*turn)(const JointPassData& data, std::uint32_t first, std::uint32_t last);
    /// As refresh(), but before any body has moved.
    void (*begin)(const JointPassData& data, std::uint32_t first, std::uint32_t last);
    /// Computes rows and biases of points and hinges from the placement of the bodies.
    void (*refresh)(const JointPassData& data, std::uint32_t first, std::uint32_t last);
    /// Computes inverses of stale lanes. Returns true if some lanes are left to invert_left().
    bool (*invert)(const JointPassData& data, std::uint32_t first, std::uint32_t last);
    /// Computes AxisPack::lead and dependent data from the rows and inverses of points.
    void (*join)(const JointPassData& data, std::uint32_t first, std::uint32_t last);
    /// Applies the stored impulses, and adds them to the sums if `sums` is set; not in the first substep of a tick.
    void (*warm_start)(const JointPassData& data, std::uint32_t first, std::uint32_t last, bool sums);
    /// With bias: soft. Without: rigid. Returns the number of clamped impulses.
    std::uint64_t (*solve)(const JointPassData& data, std::uint32_t first, std::uint32_t last, bool bias);
};

} // namespace lockstone::solve
