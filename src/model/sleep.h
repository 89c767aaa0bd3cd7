// Defines which bodies, joints and contacts are awake.
//
//   bodies     rows [0, bodies_awake): dynamic bodies that are not asleep, kinematic bodies with a velocity, and
//              static and kinematic bodies that a command changed since the last tick; the resting bodies
//              follow, in no particular order
//   joints     rows [0, joints_awake): joints with at least one awake body
//   contacts   "contacts": contacts with at least one awake body; "sleeping_contacts": the others
//
// A tick reads and writes the awake rows only. Each tick computes the islands of the awake bodies again: dynamic
// bodies that touch or are joined. So an island splits as soon as its parts separate. An island falls asleep as a
// whole when all its bodies were still for the world's sleep_time and no moving kinematic body holds one of them; its
// bodies are then linked in a ring. A body is still when it is slow, or rocks a little on the spot; a body that
// position correction moves is not. An island wakes as a whole: when a command changes one of its bodies, or when an
// awake body comes near enough to one of them to make contact points.
#pragma once

#include "model/model.h"

namespace lockstone::sim {

inline bool is_awake(const Model& w, std::uint32_t body_row) { return body_row < w.header().bodies_awake; }

/// Called by commands that change a body. Wakes the body's island; for a static or kinematic body, wakes the bodies
/// that rest on it or are joined to it. Returns the body's row, which may have changed.
std::uint32_t wake(Model& w, BodyId body);
void wake_all(Model& w);
/// Puts a new dynamic body without velocity to sleep, in an island of its own.
void start_asleep(Model& w, std::uint32_t body_row);
/// Returns true if a body sleeps and has never been awake since its creation.
bool was_never_awake(const Model& w, std::uint32_t body_row);
/// Wakes the islands of resting bodies that an awake body touches.
void wake_islands(Model& w, std::span<const BodyId> bodies);
/// Moves a body's row to the resting rows, as the first step of its removal. Returns its new row.
std::uint32_t put_to_rest(Model& w, std::uint32_t body_row);
/// put_to_rest() for the rows of several bodies, in turn.
void put_to_rest(Model& w, std::span<const BodyId> bodies);
std::uint32_t put_joint_to_rest(Model& w, std::uint32_t joint_row);
/// Wakes a new joint between two bodies that were just woken.
void wake_joint(Model& w, std::uint32_t joint_row);
/// Moves contacts without an awake body out of the table on which ticks work.
void rest_contacts(Model& w);

} // namespace lockstone::sim
