#include "reference/builds.h"

namespace reference {

const char* name_of(Build build) {
    switch (build) {
    case Build::double_plain:
        return "double";
    case Build::double_fused:
        return "double, fused";
    case Build::float_plain:
        return "float";
    case Build::float_twin:
        return "float, again";
    case Build::float_fused:
        return "float, fused";
    case Build::float_fast:
        break;
    }
    return "float, -ffast-math";
}

bool is_available(Build build) {
#if defined(__x86_64__) || defined(__i386__)
    if (build == Build::double_fused || build == Build::float_fused)
        return __builtin_cpu_supports("fma") != 0;
#endif
    (void)build;
    return true;
}

std::unique_ptr<Core> make_core(Build build, const Law& law, std::span<const BodyStart> bodies) {
    switch (build) {
    case Build::double_plain:
        return double_plain::make(law, bodies);
    case Build::double_fused:
        return double_fused::make(law, bodies);
    case Build::float_plain:
        return float_plain::make(law, bodies);
    case Build::float_twin:
        return float_twin::make(law, bodies);
    case Build::float_fused:
        return float_fused::make(law, bodies);
    case Build::float_fast:
        break;
    }
    return float_fast::make(law, bodies);
}

} // namespace reference
