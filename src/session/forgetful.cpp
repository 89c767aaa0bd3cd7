// The faulty simulation of lockstone/session/forgetful.h: restore() leaves out one column.
#include "lockstone/session/forgetful.h"

#include "base/assert.h"

#include <algorithm>

namespace lockstone::testing {

void ForgetfulSimulation::restore(const Image& image) {
    if (left_out.empty()) return real.restore(image);
    State& state = real.state();
    const ColumnInfo* info = state.layout().find_column(left_out);
    LOCKSTONE_ASSERT(info != nullptr, "no column ", left_out);
    const std::uint32_t column = static_cast<std::uint32_t>(info - state.layout().columns().data());
    const std::span<const std::byte> present = state.bytes(column);
    kept.assign(present.begin(), present.end());
    real.restore(image);
    const std::span<std::byte> restored = state.edit_bytes(column);
    std::copy_n(kept.begin(), std::min(kept.size(), restored.size()), restored.begin());
}

} // namespace lockstone::testing
