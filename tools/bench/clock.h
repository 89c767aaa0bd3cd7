// Clocks of the benchmark. Nothing here enters a simulation.
#pragma once

#include <ctime>

namespace lockstone::bench {

inline double microseconds_of(clockid_t clock) {
    timespec t{};
    clock_gettime(clock, &t);
    return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

/// What a call takes of this thread [us]: whatever else the machine does is not in it. For ticks and more.
template <class Act> double thread_us(Act&& act) {
    const double before = microseconds_of(CLOCK_THREAD_CPUTIME_ID);
    act();
    return microseconds_of(CLOCK_THREAD_CPUTIME_ID) - before;
}

/// By the wall [us], for what is too short for a system call on either side.
template <class Act> double wall_us(Act&& act) {
    const double before = microseconds_of(CLOCK_MONOTONIC);
    act();
    return microseconds_of(CLOCK_MONOTONIC) - before;
}

} // namespace lockstone::bench
