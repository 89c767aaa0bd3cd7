// A machine joins over a slow link, while another machine pauses, or after a long wait: it is admitted, exactly once.
#include "session/join/join_scenes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

TEST_CASE("a machine joins and stays at every latency below 3/16 of the timeout") {
    for (const std::uint32_t machines : {3u, 4u})
        for (const std::uint32_t way_ms : {600u, 930u}) { // [ms]; the limit is 940
            CAPTURE(machines);
            CAPTURE(way_ms);
            CHECK(joins::comes_from_afar(machines, way_ms) == "");
        }
}

TEST_CASE("a joining machine keeps its seat when another machine pauses for less than the timeout") {
    for (std::uint64_t moment = 20; moment <= 70; moment += 5)
        for (const std::uint64_t pause : {150u, 210u}) {
            CAPTURE(moment);
            CAPTURE(pause);
            Match match({.machines = 3, .link = {.latency_ms = 60}, .absent = 1u << 2, .record = false});
            match.run(120);
            match.join(2);
            for (std::uint64_t frame = 0; frame < 900; ++frame)
                match.frame(/*asleep: machine 1*/ frame >= moment && frame < moment + pause ? 2u : 0u);
            CHECK(match.notices<PlayerDisconnected>(0).empty());
            CHECK(match.notices<PlayerJoined>(2).size() == 1);
        }
}

TEST_CASE("a machine that could not join for a long time joins after a restart with a higher life number") {
    Match match({.machines = 3, .link = {.latency_ms = 40}, .absent = 1u << 2, .record = false});
    match.run(120);
    match.network.set_link(2, 1, {.loss_permille = 1000});
    match.join(2, 1);
    match.run(60 * 60 * 9); // more than 256 tickets, one every two seconds
    CHECK(match.notices<PlayerJoined>(2).empty());
    match.crash(2);
    match.run(60);
    match.network.set_link(2, 1, {.latency_ms = 40});
    match.join(2, 2);
    match.run(600);
    CHECK(match.notices<PlayerJoined>(2).size() == 1);
}
