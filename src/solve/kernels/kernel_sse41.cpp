// The kernels for SSE4.1, compiled with the flags of this instruction set where the target is x86.
#include "lockstone/compiler.h"

#if LOCKSTONE_HAS_X86

#include "solve/bodies/kernel.h"
#include "solve/contacts/kernel.h"
#include "solve/joints/pack/kernel.h"
#include "solve/kernels/kernels.h"
#include "solve/lanes/sse41.h"
#include "solve/pairs/bounds_kernel.h"
#include "solve/pairs/kernel.h"
#include "solve/pairs/support_kernel.h"

namespace lockstone::solve {

constinit const solve::BodyKernel sse41_bodies = MovedBodies<Sse41>::table();
constinit const ContactKernel sse41_contacts = Kernel<Sse41>::table();
constinit const solve::PairKernel sse41_pairs = PairLanes<Sse41>::table();
constinit const shapes::SupportKernel sse41_hulls = HullSupport<Sse41>::table();
constinit const collide::BoundsKernel sse41_bounds = PlacedBoxes<Sse41>::table();
constinit const solve::JointKernel sse41_joints = PackedJoints<Sse41>::table();

} // namespace lockstone::solve

#endif
