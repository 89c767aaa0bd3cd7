// What only Lockstone can do: save, restore, hash.
#pragma once

#include "engines/scene.h"
#include "lockstone/world.h"

namespace engines {

/// The world of an engine that make_lockstone made.
lockstone::World& world_of(Engine& engine);

} // namespace engines
