// Equal keys, nonces and cookies for every input, so that an input repeats its behaviour. For fuzzers only.
#pragma once

#include "lockstone/math/random.h"

#include <cstddef>
#include <cstdint>

#include <sodium.h>

namespace fuzz {

inline lockstone::Random drawn = lockstone::Random::seeded(1);

inline std::uint32_t draw() { return drawn.below(0xffffffffu); }
inline void fill(void* const to, const std::size_t size) {
    for (std::size_t i = 0; i < size; ++i)
        static_cast<unsigned char*>(to)[i] = static_cast<unsigned char>(drawn.below(256));
}

inline void draw_the_same_keys() {
    static randombytes_implementation same{[] { return "the same"; }, draw, nullptr, nullptr, fill, nullptr};
    static const bool chosen = [] {
        return randombytes_set_implementation(&same) == 0 && sodium_init() >= 0;
    }();
    if (chosen) drawn = lockstone::Random::seeded(1);
}

} // namespace fuzz
