// The contract: a world that is saved and restored at any tick, in any way, continues with equal bits and equal events.
#include "lockstone/tasks.h"
#include "lockstone/testing.h"
#include "metamorphic/stories.h"
#include "support/task_runners.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

const std::vector<Run>& runs() {
    static const std::vector<Run> all = [] {
        std::vector<Run> out;
        for (const Story& story : stories()) out.push_back(run_of(story));
        return out;
    }();
    return all;
}

const Run& run_named(std::string_view name) {
    return *std::ranges::find_if(runs(), [&](const Run& r) { return r.story.name == name; });
}

int count_of(const Run& run, EventKind kind) {
    int count = 0;
    World w = run.story.start();
    for (int t = 0; t < run.story.ticks; ++t) {
        run.story.step(w);
        count += static_cast<int>(
            std::ranges::count_if(w.events(), [&](const Event& e) { return e.kind == kind; }));
    }
    return count;
}

/// A second world follows the run. At regular ticks `move` gets that world and the number of the move, and returns a
/// world that must continue as the run does.
template <class Move> std::string moved(const Run& run, Move&& move) {
    World walker = run.story.start();
    for (int t = 0, number = 0; t <= run.story.ticks; ++t) {
        if (t % run.story.moved_every == 0) {
            World other = move(walker, number++);
            std::string e = departs(run, other, static_cast<std::size_t>(t), run.story.after_move);
            if (!e.empty()) return e;
        }
        if (t < run.story.ticks) run.story.step(walker);
    }
    return {};
}

/// Restores all images, alternately from both ends, so that the caches always come from another tick.
std::string restored_everywhere(const Run& run, World w) {
    for (std::size_t i = 0; i < run.images.size(); ++i) {
        const std::size_t t = i % 2 == 0 ? i : run.images.size() - 1 - i;
        w.restore(run.images[t]);
        if (std::string e = departs(run, w, t, run.story.after); !e.empty()) return e;
    }
    return {};
}

} // namespace

TEST_CASE("the runs contain breaks and sleepers that wake and rides and jumps and pushes and crouching") {
    World zoo = run_named("every kind of shape").story.start();
    zoo.restore(run_named("every kind of shape").images.back());
    CHECK(zoo.faults() == Faults{});
    const Run& joints = run_named("joints");
    CHECK(count_of(joints, EventKind::joint_break) > 0);
    CHECK(count_of(joints, EventKind::body_sleep) > 0);
    CHECK(count_of(joints, EventKind::body_wake) > 0);
    CHECK(count_of(run_named("sleepers"), EventKind::body_wake) > 10);
    World towers = start_sleepers();
    std::uint32_t least = towers.awake_count(), most = least;
    for (int t = 0; t < 260; ++t) {
        step_sleepers(towers);
        least = std::min(least, towers.awake_count()), most = std::max(most, towers.awake_count());
    }
    CHECK(least <= 2);
    CHECK(most > 12);
    for (const Run& run : runs())
        if (run.story.name.ends_with("breaks")) {
            INFO(run.story.name);
            CHECK(count_of(run, EventKind::joint_break) == 1);
        }
    using namespace test::character;
    World w = start_characters();
    bool crouched = false, rode = false, jumped = false, climbed = false, pushed = false;
    for (int t = 0; t < 240; ++t) {
        step_characters(w);
        for (std::uint32_t i = 0; i < 3; ++i) {
            const CharacterState s = w.character_state(w.character_at(i));
            crouched |= s.crouched != 0;
            rode |= s.ground_velocity != Vec3{};
            jumped |= s.has_jumped != 0;
            climbed |= stands(w, w.character_at(i)) && feet(w, w.character_at(i))[1] > 1;
            CHECK(overlap(w, w.character_at(i)) < 0.02);
        }
        for (const BodyId b : w.bodies()) pushed |= w.mass(b) == 25_r && std::abs(velocity(w, b)[0]) > 0.5;
    }
    CHECK((crouched && rode && jumped && climbed && pushed));
}

TEST_CASE("a restore of any tick into the same world replays to the same hashes and events") {
    for (const Run& run : runs()) {
        INFO(run.story.name);
        CHECK(restored_everywhere(run, run.story.start()) == "");
    }
}

