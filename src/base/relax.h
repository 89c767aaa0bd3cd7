// One step of a polling loop of a thread that waits for another thread.
#pragma once

#include "lockstone/compiler.h"

#if LOCKSTONE_HAS_X86
#include <immintrin.h>
#endif
#if !defined(LOCKSTONE_NO_THREADS)
#include <thread>
#endif

namespace lockstone::base {

/// Yields to the other hardware thread of the core and, after every 4096 polls, to other threads of the system. Not
/// more often: the scheduler of Linux 6.18 makes a thread that yields often wait until it has had less time than all
/// others.
inline void relax(int looks) {
#if !defined(LOCKSTONE_NO_THREADS)
    if (looks > 0 && looks % 4096 == 0) return std::this_thread::yield();
#endif
#if LOCKSTONE_HAS_X86
    _mm_pause();
#elif defined(__aarch64__) && LOCKSTONE_GNU
    asm volatile("yield");
#endif
}

} // namespace lockstone::base
