// What a tick reports.
#pragma once

#include "lockstone/event.h"
#include "tick/contacts.h"

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

/// Contact points of the last tick, which are made when somebody asks for them.
struct ContactPoints {
    std::vector<ContactPoint> list;
    bool wait = false; ///< they are not made yet

    void clear() { list.clear(), wait = false; }
};
/// Makes them, if they wait: before a row, pose or material that they are made of changes, or when asked for.
void find_contact_points(const Model& w, const PlacedShapes& placed, const PosesBefore& before,
                         const ContactList& table, const FoundContacts& found, ContactPoints& out);

/// What began or ceased to touch, woke or landed.
void publish_events(Model& w, const PlacedShapes& placed, const NearPairs& near, const FoundContacts& found,
                    std::span<const Event> landings, const ContactList& table, std::vector<Event>& events);
/// Sorts the tick's events, once it is known who falls asleep.
void order_events(std::vector<Event>& events);

} // namespace lockstone::sim