TEST_CASE("a restore of any tick into a world with another history replays to the same hashes") {
    World other = start_script(Scenery::pile);
    for (int i = 0; i < 90; ++i) step_script(other);
    for (std::uint32_t row = 0; row < other.body_count(); row += 2)
        done(other.set_pose(other.body_at(row), at(row * 3.0 - 40, 20, row)));
    other.tick();
    Image foreign;
    other.save(foreign);
    for (const Scenery scenery : sceneries) {
        INFO(std::string(name_of(scenery)));
        const Run run = run_of(script_story(scenery, long_or(600, 150)));
        World w = other.clone();
        for (std::size_t t = 0; t < run.images.size(); t += 3) {
            w.restore(run.images[t]);
            REQUIRE(departs(run, w, t, 12) == "");
            w.restore(foreign);
            for (int i = 0; i < 3; ++i) step_script(w);
        }
    }
}

TEST_CASE(
    "a portable image of any tick replays to the same hashes in a world that is fresh or used or roomy") {
    for (const Run& run : runs()) {
        INFO(run.story.name);
        CHECK(moved(run, [&](const World& from, int number) {
                  World to = run.story.start();
                  const WorldDef& d = to.def();
                  for (int i = 0; number % 2 == 1 && i < 3; ++i) run.story.step(to);
                  if (number % 3 == 1)
                      done(to.reserve({.bodies = d.bodies_max,
                                       .shapes = d.shapes_max,
                                       .contacts = std::min(512u, d.contacts_max)}));
                  done(to.restore_portable(from.save_portable()));
                  CHECK(to.awake_count() == from.awake_count());
                  return to;
              }) == "");
    }
}

TEST_CASE("a clone at another address continues alike and does not change its original") {
    for (const Run& run : runs()) {
        INFO(run.story.name);
        CHECK(moved(run, [](const World& from, int) { return from.clone(); }) == "");
    }
}

TEST_CASE("a world continues alike from any tick with workers and with tasks in random order") {
    const auto two = make_worker_pool(2), three = make_worker_pool(3);
    test::ShuffledTasks shuffled(5);
    const std::array<Tasks*, 3> tasks{three.get(), &shuffled, two.get()};
    for (const char* name : {"pile", "convex-pile", "rollback-arena", "terrain", "water"}) {
        INFO(name);
        const Run& run = run_named(name);
        for (std::size_t i = 0; i < tasks.size(); ++i) {
            World w = run.story.start();
            w.set_tasks(tasks[i]);
            CHECK(departs(run, w, 0, 120) == "");
            for (std::size_t from = i; from < run.images.size(); from += 7) {
                w.restore(run.images[from]);
                REQUIRE(departs(run, w, from, 5) == "");
            }
            w.set_tasks(nullptr);
        }
    }
}

TEST_CASE("planted fault: the check finds a restore that loses a part of a column and names the column") {
    struct Loss {
        const char* story;
        const char* column;
        std::string_view leaf; ///< empty: all leaves from `first_byte` on
        std::size_t first_byte, from, within;
        int ways; ///< the least number of ticks with a difference
    };
    // A character's row keeps its ids, definition and input. A sleeper may show the loss in a later tick.
    constexpr std::size_t kept = sizeof(CharacterId) + sizeof(BodyId) + sizeof(ShapeId) +
                                 sizeof(CharacterDef) + sizeof(CharacterInput);
    for (const Loss& loss : {Loss{"characters", "character.row", "", kept, 0, 1, 60},
                             {"joints", "joint.memory", "", 0, 40, 1, 1},
                             {"every kind of shape", "contact.memory", "", 0, 200, 30, 1},
                             {"pile", "contact.memory", "", 0, 30, 1, 1},
                             {"sleepers", "body.sleep", "", 0, 10, 60, 1},
                             {"sleepers", "sleeping_contact.memory", "", 0, 10, 60, 1},
                             {"vehicles", "vehicle.memory", "wheel[0].spin", 0, 60, 1, 1}}) {
        INFO(loss.story, ": ", loss.column);
        const Run& run = run_named(loss.story);
        World w = run.story.start(), good = run.story.start();
        int ways = 0;
        std::string named;
        for (std::size_t t = loss.from; t < run.images.size() && ways < loss.ways; ++t) {
            w.restore(run.images[t]), good.restore(run.images[t]);
            State& state = testing::state_of(w);
            const ColumnInfo* column = state.layout().find_column(loss.column);
            REQUIRE(column != nullptr);
            const std::span<std::byte> bytes =
                state.edit_bytes(static_cast<std::uint32_t>(column - state.layout().columns().data()));
            for (std::size_t row = 0; row < bytes.size(); row += column->row_size)
                for (const LeafInfo& leaf : column->leaves)
                    if (leaf.offset >= loss.first_byte && (loss.leaf.empty() || leaf.name == loss.leaf))
                        std::ranges::fill(bytes.subspan(row + leaf.offset, leaf.size), std::byte{});
            REQUIRE(same_motion(w, good));
            if (World copy = w.clone(); copy.hash() != run.hashes[t]) named = departs(run, copy, t, 1);
            bool parted = false;
            for (std::size_t i = 0; i < loss.within && !parted; ++i) {
                run.story.step(w), run.story.step(good);
                parted = !same_motion(w, good);
            }
            ways += parted ? 1 : 0;
        }
        CHECK(ways >= loss.ways);
        CHECK(named.find(std::string("column ") + loss.column + ", row ") != std::string::npos);
    }
}

