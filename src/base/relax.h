// A look in vain by a thread that waits for another one.
#pragma once

#include "lockstone/compiler.h"

#if LOCKSTONE_HAS_X86
#include <immintrin.h>
#endif
#if !defined(LOCKSTONE_NO_THREADS)
#include <thread>
#endif

namespace lockstone::base {

/// Gives the processor's other thread a chance; after very many looks, other threads of the system. Linux 6.18 makes a thread that often gives
/// its processor away wait until it has had less than all others.
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
