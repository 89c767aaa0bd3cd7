// Packs that are wanted soon, where there are more than a cache holds.
#pragma once

#include "lockstone/compiler.h"
#include "solve/contacts/pack.h"

#include <cstddef>

namespace lockstone::solve {

template <class L> struct Ahead {
    using Pack = ContactPack<L::lanes>;

    /// While pack `i` is worked on: asks for the cache lines of the pack after the next, and of the bodies of the next. There may be no such packs: it
    /// is a hint.
    static void ask_for(const void* packs, std::uint32_t i, const PassData& data) {
#if LOCKSTONE_GNU
        const Pack* const next = static_cast<const Pack*>(packs) + i + 1;
        const char* const bytes = reinterpret_cast<const char*>(next + 1);
        for (std::size_t at = 0; at < sizeof(Pack); at += 64) __builtin_prefetch(bytes + at);
        asm volatile(""); // g++ takes calls away of functions that do nothing but ask
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
