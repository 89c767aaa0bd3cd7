// Thin plates that fall and hit a floor flat.
#include "support/effort.h"
#include "support/rigs/slapped_plate.h"

#include <doctest/doctest.h>

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
    // 12 of 100 plates sink in, out of 2,000. The share of a small sample varies: one and a half times as many, and three more.
    CHECK(slaps.deep <= 3 + count * 18 / 100);
    CHECK(slaps.deepest <= 0.1);
}
