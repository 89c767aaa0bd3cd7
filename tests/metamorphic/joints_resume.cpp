// All kinds of joints, driven, changed, broken, made and destroyed while the world runs, with bodies that fall asleep:
// a world that was saved and restored at any tick goes on to the same bits.
#include "lockstone/testing.h"
#include "replay/replay.h"
#include "scenes/scenes.h"
#include "support/rigs/joint_scenes.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <functional>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

int run_length() { return std::getenv("LOCKSTONE_LONG") != nullptr ? 400 : 120; }

/// A pair of bodies for every kind, side by side over a floor, and a chain that comes to rest.
World start_joints() {
    WorldDef def = drowsy_def();
    def.joints_max = 64;
    def.sleep_time = real(0.2);
    World w = made(World::create(def));
    add_floor(w);
    for (std::size_t i = 0; i < std::size(joint_kinds); ++i) {
        const double z = 4.0 * static_cast<double>(i);
        const JointKind kind = joint_kinds[i];
        const BodyId a = add_crate(w, at(-1, 3, z)), b = add_crate(w, at(1, 3, z));
        JointDef def_a = hinge_joint(), joint = plain_joint(kind);
        joint.user_key = i;
        if (i % 3 == 0) made(w.create_joint(def_a, {}, a, at(-1, 3.4, z)));
        if (kind == JointKind::pulley) joint.ground_a = vec(-1, 6, z), joint.ground_b = vec(1, 6, z);
        if (kind == JointKind::hinge)
            joint.axis[about_x] = {.mode = AxisMode::limited,
                                   .lower = real(-0.5),
                                   .upper = real(0.5),
                                   .motor_speed = Real(2),
                                   .motor_force = Real(900)};
        if (kind == JointKind::ball) joint.swing = real(0.5), joint.axis[about_x].friction = Real(20);
        if (kind == JointKind::weld) joint.break_torque = Real(9000);
        joint.body_a = a, joint.body_b = b;
        if (kind < JointKind::distance || kind > JointKind::pulley)
            made(w.create_joint(joint, a, b, at(0, 3, z)));
        else
            made(w.create_joint(joint));
    }
    BodyId before{};
    for (int i = 0; i < 4; ++i) {
        const BodyId link =
            add(w, {.pose = at(6 + 0.5 * i, 0.2, 0)}, {.geometry = capsule(real(0.1), real(0.1))});
        if (before) made(w.create_joint(ball_joint(), before, link, at(5.75 + 0.5 * i, 0.2, 0)));
        before = link;
    }
    return w;
}

JointId joint_from(const World& w, std::uint64_t start) {
    return w.joint_at(static_cast<std::uint32_t>(start % w.joint_count()));
}

/// Commands that depend on the state and its tick alone, then the tick.
void step_joints(World& w) {
    const std::uint64_t tick = w.tick_count();
    const BodyId body = w.body_at(static_cast<std::uint32_t>(tick * 5 % w.body_count()));
    if (tick % 11 == 3 && w.kind(body) == BodyKind::dynamic)
        done(w.add_impulse(body, vec(900, 500, static_cast<double>(tick % 3) * 300), vec(50, 200, 30)));
    if (tick % 13 == 5) {
        const JointId joint = joint_from(w, tick);
        JointAxis axis = w.joint(joint).axis[about_x];
        axis.motor_speed = -axis.motor_speed, axis.friction = Real(static_cast<std::int32_t>(tick % 50));
        done(w.set_joint_axis(joint, about_x, axis));
    }
    if (tick % 29 == 17) {
        const JointDef def = w.joint(joint_from(w, tick / 2));
        done(w.destroy(joint_from(w, tick / 2)));
        made(w.create_joint(def));
    }
    if (tick % 37 == 21) {
        const JointId joint = joint_from(w, tick);
        JointDef def = w.joint(joint);
        def.frame_b.position.y += real(0.05);
        done(w.set_joint_frames(joint, def.frame_a, def.frame_b));
    }
    w.tick();
}

struct Straight {
    std::vector<Image> images;
    std::vector<std::uint64_t> hashes;
};
Straight straight_run() {
    Straight run;
    World w = start_joints();
    for (int t = 0; t <= run_length(); ++t) {
        w.save(run.images.emplace_back());
        run.hashes.push_back(w.hash());
        if (t < run_length()) step_joints(w);
    }
    return run;
}
const Straight& the_run() {
    static const Straight run = straight_run();
    return run;
}

/// Empty when `w`, at tick `from`, follows the run for `ticks`.
std::string departs(World& w, std::size_t from, std::size_t ticks) {
    const Straight& run = the_run();
    for (std::size_t t = from;; ++t) {
        if (w.hash() != run.hashes[t]) {
            World expected = start_joints();
            expected.restore(run.images[t]);
            return "from tick " + std::to_string(from) + ": " + difference(expected, w);
        }
        if (t + 1 == run.hashes.size() || t == from + ticks) return {};
        step_joints(w);
    }
}

