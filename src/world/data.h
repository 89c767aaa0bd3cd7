// A world's inside: the state, and all that is kept beside it. Nobody but World sees the whole; phases and rooms are handed what
// they read and write.
#pragma once

#include "lockstone/world.h"
#include "tick/tick.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace lockstone::sim {

struct Data : Model {
    Data(const WorldDef& def, const GameSchema& schema, std::shared_ptr<const AssetLibrary> assets);
    Data(const Data& other); ///< the state; fresh scratch, no journal, no tasks

    Scene scene() { return {*this, placed, query, hooks.tasks}; }

    PlacedShapes placed;
    QueryScratch query;
    TickScratch scratch;
    TickOutput output;
    TickHooks hooks;
    Journal* journal = nullptr;
    std::vector<std::byte> written_row, canonical_row; ///< memory: of a game column, to be written, as it was
};

/// One tick, and the journal hears of it.
void tick(Data& w);
/// Checks a command, applies it and tells the journal. On error nothing has changed.
Result<World::Applied> apply(Data& w, const Command& command);
/// Makes the contact points of the last tick, if they wait.
void find_contact_points(Data& w);
/// Memory ahead of need: World::reserve.
Status reserve(Data& w, const WorldRows& rows);
/// After the state was replaced from outside: what was derived from the one before it is forgotten, the last tick's output is gone.
void forget_derived(Data& w);
void tell_of_restore(const Data& w); ///< the journal, if there is one
/// Fills all scratch that is written before it is read with a byte; caches stay.
void poison_scratch(Data& w, std::byte with);

} // namespace lockstone::sim
