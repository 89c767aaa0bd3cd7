// The worst-first resolver: listings 7, 8 and 9 of the thesis.
#pragma once

#include "reference/engine/collision.h"

#include <vector>

namespace reference::LOCKSTONE_REFERENCE_BUILD {

/// Resolves all that touches: positions, then velocities, each the worst first. Of equal ones the first in the list.
/// `log` gets what was done, in order.
void resolve(std::span<Collision> collisions, const Resolver& settings, Number duration,
             std::vector<Resolved>& log);

} // namespace reference::LOCKSTONE_REFERENCE_BUILD
