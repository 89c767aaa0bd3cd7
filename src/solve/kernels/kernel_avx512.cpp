// The kernels for AVX-512, compiled with the flags of this instruction set where the target is x86.
#include "lockstone/compiler.h"

#if LOCKSTONE_HAS_X86

#if LOCKSTONE_GNU && !defined(__clang__)
#pragma GCC diagnostic ignored                                                                               \
    "-Wuninitialized" // in the intrinsics of g++ 12: the part of a vector that a mask of all lanes leaves
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif

#include "solve/contacts/kernel.h"
#include "solve/kernels/kernels.h"
#include "solve/lanes/avx512.h"
#include "solve/pairs/kernel.h"
#include "solve/pairs/support_kernel.h"

namespace lockstone::solve {

constinit const ContactKernel avx512_contacts = Kernel<Avx512>::table();
constinit const solve::PairKernel avx512_pairs = PairLanes<Avx512>::table();
constinit const shapes::SupportKernel avx512_hulls = HullSupport<Avx512>::table();

} // namespace lockstone::solve

#endif
