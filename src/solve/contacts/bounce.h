// Restitution and rolling resistance. Few contacts have them, so these contacts are solved one by one.
#pragma once

#include "solve/contacts/prepare.h"

namespace lockstone::solve {

/// The effect of the elastic impacts of a substep on a body.
struct Struck {
    std::uint32_t round; ///< the last round of rebound() that changed the body, from 1 on; 0: none
    std::int64_t time;   ///< of its last impact: fraction of the substep, Unit
    /// Added to the velocity while the body moves: until the impact the body moves with its old velocity.
    std::int64_t v[3], u[3];
};

/// Solves the impacts of elastic contacts before the passes of a substep. A point that comes in faster than
/// PassSettings::bounce_speed_min and reaches the surface within the substep parts at restitution times the speed of
/// its impact. Rounds over the contacts follow until no point hits, at most 32: so the last of five balls in a row
/// leaves at the speed of the first, where passes would share the speed among all five. An impact is no load, so its
/// impulse is in no warm start; Bounce::impulse sums the impacts of a tick. Impacts cause friction, within the cone and
/// against the remaining sliding.
/// source: Stronge, Impact Mechanics (2000)
/// `bounces`: in the order of contacts. `arrival`: PassData::arrival. `struck`: by body, all zero.
template <unsigned N>
void rebound(std::span<Bounce> bounces, std::span<ContactPack<N>> packs, const PassSettings& settings,
             solve::SolverBodies& bodies, WarmStart* arrival, std::span<Struck> struck);
/// Adds Struck::v and u to the velocities of the bodies that were hit, before bodies move, and marks these bodies as
/// plain_struck.
void begin_ways(std::span<const Struck> struck, solve::SolverBodies& bodies);
/// Subtracts Struck::v and u again after the move.
void end_ways(std::span<const Struck> struck, solve::SolverBodies& bodies);
/// Lists the contacts whose points took an impulse in an elastic impact, in the order of contacts. `contact_of_lane`:
/// [pack * lanes + lane].
void list_impacts(std::span<const Bounce> bounces, std::span<const std::uint32_t> contact_of_lane,
                  std::uint32_t lanes, std::vector<solve::ContactImpact>& out);
/// One pass over rolling resistance, bounded by the present normal impulses. A warm start applies the impulses of the
/// last tick instead.
template <unsigned N>
void solve_rolling(std::span<Rolling> rolling, std::span<const ContactPack<N>> packs,
                   solve::SolverBodies& bodies, bool warm_start);

} // namespace lockstone::solve
