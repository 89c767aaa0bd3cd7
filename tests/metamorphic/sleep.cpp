// What sleeps changes nothing for what is awake, and sleeping and waking survive restoring at every tick.
#include "lockstone/testing.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// Towers that fall asleep, balls that wake them one after the other, a lift that starts and stops, joined pairs.
World start() {
    WorldDef def = drowsy_def();
    def.contacts_max = 400;
    World w = made(World::create(def));
    add_floor(w);
    for (int t = 0; t < 4; ++t)
        for (int i = 0; i < 3; ++i) add_crate(w, at(5.0 * t, 0.5 + i, 0));
    add(w, {.kind = BodyKind::kinematic, .pose = at(-6, 0.25, 0), .user_key = 7},
        {.geometry = box(real(1), real(0.25), real(1))});
    add_crate(w, at(-6, 1, 0));
    const BodyId a = add_ball(w, at(-12, 0.5, 0)), b = add_ball(w, at(-14, 0.5, 0));
    made(w.create_joint(weld_joint(), a, b, at(-13, 0.5, 0)));
    return w;
}

BodyId lift_of(const World& w) {
    for (BodyId b : w.bodies())
        if (w.user_key(b) == 7) return b;
    return {};
}

/// A pure function of the world and its tick.
void step(World& w) {
    const std::uint64_t t = w.tick_count();
    if (t % 60 == 55) {
        const int tower = static_cast<int>(t / 60 % 4);
        add(w, {.pose = at(5.0 * tower - 1.5, 1.7, 0.1), .linear_velocity = vec(6, 1, 0)},
            {.geometry = sphere(real(0.3))});
    }
    if (t == 80) done(w.set_velocity(lift_of(w), vec(0, 0.5, 0), {}));
    if (t == 120) done(w.set_velocity(lift_of(w), {}, {}));
    if (t == 190) done(w.wake_body(lift_of(w)));
    w.tick();
}

constexpr int run_ticks = 260;

struct Recorded {
    std::vector<Image> images;
    std::vector<std::uint64_t> hashes;
    std::uint32_t least_awake = 1000, most_awake = 0;
    int wakings = 0;
};
Recorded record() {
    Recorded r;
    World w = start();
    for (int t = 0; t <= run_ticks; ++t) {
        w.save(r.images.emplace_back());
        r.hashes.push_back(w.hash());
        r.least_awake = std::min(r.least_awake, w.awake_count());
        r.most_awake = std::max(r.most_awake, w.awake_count());
        for (const Event& e : w.events()) r.wakings += e.kind == EventKind::body_wake ? 1 : 0;
        if (t < run_ticks) step(w);
    }
    return r;
}

/// The tick at which a restored world parts from the run, -1: never.
int parts_at(const Recorded& r, World& w, int from, int ticks) {
    for (int t = from; t <= std::min(run_ticks, from + ticks); ++t) {
        if (w.hash() != r.hashes[static_cast<std::size_t>(t)]) return t;
        step(w);
    }
    return -1;
}

} // namespace

TEST_CASE("a world that sleeps and wakes is restored at every tick, forwards and backwards, with caches of "
          "other ticks") {
    const Recorded r = record();
    CHECK(r.least_awake <= 2);
    CHECK(r.most_awake > 12);
    CHECK(r.wakings > 10);
    World w = start();
    for (int i = 0; i <= run_ticks; ++i) {
        const int t = i % 2 == 0 ? i : run_ticks - i;
        w.restore(r.images[static_cast<std::size_t>(t)]);
        REQUIRE(parts_at(r, w, t, 40) == -1);
    }
}

TEST_CASE("through portable images into fresh worlds, sleepers stay asleep and wake alike") {
    const Recorded r = record();
    World walker = start();
    for (int t = 0; t < run_ticks; ++t) {
        if (t % 5 == 0) {
            World fresh = made(World::create(walker.def()));
            done(fresh.restore_portable(walker.save_portable()));
            REQUIRE(fresh.awake_count() == walker.awake_count());
            REQUIRE(parts_at(r, fresh, t, 70) == -1);
        }
        step(walker);
    }
}

TEST_CASE("sleep timers and islands are state: without them a restored world parts") {
    const Recorded r = record();
    for (const char* column : {"body.sleep", "sleeping_contact.memory"}) {
        INFO(std::string(column));
        bool parted = false;
        for (int t = 10; t < run_ticks && !parted; t += 10) {
            World w = start();
            w.restore(r.images[static_cast<std::size_t>(t)]);
            State& state = testing::state_of(w);
            for (std::uint32_t c = 0; c < state.layout().columns().size(); ++c)
                if (state.layout().columns()[c].name == column)
                    for (std::byte& b : state.edit_bytes(c)) b = std::byte{};
            // What was forgotten shows in the hash at once; what counts is that motion parts too.
            for (int i = 0; i < 60 && t + i < run_ticks && !parted; ++i) {
                World good = start();
                good.restore(r.images[static_cast<std::size_t>(t + i)]);
                for (BodyId body : good.bodies())
                    parted |= !w.is_alive(body) || w.pose(body) != good.pose(body) ||
                              w.is_awake(body) != good.is_awake(body);
                step(w);
            }
        }
        CHECK(parted);
    }
}

TEST_CASE("a hundred sleepers elsewhere change no bit of what is awake here") {
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
