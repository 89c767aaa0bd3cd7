// Functions over the data of a World: the tick, and the reset of derived data after a restore.
#include "world/data.h"
#include "base/poison.h"

namespace lockstone::sim {

void tick(Data& w) {
    tick(w, w.placed, w.query, w.scratch, w.output, w.hooks);
    if (w.journal != nullptr) w.journal->on_tick(w.header().tick - 1, w.state.hash());
}

void find_contact_points(Data& w) {
    find_contact_points(w, w.placed, w.scratch.pose_before, w.scratch.table.list, w.scratch.found,
                        w.output.contact_points);
}

void forget_derived(Data& w) {
    w.placed.structure_stale = true, w.placed.is_current = false;
    w.placed.fit(w.state.capacity(w.m.shape_slots));
    w.output.events.clear();
    w.output.contact_points.clear();
    w.output.phase_hashes.clear();
}

void tell_of_restore(const Data& w) {
    if (w.journal != nullptr) w.journal->on_restore(w.header().tick);
}

void poison_scratch(Data& w, std::byte with) {
    poison_scratch(w, w.placed, w.query, w.scratch, with);
    base::poison(with, w.written_row, w.canonical_row);
}

} // namespace lockstone::sim
