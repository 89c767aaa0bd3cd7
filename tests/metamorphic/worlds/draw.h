// Draws random stories over the whole public interface.
#pragma once

#include "story.h"

namespace worlds {

/// Sizes of the worlds of a run.
struct Extent {
    std::uint32_t bodies_most =
        700;                   ///< most worlds have far fewer: sizes are spread evenly over powers of two
    std::uint32_t work = 5000; ///< bodies times ticks, about
    bool has_large = true;     ///< one world in sixty has up to 5000 bodies
};

/// The story of a seed: the same on every machine. Beside it the hash after each tick, as a world of the default mode had it.
struct Drawn {
    Story story;
    std::vector<std::uint64_t> hashes;
};
Drawn draw(std::uint64_t seed, const Extent& extent = {});

} // namespace worlds
