// Bodies fall asleep in their final places: no island sleeps while a position correction moves one of its bodies, or
// while one oscillates.
#include "support/effort.h"
#include "support/rigs/corrected.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

TEST_CASE("a body that its joint pulls from far off sleeps within 1 mm and 0.1 degrees of its place") {
    for (int seed = 1; seed <= tries(60); ++seed)
        CHECK(pulled_body_fault(static_cast<std::uint64_t>(seed)) == "");
}

TEST_CASE("a body that begins inside another one sleeps outside of it") {
    for (int seed = 1; seed <= tries(60); ++seed)
        CHECK(buried_body_fault(static_cast<std::uint64_t>(seed)) == "");
}

TEST_CASE("the solver pushes overlap out at push_speed_max and at a tenth of it if a joint holds the body") {
    for (int seed = 1; seed <= tries(60); ++seed) CHECK(push_fault(static_cast<std::uint64_t>(seed)) == "");
}

TEST_CASE("a raft sleeps within 2 mm of its waterline") {
    for (int seed = 1; seed <= tries(40); ++seed) CHECK(raft_fault(static_cast<std::uint64_t>(seed)) == "");
}
