// The worst-first resolver: listings 7, 8 and 9 of the thesis.
#pragma once

#include "reference/engine/collision.h"

#include <vector>

namespace reference::LOCKSTONE_REFERENCE_BUILD {

/// Resolves all contacts: positions, then velocities, each with the worst first; of equal ones the first in the list.
/// Appends each iteration to `log`.
void resolve(std::span<Collision> collisions, const Resolver& settings, Number duration,
             std::vector<Resolved>& log);

} // namespace reference::LOCKSTONE_REFERENCE_BUILD
