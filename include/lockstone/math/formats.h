// Formats of physical quantities, with their range and step.
//
//   role        quantity                            format  range   step
//   Real        public scalar, world position       I32F32  2.1e9   2.3e-10
//   Speed       velocity, impulse / mass [m/s]      I13F19  4096    1.9e-6   also angular velocity [rad/s]
//   Unit        orientation, unit vectors, ratios   I2F30   2       9.3e-10
//   Length      shape vertices, lever arms [m]      I8F24   128     6.0e-8
//   Separation  gap, pose change in a tick [m]      I5F27   16      7.5e-9   its step is the resting jitter
//   Jacobian    rows of the solver                  I4F28   8       3.7e-9
//   Coordinate  points of assets and shapes [m]     I40F24  5.5e11  6.0e-8   meshes, far or large shapes
//   Bound       broad-phase bounds [m]              I16F16  32768   1.5e-5   rounded outward
#pragma once

#include "lockstone/math/fixed.h"

namespace lockstone {

using Speed = I13F19;      ///< velocity and impulse / mass [m/s], angular velocity [rad/s]
using Unit = I2F30;        ///< components of unit vectors and rotations, ratios
using Length = I8F24;      ///< sizes and vertices of shapes, lever arms [m]
using Coordinate = I40F24; ///< points of assets, and of far or large shapes [m]
using Separation = I5F27;  ///< gaps and changes of position within a tick [m]
using Jacobian = I4F28;    ///< entries of solver rows
using Bound = I16F16;      ///< broad-phase bounds [m]

/// 1 as a Unit.
inline constexpr Unit unit_one = Unit::from_raw(1 << 30);

} // namespace lockstone
