// Axis locks, applied wherever a velocity enters: along and about locked axes there is none, whatever gave it.
#pragma once

#include "solve/bodies/rows.h"

namespace lockstone::solve {

/// Removes the parts along and about locked axes; `locks`: AxisLock bits.
constexpr void drop_locked(Velocity& v, std::uint32_t locks) {
    for (int i = 0; i < 3; ++i) {
        if (((locks >> i) & 1u) != 0) v.linear[i] = Speed{};
        if (((locks >> (3 + i)) & 1u) != 0) v.angular[i] = Speed{};
    }
}

} // namespace lockstone::solve