std::string moved_at_every_tick(const std::function<World(const World&)>& move, std::size_t ticks_after) {
    World walker = start_joints();
    for (std::size_t t = 0; t < the_run().images.size(); ++t) {
        World other = move(walker);
        if (std::string e = departs(other, t, ticks_after); !e.empty()) return e;
        if (t + 1 < the_run().images.size()) step_joints(walker);
    }
    return {};
}

} // namespace

TEST_CASE("the run with all kinds of joints has breaks, sleepers and sleepers that wake") {
    World w = start_joints();
    int broken = 0, fell_asleep = 0, woke = 0;
    for (int t = 0; t < run_length(); ++t) {
        step_joints(w);
        for (const Event& e : w.events()) {
            broken += e.kind == EventKind::joint_break;
            fell_asleep += e.kind == EventKind::body_sleep;
            woke += e.kind == EventKind::body_wake;
        }
    }
    CHECK(broken > 0);
    CHECK(fell_asleep > 0);
    CHECK(woke > 0);
}

TEST_CASE("joints: restored at any tick, forwards and backwards, the same world goes on to the same hashes") {
    World w = start_joints();
    const std::size_t count = the_run().images.size();
    for (std::size_t i = 0; i < count; ++i) {
        const std::size_t t = i % 2 == 0 ? i : count - 1 - i;
        w.restore(the_run().images[t]);
        REQUIRE(departs(w, t, 15) == "");
    }
}

TEST_CASE("joints: a portable image and a clone of any tick go on to the same hashes") {
    CHECK(moved_at_every_tick(
              [](const World& from) {
                  World to = start_joints();
                  for (int i = 0; i < 3; ++i) step_joints(to); // with caches of its own
                  done(to.restore_portable(from.save_portable()));
                  return to;
              },
              8) == "");
    CHECK(moved_at_every_tick([](const World& from) { return from.clone(); }, 8) == "");
}

TEST_CASE("planted fault: warm starts and turns of joints that a restore forgets are found out") {
    for (std::size_t byte : {std::size_t{0}, std::size_t{1}}) {
        World w = start_joints();
        w.restore(the_run().images[40]);
        State& s = testing::state_of(w);
        const ColumnInfo* info = s.layout().find_column("joint.memory");
        REQUIRE(info != nullptr);
        const auto index = static_cast<std::uint32_t>(info - s.layout().columns().data());
        const std::span<std::byte> bytes = s.edit_bytes(index);
        if (byte == 0)
            std::ranges::fill(bytes, std::byte{});
        else
            bytes[0] ^= std::byte{1};
        World straight = start_joints();
        straight.restore(the_run().images[40]);
        REQUIRE(same_motion(w, straight));
        step_joints(straight);
        World forgetful = w.clone();
        step_joints(forgetful);
        if (byte == 0) CHECK_FALSE(same_motion(forgetful, straight));
        CHECK(departs(w, 40, 5).find("joint.memory") != std::string::npos); // and it is named
    }
}

TEST_CASE("joints: a recording of the grid of all kinds plays back to the same hashes, in both modes") {
    for (const bool commands : {false, true}) {
        const auto game = made(make_scene("joint-grid"));
        replay::MemorySink sink;
        World world = made(game->start());
        std::vector<std::uint64_t> hashes{world.hash()};
        const auto by_inputs = [&] {
            auto recorder = made(replay::InputRecorder::begin(sink, *game, world, {.keyframe_ticks = 40}));
            for (int t = 0; t < 160; ++t) {
                REQUIRE(game->advance(world, {}).ok());
                done(recorder.after_tick(world, {}));
                hashes.push_back(world.hash());
            }
            done(recorder.close());
        };
        const auto by_commands = [&] {
            const auto recorder =
                made(replay::CommandRecorder::begin(sink, world, "joints", {.keyframe_ticks = 40}));
            for (int t = 0; t < 160; ++t) {
                REQUIRE(game->advance(world, {}).ok());
                hashes.push_back(world.hash());
            }
            done(recorder->close());
        };
        commands ? by_commands() : by_inputs();
        const replay::Recording recording =
            made(replay::Recording::from_bytes(sink.bytes, "grid.lsr", replay::OnDamage::refuse));
        replay::Player player = made(replay::Player::open(recording, commands ? nullptr : game.get()));
        for (std::uint64_t t : {160u, 0u, 151u, 77u, 41u, 150u}) {
            done(player.seek(t));
            REQUIRE(player.world().hash() == hashes[t]);
            REQUIRE(player.agrees());
        }
    }
}
