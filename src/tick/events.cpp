// What a tick reports: which pairs began or ceased to touch, and the points where they do.
#include "tick/phases.h"

#include "base/room.h"
#include "model/surface.h"

#include <algorithm>
#include <tuple>

namespace lockstone::sim {

namespace {

/// Bodies of destroyed shapes are null.
Event event_of(const Data& w, const ContactKey& key, std::uint32_t flags, bool begin) {
    const bool sensor = (flags & solve::contact_sensor) != 0;
    const bool swap = (flags & solve::contact_sensor_is_b) != 0;
    const auto body = [&](ShapeId id) {
        const std::uint32_t row = w.row_of(id);
        return row == Data::dead ? BodyId{} : w.state.rows(w.m.shape)[row].body;
    };
    Event e{};
    e.kind = sensor ? (begin ? EventKind::sensor_begin : EventKind::sensor_end)
                    : (begin ? EventKind::contact_begin : EventKind::contact_end);
    e.shape_a = swap ? key.b : key.a;
    e.shape_b = swap ? key.a : key.b;
    e.body_a = body(e.shape_a);
    e.body_b = body(e.shape_b);
    e.tick = w.header().tick;
    return e;
}

bool was_hit(std::span<const ContactMemory> rows) {
    for (const ContactMemory& memory : rows) {
        if ((memory.flags & solve::contact_hit) != 0) return true;
        for (std::uint32_t k = 0; k < memory.count; ++k)
            if (memory.points[k].normal.raw > 0) return true;
    }
    return false;
}

/// Where the key's a and b touch.
struct Parts {
    SurfacePart a, b;
};
Parts parts_of(const Data& w, const ContactKey& key, const ContactMemory& memory) {
    const bool flipped = (memory.flags & solve::contact_flipped) != 0;
    return {part_of(w, key.a, flipped ? memory.piece_b : memory.piece_a),
            part_of(w, key.b, flipped ? memory.piece_a : memory.piece_b)};
}

/// Of bodies that slept when the last tick ended.
void publish_waking(Data& w) {
    for (std::uint32_t row = 0; row < w.header().bodies_awake; ++row) {
        if (w.state.rows(w.m.body_sleep)[row].island == 0) continue;
        w.state.edit_row(w.m.body_sleep, row).island = 0;
        Event e{};
        e.kind = EventKind::body_wake;
        e.body_a = w.state.rows(w.m.body_info)[row].id;
        e.tick = w.header().tick;
        w.events.push_back(e);
    }
}

void publish_drop(Data& w) {
    if (w.scratch.contacts_dropped == 0) return;
    Event e{};
    e.kind = EventKind::contacts_dropped;
    e.tick = w.header().tick;
    w.events.push_back(e);
}

} // namespace

void find_contact_points(Data& w) {
    if (!w.contact_points_wait) return;
    w.contact_points_wait = false;
    const Scratch& s = w.scratch;
    const std::span<const ContactKey> keys = s.table.list.keys;
    const std::span<const ContactMemory> memories = s.table.list.memories;
    std::size_t count = 0;
    for (const solve::Contact& c : s.contacts) count += c.count;
    base::make_room(w.contact_points, count);
    for (const solve::Contact& c : s.contacts) {
        const bool flipped = (memories[c.memory].flags & solve::contact_flipped) != 0;
        const ShapeId shape = flipped ? keys[c.memory].a : keys[c.memory].b;
        const std::uint32_t body_b = w.row_of(w.state.rows(w.m.shape)[w.row_of(shape)].body);
        const Parts parts = parts_of(w, keys[c.memory], memories[c.memory]);
        for (std::uint32_t k = 0; k < c.count; ++k)
            w.contact_points.push_back({keys[c.memory].a, keys[c.memory].b,
                                        pose_before(w, body_b).position + to<Real>(c.points[k].lever_b),
                                        flipped ? -c.normal : c.normal, c.points[k].separation,
                                        memories[c.memory].points[k].normal, parts.a, parts.b});
    }
}

void publish_events(Data& w) {
    Scratch& s = w.scratch;
    const std::span<ContactMemory> memories = s.table.list.memories;
    w.events.reserve(64); // what a usual tick has, so that one with more than ever seldom allocates
    for (const Scratch::Ended& ended : s.ended)
        w.events.push_back(event_of(w, ended.key, ended.flags, false));
    for (const Scratch::ContactResult& result : s.results) {
        const std::span<ContactMemory> rows = memories.subspan(result.first_row, result.row_count);
        const bool sensor = (result.flags & solve::contact_sensor) != 0;
        const bool now = result.overlaps || (!sensor && was_hit(rows));
        for (ContactMemory& row : rows)
            row.flags &= ~std::uint32_t{solve::contact_touching | solve::contact_hit};
        if (now) rows[0].flags |= solve::contact_touching;
        if (now == result.was_touching) continue;
        const ContactKey& key = s.near[result.near].key;
        Event e = event_of(w, key, result.flags, now);
        if (now) {
            e.point = result.point;
            if (!sensor) e.normal = result.normal;
            e.approach_speed = result.approach;
            Parts parts = parts_of(w, key, rows[result.deepest_row]);
            if (e.shape_a != key.a) std::swap(parts.a, parts.b);
            e.part_a = parts.a, e.part_b = parts.b;
        }
        w.events.push_back(e);
    }
    publish_drop(w);
    publish_waking(w);
    const std::vector<Event>& landings = s.characters.landings;
    w.events.insert(w.events.end(), landings.begin(), landings.end());
    w.contact_points_wait = true;
}

void order_events(Data& w) {
    std::sort(w.events.begin(), w.events.end(), [](const Event& x, const Event& y) {
        return std::tie(x.kind, x.shape_a, x.shape_b, x.joint, x.body_a) <
               std::tie(y.kind, y.shape_a, y.shape_b, y.joint, y.body_a);
    });
}

} // namespace lockstone::sim
