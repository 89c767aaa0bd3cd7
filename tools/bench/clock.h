// Clocks of the benchmark. No simulation reads them.
#pragma once

#include <ctime>

namespace lockstone::bench {

inline double microseconds_of(clockid_t clock) {
    timespec t{};
    clock_gettime(clock, &t);
    return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

/// The processor time that a call takes on this thread [us]. Other work of the machine does not count. For ticks and
/// longer work.
template <class Act> double thread_us(Act&& act) {
    const double before = microseconds_of(CLOCK_THREAD_CPUTIME_ID);
    act();
    return microseconds_of(CLOCK_THREAD_CPUTIME_ID) - before;
}

/// The wall time that a call takes [us]. For calls so short that a system call before and after them would distort the
/// result.
template <class Act> double wall_us(Act&& act) {
    const double before = microseconds_of(CLOCK_MONOTONIC);
    act();
    return microseconds_of(CLOCK_MONOTONIC) - before;
}

} // namespace lockstone::bench
