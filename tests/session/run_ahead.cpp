// The runner shows the world some ticks ahead. Confirmed ticks, inputs and events do not change by that.
#include "session/run_ahead.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

TEST_CASE("a match with run-ahead confirms and reports the same as one without") {
    for (const HostileScene& scene : run_ahead_scenes()) {
        CAPTURE(std::string(scene.name));
        CHECK(scene.run() == "");
    }
}

TEST_CASE("the check finds a match that continues from a state of run-ahead") {
    // The planted fault: one column keeps its value of the shown tick when the runner restores the present one.
    MatchDef def{.players = {0}, .machines = 1, .input_delay = 0};
    def.column_left_out = "agent.motion";
    CHECK(shown_ahead(def, 0) == ""); // without run-ahead nothing is restored, so the column does no harm
    CHECK(shown_ahead(def, 2) == "what is confirmed is not what it is without");
}

TEST_CASE("run-ahead shows the state that follows when the present input is held") {
    for (std::uint32_t ahead = 1; ahead <= run_ahead_limit; ++ahead) {
        AheadMatch match({.players = {0}, .machines = 1, .input_delay = 0, .run_ahead = ahead});
        Arena expected(1);
        for (std::uint64_t tick = 0; tick < 200; ++tick) {
            match.play(1);
            const auto advance = [](Arena& arena, std::uint64_t held) {
                const auto bytes = encode_input(scripted_pad(0, held));
                const PlayerInput input{bytes, InputStatus::confirmed};
                arena.advance({&input, 1});
            };
            advance(expected, tick);
            Arena shown(1);
            shown.state() = expected.state();
            for (std::uint32_t i = 0; i < ahead; ++i) advance(shown, tick);
            REQUIRE(match.arena(0).hash() == shown.hash());
        }
    }
}

TEST_CASE("run-ahead with an input delay uses the known inputs before it holds the last one") {
    AheadMatch match({.players = {0}, .machines = 1, .input_delay = 2, .run_ahead = 4}),
        plain({.players = {0}, .machines = 1, .input_delay = 2});
    match.play(100), plain.play(102); // ticks 100 and 101 run on inputs that are given already
    Arena expected(1);
    expected.state() = plain.arena(0).state();
    // the input of tick 101, the newest one given by then
    const auto last = encode_input(scripted_pad(0, 99));
    const PlayerInput input{last, InputStatus::confirmed};
    for (int i = 0; i < 2; ++i) expected.advance({&input, 1});
    CHECK(match.arena(0).hash() == expected.hash());
}

TEST_CASE("run-ahead of k ticks costs k more ticks and one more restore per frame and no save") {
    AheadMatch match({.players = {0}, .machines = 1, .run_ahead = 3}), plain({.players = {0}, .machines = 1});
    match.play(200), plain.play(200);
    CHECK(match.arena(0).advances == plain.arena(0).advances + 3 * 200);
    CHECK(match.arena(0).restores == plain.arena(0).restores + 199);
    CHECK(match.arena(0).saves == plain.arena(0).saves);
    const std::uint64_t hash = plain.arena(0).hash();
    match.machine(0).runner.reset(); // then the simulation holds the played tick, not the shown one
    CHECK(match.arena(0).hash() == hash);
}

TEST_CASE("a session rejects run-ahead of more than four ticks and a sync test rejects any") {
    SimulatedNetwork network(1, {}, 1);
    SessionDef def;
    def.players = {0};
    def.run_ahead = 5;
    const auto refused = make_rollback_session(def, network.endpoint(0));
    REQUIRE_FALSE(refused);
    CHECK(refused.error().message == "session: run_ahead is 5, at most 4 ticks");
    def.run_ahead = 1;
    CHECK(make_rollback_session(def, network.endpoint(0)));
    const auto sync_test = make_sync_test_session(def, 2);
    REQUIRE_FALSE(sync_test);
    CHECK(sync_test.error().message == "session: run_ahead is 1; a sync test shows nothing ahead");
}
