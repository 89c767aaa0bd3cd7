// What World points to. Its members are in world.cpp and query.cpp.
#pragma once

#include "sim/data.h"

namespace lockstone {

struct World::Impl : sim::Data {
    using sim::Data::Data;
};

} // namespace lockstone
