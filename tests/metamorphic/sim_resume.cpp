// The contract: a world that is saved and restored at any tick, in any way, goes on to the same bits.
#include "support/sim_replay.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <functional>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

int run_length() { return std::getenv("LOCKSTONE_LONG") != nullptr ? 600 : 150; }

/// A world full of other things, with every cache filled by them.
World stranger() {
    World w = start_script(Scenery::pile);
    for (int i = 0; i < 90; ++i) step_script(w);
    for (std::uint32_t row = 0; row < w.body_count(); row += 2)
        done(w.set_pose(w.body_at(row), at(row * 3.0 - 40, 20, row)));
    w.tick();
    return w;
}

using Move = std::function<World(const World&)>;

/// The world is moved at every tick, and goes on from there to the end of the run.
std::string moved_at_every_tick(const Run& run, const Move& move, std::size_t ticks_after) {
    World walker = start_script(run.scenery, run.integrator);
    for (std::size_t t = 0; t < run.images.size(); ++t) {
        World other = move(walker);
        if (std::string e = departs(run, other, t, ticks_after); !e.empty()) return e;
        if (t + 1 < run.images.size()) step_script(walker);
    }
    return {};
}

} // namespace

TEST_CASE("restoring any tick into the same world replays to the same hashes to the end of the run") {
    for (Scenery scenery : sceneries) {
        INFO(std::string(name_of(scenery)));
        const Run run = run_of(scenery, run_length());
        World w = start_script(scenery);
        // Backwards and forwards, so that the caches always hold another time.
        for (std::size_t i = 0; i < run.images.size(); ++i) {
            const std::size_t t = i % 2 == 0 ? i : run.images.size() - 1 - i;
            w.restore(run.images[t]);
            REQUIRE(departs(run, w, t, run.images.size()) == "");
        }
    }
}

TEST_CASE("restoring any tick into a world that ran something else entirely replays to the same hashes") {
    const World other = stranger();
    for (Scenery scenery : sceneries) {
        INFO(std::string(name_of(scenery)));
        const Run run = run_of(scenery, run_length());
        World w = other.clone();
        for (std::size_t t = 0; t < run.images.size(); t += 3) {
            w.restore(run.images[t]);
            REQUIRE(departs(run, w, t, 12) == "");
            Image foreign;
            other.save(foreign);
            w.restore(foreign);
            for (int i = 0; i < 3; ++i) step_script(w);
        }
    }
}

TEST_CASE("a portable image of any tick, loaded by a fresh world, replays to the same hashes") {
    for (Scenery scenery : sceneries) {
        INFO(std::string(name_of(scenery)));
        const Move move = [&](const World& from) {
            World to = start_script(scenery);
            done(to.restore_portable(from.save_portable()));
            return to;
        };
        CHECK(moved_at_every_tick(run_of(scenery, run_length()), move, 20) == "");
    }
}

TEST_CASE("a clone at another address goes on alike and leaves its original alone") {
    for (Scenery scenery : sceneries) {
        INFO(std::string(name_of(scenery)));
        CHECK(moved_at_every_tick(
                  run_of(scenery, run_length()), [](const World& w) { return w.clone(); }, 20) == "");
    }
}

TEST_CASE("restoring works alike under every integrator") {
    for (Integrator integrator :
         {Integrator::verlet, Integrator::velocity_verlet, Integrator::runge_kutta_4}) {
        INFO(std::string(name_of(integrator)));
        const Run run = run_of(Scenery::fields, 60, integrator);
        CHECK(moved_at_every_tick(
                  run, [](const World& w) { return w.clone(); }, 60) == "");
    }
}

TEST_CASE("a world made and run after unrelated worlds is the same world") {
    const Run run = run_of(Scenery::pile, 60);
    std::vector<World> others;
    for (int i = 0; i < 5; ++i) others.push_back(stranger());
    World w = start_script(Scenery::pile);
    for (std::size_t t = 0; t < run.hashes.size(); ++t) {
        REQUIRE(w.hash() == run.hashes[t]);
        step_script(w);
        step_script(others[t % others.size()]);
    }
}