TEST_CASE("planted fault: the check finds lost memory of every kind of joint in some tick and a break at a "
          "wrong tick") {
    for (const JointVariant& v : joint_variants()) {
        INFO(std::string(v.name));
        const Run& run = run_named(v.name);
        World w = run.story.start(), good = run.story.start();
        int other = 0;
        for (const Image& image : run.images) {
            w.restore(image), good.restore(image);
            State& s = testing::state_of(w);
            const ColumnInfo* info = s.layout().find_column("joint.memory");
            std::ranges::fill(s.edit_bytes(static_cast<std::uint32_t>(info - s.layout().columns().data())),
                              std::byte{});
            run.story.step(w), run.story.step(good);
            other += same_motion(w, good) ? 0 : 1;
        }
        CHECK(other > 0);
        Run late = run_of(run_named(std::string(v.name) + ", that breaks").story);
        std::ranges::rotate(late.events, late.events.end() - 1); // each event is one place later
        CHECK(restored_everywhere(late, late.story.start()).find("other events") != std::string::npos);
    }
}

TEST_CASE(
    "planted fault: the check finds another density of water and another speed of wind and a missing blast") {
    const Run &water = run_named("water"), &blast = run_named("blast");
    World w = water.story.start(), straight = water.story.start();
    for (std::uint32_t row = 0; row < w.field_count(); ++row) {
        w.restore(water.images[10]), straight.restore(water.images[10]);
        FieldDef def = w.field(w.field_at(row));
        def.density += 1_r, def.velocity.x += 0.01_r;
        done(w.set_field(w.field_at(row), def));
        REQUIRE(same_motion(w, straight));
        water.story.step(w), water.story.step(straight);
        CHECK_FALSE(same_motion(w, straight));
    }
    World other = blast.story.start(), after = blast.story.start();
    other.restore(blast.images[60]), after.restore(blast.images[61]);
    other.tick(); // the game applies the blast of tick 60
    CHECK_FALSE(same_motion(other, after));
}

TEST_CASE(
    "phases have the same hashes and names in a run and in its replay and an observer changes no hash") {
    struct Names final : PhaseObserver {
        std::vector<std::string> list;
        void on_phase(const char* phase) override { list.emplace_back(phase); }
    };
    const Run run = run_of(script_story(Scenery::pile, 60));
    Names of_left, of_right;
    World left = run.story.start(), right = run.story.start();
    left.record_phase_hashes(true), right.record_phase_hashes(true);
    left.observe_phases(&of_left), right.observe_phases(&of_right);
    for (std::size_t t = 0; t + 1 < run.images.size(); ++t) {
        right.restore(run.images[t]);
        step_script(left), step_script(right);
        REQUIRE(left.hash() == run.hashes[t + 1]);
        REQUIRE(of_left.list == of_right.list);
        REQUIRE(left.phase_hashes().size() > 3);
        REQUIRE(left.phase_hashes().size() == right.phase_hashes().size());
        for (std::size_t i = 0; i < left.phase_hashes().size(); ++i) {
            INFO("tick ", t, ", phase ", std::string(left.phase_hashes()[i].phase));
            REQUIRE(left.phase_hashes()[i].hash == right.phase_hashes()[i].hash);
        }
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

TEST_CASE("the commands of a journal give a fresh world the same hash after every tick") {
    for (const Scenery scenery : sceneries) {
        INFO(std::string(name_of(scenery)));
        World w = start_script(scenery), fresh = start_script(scenery);
        Tape tape;
        w.set_journal(&tape);
        for (int t = 0; t < long_or(600, 150); ++t) step_script(w);
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
