// Restitution and rolling resistance: contacts that have them are few, so they are solved one by one.
#pragma once

#include "solve/contacts/prepare.h"

namespace lockstone::solve {

/// After a warm start, which gave `warm` to each body: the work of the impulses that points carry. Where passes take back what it gave too much,
/// they take no energy of the impact.
template <unsigned N>
void note_warm_start(std::span<const ContactPack<N>> packs, Bounce* bounces, const WarmStart* warm,
                     const solve::SolverBodies& bodies);
/// Points that came in fast and were hit go back at restitution times that speed. What still comes in then, in a tick whose last substep left
/// a part to the next one, is stopped first. The points of a contact together give back at most restitution squared times the energy that they
/// took together: the part that another contact stopped is given back by that other contact. Impulses that are given so bring friction, within
/// the cone and against the sliding that is left. source: Stronge, Impact Mechanics (2000)
/// `lanes`: those of contacts that bounce, in the order of contacts: pack * N + lane.
template <unsigned N>
void give_back(std::span<const std::uint32_t> lanes, std::span<const Bounce> bounces,
               std::span<ContactPack<N>> packs, std::int32_t speed_min, solve::SolverBodies& bodies);
/// One pass over rolling resistance, bounded by the normal impulses as they are now. For a warm start: the impulses of the last tick.
template <unsigned N>
void solve_rolling(std::span<Rolling> rolling, std::span<const ContactPack<N>> packs,
                   solve::SolverBodies& bodies, bool warm_start);

} // namespace lockstone::solve
