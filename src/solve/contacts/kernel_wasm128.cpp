// Of modules that are compiled with vectors (-msimd128): others do not load where there are none.
#if defined(__wasm_simd128__)

#include "solve/contacts/kernel.h"
#include "solve/contacts/kernels.h"
#include "solve/lanes/wasm128.h"

namespace lockstone::solve {

constinit const ContactKernel wasm128_kernel = Kernel<Wasm128>::table();

} // namespace lockstone::solve

#endif
