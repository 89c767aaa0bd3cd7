// Events and contact points that a tick reports.
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
    /// The pose of any body: a body that rests has not moved.
    const Transform& of(const Model& w, std::uint32_t row) const {
        return row < list.size() ? list[row] : w.state.rows(w.m.body_pose)[row];
    }
};

/// Contact points of the last tick, computed at the first read.
struct ContactPoints {
    std::vector<ContactPoint> list;
    std::vector<std::array<BodyId, 2>> bodies; ///< by point: the bodies of its two shapes
    /// Pairs of a body's slot and the index of one of its points, sorted. Empty until the first call of points_of()
    /// after a tick.
    std::vector<std::pair<std::uint32_t, std::uint32_t>> of_body;
    bool wait = false; ///< the points are not computed yet

    void clear() { list.clear(), bodies.clear(), of_body.clear(), wait = false; }
    void reserve(std::size_t points) { list.reserve(points), bodies.reserve(points); }
};
/// Appends the points of a body's shapes to `out`, in the order of the list.
void points_of(ContactPoints& points, BodyId body, std::vector<ContactPoint>& out);
/// Computes the points if `wait` is set: when they are first read, or before a row, pose or material on which they
/// depend changes.
void find_contact_points(const Model& w, const PlacedShapes& placed, const PosesBefore& before,
                         const ContactList& table, const FoundContacts& found, ContactPoints& out);

/// Appends the events for pairs that began or ceased to touch, dropped contacts, bodies that woke and characters that
/// landed.
void publish_events(Model& w, const PlacedShapes& placed, const NearPairs& near, const FoundContacts& found,
                    std::span<const Event> landings, const ContactList& table, std::vector<Event>& events);
/// Sorts the tick's events. Called after the events of bodies that fall asleep are added.
void order_events(std::vector<Event>& events);

} // namespace lockstone::sim
