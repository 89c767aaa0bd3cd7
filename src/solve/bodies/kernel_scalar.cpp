#include "solve/bodies/kernel.h"
#include "solve/bodies/kernels.h"
#include "solve/lanes/scalar.h"

namespace lockstone::solve {

constinit const dynamics::BodyKernel scalar_bodies = MovedBodies<Scalar>::table();

} // namespace lockstone::solve
