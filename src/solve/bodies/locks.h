// Axis locks. Every command or step that sets a velocity drops the parts along and about locked axes.
#pragma once

#include "solve/bodies/rows.h"

namespace lockstone::solve {

/// Removes the parts of a velocity along and about locked axes. `locks`: AxisLock bits.
constexpr void drop_locked(Velocity& v, std::uint32_t locks) {
    for (int i = 0; i < 3; ++i) {
        if (((locks >> i) & 1u) != 0) v.linear[i] = Speed{};
        if (((locks >> (3 + i)) & 1u) != 0) v.angular[i] = Speed{};
    }
}

} // namespace lockstone::solve
