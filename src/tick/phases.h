// The phases of a tick that need shapes: see tick.cpp for their order.
#pragma once

#include "world/data.h"

#include <algorithm>

namespace lockstone::sim {

/// Where a body was when the tick began.
inline const Transform& pose_before(const Data& w, std::uint32_t row) {
    return row < w.scratch.pose_before.size() ? w.scratch.pose_before[row] : w.state.rows(w.m.body_pose)[row];
}

/// Pairs in one of Scratch::near_chunks: all of them where one worker does the work, so nothing has to be put together.
inline std::uint32_t pairs_per_chunk(const Data& w) {
    return w.tasks != nullptr ? 16 : std::max(static_cast<std::uint32_t>(w.scratch.near.size()), 1u);
}
inline constexpr Length margin_base =
    decimal<Length>("0.005"); ///< [m]: contacts are made this far ahead of touching

/// How far ahead contacts of something with a velocity reach, or of two with a relative one: not less than it goes in a
/// tick, in steps by a factor of two, so that it seldom grows while they near each other; nothing for what goes less
/// than half of `margin_base`.
Length ahead_of(SpeedVec3 velocity, std::uint32_t tick_rate);

void update_bounds(Data& w); ///< world poses, margins and bounds of shapes that may have moved   (bounds.cpp)
/// Islands that something awake touches; true when there were any, and bounds and pairs have to be found again.
bool wake_touched(Data& w); //                                                                    (sleep.cpp)
bool has_contact_points(Data& w,
                        const Scratch::Near& near); //                                  (contacts.cpp)
void find_pairs(Data& w); ///< shapes that may meet and are near, in pair order                (pairs.cpp)
void collide(Data& w); ///< manifolds, with what they keep of the last tick                    (contacts.cpp)
void place_contacts(
    Data& w); ///< what the chunks of `collide` made becomes the contact table (contact_table.cpp)
void list_joints(
    Data& w); ///< in slot order, as the solver takes them                            (joints.cpp)
void list_fields(
    Data& w); ///< those of acceleration, and whose shapes they look at               (fields.cpp)
void break_joints(Data& w); ///< of joints that bore too much                                    (joints.cpp)
void settle(Data& w); ///< islands that rest fall asleep                                         (sleep.cpp)
void publish_events(
    Data& w); ///< touching flags; what began, ended, woke or landed                 (events.cpp)
/// The contact points of the last tick, which are made when somebody asks for them, or before a row, pose or material that they are
/// made of changes. Nothing where they are made. (events.cpp)
void find_contact_points(Data& w);
void order_events(Data& w); ///< the last of all, since what falls asleep is known last         (events.cpp)

} // namespace lockstone::sim
