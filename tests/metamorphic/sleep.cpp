// Sleeping bodies change no motion of awake ones.
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <utility>
#include <vector>

using namespace lockstone;
using namespace lockstone::test::scene;

TEST_CASE("a hundred distant sleepers change no bit of awake bodies") {
    const auto run = [](int sleepers) {
        WorldDef def;
        def.contacts_max = 4096;
        World w = made(World::create(def));
        add_floor(w);
        std::vector<BodyId> awake;
        for (int i = 0; i < 12; ++i)
            awake.push_back(add_ball(w, at(0.3 * i, 40 + 1.2 * i, 0.1 * (i % 3)), 0.5, 0.3));
        for (int i = 0; i < sleepers; ++i) add_crate(w, at(50 + 2 * (i / 2), 0.5 + i % 2, 0));
        for (int t = 0; t < 300; ++t) w.tick();
        std::vector<Transform> poses;
        for (BodyId b : awake) poses.push_back(w.pose(b));
        return std::pair(poses, w.awake_count());
    };
    const auto alone = run(0), among = run(100);
    CHECK(alone.first == among.first);
    CHECK(alone.second == among.second);
}
