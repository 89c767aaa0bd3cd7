// The phases of a tick that need shapes: see tick.cpp for their order.
#pragma once

#include "sim/data.h"

namespace lockstone::sim {

inline constexpr Length margin_base =
    decimal<Length>("0.01"); ///< [m]: contacts are made this far ahead of touching

void update_bounds(Data& w); ///< world poses, margins and bounds of shapes that may have moved   (bounds.cpp)
void find_pairs(Data& w);    ///< shapes that may meet and are near, in pair order                (pairs.cpp)
void collide(Data& w); ///< manifolds, with what they keep of the last tick: the contact table (contacts.cpp)
void publish_events(
    Data& w); ///< touching flags; events in their total order; contact points      (events.cpp)

} // namespace lockstone::sim
