// Compiled with the flags of its instruction set where the target is x86.
#if defined(__x86_64__) || defined(__i386__)

#include "solve/contacts/kernel.h"
#include "solve/contacts/kernels.h"
#include "solve/lanes/sse41.h"

namespace lockstone::solve {

constinit const ContactKernel sse41_kernel = Kernel<Sse41>::table();

} // namespace lockstone::solve

#endif
