// The data of a body from which rows are made: its response to impulses, and its freedom to move.
#pragma once

#include "lockstone/math/vec.h"

#include <cstdint>

namespace lockstone::solve {

/// A symmetric 3x3 matrix.
template <class T> struct Symmetric { T xx, yy, zz, xy, xz, yz; };

/// One cache line. Kernels read and write it in rows of four numbers, from the mantissa on.
struct alignas(64) BodyInertia {
    /// K^-1 = mantissa / 2^inv_exponent, the largest entry in [2^28, 2^30)
    Symmetric<std::int32_t> inv_mantissa;
    std::int32_t inv_exponent;
    /// Bit per axis: it may move along the axis; it may turn about the axis
    std::uint32_t linear_mask, angular_mask;
    std::uint32_t turn; ///< entry of SolverBodies::turns + 1, 0: not followed
    Real mass;          ///< [kg], for movable bodies
    bool movable;       ///< dynamic and with mass
    bool moves;         ///< dynamic or kinematic
    bool jointed;       ///< a joint holds it
    bool pressed;       ///< a heavy body presses it against other bodies: contacts/pressed.h
};

} // namespace lockstone::solve
