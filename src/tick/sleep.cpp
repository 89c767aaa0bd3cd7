#include "tick/sleep.h"

#include "lockstone/math/math.h"
#include "tick/phases.h"

#include <algorithm>

namespace lockstone::sim {

namespace {

// ---- rows change sides --------------------------------------------------------------------------------------

void swap_rows(State& state, TableId table, std::uint32_t x, std::uint32_t y) {
    if (x == y) return;
    const std::span<const ColumnInfo> columns = state.layout().columns();
    for (std::uint32_t c = 0; c < columns.size(); ++c) {
        if (columns[c].table != table.index) continue;
        const std::span<std::byte> a = state.edit_bytes(c, x, 1), b = state.edit_bytes(c, y, 1);
        std::swap_ranges(a.begin(), a.end(), b.begin());
    }
}

void swap_bodies(Data& w, std::uint32_t x, std::uint32_t y) {
    find_contact_points(w);
    swap_rows(w.state, w.m.bodies, x, y);
    for (std::uint32_t row : {x, y})
        w.state.edit_row(w.m.body_slot, w.state.rows(w.m.body_info)[row].id.index - 1).row = row;
}

void swap_joints(Data& w, std::uint32_t x, std::uint32_t y) {
    swap_rows(w.state, w.m.joints, x, y);
    for (std::uint32_t row : {x, y})
        w.state.edit_row(w.m.joint_slot, w.state.rows(w.m.joint)[row].id.index - 1).row = row;
}

template <class Visit> void for_each_joint(const Data& w, BodyId body, Visit&& visit) {
    const std::span<const Slot> slots = w.state.rows(w.m.joint_slot);
    std::uint32_t slot = w.state.rows(w.m.body_info)[w.row_of(body)].first_joint;
    while (slot != 0) {
        const std::uint32_t row = slots[slot - 1].row;
        const JointRow& joint = w.state.rows(w.m.joint)[row];
        slot = joint.def.body_a == body ? joint.next_a : joint.next_b;
        visit(row, joint.def.body_a == body ? joint.def.body_b : joint.def.body_a);
    }
}

/// Of a resting body.
void raise(Data& w, BodyId body) {
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

BodyId body_in_slot(const Data& w, std::uint32_t slot) {
    return w.state.rows(w.m.body_info)[w.state.rows(w.m.body_slot)[slot - 1].row].id;
}

/// The body, and if it sleeps in an island all of that.
void raise_island(Data& w, BodyId body) {
    if (is_awake(w, w.row_of(body))) return;
    std::uint32_t next = w.state.rows(w.m.body_sleep)[w.row_of(body)].next;
    raise(w, body);
    while (next != 0 && next != body.index) {
        const BodyId member = body_in_slot(w, next);
        if (is_awake(w, w.row_of(member))) break; // a ring from outside may lead past its start
        next = w.state.rows(w.m.body_sleep)[w.row_of(member)].next;
        raise(w, member);
    }
}

// ---- contacts change sides ----------------------------------------------------------------------------------

bool is_shape_awake(const Data& w, ShapeId shape) {
    const std::uint32_t row = w.row_of(shape);
    return row == Data::dead || is_awake(w, w.row_of(w.state.rows(w.m.shape)[row].body));
}
bool is_contact_awake(const Data& w, const ContactKey& key) {
    return is_shape_awake(w, key.a) || is_shape_awake(w, key.b);
}

/// Adds rows to a list, which stays sorted.
void merge(const ContactList& more, ContactList& into) {
    const auto order = [](const ContactKey& k) { return std::pair(k.a.index, k.b.index); };
    std::size_t old = into.keys.size(), fresh = more.keys.size(), at = old + fresh;
    into.keys.resize(at), into.memories.resize(at);
    while (fresh != 0) { // from behind, so that nothing is overwritten before it has moved
        const bool takes_old = old != 0 && !(order(into.keys[old - 1]) < order(more.keys[fresh - 1]));
        const ContactList& from = takes_old ? into : more;
        const std::size_t row = takes_old ? --old : --fresh;
        --at;
        into.keys[at] = from.keys[row], into.memories[at] = from.memories[row];
    }
}

/// Moves rows that are on the wrong side of two tables, both of which stay sorted.
void sort_out(Data& w, const ContactTables& from, const ContactTables& to, bool move_awake) {
    const auto moves = [&](const ContactKey& key) { return is_contact_awake(w, key) == move_awake; };
    if (std::ranges::none_of(w.state.rows(from.key), moves)) return;
    SleepScratch& s = w.scratch.sleep;
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

void wake_contacts(Data& w) { sort_out(w, w.m.sleeping_contacts, w.m.contacts, true); }
void rest_contacts(Data& w) { sort_out(w, w.m.contacts, w.m.sleeping_contacts, false); }

/// The islands of bodies that rest on a body or are joined to it, and of vehicles that stand on it.
void raise_neighbours(Data& w, BodyId body) {
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
            if (shape != Data::dead && w.state.rows(w.m.shape)[shape].body == body) raise_island(w, chassis);
        }
    }
    std::vector<BodyId>& joined = w.scratch.sleep.leaving;
    joined.clear();
    for_each_joint(w, body, [&](std::uint32_t, BodyId other) {
        if (other) joined.push_back(other);
    });
    for (BodyId other : joined) raise_island(w, other);
}

} // namespace

// ---- waking -------------------------------------------------------------------------------------------------

std::uint32_t wake(Data& w, BodyId body) {
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

void wake_all(Data& w) {
    for (std::uint32_t row = w.header().bodies_awake; row < w.state.count(w.m.bodies); ++row)
        if (w.state.rows(w.m.body_info)[row].kind == BodyKind::dynamic) {
            raise_island(w, w.state.rows(w.m.body_info)[row].id);
            row = w.header().bodies_awake - 1; // rows from here on have changed
        }
    wake_contacts(w);
}

std::uint32_t put_to_rest(Data& w, std::uint32_t body_row) {
    if (!is_awake(w, body_row)) return body_row;
    const std::uint32_t last = --w.edit_header().bodies_awake;
    swap_bodies(w, body_row, last);
    return last;
}

std::uint32_t put_joint_to_rest(Data& w, std::uint32_t joint_row) {
    if (joint_row >= w.header().joints_awake) return joint_row;
    const std::uint32_t last = --w.edit_header().joints_awake;
    swap_joints(w, joint_row, last);
    return last;
}

void wake_joint(Data& w, std::uint32_t joint_row) {
    std::uint32_t& awake = w.edit_header().joints_awake;
    if (joint_row >= awake) swap_joints(w, joint_row, awake++);
}

bool wake_touched(Data& w) {
    std::vector<BodyId>& touched = w.scratch.sleep.leaving;
    touched.clear();
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    const std::span<const Slot> shape_slots = w.state.rows(w.m.shape_slot),
                                body_slots = w.state.rows(w.m.body_slot);
    const std::uint32_t awake = w.header().bodies_awake;
    for (const Scratch::Near& near : w.scratch.near) {
        const ShapeRow& a = shapes[shape_slots[near.key.a.index - 1].row];
        const ShapeRow& b = shapes[shape_slots[near.key.b.index - 1].row];
        const std::uint32_t row_a = body_slots[a.body.index - 1].row,
                            row_b = body_slots[b.body.index - 1].row;
        const bool wakes_a = row_a >= awake, wakes_b = row_b >= awake;
        if (wakes_a == wakes_b || (w.traits_of(a).sensor | w.traits_of(b).sensor) != 0) continue;
        if (w.state.rows(w.m.body_info)[wakes_a ? row_a : row_b].kind != BodyKind::dynamic) continue;
        if (has_contact_points(w, near)) touched.push_back(wakes_a ? a.body : b.body);
    }
    for (BodyId body : touched) raise_island(w, body);
    if (!touched.empty()) wake_contacts(w);
    return !touched.empty();
}

// ---- falling asleep -----------------------------------------------------------------------------------------

namespace {

/// |v| + |w| times twice the largest gyration radius is below the limit: no point of a solid body is much faster.
bool is_below(const Velocity& v, const BodyMass& mass, Speed limit) {
    for (int i = 0; i < 3; ++i)
        if (abs(v.linear[i]) >= limit) return false;
    const Real radius = max(mass.gyration.x, max(mass.gyration.y, mass.gyration.z)) * 2;
    return to<Real>(length(v.linear)) + to<Real>(length(v.angular)) * radius < to<Real>(limit);
}

/// What counts as still: slow, or at most four times as fast but not away from where the still ticks began. What rocks or
/// shakes on the spot between its neighbours would keep an island awake otherwise.
/// source: Rouwe, Jolt Physics, Body::UpdateSleepStateInternal, for the idea to look at how far a body went
struct Stillness {
    std::uint32_t ticks_to_sleep;
    Speed slow, rocking;
    Speed away; ///< of BodySleep::moved: what sleep_speed covers in sleep_time [tick m/s]

    explicit Stillness(const Config& c)
        : ticks_to_sleep(static_cast<std::uint32_t>(std::max<std::int64_t>(
              1, floor_to_int(c.sleep_time * static_cast<std::int32_t>(c.tick_rate))))),
          slow(to<Speed>(c.sleep_speed)), rocking(to<Speed>(c.sleep_speed * 4)),
          away(to<Speed>(c.sleep_speed * Real(ticks_to_sleep))) {}

    bool is_still(const Velocity& v, const Velocity& moved, const BodyMass& mass) const {
        return is_below(v, mass, slow) || (is_below(v, mass, rocking) && is_below(moved, mass, away));
    }
    void count(BodySleep& sleep, const Velocity& v, const BodyMass& mass) const {
        sleep.moved = {sleep.moved.linear + v.linear, sleep.moved.angular + v.angular};
        if (is_still(v, sleep.moved, mass))
            sleep.still_ticks = std::min(sleep.still_ticks + 1, 1u << 30);
        else
            restart(sleep);
    }
};

struct Islands {
    Data& w;
    SleepScratch& s;
    std::uint32_t awake;
    std::span<const BodyInfo> info;
    std::span<const Velocity> velocity;

    explicit Islands(Data& data)
        : w(data), s(data.scratch.sleep), awake(data.header().bodies_awake),
          info(data.state.rows(data.m.body_info)), velocity(data.state.rows(data.m.body_velocity)) {}

    std::uint32_t root(std::uint32_t row) {
        while (s.parent[row] != row) row = s.parent[row] = s.parent[s.parent[row]];
        return row;
    }
    bool is_dynamic(std::uint32_t row) const { return row < awake && info[row].kind == BodyKind::dynamic; }
    /// A kinematic body that moves keeps awake what it holds.
    bool holds(std::uint32_t row) const {
        return row < awake && info[row].kind == BodyKind::kinematic && velocity[row] != Velocity{};
    }
    void link(std::uint32_t a, std::uint32_t b) {
        if (is_dynamic(a) && holds(b)) s.still_ticks[a] = 0;
        if (is_dynamic(b) && holds(a)) s.still_ticks[b] = 0;
        if (!is_dynamic(a) || !is_dynamic(b)) return;
        const std::uint32_t x = root(a), y = root(b);
        s.parent[std::max(x, y)] = std::min(x, y);
    }
    void find() {
        s.parent.resize(awake);
        for (std::uint32_t row = 0; row < awake; ++row) s.parent[row] = row;
        for (const solve::Contact& c : w.scratch.contacts) link(c.body_a, c.body_b);
        for (const solve::Joint& j : w.scratch.joints) link(j.body_a, j.body_b);
        for (const Standing& v : w.scratch.vehicle_solver.standing()) link(v.chassis, v.ground);
        for (std::uint32_t row = 0; row < awake; ++row) {
            std::uint32_t& least = s.still_ticks[root(row)];
            least = std::min(least, s.still_ticks[row]);
        }
    }
};

/// How long each awake body has been still, in the state and in the scratch.
void count_still_ticks(Data& w, const Stillness& stillness) {
    const std::uint32_t awake = w.header().bodies_awake;
    const std::span<BodySleep> sleep = w.state.edit(w.m.body_sleep, 0, awake);
    const std::span<const BodyInfo> info = w.state.rows(w.m.body_info);
    const solve::MassView mass = w.masses();
    const std::span<const Velocity> velocity = w.state.rows(w.m.body_velocity);
    w.scratch.sleep.still_ticks.resize(awake);
    for (std::uint32_t row = 0; row < awake; ++row) {
        if (info[row].kind == BodyKind::dynamic) stillness.count(sleep[row], velocity[row], mass[row]);
        w.scratch.sleep.still_ticks[row] = sleep[row].still_ticks;
    }
}

/// The bodies of islands that have been still for long enough, with their rings; in slot order.
void put_islands_to_sleep(Data& w) {
    const Stillness stillness(w.state.rows(w.m.config)[0]);
    count_still_ticks(w, stillness);
    Islands islands(w);
    islands.find();
    SleepScratch& s = w.scratch.sleep;
    const std::size_t begin = s.leaving.size();
    for (std::uint32_t row = 0; row < islands.awake; ++row)
        if (islands.is_dynamic(row) && s.still_ticks[islands.root(row)] >= stillness.ticks_to_sleep)
            s.leaving.push_back(islands.info[row].id);
    if (s.leaving.size() == begin) return;
    std::sort(s.leaving.begin() + static_cast<std::ptrdiff_t>(begin), s.leaving.end());
    s.first.assign(islands.awake, 0), s.last.assign(islands.awake, 0);
    for (std::size_t i = begin; i < s.leaving.size(); ++i) {
        const std::uint32_t slot = s.leaving[i].index, row = w.row_of(s.leaving[i]), root = islands.root(row);
        if (s.first[root] == 0) s.first[root] = slot;
        BodySleep& sleep = w.state.edit_row(w.m.body_sleep, row);
        sleep = {0, s.first[root], s.first[root], {}}; // the ring is closed behind each
        if (s.last[root] != 0)
            w.state.edit_row(w.m.body_sleep, w.state.rows(w.m.body_slot)[s.last[root] - 1].row).next = slot;
        s.last[root] = slot;
        w.state.edit_row(w.m.body_velocity, row) = {};
    }
}

void publish_sleep(Data& w, std::span<const BodyId> bodies) {
    for (BodyId body : bodies) {
        if (w.state.rows(w.m.body_info)[w.row_of(body)].kind != BodyKind::dynamic) continue;
        Event e{};
        e.kind = EventKind::body_sleep;
        e.body_a = body;
        e.tick = w.header().tick;
        w.events.push_back(e);
    }
}

} // namespace

void settle(Data& w) {
    SleepScratch& s = w.scratch.sleep;
    s.leaving.clear();
    for (std::uint32_t row = 0; row < w.header().bodies_awake; ++row) {
        const BodyInfo& info = w.state.rows(w.m.body_info)[row];
        const bool rests =
            info.kind == BodyKind::static_ ||
            (info.kind == BodyKind::kinematic && w.state.rows(w.m.body_velocity)[row] == Velocity{});
        if (rests) s.leaving.push_back(info.id);
    }
    if (w.state.rows(w.m.config)[0].sleeping != 0) put_islands_to_sleep(w);
    if (s.leaving.empty()) return;
    for (BodyId body : s.leaving) put_to_rest(w, w.row_of(body));
    for (std::uint32_t row = w.header().joints_awake; row-- > 0;) {
        const JointDef& def = w.state.rows(w.m.joint)[row].def;
        const bool held =
            (def.body_a && is_awake(w, w.row_of(def.body_a))) || is_awake(w, w.row_of(def.body_b));
        if (!held) put_joint_to_rest(w, row);
    }
    rest_contacts(w);
    publish_sleep(w, s.leaving);
    w.scratch.structure_stale = true;
}

} // namespace lockstone::sim
