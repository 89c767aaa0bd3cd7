// The kernels of plain integers in this program. The linker takes these and ignores the library's in its archive.
#include "solve/kernels/kernels.h"
#include "lanes/checked_lanes.h"
#include "solve/bodies/kernel.h"
#include "solve/contacts/kernel.h"
#include "solve/joints/pack/kernel.h"
#include "solve/pairs/bounds_kernel.h"
#include "solve/pairs/kernel.h"
#include "solve/pairs/support_kernel.h"

namespace lockstone::solve {

using test::CheckedLanes;

constinit const solve::BodyKernel scalar_bodies = MovedBodies<CheckedLanes>::table();
constinit const ContactKernel scalar_contacts = Kernel<CheckedLanes>::table();
constinit const solve::PairKernel scalar_pairs = PairLanes<CheckedLanes>::table();
constinit const shapes::SupportKernel scalar_hulls = HullSupport<CheckedLanes>::table();
constinit const collide::BoundsKernel scalar_bounds = PlacedBoxes<CheckedLanes>::table();
constinit const solve::JointKernel scalar_joints = PackedJoints<CheckedLanes>::table();

} // namespace lockstone::solve
