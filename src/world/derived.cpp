// After the state was replaced from outside: what was derived from the one before it is forgotten.
#include "world/data.h"

namespace lockstone::sim {

void forget_derived(Data& w) {
    w.scratch.structure_stale = true;
    w.scratch.fit(w.state.capacity(w.m.shape_slots));
    w.scratch.query.is_fresh = false; // tick and commands may become what they were when last asked
    w.events.clear();
    w.contact_points.clear(), w.contact_points_wait = false;
    w.phase_hashes.clear();
}

void tell_of_restore(const Data& w) {
    if (w.journal != nullptr) w.journal->on_restore(w.header().tick);
}

} // namespace lockstone::sim
