// Characters under rollback: every tick run again from a saved state, through the session and its event ledger.
#include "lockstone/session/forgetful.h"
#include "session/match.h"

#include "scenes/scenes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

/// The scene `character` with two players who follow the script, under a sync test.
struct Course {
    std::unique_ptr<Game> game = make_scene("character", {.size = 0, .seed = 1, .players = 2}).value();
    World world = game->start().value();
    WorldSimulation whole{world, *game};
    testing::ForgetfulSimulation simulation;
    std::unique_ptr<Session> session;
    EventLaw events;
    SessionRunner runner;
    std::uint64_t landings = 0; ///< confirmed

    explicit Course(std::uint32_t depth, std::string column_left_out = "")
        : simulation(whole, std::move(column_left_out)), session(make(*game, depth)),
          runner(*session, simulation) {}

    static std::unique_ptr<Session> make(const Game& game, std::uint32_t depth) {
        SessionDef def;
        def.input_size = game.input_size();
        def.players = {0, 0};
        return make_sync_test_session(def, depth).value();
    }
    /// How many events were seen.
    std::uint64_t run(std::uint64_t ticks) {
        std::uint64_t seen = 0;
        std::vector<std::byte> input(game->input_size());
        for (std::uint64_t i = 0; i < ticks && runner.sync_failure() == nullptr; ++i) {
            for (std::uint32_t p = 0; p < 2; ++p) {
                scripted_input(*game, 1, session->current_tick(), p, input);
                session->add_local_input(p, input);
            }
            REQUIRE(runner.frame(i).stall == Stall::none);
            for (const SessionEvent& e : runner.events()) {
                events.see(e), ++seen;
                landings += e.event.kind == EventKind::character_landed && e.status == EventStatus::confirmed;
            }
        }
        return seen;
    }
};

} // namespace

TEST_CASE("characters that walk, climb, crouch, push and ride survive rollback at every tick") {
    for (const std::uint32_t depth : {1u, 6u}) {
        Course course(depth);
        const std::uint64_t seen = course.run(depth == 1 ? 460 : 240);
        INFO("depth ", depth);
        CHECK(course.runner.sync_failure() == nullptr);
        CHECK(seen > 0);
        CHECK(course.landings > 0);
        CHECK(course.events.holds(course.session->current_tick() - depth - 1));
        CHECK(course.session->stats().hashes_compared > 200);
    }
}

TEST_CASE("planted: a rollback that forgets what characters remember is found") {
    Course course(3, "character.row");
    course.run(240);
    CHECK(course.runner.sync_failure() != nullptr);
}
