#pragma once

#include "lockstone/testing.h"
#include "world/data.h"

namespace lockstone::sim {

/// testing::disturb() of a world's inside.
void disturb(Data& w, testing::Leftover what, std::uint64_t seed);

} // namespace lockstone::sim
