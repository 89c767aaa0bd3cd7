// Bytes that are wanted soon.
#pragma once

#include "lockstone/compiler.h"

#include <cstddef>

namespace lockstone::base {

/// Asks for the cache lines of an object that will be read; no more than a hint.
template <class T> inline void prefetch(const T& object) {
#if LOCKSTONE_GNU
    const auto* bytes = reinterpret_cast<const std::byte*>(&object);
    for (std::size_t at = 0; at < sizeof(T); at += 64) __builtin_prefetch(bytes + at);
    asm volatile(""); // g++ takes calls away of functions that do nothing but ask
#else
    static_cast<void>(object);
#endif
}

} // namespace lockstone::base
