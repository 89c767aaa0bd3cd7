// What a tick reports.
#pragma once

#include "lockstone/event.h"
#include "tick/contacts.h"

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace lockstone::sim {

/// Poses of the awake bodies when the tick began, by row.
struct PosesBefore {
    std::vector<Transform> list;
    /// Of any body: what rests is where it was.
    const Transform& of(const Model& w, std::uint32_t row) const {
        return row < list.size() ? list[row] : w.state.rows(w.m.body_pose)[row];
    }
};

/// Contact points of the last tick. The first call that reads them makes them.
struct ContactPoints {
    std::vector<ContactPoint> list;
    std::vector<std::array<BodyId, 2>> bodies; ///< by point: those of its two shapes
    /// A body's slot and a point of it, sorted. points_of() makes it when it is first called after a tick; empty before.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> of_body;
    bool wait = false; ///< they are not made yet

    void clear() { list.clear(), bodies.clear(), of_body.clear(), wait = false; }
    void reserve(std::size_t points) { list.reserve(points), bodies.reserve(points); }
};
/// Appends the points of a body's shapes to `out`, in the order of the list.
void points_of(ContactPoints& points, BodyId body, std::vector<ContactPoint>& out);
/// Makes them, if they wait: before a row, pose or material that they are made of changes, or when asked for.
void find_contact_points(const Model& w, const PlacedShapes& placed, const PosesBefore& before,
                         const ContactList& table, const FoundContacts& found, ContactPoints& out);

/// What began or ceased to touch, woke or landed.
void publish_events(Model& w, const PlacedShapes& placed, const NearPairs& near, const FoundContacts& found,
                    std::span<const Event> landings, const ContactList& table, std::vector<Event>& events);
/// Sorts the tick's events, once it is known who falls asleep.
void order_events(std::vector<Event>& events);

} // namespace lockstone::sim
