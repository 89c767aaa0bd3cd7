// Who is awake.
//
//   bodies     rows [0, bodies_awake): dynamic bodies that move, kinematic ones with a velocity, and static and kinematic
//              ones that a command touched since the last tick; behind them what rests, in no particular order
//   joints     rows [0, joints_awake): those of which a body is awake
//   contacts   "contacts": those of which a body is awake; "sleeping_contacts": the others
//
// A tick reads and writes the awake rows only. Islands are found anew in every tick, among what is awake: dynamic bodies
// that touch or are joined, so they split as soon as they part. An island falls asleep as a whole when all its bodies were
// still for the world's sleep_time and none of them is held by a kinematic body that moves; its bodies then stand in a ring.
// A body is still when it is slow, or rocks a little on the spot; a body that position correction moves is not. An island wakes as a
// whole: when a command touches one of its bodies, or something awake comes near enough to one to make contact points.
#pragma once

#include "model/model.h"

namespace lockstone::sim {

inline bool is_awake(const Model& w, std::uint32_t body_row) { return body_row < w.header().bodies_awake; }

/// For a command that touches a body: wakes its island; of a static or kinematic body, those that rest on it or are joined to it.
/// Returns the body's row, which may have changed.
std::uint32_t wake(Model& w, BodyId body);
void wake_all(Model& w);
/// Puts a dynamic body that was just made, and has no velocity, to sleep in an island of its own.
void start_asleep(Model& w, std::uint32_t body_row);
/// Whether a sleeping body has slept since it was made.
bool was_never_awake(const Model& w, std::uint32_t body_row);
/// The islands of resting bodies that something awake touches.
void wake_islands(Model& w, std::span<const BodyId> bodies);
/// Takes a row to the resting ones, as the first step of removing it. Returns the row it has then.
std::uint32_t put_to_rest(Model& w, std::uint32_t body_row);
std::uint32_t put_joint_to_rest(Model& w, std::uint32_t joint_row);
/// Wakes the joint that was made between two bodies that were just woken.
void wake_joint(Model& w, std::uint32_t joint_row);
/// Moves contacts of which no body is awake any more out of the table that a tick works on.
void rest_contacts(Model& w);

} // namespace lockstone::sim
