// Draws random stories over the whole public interface.
#pragma once

#include "story.h"

namespace worlds {

/// Sizes of the worlds of a run.
struct Extent {
    std::uint32_t bodies_most = 700; ///< most worlds have far fewer: sizes are uniform over powers of two
    std::uint32_t work = 5000;       ///< bodies times ticks, about
    bool has_large = true;           ///< one world in sixty has up to 5000 bodies
};

/// The story of a seed, equal on every machine, and the hash after each tick in a world of the default mode.
struct Drawn {
    Story story;
    std::vector<std::uint64_t> hashes;
};
Drawn draw(std::uint64_t seed, const Extent& extent = {});

} // namespace worlds
