// Compiled with the flags of its instruction set where the target is x86.
#if defined(__x86_64__) || defined(__i386__)

#include "solve/bodies/kernel.h"
#include "solve/bodies/kernels.h"
#include "solve/lanes/avx2.h"

namespace lockstone::solve {

constinit const dynamics::BodyKernel avx2_bodies = MovedBodies<Avx2>::table();

} // namespace lockstone::solve

#endif
