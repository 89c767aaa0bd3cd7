// Manifolds of the pairs that are near, and with them the contact table of this tick.
#include "sim/phases.h"

#include "lockstone/math.h"
#include "sim/surface.h"

#include <algorithm>

namespace lockstone::sim {

namespace {

constexpr Separation touching_gap = decimal<Separation>("0.005"); ///< [m]: nearer counts as touching

/// The rows and shapes of a contact, in the order the narrow phase wants them.
struct Couple {
    const ShapeRow *a, *b;
    std::uint32_t body_a, body_b;
    const Scratch::Shape *at_a, *at_b;
    collide::RelativePose pose;
    Quat rotation; ///< of the pose
    Length margin;
    bool flipped, sensor;
};

/// Whether shape b is the narrow phase's A: the greater kind is, of equal kinds the larger. Of two convex shapes one that
/// is larger than a lever can be comes first whatever its kind, as contact points are told from B's origin.
bool goes_after(const ShapeRow& a, const Scratch::Shape& at_a, const ShapeRow& b,
                const Scratch::Shape& at_b) {
    const ShapeKind ka = a.geometry.kind, kb = b.geometry.kind;
    const bool are_convex = ka <= ShapeKind::hull && kb <= ShapeKind::hull;
    const bool is_huge = max(at_a.reach, at_b.reach) > Coordinate(128);
    if (ka == kb || (are_convex && is_huge)) return at_a.reach < at_b.reach;
    return ka < kb;
}

Couple couple_of(const Data& w, const ContactKey& key) {
    const std::span<const ShapeRow> shapes = w.state.rows(w.m.shape);
    Couple c{};
    c.a = &shapes[w.row_of(key.a)], c.b = &shapes[w.row_of(key.b)];
    c.at_a = &w.scratch.shape[key.a.index - 1], c.at_b = &w.scratch.shape[key.b.index - 1];
    c.flipped = goes_after(*c.a, *c.at_a, *c.b, *c.at_b);
    if (c.flipped) std::swap(c.a, c.b), std::swap(c.at_a, c.at_b);
    c.body_a = w.row_of(c.a->body);
    c.body_b = w.row_of(c.b->body);
    c.rotation = conjugate(c.at_a->pose.rotation) * c.at_b->pose.rotation;
    c.pose = c.a->geometry.kind == ShapeKind::plane ? collide::plane_relative_pose(c.at_a->pose, c.at_b->pose)
                                                    : collide::relative_pose(c.at_a->pose, c.at_b->pose);
    c.margin = c.at_a->margin + c.at_b->margin;
    c.sensor = (c.a->sensor | c.b->sensor) != 0;
    return c;
}

ContactMemory memory_of(const Couple& c, const collide::Manifold& manifold, std::uint32_t flags) {
    ContactMemory memory{};
    memory.flags = flags;
    memory.count = manifold.count;
    // Only shapes of many pieces say which of them it is.
    if (c.a->geometry.kind >= ShapeKind::compound && c.a->geometry.kind <= ShapeKind::mesh)
        memory.piece_a = manifold.piece_a;
    if (c.b->geometry.kind == ShapeKind::compound)
        memory.piece_b = manifold.piece_b;
    memory.normal = manifold.normal;
    for (std::uint32_t k = 0; k < manifold.count; ++k) {
        const collide::ManifoldPoint& p = manifold.points[k];
        memory.points[k].position = p.position;
        memory.points[k].feature = p.feature;
        memory.points[k].separation = p.separation;
    }
    memory.made_position = c.pose.position;
    memory.made_rotation = c.rotation;
    memory.margin = c.margin;
    return memory;
}

/// Whether the contact goes through a one-way shape: it did when they met, or it comes from the wrong side now.
bool passes(const Couple& c, std::span<const ContactMemory> old, UnitVec3 normal) {
    for (const ContactMemory& m : old)
        if (m.count != 0) return (m.flags & dynamics::contact_passing) != 0;
    const auto wrong_side = [](const ShapeRow& shape, const Scratch::Shape& at, UnitVec3 out) {
        return shape.one_way != 0 && dot<Unit>(to_rotation(at.pose.rotation).y, out) < half(unit_one);
    };
    return wrong_side(*c.a, *c.at_a, normal) || wrong_side(*c.b, *c.at_b, -normal);
}

Real mixed(Mix rule_a, Mix rule_b, Real a, Real b) {
    switch (std::max(rule_a, rule_b)) {
    case Mix::geometric_mean:
        return a == b ? a : sqrt(a * b);
    case Mix::average:
        return half(a + b);
    case Mix::minimum:
        return min(a, b);
    case Mix::multiply:
        return a * b;
    case Mix::maximum:
        break;
    }
    return max(a, b);
}

/// What the surfaces of b and a do against each other besides the bodies' motion, world axes.
SpeedVec3 surface_velocity(const Couple& c, const Touch& a, const Touch& b) {
    const auto of = [](const Touch& touch, const Scratch::Shape& at) {
        return touch.velocity == Vec3{} ? Vec3{} : rotate(at.pose.rotation, touch.velocity);
    };
    return to<Speed>(of(b, *c.at_b) - of(a, *c.at_a));
}

/// Closing speed of the two bodies at a point, along the normal.
Speed approach_speed(const Data& w, const Couple& c, UnitVec3 normal, const dynamics::ContactPoint& p) {
    const std::span<const Velocity> v = w.state.rows(w.m.body_velocity);
    const SpeedVec3 at_a = v[c.body_a].linear + cross<Speed>(v[c.body_a].angular, p.lever_a);
    const SpeedVec3 at_b = v[c.body_b].linear + cross<Speed>(v[c.body_b].angular, p.lever_b);
    return -dot<Speed>(at_b - at_a, normal);
}

bool has_corners(const ShapeRow& shape) {
    const ShapeKind kind = shape.geometry.kind;
    return (kind == ShapeKind::box || kind == ShapeKind::hull) && shape.geometry.radius == Length{};
}

/// Moves levers to the middle of the tick: a point between corners and faces goes with them, and levers of the start of
/// the tick would let what falls over gain its speed half a tick late. Round shapes roll over their points instead. On a
/// ground (A) the corners are B's; between two bodies the point goes as the mean of both.
void advance_levers(const Data& w, const Couple& c, dynamics::ContactPoint& p) {
    const bool on_ground = c.a->geometry.kind > ShapeKind::compound;
    if (!has_corners(*c.b) || !(on_ground || has_corners(*c.a))) return;
    const std::span<const Velocity> v = w.state.rows(w.m.body_velocity);
    const Velocity &a = v[c.body_a], &b = v[c.body_b];
    const SpeedVec3 at_b = b.linear + cross<Speed>(b.angular, p.lever_b);
    const SpeedVec3 at_a = a.linear + cross<Speed>(a.angular, p.lever_a);
    const SpeedVec3 goes = on_ground ? at_b : lockstone::scale<Speed>(at_a + at_b, half(unit_one));
    const Unit half_tick =
        Unit::from_raw(unit_one.raw / (2 * static_cast<std::int32_t>(w.state.rows(w.m.config)[0].tick_rate)));
    const LengthVec3 by_a = lockstone::scale<Length>(goes - a.linear, half_tick),
                     by_b = lockstone::scale<Length>(goes - b.linear, half_tick);
    // Less than an eighth of the lever: beyond, a chord is no arc any more.
    const auto most = [](LengthVec3 x) { return max(abs(x.x), max(abs(x.y), abs(x.z))).raw; };
    const auto small = [&](LengthVec3 by, LengthVec3 lever) { return most(by) <= most(lever) / 8; };
    if (!small(by_b, p.lever_b) || (!on_ground && !small(by_a, p.lever_a))) return;
    p.lever_a = p.lever_a + by_a;
    p.lever_b = p.lever_b + by_b;
}

/// One manifold as the solver wants it, with the separations of this tick; tells `seen` of its deepest point.
void add_contact(const Data& w, const Couple& c, std::uint32_t row, const ContactMemory& memory,
                 const dynamics::Shift& shift, Separation& deepest, Scratch::Seen& seen,
                 std::vector<dynamics::Contact>& contacts) {
    const std::span<const Transform> poses = w.state.rows(w.m.body_pose);
    const Rotation axes = to_rotation(c.at_a->pose.rotation);
    const LengthVec3 from_a = to<Length>(c.at_b->pose.position - poses[c.body_a].position);
    const LengthVec3 from_b = to<Length>(c.at_b->pose.position - poses[c.body_b].position);
    dynamics::Contact contact{};
    // What rests is the solver's still body.
    contact.body_a = std::min(c.body_a, w.header().bodies_awake);
    contact.body_b = std::min(c.body_b, w.header().bodies_awake);
    contact.memory = row;
    contact.count = memory.count;
    contact.normal = lockstone::mul<Unit>(axes, memory.normal);
    for (std::uint32_t k = 0; k < memory.count; ++k) {
        const LengthVec3 arm = lockstone::mul<Length>(axes, memory.points[k].position);
        const Separation separation = dynamics::separation_after(memory, k, shift);
        contact.points[k] = {arm + from_a, arm + from_b, separation};
        advance_levers(w, c, contact.points[k]);
        if (separation >= deepest) continue;
        deepest = separation;
        seen.deepest_row = row - seen.first_row;
        seen.point = c.at_b->pose.position + to<Real>(arm);
        seen.normal = c.flipped ? -contact.normal : contact.normal;
        seen.approach = approach_speed(w, c, contact.normal, contact.points[k]);
    }
    if (c.sensor || (memory.flags & dynamics::contact_passing) != 0) return;
    if (is_movers_contact(w, c.a->body, c.b->body, contact.normal)) return;
    const Touch a = touch_of(*c.a, c.at_a->solid, memory.piece_a),
                b = touch_of(*c.b, c.at_b->solid, memory.piece_b);
    contact.friction = to<Jacobian>(mixed(c.a->friction_mix, c.b->friction_mix, a.friction, b.friction));
    contact.restitution =
        to<Unit>(mixed(c.a->restitution_mix, c.b->restitution_mix, a.restitution, b.restitution));
    contact.rolling = to<Unit>(max(a.rolling, b.rolling));
    contact.surface_velocity = surface_velocity(c, a, b);
    contacts.push_back(contact);
}

/// The rows of one pair, into the worker's: those of the last tick while the shapes stand to each other as they did, else
/// new ones. At least one row, which may have no points. Returns how many.
std::uint32_t manifolds_of(const Couple& c, std::span<const ContactMemory> old, dynamics::Shift& shift,
                           Scratch::NarrowWorker& worker) {
    std::array<ContactMemory, collide::Manifolds::max>& rows = worker.rows;
    if (!old.empty() && ((old[0].flags & dynamics::contact_flipped) != 0) == c.flipped &&
        dynamics::still_good(old[0], c.pose.position, c.rotation, c.at_b->reach, c.margin, shift)) {
        std::ranges::copy(old, rows.begin());
        return static_cast<std::uint32_t>(old.size());
    }
    shift = {};
    std::uint32_t flags = (c.flipped ? dynamics::contact_flipped : 0u);
    if (c.sensor) flags |= dynamics::contact_sensor;
    if ((c.flipped ? c.a : c.b)->sensor != 0) flags |= dynamics::contact_sensor_is_b;
    collide::collide(c.at_a->solid, c.at_b->solid, c.pose, c.margin, worker.narrow, worker.manifolds);
    if (worker.manifolds.count == 0) {
        rows[0] = memory_of(c, {}, flags);
        return 1;
    }
    const Rotation axes = to_rotation(c.at_a->pose.rotation);
    if ((c.a->one_way | c.b->one_way) != 0 &&
        passes(c, old, lockstone::mul<Unit>(axes, worker.manifolds.items[0].normal)))
        flags |= dynamics::contact_passing;
    dynamics::Taken taken;
    for (std::uint32_t i = 0; i < worker.manifolds.count; ++i) {
        rows[i] = memory_of(c, worker.manifolds.items[i], flags);
        dynamics::carry_impulses(old, taken, rows[i]);
    }
    return worker.manifolds.count;
}

constexpr std::uint32_t pairs_per_chunk = 16;

using NearChunk = Scratch::NearChunk;

std::span<const ContactMemory> old_rows(const Scratch& s, const Scratch::Near& near) {
    return std::span(s.old_memories).subspan(near.old_first, near.old_count);
}

/// The rows and contacts of one pair, at the end of the chunk's. Writes to the chunk and the worker alone.
void collide_pair(const Data& w, const Scratch::Near& near, Scratch::NarrowWorker& worker, NearChunk& chunk) {
    const Couple c = couple_of(w, near.key);
    const std::span<const ContactMemory> old = old_rows(w.scratch, near);
    dynamics::Shift shift{};
    const std::uint32_t count = manifolds_of(c, old, shift, worker);
    Scratch::Seen seen{};
    seen.first_row = static_cast<std::uint32_t>(chunk.keys.size());
    seen.row_count = count;
    seen.was_touching = !old.empty() && (old[0].flags & dynamics::contact_touching) != 0;
    Separation deepest = Separation::max();
    for (std::uint32_t i = 0; i < count; ++i) {
        const ContactMemory& row = worker.rows[i];
        if (row.count != 0) add_contact(w, c, seen.first_row + i, row, shift, deepest, seen, chunk.contacts);
        chunk.keys.push_back(near.key);
        chunk.memories.push_back(row);
    }
    seen.overlaps = deepest <= (c.sensor ? Separation{} : touching_gap) &&
                    (worker.rows[0].flags & dynamics::contact_passing) == 0;
    chunk.seen.push_back(seen);
}

/// Takes those pairs out of a chunk whose rows do not fit into `room`. Returns how many rows that were.
std::uint32_t drop_pairs(Scratch& s, std::span<const Scratch::Near> pairs, NearChunk& chunk,
                         std::size_t room) {
    std::uint32_t dropped = 0, rows = 0, contacts = 0, kept = 0;
    std::size_t contact = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        Scratch::Seen seen = chunk.seen[i];
        const std::uint32_t end = seen.first_row + seen.row_count;
        const bool fits = seen.row_count <= room - rows;
        if (!fits && seen.was_touching) s.ended.push_back({pairs[i].key, old_rows(s, pairs[i])[0].flags});
        for (; contact < chunk.contacts.size() && chunk.contacts[contact].memory < end; ++contact) {
            if (!fits) continue;
            dynamics::Contact& moved = chunk.contacts[contacts++] = chunk.contacts[contact];
            moved.memory = moved.memory - seen.first_row + rows;
        }
        if (!fits) {
            dropped += seen.row_count;
            continue;
        }
        for (std::uint32_t from = seen.first_row; from < end; ++from) {
            chunk.keys[rows + (from - seen.first_row)] = chunk.keys[from];
            chunk.memories[rows + (from - seen.first_row)] = chunk.memories[from];
        }
        seen.first_row = rows;
        rows += seen.row_count;
        chunk.seen[kept++] = seen;
    }
    chunk.keys.resize(rows), chunk.memories.resize(rows);
    chunk.contacts.resize(contacts), chunk.seen.resize(kept);
    return dropped;
}

/// Where each chunk goes, in pair order. What the table has no room for is dropped.
void place_chunks(Data& w, std::span<NearChunk> chunks) {
    Scratch& s = w.scratch;
    const std::uint32_t room = w.state.capacity(w.m.contacts) - w.state.count(w.m.sleeping_contacts);
    std::uint32_t rows = 0, seen = 0, contacts = 0, dropped = 0;
    for (std::size_t i = 0; i < chunks.size(); ++i) {
        NearChunk& chunk = chunks[i];
        if (chunk.keys.size() > room - rows)
            dropped += drop_pairs(s, std::span(s.near).subspan(i * pairs_per_chunk, chunk.seen.size()), chunk,
                                  room - rows);
        chunk.first_row = rows, chunk.first_seen = seen, chunk.first_contact = contacts;
        rows += static_cast<std::uint32_t>(chunk.keys.size());
        seen += static_cast<std::uint32_t>(chunk.seen.size());
        contacts += static_cast<std::uint32_t>(chunk.contacts.size());
    }
    w.state.resize(w.m.contacts, rows);
    s.seen.resize(seen);
    s.contacts.resize(contacts);
    if (dropped != 0) w.state.edit_row(w.m.faults, 0).contacts_dropped += dropped;
}

void copy_chunk(const NearChunk& chunk, std::span<ContactKey> keys, std::span<ContactMemory> memories,
                Scratch& s) {
    std::ranges::copy(chunk.keys, keys.begin() + chunk.first_row);
    std::ranges::copy(chunk.memories, memories.begin() + chunk.first_row);
    for (std::size_t i = 0; i < chunk.seen.size(); ++i) {
        Scratch::Seen& seen = s.seen[chunk.first_seen + i] = chunk.seen[i];
        seen.first_row += chunk.first_row;
    }
    for (std::size_t i = 0; i < chunk.contacts.size(); ++i) {
        dynamics::Contact& contact = s.contacts[chunk.first_contact + i] = chunk.contacts[i];
        contact.memory += chunk.first_row;
    }
}

} // namespace

