#include "solve/contacts/kernel.h"
#include "solve/contacts/kernels.h"
#include "solve/lanes/scalar.h"

namespace lockstone::solve {

constinit const ContactKernel scalar_kernel = Kernel<Scalar>::table();

} // namespace lockstone::solve
