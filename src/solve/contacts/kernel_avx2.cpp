// Compiled with the flags of its instruction set where the target is x86.
#if defined(__x86_64__) || defined(__i386__)

#include "solve/contacts/kernel.h"
#include "solve/contacts/kernels.h"
#include "solve/lanes/avx2.h"

namespace lockstone::solve {

constinit const ContactKernel avx2_kernel = Kernel<Avx2>::table();

} // namespace lockstone::solve

#endif
