// Restitution and rolling resistance: contacts that have them are few, so they are solved one by one.
#pragma once

#include "solve/contacts/prepare.h"

namespace lockstone::solve {

/// Points that are not hit yet come in at this speed. Measured in every substep: a ball that returned with the speed it had
/// when the tick began would lose what it gained in the rest of it, a twentieth of its height a bounce.
template <unsigned N>
void measure_approach(std::span<Bounce> bounces, std::span<const ContactPack<N>> packs,
                      const solve::SolverBodies& bodies);
/// Points that came in fast and were hit go back at restitution times that speed, but with no more energy than they took:
/// what another contact stopped is that one's to give back. source: Stronge, Impact Mechanics (2000)
template <unsigned N>
void give_back(std::span<Bounce> bounces, std::span<ContactPack<N>> packs, std::int32_t speed_min,
               solve::SolverBodies& bodies);
/// One pass over rolling resistance, within what the normal impulses allow now; or, for a warm start, what was remembered.
template <unsigned N>
void solve_rolling(std::span<Rolling> rolling, std::span<const ContactPack<N>> packs,
                   solve::SolverBodies& bodies, bool warm_start);

} // namespace lockstone::solve
