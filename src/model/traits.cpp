// What bodies and shapes are like, and what pushes them: rows of tables beside theirs.
#include "world/data.h"

namespace lockstone::sim {

void set_traits(Data& w, std::uint32_t body_row, const BodyTraits& traits) {
    std::uint32_t free = w.header().body_traits_free;
    const std::uint32_t now = w.state.rows(w.m.body_info)[body_row].traits;
    const std::uint32_t row = exchange_shared(w.state, w.m.body_traits, now, traits, free);
    w.state.edit_row(w.m.body_info, body_row).traits = row;
    w.edit_header().body_traits_free = free;
}

void set_shape_traits(Data& w, std::uint32_t shape_row, const ShapeTraits& traits) {
    std::uint32_t free = w.header().shape_traits_free;
    const std::uint32_t now = w.state.rows(w.m.shape)[shape_row].traits;
    const std::uint32_t row = exchange_shared(w.state, w.m.shape_traits, now, traits, free);
    w.state.edit_row(w.m.shape, shape_row).traits = row;
    w.edit_header().shape_traits_free = free;
}

BodyForce& force_on(Data& w, std::uint32_t body_row) {
    const std::uint32_t push = w.state.rows(w.m.body_push)[body_row], count = w.state.count(w.m.forces);
    if (push != 0 && push <= count) return w.state.edit_row(w.m.force, push - 1);
    const std::uint32_t row = count; // below bodies_max: this body has none yet
    w.state.resize(w.m.forces, row + 1);
    w.state.edit_row(w.m.body_push, body_row) = row + 1;
    w.state.edit_row(w.m.pushed, row) = w.state.rows(w.m.body_info)[body_row].id.index;
    return w.state.edit_row(w.m.force, row);
}

void forget_force(Data& w, std::uint32_t body_row) {
    const std::uint32_t push = w.state.rows(w.m.body_push)[body_row];
    if (push == 0 || push > w.state.count(w.m.forces)) return;
    const std::uint32_t last = w.state.count(w.m.forces) - 1;
    if (push - 1 != last) {
        const std::uint32_t moved = w.state.rows(w.m.pushed)[last];
        w.state.edit_row(w.m.force, push - 1) = w.state.rows(w.m.force)[last];
        w.state.edit_row(w.m.pushed, push - 1) = moved;
        w.state.edit_row(w.m.body_push, w.state.rows(w.m.body_slot)[moved - 1].row) = push;
    }
    w.state.edit_row(w.m.body_push, body_row) = 0;
    w.state.resize(w.m.forces, last);
}

void forget_forces(Data& w) {
    const std::span<const Slot> slots = w.state.rows(w.m.body_slot);
    for (const std::uint32_t slot : w.state.rows(w.m.pushed))
        if (slot != 0 && slot <= slots.size() && slots[slot - 1].is_alive())
            w.state.edit_row(w.m.body_push, slots[slot - 1].row) = 0;
    w.state.resize(w.m.forces, 0);
}

} // namespace lockstone::sim
