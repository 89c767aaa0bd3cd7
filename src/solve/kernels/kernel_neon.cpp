// The kernels for NEON, which every AArch64 has. With big-endian bytes its intrinsics number lanes differently.
#include "lockstone/compiler.h"

#if LOCKSTONE_HAS_NEON

#include "solve/bodies/kernel.h"
#include "solve/contacts/kernel.h"
#include "solve/joints/pack/kernel.h"
#include "solve/kernels/kernels.h"
#include "solve/lanes/neon.h"
#include "solve/pairs/bounds_kernel.h"
#include "solve/pairs/kernel.h"
#include "solve/pairs/support_kernel.h"

namespace lockstone::solve {

constinit const solve::BodyKernel neon_bodies = MovedBodies<Neon>::table();
constinit const ContactKernel neon_contacts = Kernel<Neon>::table();
constinit const solve::PairKernel neon_pairs = PairLanes<Neon>::table();
constinit const shapes::SupportKernel neon_hulls = HullSupport<Neon>::table();
constinit const collide::BoundsKernel neon_bounds = PlacedBoxes<Neon>::table();
constinit const solve::JointKernel neon_joints = PackedJoints<Neon>::table();

} // namespace lockstone::solve

#endif
