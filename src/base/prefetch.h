// Prefetches bytes that will be read soon.
#pragma once

#include "lockstone/compiler.h"

#include <cstddef>

namespace lockstone::base {

/// Prefetches the cache lines of an object. A hint only; it changes no result.
template <class T> inline void prefetch(const T& object) {
#if LOCKSTONE_GNU
    const auto* bytes = reinterpret_cast<const std::byte*>(&object);
    for (std::size_t at = 0; at < sizeof(T); at += 64) __builtin_prefetch(bytes + at);
    asm volatile(""); // g++ removes calls of functions that only prefetch
#else
    static_cast<void>(object);
#endif
}

} // namespace lockstone::base
