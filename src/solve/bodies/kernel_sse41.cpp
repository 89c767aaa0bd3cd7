// Compiled with the flags of its instruction set where the target is x86.
#if defined(__x86_64__) || defined(__i386__)

#include "solve/bodies/kernel.h"
#include "solve/bodies/kernels.h"
#include "solve/lanes/sse41.h"

namespace lockstone::solve {

constinit const dynamics::BodyKernel sse41_bodies = MovedBodies<Sse41>::table();

} // namespace lockstone::solve

#endif