bool has_contact_points(Data& w, const ContactKey& key) {
    const Couple c = couple_of(w, key);
    collide::collide(c.at_a->solid, c.at_b->solid, c.pose, c.margin, w.scratch.narrow, w.scratch.manifolds);
    return w.scratch.manifolds.count != 0;
}

void collide(Data& w) {
    Scratch& s = w.scratch;
    const std::uint32_t pairs = static_cast<std::uint32_t>(s.near.size());
    const std::uint32_t chunk_count = (pairs + pairs_per_chunk - 1) / pairs_per_chunk;
    while (s.near_chunks.size() < chunk_count) {
        NearChunk& chunk = s.near_chunks.emplace_back();
        chunk.keys.reserve(2 * pairs_per_chunk), chunk.memories.reserve(2 * pairs_per_chunk);
        chunk.contacts.reserve(2 * pairs_per_chunk), chunk.seen.reserve(pairs_per_chunk);
    }
    if (s.narrow_workers.size() < base::worker_count(w.tasks))
        s.narrow_workers.resize(base::worker_count(w.tasks));
    const Data& seen = w;
    base::for_chunks(
        w.tasks, pairs, pairs_per_chunk, [&](std::uint32_t first, std::uint32_t last, std::uint32_t worker) {
            NearChunk& chunk = s.near_chunks[first / pairs_per_chunk];
            chunk.keys.clear(), chunk.memories.clear(), chunk.seen.clear(), chunk.contacts.clear();
            for (std::uint32_t i = first; i < last; ++i)
                collide_pair(seen, seen.scratch.near[i], s.narrow_workers[worker], chunk);
        });
    const std::span<NearChunk> chunks = std::span(s.near_chunks).first(chunk_count);
    place_chunks(w, chunks);
    const std::span<ContactKey> keys = w.state.edit(w.m.contact_key);
    const std::span<ContactMemory> memories = w.state.edit(w.m.contact_memory);
    base::for_chunks(w.tasks, chunk_count, 8, [&](std::uint32_t first, std::uint32_t last, std::uint32_t) {
        for (std::uint32_t i = first; i < last; ++i) copy_chunk(chunks[i], keys, memories, s);
    });
}

} // namespace lockstone::sim
