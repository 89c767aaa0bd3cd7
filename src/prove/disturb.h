#pragma once

#include "lockstone/testing.h"
#include "world/data.h"

namespace lockstone::sim {

/// testing::disturb() for the data of a world.
void disturb(Data& w, testing::Leftover what, std::uint64_t seed);

} // namespace lockstone::sim
