// The data of a world: the state, and the derived data beside it. Only World has all of it; phases and other layers
// receive the parts that they read and write.
#pragma once

#include "lockstone/world.h"
#include "tick/tick.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace lockstone::sim {

struct Data : Model {
    Data(const WorldDef& def, const GameSchema& schema, std::shared_ptr<const AssetLibrary> assets);
    Data(const Data& other); ///< copies the state; scratch memory is new, without journal and tasks

    Scene scene() { return {*this, placed, query, hooks.tasks}; }

    PlacedShapes placed;
    QueryScratch query;
    TickScratch scratch;
    TickOutput output;
    TickHooks hooks;
    Journal* journal = nullptr;
    /// Scratch memory: a row of a game column to be written, and the row as it was.
    std::vector<std::byte> written_row, canonical_row;
};

/// Runs one tick, and reports it to the journal.
void tick(Data& w);
/// Checks a command, applies it and reports it to the journal. On error nothing has changed.
Result<World::Applied> apply(Data& w, const Command& command);
/// Computes the contact points of the last tick, if that has not been done yet.
void find_contact_points(Data& w);
/// Reserves memory ahead of need: World::reserve.
Status reserve(Data& w, const WorldRows& rows);
/// Resets derived data after the state was replaced from outside, and clears the output of the last tick.
void forget_derived(Data& w);
void tell_of_restore(const Data& w); ///< reports it to the journal, if there is one
/// Overwrites all scratch memory that every tick writes before it reads it; caches keep their values.
void poison_scratch(Data& w, std::byte with);

} // namespace lockstone::sim
