// The kernels in plain integers, for every machine.
#include "solve/bodies/kernel.h"
#include "solve/contacts/kernel.h"
#include "solve/joints/pack/kernel.h"
#include "solve/kernels/kernels.h"
#include "solve/lanes/scalar.h"
#include "solve/pairs/bounds_kernel.h"
#include "solve/pairs/kernel.h"
#include "solve/pairs/support_kernel.h"

namespace lockstone::solve {

constinit const solve::BodyKernel scalar_bodies = MovedBodies<Scalar>::table();
constinit const ContactKernel scalar_contacts = Kernel<Scalar>::table();
constinit const solve::PairKernel scalar_pairs = PairLanes<Scalar>::table();
constinit const shapes::SupportKernel scalar_hulls = HullSupport<Scalar>::table();
constinit const collide::BoundsKernel scalar_bounds = PlacedBoxes<Scalar>::table();
constinit const solve::JointKernel scalar_joints = PackedJoints<Scalar>::table();

} // namespace lockstone::solve
