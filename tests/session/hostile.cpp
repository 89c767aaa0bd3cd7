// One hostile machine among three or four: the others continue, agree, and soon drop it.
#include "session/hostile_scenes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

TEST_CASE("a machine that lies does not desynchronize, stop or slow down the honest machines") {
    for (const HostileScene& scene : hostile_scenes()) {
        CAPTURE(std::string(scene.name));
        CHECK(scene.run() == "");
    }
}

TEST_CASE("drop_peer() removes one of two machines at once and one of three when both others call it") {
    Match two({.link = {.latency_ms = 40}});
    two.run(60);
    REQUIRE(two.machine(0).session->drop_peer(1).ok());
    two.run(30);
    CHECK(two.notices<PlayerDisconnected>(0).size() == 1);
    CHECK(two.notices<PlayerDisconnected>(1).size() == 1); // gets a notice at once, no timeout

    Match three({.machines = 3, .link = {.latency_ms = 40}});
    three.run(60);
    REQUIRE(three.machine(0).session->drop_peer(2).ok());
    three.run(120);
    CHECK(three.notices<PlayerDisconnected>(0).empty());
    CHECK(three.machine(0).timeline.ticks.size() > 150);
    REQUIRE(three.machine(1).session->drop_peer(2).ok());
    three.run(120);
    CHECK(three.notices<PlayerDisconnected>(0).size() == 1);
    CHECK(three.notices<PlayerDisconnected>(1).size() == 1);
    CHECK(three.notices<MatchStopped>(2).size() == 1);
    CHECK(three.agree(0, 1));

    for (const PeerId nobody : {PeerId{0}, PeerId{3}, ~PeerId{0}}) {
        const Status refused = three.machine(0).session->drop_peer(nobody);
        REQUIRE_FALSE(refused.ok());
        CHECK(refused.error().message ==
              "drop_peer: machine " + std::to_string(nobody) + " is not a peer of this match");
    }
}

TEST_CASE("a machine that receives no packets reports a stop or a disconnection and the others continue") {
    HostileMatch h(4);
    h.match.run(200);
    for (PeerId other = 0; other < 3; ++other) h.match.network.set_link(other, 3, {.loss_permille = 1000});
    h.match.run(400);
    CHECK(h.trouble({0, 1, 2}, 400) == "");
    const auto told = h.match.notices<MatchStopped>(3).size() + h.match.notices<PlayerDisconnected>(3).size();
    CHECK(told > 0);
}
