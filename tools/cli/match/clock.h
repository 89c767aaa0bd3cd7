// The clock of the programs that play a match.
#pragma once

#include <chrono>
#include <cstdint>

namespace lockstone::cli {

/// Milliseconds since 1970. The first call reads the system clock; later calls add the time of the steady clock. If the
/// system clock is set during a match, the jump would otherwise look as if all peers had been silent.
inline std::uint64_t unix_ms() {
    using namespace std::chrono;
    static const auto begun = steady_clock::now();
    static const auto begun_unix = system_clock::now().time_since_epoch();
    return static_cast<std::uint64_t>(
        duration_cast<milliseconds>(begun_unix + (steady_clock::now() - begun)).count());
}

} // namespace lockstone::cli
