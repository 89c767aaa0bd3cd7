// The scenes of joining and of relays, run without a fault. The planted faults run the same scenes.
#include "session/join/join_scenes.h"
#include "session/join/relayed_scenes.h"
#include "support/effort.h"

#include <doctest/doctest.h>

using namespace lockstone::test;

TEST_CASE("machines rejoin a match and detect the lies of a host") {
    for (const HostileScene& scene : join_scenes()) {
        CAPTURE(std::string(scene.name));
        CHECK(scene.run() == "");
    }
}

TEST_CASE("relays serve their spectators under any behaviour of hosts and other spectators") {
    for (const HostileScene& scene : relay_scenes()) {
        CAPTURE(std::string(scene.name));
        CHECK(scene.run() == "");
    }
}

TEST_CASE("a match continues when its first machine leaves while another one joins and when the first one "
          "rejoins") {
    for (int frames = -100; frames <= 200; frames += is_too_long_here() ? 100 : 20)
        for (const std::uint32_t machines : {3u, 4u}) {
            CAPTURE(frames);
            CAPTURE(machines);
            CHECK(joins::first_goes(machines, frames) == "");
        }
}
