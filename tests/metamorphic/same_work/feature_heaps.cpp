// Heaps whose bodies have features that the solver handles separately: rolling resistance, restitution, locked axes,
// moving surfaces. Neither the width of lanes nor the number of workers changes a bit. The sizes lie on both sides of
// those from which workers share bodies and packs.
#include "support/rigs/feature_pit.h"

#include <doctest/doctest.h>

using namespace lockstone::test::features;

TEST_CASE("heaps that roll and bounce and slide and have locked axes get the same bits with any lanes and "
          "workers") {
    std::uint64_t seed = 1;
    for (const std::uint32_t bodies : {40u, 150u, 400u, 900u})
        for (const unsigned features :
             {unsigned{rolls}, unsigned{bounces}, unsigned{locks}, rolls | bounces | locks | slides}) {
            INFO(bodies, " bodies, features ", features, ", seed ", seed);
            CHECK(first_difference(bodies, features, seed++, bodies < 300 ? 80 : 40) == "");
        }
}
