// The tables of kernels of this build, by instruction set. Each set has a file of its own, kernel_*.cpp.
#pragma once

#include "collide/bounds_kernel.h"
#include "shapes/hull/support_kernel.h"
#include "solve/bodies/body_kernel.h"
#include "solve/contacts/pack.h"
#include "solve/joints/pack/joint_pack.h"
#include "solve/pairs/pair_kernel.h"

#include "lockstone/simd.h"

namespace lockstone::solve {

struct Kernels {
    const ContactKernel* contacts;
    const solve::JointKernel* joints;
    const solve::BodyKernel* bodies;
    const solve::PairKernel* pairs;
    const shapes::SupportKernel* hulls;
    const collide::BoundsKernel* bounds;
};

/// Returns null where the build or the machine lacks the instructions.
const Kernels* kernels_of(Simd level);

extern const ContactKernel scalar_contacts, sse41_contacts, avx2_contacts, avx512_contacts, neon_contacts,
    wasm128_contacts;
extern const solve::JointKernel scalar_joints, sse41_joints, avx2_joints, neon_joints, wasm128_joints;
extern const solve::BodyKernel scalar_bodies, sse41_bodies, avx2_bodies, neon_bodies, wasm128_bodies;
extern const solve::PairKernel scalar_pairs, sse41_pairs, avx2_pairs, avx512_pairs, neon_pairs, wasm128_pairs;
extern const shapes::SupportKernel scalar_hulls, sse41_hulls, avx2_hulls, avx512_hulls, neon_hulls,
    wasm128_hulls;
extern const collide::BoundsKernel scalar_bounds, sse41_bounds, avx2_bounds, neon_bounds, wasm128_bounds;

} // namespace lockstone::solve
