// Heavy bodies on light ones rest where they were placed, at every mass, and a light body without support takes no
// momentum.
#include "support/effort.h"
#include "support/rigs/heavy_load.h"
#include "support/rigs/plank.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

TEST_CASE("a load of up to 10000 times the mass rests on grounded bodies and never rises above its start") {
    const int count = is_long_run() ? 40'000 : tries(400);
    for (int seed = 1; seed <= count; ++seed) CHECK(heavy_load_fault(static_cast<std::uint64_t>(seed)) == "");
}

TEST_CASE("a heavy body that hits light bodies in free space keeps the total momentum") {
    for (int seed = 1; seed <= tries(400); ++seed)
        CHECK(free_row_fault(static_cast<std::uint64_t>(seed)) == "");
}

TEST_CASE("a plank under a car's wheels sinks into the ground by at most 5 mm") {
    for (int seed = 1; seed <= tries(40); ++seed) CHECK(plank_fault(static_cast<std::uint64_t>(seed)) == "");
}
