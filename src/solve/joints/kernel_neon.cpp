// Every AArch64 has NEON; its intrinsics count lanes otherwise where bytes are big-endian.
#if defined(__aarch64__) && !defined(__AARCH64EB__)

#include "solve/joints/kernel.h"
#include "solve/joints/kernels.h"
#include "solve/lanes/neon.h"

namespace lockstone::solve {

constinit const dynamics::JointKernel neon_joints = PackedJoints<Neon>::table();

} // namespace lockstone::solve

#endif
