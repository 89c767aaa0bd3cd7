// Thin plates that fall and hit a floor flat.
#include "support/effort.h"
#include "support/rigs/slapped_plate.h"

#include <doctest/doctest.h>

#include <algorithm>

using namespace lockstone::test;

TEST_CASE("a plate that slaps onto a floor does not sink in") {
    for (const double thickness : {0.005, 0.01, 0.02})
        for (const double tilt : {0.0, 0.02, 0.1, 0.5})
            for (const int floor : {0, 1, 2}) {
                const Plate plate{1, 0.5, thickness, tilt, 0, 1.2, 0, 0, floor};
                CAPTURE(thickness);
                CAPTURE(tilt);
                CAPTURE(floor);
                CHECK(slap_depth(plate, 30) <= 0.025);
                CHECK(slap_depth(plate, 60) <= 0.01);
                CHECK(slap_depth(plate, 120) <= 0.01);
            }
}

TEST_CASE("few random plates that slap onto a floor sink in") {
    const int count = is_long_run() ? 20'000 : tries(200);
    const Slaps slaps = slap_many(count);
    CAPTURE(slaps.deep);
    CAPTURE(slaps.deepest);
    CHECK(slaps.deep <= std::max(count * 3 / 20, 1));
    CHECK(slaps.deepest <= 0.1);
}
