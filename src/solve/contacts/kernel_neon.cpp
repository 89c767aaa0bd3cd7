// Every AArch64 has NEON; its intrinsics count lanes otherwise where bytes are big-endian.
#if defined(__aarch64__) && !defined(__AARCH64EB__)

#include "solve/contacts/kernel.h"
#include "solve/contacts/kernels.h"
#include "solve/lanes/neon.h"

namespace lockstone::solve {

constinit const ContactKernel neon_kernel = Kernel<Neon>::table();

} // namespace lockstone::solve

#endif
