// Bodies by the game's own keys: the same definitions make the same world, in whatever order they are handed over.
//
//   std::vector<Assembly> level = ...                      // from a hash map, a network, threads: any order
//   auto ids = assemble(world, level);                     // in the order of `level`
#pragma once

#include "lockstone/world.h"

#include <span>
#include <vector>

namespace lockstone {

struct Assembly {
    BodyDef body;                 ///< `user_key` differs from those of all others that are handed over
    std::vector<ShapeDef> shapes; ///< those of one body have keys that differ
};

/// Creates bodies and their shapes in ascending order of user_key, so that ids, rows and hash do not depend on the order
/// here. Returns the ids in the order here. On error, which names the key, the world is as it was.
Result<std::vector<BodyId>> assemble(World& world, std::span<const Assembly> assemblies);

} // namespace lockstone
