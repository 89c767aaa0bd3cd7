// Joints side by side: the point parts that no tree solves, with the rows that only turn the same bodies.
//
//   C = s, axes of the world; J = 2^-e (-1, -K_A^-1 [rA] ; 1, K_B^-1 [rB]), [r] e = r x e
//
// The generic rows of joint_rows.h say the same. Here the linear part is one number, and nothing is looped over that is zero.
// Rows and biases are made anew in every substep, from where bodies have turned to since the tick began (TurnedBody): by the unit quaternion
//
//   q = (sinc(|h|) h, cos |h|),  h = K^-1 theta / 2    three terms of each series: off by less than |h|^6 / 720 = 4e-11
//
// for bodies that have turned by at most 1 / 16 rad about each axis; for others, and for those that are followed
// (followed_turn.h), q is given. The inverse is that of rows that were made when no body stood further than
// a = 2^-9 rad about each axis from where it is: impulses are off by a part 2 a, which the next pass takes out.
//
// Of a hinge whose two axes are within 45 degrees the rows about the axes are made here as well (lock_y, lock_z of joint_parts.h):
//
//   C = - xB . zA, xB . yA    arms zA x xB, xB x yA
//
// and its limits are looked at: while the twist t, about an axis that both bodies hardly differ in, is within `reach` of the middle
// of what may not touch a limit, cos(t - middle) > cos(reach), there is no row for them. sin t = zA . yB, cos t = yA . yB: beside
// 2 atan2 of joint_parts.h that is off by the square of the angle between the axes, which is_out_of_reach() has room for.
// A pack has four lanes whatever the instruction set (solve/joints): one with fewer takes a pack in pieces. Joints of a pack share no
// body that impulses move, and each lane is a joint of its own, so every width gives the same bits.
#pragma once

#include "solve/joints/joint_rows.h"

#include <cstddef>
#include <cstdint>

