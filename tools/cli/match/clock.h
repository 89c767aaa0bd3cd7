// The time of a match's programs.
#pragma once

#include <chrono>
#include <cstdint>

namespace lockstone::cli {

/// [ms] since 1970, as the machine's clock said when the process first asked. It goes on evenly from there: where the clock is set anew in
/// the middle of a match, a jump of some seconds would look like the silence of everybody.
inline std::uint64_t unix_ms() {
    using namespace std::chrono;
    static const auto begun = steady_clock::now();
    static const auto begun_unix = system_clock::now().time_since_epoch();
    return static_cast<std::uint64_t>(
        duration_cast<milliseconds>(begun_unix + (steady_clock::now() - begun)).count());
}

} // namespace lockstone::cli
