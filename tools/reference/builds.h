// The factory functions of all builds: equal sources, compiled with different number types and flags. See Build.
#pragma once

#include "reference/engine/core.h"

namespace reference {

namespace double_plain {
std::unique_ptr<Core> make(const Law& law, std::span<const BodyStart> bodies);
}
namespace double_fused {
std::unique_ptr<Core> make(const Law& law, std::span<const BodyStart> bodies);
}
namespace float_plain {
std::unique_ptr<Core> make(const Law& law, std::span<const BodyStart> bodies);
}
namespace float_twin {
std::unique_ptr<Core> make(const Law& law, std::span<const BodyStart> bodies);
}
namespace float_fused {
std::unique_ptr<Core> make(const Law& law, std::span<const BodyStart> bodies);
}
namespace float_fast {
std::unique_ptr<Core> make(const Law& law, std::span<const BodyStart> bodies);
}

} // namespace reference
