// Events of a tick: pairs that began or ceased to touch. Also the contact points of the pairs that touch.
#include "tick/events.h"

#include "base/room.h"
#include "scene/surface.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

namespace lockstone::sim {

namespace {

/// The bodies of destroyed shapes are null.
Event event_of(const Model& w, const ContactKey& key, std::uint32_t flags, bool begin) {
    const bool sensor = (flags & solve::contact_sensor) != 0;
    const bool swap = (flags & solve::contact_sensor_is_b) != 0;
    const auto body = [&](ShapeId id) {
        const std::uint32_t row = w.row_of(id);
        return row == Model::dead ? BodyId{} : w.state.rows(w.m.shape)[row].body;
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

/// The parts of the key's shapes a and b that touch.
struct Parts {
    SurfacePart a, b;
};
Parts parts_of(const Model& w, const PlacedShapes& placed, const ContactKey& key,
               const ContactMemory& memory) {
    const bool flipped = (memory.flags & solve::contact_flipped) != 0;
    return {part_of(w, placed, key.a, flipped ? memory.piece_b : memory.piece_a),
            part_of(w, placed, key.b, flipped ? memory.piece_a : memory.piece_b)};
}

/// Appends an event if a pair began or ceased to touch.
void publish_change(const Model& w, const PlacedShapes& placed, const ContactResult& result,
                    const ContactList& table, std::vector<Event>& events) {
    if (result.is_touching == result.was_touching) return;
    Event e = event_of(w, result.key, result.flags, result.is_touching);
    if (result.is_touching) {
        e.point = result.point;
        if ((result.flags & solve::contact_sensor) == 0) e.normal = result.normal;
        e.approach_speed = result.approach;
        Parts parts = parts_of(w, placed, result.key, table.memories[result.first_row + result.deepest_row]);
        if (e.shape_a != result.key.a) std::swap(parts.a, parts.b);
        e.part_a = parts.a, e.part_b = parts.b;
    }
    events.push_back(e);
}

/// Appends an event for each body that woke: its sleep row still has an island.
void publish_waking(Model& w, std::vector<Event>& events) {
    const std::span<const BodySleep> sleep = w.state.rows(w.m.body_sleep).first(w.header().bodies_awake);
    for (std::uint32_t row = 0; row < sleep.size(); ++row) {
        if (sleep[row].island == 0) continue;
        w.state.edit_row(w.m.body_sleep, row).island = 0;
        Event e{};
        e.kind = EventKind::body_wake;
        e.body_a = w.state.rows(w.m.body_info)[row].id;
        e.tick = w.header().tick;
        events.push_back(e);
    }
}

void publish_drop(const Model& w, std::vector<Event>& events) {
    Event e{};
    e.kind = EventKind::contacts_dropped;
    e.tick = w.header().tick;
    events.push_back(e);
}

} // namespace

void find_contact_points(const Model& w, const PlacedShapes& placed, const PosesBefore& before,
                         const ContactList& table, const FoundContacts& found, ContactPoints& out) {
    if (!out.wait) return;
    out.wait = false;
    const std::span<const ContactKey> keys = table.keys;
    const std::span<const ContactMemory> memories = table.memories;
    std::size_t count = 0;
    for (const solve::Contact& c : found.contacts) count += c.count;
    base::make_room(out.list, count), base::make_room(out.bodies, count);
    auto impact = found.impacts.begin();
    for (const solve::Contact& c : found.contacts) {
        const auto index = static_cast<std::uint32_t>(&c - found.contacts.data());
        const bool is_hit = impact != found.impacts.end() && impact->contact == index;
        const bool flipped = (memories[c.memory].flags & solve::contact_flipped) != 0;
        const auto body_of = [&](ShapeId shape) { return w.state.rows(w.m.shape)[w.row_of(shape)].body; };
        const std::array<BodyId, 2> bodies{body_of(keys[c.memory].a), body_of(keys[c.memory].b)};
        const std::uint32_t body_b = w.row_of(bodies[flipped ? 0 : 1]);
        const Parts parts = parts_of(w, placed, keys[c.memory], memories[c.memory]);
        for (std::uint32_t k = 0; k < c.count; ++k) {
            const Speed impulse = memories[c.memory].points[k].normal;
            out.bodies.push_back(bodies);
            out.list.push_back({keys[c.memory].a, keys[c.memory].b,
                                before.of(w, body_b).position + to<Real>(c.points[k].lever_b),
                                flipped ? -c.normal : c.normal, c.points[k].separation,
                                is_hit ? impulse + impact->impulse[k] : impulse, parts.a, parts.b});
        }
        if (is_hit) ++impact;
    }
}

void points_of(ContactPoints& points, BodyId body, std::vector<ContactPoint>& out) {
    if (points.of_body.empty()) {
        for (std::uint32_t i = 0; i < points.bodies.size(); ++i)
            for (const BodyId id : points.bodies[i]) points.of_body.emplace_back(id.index, i);
        std::sort(points.of_body.begin(), points.of_body.end());
    }
    const auto first = std::ranges::lower_bound(points.of_body, std::pair{body.index, 0u});
    for (auto at = first; at != points.of_body.end() && at->first == body.index; ++at)
        if (std::ranges::find(points.bodies[at->second], body) != points.bodies[at->second].end())
            out.push_back(points.list[at->second]);
}

void publish_events(Model& w, const PlacedShapes& placed, const NearPairs& near, const FoundContacts& found,
                    std::span<const Event> landings, const ContactList& table, std::vector<Event>& events) {
    events.reserve(64); // a usual number, so that a tick with more events than ever before seldom allocates
    for (const ContactResult& result : near.ended) publish_change(w, placed, result, table, events);
    for (const ContactResult& result : found.results) publish_change(w, placed, result, table, events);
    if (found.dropped != 0) publish_drop(w, events);
    publish_waking(w, events);
    events.insert(events.end(), landings.begin(), landings.end());
}

void order_events(std::vector<Event>& events) { std::sort(events.begin(), events.end(), precedes); }

} // namespace lockstone::sim
