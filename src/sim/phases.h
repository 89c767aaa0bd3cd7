// The phases of a tick that need shapes: see tick.cpp for their order.
#pragma once

#include "sim/data.h"

namespace lockstone::sim {

void update_bounds(Data& w);  ///< world poses, margins and bounds of shapes that may have moved
void find_pairs(Data& w);     ///< the contact table of this tick, memories carried over, in pair order
void collide(Data& w);        ///< manifolds, in world axes
void publish_events(Data& w); ///< touching flags; events in their total order; contact points for drawing

} // namespace lockstone::sim