namespace lockstone::solve {

inline constexpr unsigned pack_lanes = 4;

/// The inverses of the parts of a pack, as Inverse.
struct PackInverse {
    std::int32_t m[6][pack_lanes];
    std::int64_t shift[pack_lanes], half[pack_lanes]; ///< half = 2^(shift - 1)
    std::uint32_t odd; ///< bit per lane: shift is outside 1 .. 62, and half zero
};

/// The bodies of one side: point rows and shares.
struct PackSide {
    std::uint32_t place[pack_lanes]; ///< of the body: bytes from the first SolverBody on
    std::uint32_t held[pack_lanes];  ///< of its rotation: bytes from JointStartData::rotations on
    std::uint32_t moved;             ///< bit per lane: impulses move the body; others are read, never written
    bool shifts;                     ///< of some lane `shift` is not zero
    std::int32_t x[3][3][pack_lanes];                 ///< turning arms by rows, 28 fraction bits
    std::int32_t pull[pack_lanes];                    ///< 2^-e times the share, 28 fraction bits
    std::int32_t share[pack_lanes];                   ///< mantissa, 30 fraction bits
    std::int64_t shift[pack_lanes], half[pack_lanes]; ///< v += (r p + half) / 2^shift
    // What arms are made of: the lever when the tick began, how the body has turned since, K^-1.
    std::uint32_t turned[pack_lanes];      ///< of the body: bytes from the first TurnedBody on
    std::int32_t own_lever[3][pack_lanes]; ///< in the body's axes, Length
    std::int32_t lever[3][pack_lanes];     ///< world axes, components within 2^28; lever_bits fraction bits
    std::int32_t inverse[6][pack_lanes];   ///< mantissas of K^-1: xx, yy, zz, xy, xz, yz
    std::int64_t lever_bits[pack_lanes];   ///< 22 .. 32
    std::int64_t spin_shift[pack_lanes];   ///< of K^-1 u to Speed
    std::int64_t arm_shift[pack_lanes], arm_half[pack_lanes]; ///< of K^-1 [r] to x
};

struct JointPack {
    PackSide a, b;
    std::uint32_t count;              ///< lanes in use, from the first on
    std::uint32_t memory[pack_lanes]; ///< of its joint: row of the memory column
    std::int64_t mass[pack_lanes];    ///< as of its JointWork, Real
    std::uint8_t whole[pack_lanes];   ///< the joint has no rows but those of this point
    std::uint32_t turn;               ///< entry of JointTick::turns, where turn_rows is not zero
    std::uint32_t turn_rows;          ///< rows of each joint that only turn, solved before its point
    std::uint32_t first_axis;         ///< of JointTick::axis_packs
    std::uint32_t axis_count;     ///< single axes of the joint that has the most, solved before all others
    bool hinges;                  ///< they are those of hinges
    std::int32_t one[pack_lanes]; ///< 2^-e, 28 fraction bits
    PackInverse inverse;
    std::int32_t impulse[3][pack_lanes];  ///< p', Speed
    std::int32_t bias[3][pack_lanes];     ///< Speed
    std::int32_t bias_before[pack_lanes]; ///< its largest part when the tick began
    /// From A's centre of mass to B's when the tick began; of the world, the anchor. [m], Real
    std::int64_t apart[3][pack_lanes];
    std::int64_t near_shift[pack_lanes], ahead_shift[pack_lanes]; ///< of C and of the arc to 2^-e
    std::uint32_t over; ///< bit per lane: entries have grown to 2, the rows want a larger e
    /// JointSeen by which inverses become stale: in this update; and from the next one on, as the rows of now ask
    std::uint8_t asks[pack_lanes], asks_next[pack_lanes];
    std::int32_t stale[pack_lanes];         ///< all ones: inverses are to be made anew
    std::uint32_t points_left, hinges_left; ///< bit per lane: and lanes could not
    std::int32_t push_max[pack_lanes];      ///< of the bias: by the error, Speed
    std::int32_t exponent[pack_lanes];      ///< e
    std::int64_t sum[3][pack_lanes];        ///< of p' over the substeps so far
};

/// The rows of a pack that only turn. Those of a lane are a JointBlock's where generic is set, else made with the point's.
struct TurnPack {
    std::int32_t ja[3][3][pack_lanes], jb[3][3][pack_lanes]; ///< [row][axis], 28 fraction bits
    PackInverse inverse;
    std::int32_t impulse[3][pack_lanes], bias[3][pack_lanes]; ///< Speed
    std::int64_t sum[3][pack_lanes];                          ///< of p' since the rows were made
    std::int32_t generic[pack_lanes];                         ///< all ones, or zero
    // Of a hinge:
    /// Y and z of A's frame, x and y of B's, in the axes of their bodies, 30 fraction bits. In those of the world where `world_a`
    /// or `world_b` is all ones.
    std::int32_t local_a[2][3][pack_lanes], local_b[2][3][pack_lanes];
    std::int32_t world_a[pack_lanes], world_b[pack_lanes];
    std::int32_t frame_a[2][3][pack_lanes], frame_b[2][3][pack_lanes]; ///< when the tick began, world axes
    std::int32_t axis[2][3][pack_lanes];                   ///< about which the rows turn B, 28 fraction bits
    std::int32_t exponent[pack_lanes];                     ///< e of its rows
    std::int64_t shift_a[pack_lanes], shift_b[pack_lanes]; ///< of K^-1 axis to the rows
    std::int64_t bias_shift[pack_lanes];                   ///< of C rate to 2^-e
    std::int32_t push_max[pack_lanes];                     ///< of the bias, Speed
    /// Of the middle between its limits; of the half way between them, and how much that rises at most for each radian less;
    /// of what may not touch a limit. 30 fraction bits
    std::int32_t middle_cos[pack_lanes], middle_sin[pack_lanes], limit_cos[pack_lanes],
        limit_rise[pack_lanes], reach_cos[pack_lanes];
    std::uint8_t apart[pack_lanes];   ///< its axes are too far apart for these rows
    std::uint8_t reaches[pack_lanes]; ///< its limits may be within reach
};

/// A single axis of each joint of a pack, with what passes ask of its JointAxisPart. It only turns.
struct AxisPack {
    std::int32_t acts[pack_lanes]; ///< all ones; zero: there is none, or it is idle
    std::int32_t has_spring[pack_lanes], has_motor[pack_lanes], has_lower[pack_lanes],
        has_upper[pack_lanes];                         ///< all ones or zero
    std::int32_t ja[3][pack_lanes], jb[3][pack_lanes]; ///< about x y z, 28 fraction bits
    std::int32_t ra[3][pack_lanes], rb[3][pack_lanes]; ///< responses, 28 fraction bits
    std::int32_t inverse[pack_lanes];                  ///< k^-1 = inverse / 2^shift, shift from 1 on
    std::int64_t shift[pack_lanes];
    std::int32_t spring[pack_lanes], motor[pack_lanes], lower[pack_lanes], upper[pack_lanes]; ///< p', Speed
    std::int64_t sum[pack_lanes]; ///< of all four over the substeps since the rows were made
    std::int32_t spring_bias[pack_lanes], spring_bound[pack_lanes], motor_bias[pack_lanes],
        motor_bound[pack_lanes]; ///< as in JointAxisPart
    std::int32_t lower_bias[pack_lanes], lower_relax[pack_lanes], upper_bias[pack_lanes],
        upper_relax[pack_lanes];                                    ///< as in JointAxisPart
    std::int32_t mass_scale[pack_lanes], impulse_scale[pack_lanes]; ///< of the spring, Unit
    // The direction that takes the point along (axis_with_point.h), made with the rows of the point in each substep:
    std::int32_t lead_ja[6][pack_lanes], lead_jb[6][pack_lanes], lead_ra[6][pack_lanes],
        lead_rb[6][pack_lanes];
    std::int32_t lead[pack_lanes]; ///< its k^-1 = lead / 2^lead_shift
    std::int64_t lead_shift[pack_lanes];
    std::int32_t answer[3][pack_lanes]; ///< impulses of the point for each of the axis, 28 fraction bits
};

/// Where a body is that joints hold, as packs read it: four rows of four numbers.
struct alignas(64) TurnedBody {
    std::int32_t turn[3][3]; ///< since the tick began: a rotation matrix by rows, Unit
    std::int32_t spin[3];    ///< within 2048 rad/s, Speed
    std::int32_t shift[3];   ///< since the tick began [m], Separation
    std::int32_t spare;
};

/// Four bodies that joints hold: what TurnedBodies are made of, and JointSeen.
struct HeldBodies {
    std::uint32_t place[pack_lanes];     ///< as in PackSide
    std::int32_t inverse[6][pack_lanes]; ///< K^-1 when the tick began, as in PackSide
    std::int64_t turn_shift[pack_lanes]; ///< of K^-1 theta to pack_angle_bits
    std::int64_t spin_shift[pack_lanes]; ///< of K^-1 u to Speed
    /// K^-1 theta when it strayed last, pack_angle_bits: as for packs, and as for rows of no pack
    std::int32_t packed_at[3][pack_lanes], alone_at[3][pack_lanes];
    std::int32_t strays[pack_lanes]; ///< all ones: K^-1 has no room here, so it strays whenever it has moved
};

/// What a body did that joints hold: bits of JointTick::seen.
enum JointSeen : std::uint8_t {
    seen_stirred = 1,    ///< moved or turned since the tick began
    seen_strays = 2,     ///< turned by more than rows of no pack may stay behind: row_turn_max
    seen_strays_far = 4, ///< and by more than inverses of packs may: pack_turn_max
    seen_far = 8,        ///< turned by more than theta tells since the tick began: given_turn_bits
    seen_followed = 16,  ///< its K^-1 has changed; followed_turn.h
    seen_wanted = 32     ///< it is to be placed where it is
};

/// What a pass over packs reads besides them.
struct JointPassData {
    SolverBody* bodies;
    JointPack* packs;
    TurnPack* turns;
    AxisPack* axes; ///< nullptr: passes leave single axes out
    HeldBodies* held;
    TurnedBody* turned;                     ///< that of the world, then four of each HeldBodies
    std::uint8_t* seen;                     ///< likewise
    std::int32_t rate;                      ///< of locks: error to push speed [1/s], 16 fraction bits
    std::int32_t mass_scale, impulse_scale; ///< Unit
    std::int32_t time;                      ///< of a substep, Unit [s]
};
/// What packs are started from: the bodies when the tick begins.
struct JointStartData {
    JointPack* packs;
    TurnPack* turns;
    const BodyStep* steps;
    /// The Quat of the first body that joints hold; JointBody::radii_bits is behind it.
    const std::byte* rotations;
    std::int64_t push_max; ///< of biases [m/s], Real
};
inline constexpr int joint_rate_bits = 16;
/// The mobility of an axis that takes its point along counts as at least 2^-5 of the axis' own: with 2^-6 a flail whose arm is a small weight, 15
/// radii of gyration from its hinge, gains 60 % of the energy of its fall at its limit, with 2^-5 a tenth, with 2^-4 heavier ones do.
inline constexpr int least_part_bits = 5;
inline constexpr int pack_angle_bits = 32;
inline constexpr int row_turn_bits = 11; ///< row_turn_max = 2^-11 rad; joint_work.h
/// pack_turn_max = 2^-9 rad: with 2^-8 a pendulum that swings by 150 degrees is 0.13 % slow instead of 0.10 %. Points and hinges are made anew in
/// every substep and carry the weight.
inline constexpr int pack_turn_bits = 9;
inline constexpr int given_turn_bits = 4; ///< theta tells a turn up to 2^-4 rad about an axis

/// The passes of one instruction set over packs [first, last), which share no body that impulses move.
struct JointKernel {
    /// From levers and frames in the axes of their bodies, and impulses that lie in the sums: levers and frames in world axes, K^-1,
    /// exponents and what follows from them, also those of hinges, TurnPack::apart.
    void (*start)(const JointStartData& data, std::uint32_t first, std::uint32_t last);
    /// Where held bodies are, and what they did: of HeldBodies [first, last).
    void (*turn)(const JointPassData& data, std::uint32_t first, std::uint32_t last);
    /// As refresh(), before any body has moved.
    void (*begin)(const JointPassData& data, std::uint32_t first, std::uint32_t last);
    /// Rows of points and their biases from where the bodies are.
    void (*refresh)(const JointPassData& data, std::uint32_t first, std::uint32_t last);
    /// Inverses of stale lanes. Returns whether some are left to invert_left().
    bool (*invert)(const JointPassData& data, std::uint32_t first, std::uint32_t last);
    /// AxisPack::lead and what belongs to it, by the rows and inverses of points.
    void (*join)(const JointPassData& data, std::uint32_t first, std::uint32_t last);
    /// The impulses that parts have; adds them to the sums, but for the first substep of a tick.
    void (*warm_start)(const JointPassData& data, std::uint32_t first, std::uint32_t last, bool sums);
    /// Softly and with bias, or rigidly. Returns how many impulses met their bound.
    std::uint64_t (*solve)(const JointPassData& data, std::uint32_t first, std::uint32_t last, bool bias);
};

} // namespace lockstone::solve
