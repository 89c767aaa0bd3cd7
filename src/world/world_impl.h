// What World points to. Its members are in world.cpp and query.cpp.
#pragma once

#include "base/assert.h"
#include "world/data.h"

#include <string_view>

namespace lockstone {

namespace sim {
/// Row of a table that a caller has named.
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
