// The kernels for 128-bit vectors of WebAssembly (-msimd128). Modules with vectors do not load in engines without them.
#include "lockstone/compiler.h"

#if LOCKSTONE_HAS_WASM128

#include "solve/bodies/kernel.h"
#include "solve/contacts/kernel.h"
#include "solve/joints/pack/kernel.h"
#include "solve/kernels/kernels.h"
#include "solve/lanes/wasm128.h"
#include "solve/pairs/bounds_kernel.h"
#include "solve/pairs/kernel.h"
#include "solve/pairs/support_kernel.h"

namespace lockstone::solve {

constinit const solve::BodyKernel wasm128_bodies = MovedBodies<Wasm128>::table();
constinit const ContactKernel wasm128_contacts = Kernel<Wasm128>::table();
constinit const solve::PairKernel wasm128_pairs = PairLanes<Wasm128>::table();
constinit const shapes::SupportKernel wasm128_hulls = HullSupport<Wasm128>::table();
constinit const collide::BoundsKernel wasm128_bounds = PlacedBoxes<Wasm128>::table();
constinit const solve::JointKernel wasm128_joints = PackedJoints<Wasm128>::table();

} // namespace lockstone::solve

#endif
