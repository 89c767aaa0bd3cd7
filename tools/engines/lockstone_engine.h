// Access to the functions that only Lockstone has: save, restore, hash.
#pragma once

#include "engines/scene.h"
#include "lockstone/world.h"

namespace engines {

/// The world of an engine that make_lockstone has made. Owned by the engine.
lockstone::World& world_of(Engine& engine);

} // namespace engines
