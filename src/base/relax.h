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

/// Gives the processor's other thread a chance; after many looks, other threads of the system.
inline void relax(int looks) {
#if !defined(LOCKSTONE_NO_THREADS)
    if (looks > 0 && looks % 256 == 0) return std::this_thread::yield();
#endif
#if LOCKSTONE_HAS_X86
    _mm_pause();
#elif defined(__aarch64__) && LOCKSTONE_GNU
    asm volatile("yield");
#endif
}

} // namespace lockstone::base
