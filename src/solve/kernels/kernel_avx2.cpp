// The kernels for AVX2, compiled with the flags of this instruction set where the target is x86.
#include "lockstone/compiler.h"

#if LOCKSTONE_HAS_X86

#include "solve/bodies/kernel.h"
#include "solve/contacts/kernel.h"
#include "solve/joints/pack/kernel.h"
#include "solve/kernels/kernels.h"
#include "solve/lanes/avx2.h"
#include "solve/pairs/bounds_kernel.h"
#include "solve/pairs/kernel.h"
#include "solve/pairs/support_kernel.h"

namespace lockstone::solve {

constinit const solve::BodyKernel avx2_bodies = MovedBodies<Avx2>::table();
constinit const ContactKernel avx2_contacts = Kernel<Avx2>::table();
constinit const solve::PairKernel avx2_pairs = PairLanes<Avx2>::table();
constinit const shapes::SupportKernel avx2_hulls = HullSupport<Avx2>::table();
constinit const collide::BoundsKernel avx2_bounds = PlacedBoxes<Avx2>::table();
constinit const solve::JointKernel avx2_joints = PackedJoints<Avx2>::table();

} // namespace lockstone::solve

#endif
