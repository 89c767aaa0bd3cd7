// The sync test reports no error in a sound game, and the exact error in an unsound one.
#include "session/match.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

struct SyncTest {
    SimulatedNetwork network{1, {}, 1};
    std::unique_ptr<Session> session;
    Timeline timeline;
    EventLaw events;
    SessionRunner runner;

    SyncTest(Simulation& simulation, std::uint32_t depth)
        : session(make(depth)), runner(*session, simulation, {&timeline}) {}

    static std::unique_ptr<Session> make(std::uint32_t depth) {
        SessionDef def;
        def.input_size = input_size_of<Pad>;
        def.players = {0, 0};
        return make_sync_test_session(def, depth).value();
    }
    void run(std::uint64_t ticks) {
        for (std::uint64_t i = 0; i < ticks; ++i) {
            for (std::uint32_t p = 0; p < 2; ++p)
                session->add_local_input(p, encode_input(scripted_pad(p, session->current_tick())));
            REQUIRE(runner.frame(i).stall == Stall::none);
            for (const SessionEvent& e : runner.events()) events.see(e);
        }
    }
};

/// Keeps a value outside of the state: a classic mistake.
class ForgetfulArena final : public Arena {
  public:
    using Arena::Arena;
    void advance(std::span<const PlayerInput> inputs) override {
        Arena::advance(inputs);
        if (++calls == 500) agents()[5].speed += 1;
    }

  private:
    std::uint64_t calls = 0;
};

/// Reads whether an input is predicted: the other classic mistake.
class StatusArena final : public Arena {
  public:
    using Arena::Arena;
    void advance(std::span<const PlayerInput> inputs) override {
        Arena::advance(inputs);
        if (inputs[1].status == InputStatus::predicted) agents()[2].place += 1;
    }
};

} // namespace

TEST_CASE(
    "a correct game passes the sync test at every depth and its timeline equals a run without rollbacks") {
    for (const std::uint32_t depth : {1u, 2u, 7u, 64u}) {
        Arena arena(2), straight(2);
        SyncTest test(arena, depth);
        test.run(300);
        CHECK(test.runner.sync_failure() == nullptr);
        CHECK(test.session->stats().resimulated == depth * (300 - depth));
        CHECK(test.session->stats().hashes_compared > 200);
        CHECK(test.timeline.ticks.size() == 300 - depth);
        CHECK(run_straight(test.timeline, 2, straight) == test.timeline.ticks.back().hash);
        CHECK(test.events.holds(300 - depth));
        CHECK(test.events.count(EventStatus::cancelled) == 0);
    }
}

TEST_CASE("the sync test reports the column, row and field of a game that stores a value outside its state") {
    ForgetfulArena arena(2);
    SyncTest test(arena, 4);
    test.run(200);
    const SyncTestFailure* failure = test.runner.sync_failure();
    REQUIRE(failure != nullptr);
    CHECK(failure->when == SyncTestFailure::When::resimulated);
    CHECK(failure->differences[0].column == "agent.motion");
    CHECK(failure->differences[0].row == 5);
    CHECK(failure->differences[0].field == "speed");
    CHECK(failure->first_hash != failure->second_hash);
}

TEST_CASE("the sync test detects a game whose rules read the status of an input") {
    StatusArena arena(2);
    SyncTest test(arena, 2);
    test.run(10);
    REQUIRE(test.runner.sync_failure() != nullptr);
    CHECK(test.runner.sync_failure()->differences[0].row == 2);
    CHECK(test.runner.sync_failure()->differences[0].field == "place");
}
