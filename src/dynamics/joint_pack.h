// Joints side by side: the point parts that no tree solves, with the rows that only turn the same bodies.
//
//   C = s, axes of the world; J = 2^-e (-1, -K_A^-1 [rA] ; 1, K_B^-1 [rB]), [r] e = r x e
//
// The generic rows of joint_rows.h say the same. Here the linear part is one number, nothing is looped over that is zero, and the
// error follows the motion by the rows themselves, so that rows stay while the bodies have hardly turned.
// A pack has four lanes whatever the instruction set (solve/joints): one with fewer takes a pack in pieces. Joints of a pack share no
// body that impulses move, and each lane is a joint of its own, so every width gives the same bits.
#pragma once

#include "dynamics/joint_rows.h"

#include <cstdint>

namespace lockstone::dynamics {

inline constexpr unsigned pack_lanes = 4;

/// The inverses of the parts of a pack, as Inverse.
struct PackInverse {
    std::int32_t m[6][pack_lanes];
    std::int64_t shift[pack_lanes], half[pack_lanes]; ///< half = 2^(shift - 1)
    std::uint8_t odd[pack_lanes];                     ///< shift is outside 1 .. 62, and half zero
};

/// The bodies of one side: point rows and shares.
struct PackSide {
    std::uint32_t body[pack_lanes];
    std::uint32_t movable;                            ///< bit per lane: impulses move it
    bool shifts;                                      ///< of some lane `shift` is not zero
    std::int32_t x[3][3][pack_lanes];                 ///< turning arms by rows, 28 fraction bits
    std::int32_t pull[pack_lanes];                    ///< 2^-e times the share, 28 fraction bits
    std::int32_t share[pack_lanes];                   ///< mantissa, 30 fraction bits
    std::int64_t shift[pack_lanes], half[pack_lanes]; ///< v += (r p + half) / 2^shift
};

struct JointPack {
    PackSide a, b;
    std::uint32_t count;          ///< lanes in use, from the first on
    std::uint32_t turn;           ///< entry of JointTick::turns, where turn_rows is not zero
    std::uint32_t turn_rows;      ///< rows of each joint that only turn, solved before its point
    std::int32_t one[pack_lanes]; ///< 2^-e, 28 fraction bits
    PackInverse inverse;
    std::int32_t impulse[3][pack_lanes]; ///< p', Speed
    std::int64_t
        error[3][pack_lanes]; ///< 2^-e C, less J . (shift, theta) of when the rows were made; Separation
    std::int32_t ahead[3][pack_lanes]; ///< of the bias: along the arc, Speed
    std::int32_t push_max[pack_lanes]; ///< of the bias: by the error, Speed
    std::int32_t exponent[pack_lanes]; ///< e
    std::int64_t sum[3][pack_lanes];   ///< of p' over the substeps so far
};

/// The rows of a pack that only turn, as JointBlock has them.
struct TurnPack {
    std::int32_t ja[3][3][pack_lanes], jb[3][3][pack_lanes]; ///< [row][axis], 28 fraction bits
    std::int32_t ra[3][3][pack_lanes], rb[3][3][pack_lanes];
    PackInverse inverse;
    std::int32_t impulse[3][pack_lanes], bias[3][pack_lanes]; ///< Speed
    std::int64_t sum[3][pack_lanes];                          ///< of p' since the rows were made
};

/// What a pass over packs reads besides them.
struct JointPassData {
    SolverBody* bodies;
    JointPack* packs;
    TurnPack* turns;
    std::int32_t rate;                      ///< of locks: error to push speed [1/s], 16 fraction bits
    std::int32_t mass_scale, impulse_scale; ///< Unit
};
inline constexpr int joint_rate_bits = 16;

/// The passes of one instruction set over packs [first, last), which share no body that impulses move.
struct JointKernel {
    /// The impulses that parts have; adds them to the sums, but for the first substep of a tick.
    void (*warm_start)(const JointPassData& data, std::uint32_t first, std::uint32_t last, bool sums);
    /// Softly and with bias, or rigidly. Returns how many impulses met their bound.
    std::uint64_t (*solve)(const JointPassData& data, std::uint32_t first, std::uint32_t last, bool bias);
};

} // namespace lockstone::dynamics