TEST_CASE("phase hashes agree between a run and its replay, and switching them on changes nothing") {
    const Run run = run_of(Scenery::pile, 60);
    World left = start_script(Scenery::pile), right = start_script(Scenery::pile);
    left.record_phase_hashes(true), right.record_phase_hashes(true);
    for (std::size_t t = 0; t + 1 < run.images.size(); ++t) {
        right.restore(run.images[t]);
        step_script(left), step_script(right);
        REQUIRE(left.hash() == run.hashes[t + 1]);
        REQUIRE(left.phase_hashes().size() > 3);
        REQUIRE(left.phase_hashes().size() == right.phase_hashes().size());
        for (std::size_t i = 0; i < left.phase_hashes().size(); ++i) {
            INFO("tick ", t, ", phase ", std::string(left.phase_hashes()[i].phase));
            REQUIRE(left.phase_hashes()[i].hash == right.phase_hashes()[i].hash);
        }
    }
}

TEST_CASE("an observer of phases is told the same by a run and its replay, and changes nothing") {
    struct Names final : PhaseObserver {
        std::vector<std::string> list;
        void on_phase(const char* phase) override { list.emplace_back(phase); }
    };
    const Run run = run_of(Scenery::pile, 60);
    Names of_left, of_right;
    World left = start_script(Scenery::pile), right = start_script(Scenery::pile);
    left.observe_phases(&of_left), right.observe_phases(&of_right);
    for (std::size_t t = 0; t + 1 < run.images.size(); ++t) {
        right.restore(run.images[t]);
        step_script(left), step_script(right);
        REQUIRE(left.hash() == run.hashes[t + 1]);
        REQUIRE(of_left.list == of_right.list);
    }
    for (const char* phase : {"commands", "update_bounds", "find_pairs", "collide", "prepare", "warm_start",
                              "solve_contacts", "relax_contacts", "finish", "update_sleep"})
        CHECK(std::ranges::find(of_left.list, phase) != of_left.list.end());
    const std::size_t told = of_left.list.size();
    left.clone().tick();
    left.observe_phases(nullptr);
    left.tick();
    CHECK(of_left.list.size() == told);
}

TEST_CASE(
    "a shape that takes the slot and generation of another kind of shape after a restore is alone there") {
    // The broad phase must not keep the crate's bounds for the plane that came after the restore.
    const auto start = [] {
        World w = made(World::create(small_def()));
        add_ball(w, at(0.2, 0.6, 0));
        return w;
    };
    World w = start(), fresh = start();
    Image before;
    w.save(before);
    add_wall(w, at(0, 0, 0), vec(2, 0.5, 2));
    w.tick();
    w.restore(before);
    for (World* each : {&w, &fresh}) {
        add_floor(*each);
        for (int i = 0; i < 30; ++i) each->tick();
    }
    CHECK(difference(fresh, w) == "");
    CHECK(w.contacts().size() == 1);
}

TEST_CASE("the commands of a journal, applied to a fresh world, give the same hash after every tick") {
    for (Scenery scenery : sceneries) {
        INFO(std::string(name_of(scenery)));
        World w = start_script(scenery), fresh = start_script(scenery);
        Tape tape;
        w.set_journal(&tape);
        for (int t = 0; t < run_length(); ++t) step_script(w);
        std::size_t next = 0;
        for (std::size_t t = 0; t < tape.hashes.size(); ++t) {
            for (; next < tape.commands.size() && tape.commands[next].tick == t; ++next)
                REQUIRE(fresh.apply(tape.commands[next].command).ok());
            fresh.tick();
            INFO("tick ", t);
            REQUIRE(fresh.hash() == tape.hashes[t]);
        }
        for (; next < tape.commands.size(); ++next) // the game's writes after the last tick
            REQUIRE(fresh.apply(tape.commands[next].command).ok());
        CHECK(difference(w, fresh) == "");
    }
}
