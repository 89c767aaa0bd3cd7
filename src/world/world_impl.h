// The data to which World points. World's members are in world.cpp, world_query.cpp, world_character.cpp,
// vehicle_world.cpp and reserve.cpp.
#pragma once

#include "base/assert.h"
#include "world/data.h"

#include <string_view>

namespace lockstone {

namespace sim {
/// Returns a row that a caller has named; asserts that it exists.
template <class T> const T& checked_row(std::span<const T> rows, std::uint32_t row, std::string_view what) {
    LOCKSTONE_ASSERT(row < rows.size(), what, " row ", row, " of ", rows.size());
    return rows[row];
}
} // namespace sim

struct World::Impl : sim::Data {
    using sim::Data::Data;
};

inline Status status_of(const Result<World::Applied>& applied) {
    return applied ? Status{} : Status{applied.error()};
}

} // namespace lockstone
