#include "solve/joints/kernel.h"
#include "solve/joints/kernels.h"
#include "solve/lanes/scalar.h"

namespace lockstone::solve {

constinit const dynamics::JointKernel scalar_joints = PackedJoints<Scalar>::table();

} // namespace lockstone::solve
