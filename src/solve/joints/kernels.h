// The kernels of joints that this build has, by instruction set; each in a file of its own, kernel_*.cpp.
#pragma once

#include "dynamics/joint_pack.h"

#include "lockstone/simd.h"

namespace lockstone::solve {

/// Null where the build or the machine lacks it.
const dynamics::JointKernel* joints_of(Simd level);

extern const dynamics::JointKernel scalar_joints, sse41_joints, avx2_joints, neon_joints, wasm128_joints;

} // namespace lockstone::solve
