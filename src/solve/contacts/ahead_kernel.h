// Prefetches the packs that a pass needs soon, where the cache does not hold all packs.
#pragma once

#include "lockstone/compiler.h"
#include "solve/contacts/pack.h"

#include <cstddef>

namespace lockstone::solve {

template <class L> struct Ahead {
    using Pack = ContactPack<L::lanes>;

    /// Prefetches, while pack `i` is solved, the cache lines of the pack after the next one and of the bodies of the
    /// next one. These packs need not exist: a prefetch of any address is valid.
    static void ask_for(const void* packs, std::uint32_t i, const PassData& data) {
#if LOCKSTONE_GNU
        const Pack* const next = static_cast<const Pack*>(packs) + i + 1;
        const char* const bytes = reinterpret_cast<const char*>(next + 1);
        for (std::size_t at = 0; at < sizeof(Pack); at += 64) __builtin_prefetch(bytes + at);
        asm volatile(""); // g++ removes calls of functions that only prefetch
        if (i + 1 >= data.packs) return;
        for (unsigned lane = 0; lane < L::lanes; ++lane) {
            const char* const b = reinterpret_cast<const char*>(data.bodies + next->body_b[lane]);
            __builtin_prefetch(b), __builtin_prefetch(b + 64);
        }
#else
        static_cast<void>(packs), static_cast<void>(i), static_cast<void>(data);
#endif
    }
};

} // namespace lockstone::solve
