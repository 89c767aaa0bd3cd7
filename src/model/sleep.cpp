#include "model/sleep.h"

#include "model/slots.h"

#include "lockstone/math/math.h"

#include <algorithm>

namespace lockstone::sim {

namespace {

// ---- rows move between awake and resting ----------------------------------------------------------------------

void swap_bodies(Model& w, std::uint32_t x, std::uint32_t y) {
    swap_rows(w.state, w.m.bodies, x, y);
    for (std::uint32_t row : {x, y})
        w.state.edit_row(w.m.body_slot, w.state.rows(w.m.body_info)[row].id.index - 1).row = row;
}

void swap_joints(Model& w, std::uint32_t x, std::uint32_t y) {
    swap_rows(w.state, w.m.joints, x, y);
    for (std::uint32_t row : {x, y})
        w.state.edit_row(w.m.joint_slot, w.state.rows(w.m.joint)[row].id.index - 1).row = row;
}

template <class Visit> void for_each_joint(const Model& w, BodyId body, Visit&& visit) {
    const std::span<const Slot> slots = w.state.rows(w.m.joint_slot);
    std::uint32_t slot = w.state.rows(w.m.body_info)[w.row_of(body)].first_joint;
    while (slot != 0) {
        const std::uint32_t row = slots[slot - 1].row;
        const JointRow& joint = w.state.rows(w.m.joint)[row];
        slot = joint.def.body_a == body ? joint.next_a : joint.next_b;
        visit(row, joint.def.body_a == body ? joint.def.body_b : joint.def.body_a);
    }
}

/// Moves a resting body to the awake rows.
void raise(Model& w, BodyId body) {
    const std::uint32_t first_resting = w.header().bodies_awake;
    swap_bodies(w, w.row_of(body), first_resting);
    ++w.edit_header().bodies_awake;
    BodySleep& sleep = w.state.edit_row(w.m.body_sleep, first_resting);
    restart(sleep);
    sleep.next = 0;
    std::uint32_t& joints_awake = w.edit_header().joints_awake;
    for_each_joint(w, body, [&](std::uint32_t row, BodyId) {
        if (row >= joints_awake) swap_joints(w, row, joints_awake++);
    });
}

/// BodySleep::still_ticks of a body that was created asleep; a body that fell asleep has 0.
constexpr std::uint32_t ticks_of_never_awake = 1;

BodyId body_in_slot(const Model& w, std::uint32_t slot) {
    return w.state.rows(w.m.body_info)[w.state.rows(w.m.body_slot)[slot - 1].row].id;
}

/// Wakes the body, and if it sleeps, all of its island.
void raise_island(Model& w, BodyId body) {
    if (is_awake(w, w.row_of(body))) return;
    std::uint32_t next = w.state.rows(w.m.body_sleep)[w.row_of(body)].next;
    raise(w, body);
    while (next != 0 && next != body.index) {
        const BodyId member = body_in_slot(w, next);
        if (is_awake(w, w.row_of(member))) break; // a ring from outside may not lead back to its start
        next = w.state.rows(w.m.body_sleep)[w.row_of(member)].next;
        raise(w, member);
    }
}

// ---- contacts move between awake and resting -------------------------------------------------------------------

bool is_shape_awake(const Model& w, ShapeId shape) {
    const std::uint32_t row = w.row_of(shape);
    return row == Model::dead || is_awake(w, w.row_of(w.state.rows(w.m.shape)[row].body));
}
bool is_contact_awake(const Model& w, const ContactKey& key) {
    return is_shape_awake(w, key.a) || is_shape_awake(w, key.b);
}

/// Adds rows to a list, which stays sorted.
void merge(const ContactList& more, ContactList& into) {
    const auto order = [](const ContactKey& k) { return std::pair(k.a.index, k.b.index); };
    std::size_t old = into.keys.size(), fresh = more.keys.size(), at = old + fresh;
    into.keys.resize(at), into.memories.resize(at);
    while (fresh != 0) { // backwards, so that no row is overwritten before it has moved
        const bool takes_old = old != 0 && !(order(into.keys[old - 1]) < order(more.keys[fresh - 1]));
        const ContactList& from = takes_old ? into : more;
        const std::size_t row = takes_old ? --old : --fresh;
        --at;
        into.keys[at] = from.keys[row], into.memories[at] = from.memories[row];
    }
}

/// Moves rows that belong to the other table. Both tables stay sorted.
void sort_out(Model& w, const ContactTables& from, const ContactTables& to, bool move_awake) {
    const auto moves = [&](const ContactKey& key) { return is_contact_awake(w, key) == move_awake; };
    if (std::ranges::none_of(w.state.rows(from.key), moves)) return;
    RowMoves& s = w.moves;
    read_contacts(w.state, from, s.here), read_contacts(w.state, to, s.there);
    s.moving.clear();
    std::size_t stay = 0;
    for (std::size_t i = 0; i < s.here.keys.size(); ++i) {
        if (moves(s.here.keys[i])) {
            s.moving.keys.push_back(s.here.keys[i]), s.moving.memories.push_back(s.here.memories[i]);
        } else {
            s.here.keys[stay] = s.here.keys[i], s.here.memories[stay++] = s.here.memories[i];
        }
    }
    s.here.keys.resize(stay), s.here.memories.resize(stay);
    merge(s.moving, s.there);
    write_contacts(w.state, from, s.here), write_contacts(w.state, to, s.there);
}

void wake_contacts(Model& w) { sort_out(w, w.m.sleeping_contacts, w.m.contacts, true); }

/// Wakes the islands of bodies that rest on a body or are joined to it, and of vehicles whose wheels touch it.
void raise_neighbours(Model& w, BodyId body) {
    for (std::size_t i = 0; i < w.state.rows(w.m.sleeping_contacts.key).size(); ++i) {
        const ContactKey key = w.state.rows(w.m.sleeping_contacts.key)[i];
        const BodyId a = w.state.rows(w.m.shape)[w.row_of(key.a)].body;
        const BodyId b = w.state.rows(w.m.shape)[w.row_of(key.b)].body;
        if (a == body) raise_island(w, b);
        if (b == body) raise_island(w, a);
    }
    for (std::uint32_t k = 0; k < w.state.count(w.m.vehicles); ++k) {
        const BodyId chassis = w.state.rows(w.m.vehicle)[k].def.chassis;
        for (const WheelMemory& wheel : w.state.rows(w.m.vehicle_memory)[k].wheel) {
            const std::uint32_t shape = w.row_of(wheel.ground);
            if (shape != Model::dead && w.state.rows(w.m.shape)[shape].body == body) raise_island(w, chassis);
        }
    }
    std::vector<BodyId>& joined = w.moves.joined;
    joined.clear();
    for_each_joint(w, body, [&](std::uint32_t, BodyId other) {
        if (other) joined.push_back(other);
    });
    for (BodyId other : joined) raise_island(w, other);
}

} // namespace

// ---- waking -------------------------------------------------------------------------------------------------

std::uint32_t wake(Model& w, BodyId body) {
    const std::uint32_t row = w.row_of(body);
    if (is_awake(w, row)) {
        if (w.state.rows(w.m.body_sleep)[row].still_ticks != 0)
            restart(w.state.edit_row(w.m.body_sleep, row));
        return row;
    }
    const bool is_dynamic = w.state.rows(w.m.body_info)[row].kind == BodyKind::dynamic;
    raise_island(w, body);
    if (!is_dynamic) raise_neighbours(w, body);
    wake_contacts(w);
    return w.row_of(body);
}

void wake_islands(Model& w, std::span<const BodyId> bodies) {
    for (BodyId body : bodies) raise_island(w, body);
    if (!bodies.empty()) wake_contacts(w);
}

void wake_all(Model& w) {
    for (std::uint32_t row = w.header().bodies_awake; row < w.state.count(w.m.bodies); ++row)
        if (w.state.rows(w.m.body_info)[row].kind == BodyKind::dynamic) {
            raise_island(w, w.state.rows(w.m.body_info)[row].id);
            row = w.header().bodies_awake - 1; // the rows from here on have changed
        }
    wake_contacts(w);
}

void start_asleep(Model& w, std::uint32_t body_row) {
    const std::uint32_t slot = w.state.rows(w.m.body_info)[body_row].id.index;
    w.state.edit_row(w.m.body_sleep, body_row) = {ticks_of_never_awake, slot, slot, {}};
}

bool was_never_awake(const Model& w, std::uint32_t body_row) {
    return !is_awake(w, body_row) &&
           w.state.rows(w.m.body_sleep)[body_row].still_ticks == ticks_of_never_awake;
}

std::uint32_t put_to_rest(Model& w, std::uint32_t body_row) {
    if (!is_awake(w, body_row)) return body_row;
    const std::uint32_t last = --w.edit_header().bodies_awake;
    swap_bodies(w, body_row, last);
    return last;
}

void put_to_rest(Model& w, std::span<const BodyId> bodies) {
    constexpr std::size_t many = 64;
    const std::uint32_t before = w.header().bodies_awake;
    if (bodies.size() < many || bodies.size() < before / 4) {
        for (const BodyId body : bodies) put_to_rest(w, w.row_of(body));
        return;
    }
    // Most of the awake bodies rest from now on. Moves their ids first, and then each of the other columns as a whole.
    std::vector<RowSwap>& swaps = w.moves.swaps;
    swaps.clear();
    const std::span<BodyInfo> info = w.state.edit(w.m.body_info, 0, before);
    const std::span<Slot> slots = w.state.edit(w.m.body_slot);
    std::uint32_t awake = before;
    for (const BodyId body : bodies) {
        const std::uint32_t row = slots[body.index - 1].row;
        if (row >= awake || row == --awake) continue;
        std::swap(info[row], info[awake]);
        slots[info[row].id.index - 1].row = row, slots[info[awake].id.index - 1].row = awake;
        swaps.push_back({row, awake});
    }
    w.edit_header().bodies_awake = awake;
    swap_rows(w.state, w.m.bodies, w.m.body_info.index, before, swaps);
}

std::uint32_t put_joint_to_rest(Model& w, std::uint32_t joint_row) {
    if (joint_row >= w.header().joints_awake) return joint_row;
    const std::uint32_t last = --w.edit_header().joints_awake;
    swap_joints(w, joint_row, last);
    return last;
}

void wake_joint(Model& w, std::uint32_t joint_row) {
    std::uint32_t& awake = w.edit_header().joints_awake;
    if (joint_row >= awake) swap_joints(w, joint_row, awake++);
}

void rest_contacts(Model& w) { sort_out(w, w.m.contacts, w.m.sleeping_contacts, false); }

} // namespace lockstone::sim
