// Restitution and rolling resistance: contacts that have them are few, so they are solved one by one.
#pragma once

#include "solve/contacts/prepare.h"

namespace lockstone::solve {

/// Points that came in fast and were hit go back at restitution times that speed, but with no more energy than they took: the part that
/// another contact stopped is given back by that other contact. source: Stronge, Impact Mechanics (2000)
template <unsigned N>
void give_back(std::span<Bounce> bounces, std::span<ContactPack<N>> packs, std::int32_t speed_min,
               solve::SolverBodies& bodies);
/// One pass over rolling resistance, bounded by the normal impulses as they are now. For a warm start: the impulses of the last tick.
template <unsigned N>
void solve_rolling(std::span<Rolling> rolling, std::span<const ContactPack<N>> packs,
                   solve::SolverBodies& bodies, bool warm_start);

} // namespace lockstone::solve
