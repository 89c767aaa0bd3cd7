// In steady state a frame allocates no memory: neither the session nor the runner nor the simulated network does.
#include "session/match.h"

#include "support/allocation_counter.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

std::uint64_t allocations_of_frames(bool lockstep) {
    Match match({.lockstep = lockstep,
                 .input_delay = 6,
                 .link = {.latency_ms = 60, .jitter_ms = 20, .loss_permille = 50, .duplicate_permille = 20},
                 .record = false});
    match.run(2000);
    // In a build for sanitizers a state moves whenever it may, and that allocates.
    for (PeerId peer = 0; peer < 2; ++peer)
        match.machine(peer).simulation->state().move_at_every_chance(false);
    const AllocationCounter counter;
    match.run(1000);
    CHECK(match.machine(0).session->current_tick() > 2500);
    return counter.count();
}

} // namespace

TEST_CASE("a thousand frames of a lossy match allocate no memory") {
    CHECK(allocations_of_frames(/*lockstep=*/true) == 0);
    CHECK(allocations_of_frames(/*lockstep=*/false) == 0);
}
