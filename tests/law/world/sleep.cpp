// Islands at rest fall asleep as a whole and wake as a whole; a tick does not change sleeping bodies.
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

BodyId crate_at(World& w, double x, double y, double z = 0) {
    return add(w, {.pose = at(x, y, z)}, {.geometry = box(real(0.5), real(0.5), real(0.5))});
}
void run(World& w, int ticks) {
    for (int i = 0; i < ticks; ++i) w.tick();
}
std::size_t events_of(const World& w, EventKind kind, BodyId body) {
    return static_cast<std::size_t>(std::ranges::count_if(
        w.events(), [&](const Event& e) { return e.kind == kind && e.body_a == body; }));
}
/// Ticks until the body sleeps, at most `limit`.
int ticks_to_sleep(World& w, BodyId body, int limit) {
    int ticks = 0;
    while (w.is_awake(body) && ticks < limit) w.tick(), ++ticks;
    return ticks;
}

/// Returns after how many ticks a ball on an undamped spring sleeps, at most 45.
int ticks_of_swing(double frequency, double amplitude) {
    World w = made(World::create(weightless(drowsy_def())));
    const BodyId anchor =
        add(w, {.kind = BodyKind::static_, .pose = at(0, 0, 0)}, {.geometry = sphere(real(0.1))});
    const BodyId ball = add(w, {.pose = at(2 + amplitude, 0, 0)}, {.geometry = sphere(real(0.5))});
    JointDef spring = spring_joint(real(2), real(frequency), Real{});
    spring.body_a = anchor, spring.body_b = ball;
    made(w.create_joint(spring));
    return ticks_to_sleep(w, ball, 45);
}

} // namespace

TEST_CASE("a box at rest sleeps after the sleep time with one event and then keeps every bit of its pose") {
    World w = made(World::create(drowsy_def()));
    add_floor(w);
    const BodyId crate = crate_at(w, 0, 0.5);
    std::size_t slept = 0;
    int ticks = 0;
    for (; w.is_awake(crate) && ticks < 200; ++ticks)
        w.tick(), slept += events_of(w, EventKind::body_sleep, crate);
    CHECK(ticks >= 30);
    CHECK(ticks < 60);
    CHECK(slept == 1);
    CHECK(w.awake_count() == 0);
    CHECK(w.linear_velocity(crate) == Vec3{});
    const Transform before = w.pose(crate);
    run(w, 100);
    CHECK(w.pose(crate) == before);
    CHECK(w.events().empty());
}

TEST_CASE("bodies do not sleep in a world without sleeping or while they move") {
    WorldDef def = drowsy_def();
    def.sleeping = 0;
    World sleepless = made(World::create(def));
    add_floor(sleepless);
    const BodyId crate = crate_at(sleepless, 0, 0.5);
    run(sleepless, 300);
    CHECK(sleepless.is_awake(crate));

    World w = made(World::create(weightless(drowsy_def())));
    const BodyId drifting =
        add(w, {.pose = at(0, 0, 0), .linear_velocity = vec(0.06, 0, 0)}, {.geometry = sphere(real(0.5))});
    const BodyId turning =
        add(w, {.pose = at(5, 0, 0), .angular_velocity = vec(0, 0.2, 0)}, {.geometry = sphere(real(0.5))});
    const BodyId still = add(w, {.pose = at(9, 0, 0)}, {.geometry = sphere(real(0.5))});
    run(w, 300);
    CHECK(w.is_awake(drifting));
    CHECK(w.is_awake(turning));
    CHECK(!w.is_awake(still));
}

TEST_CASE("a body that swings sleeps unless it is fast or swings as far as the sleep speed goes in the sleep "
          "time") {
    CHECK(ticks_of_swing(2, 0.006) <= 40); // at most 75 mm/s, 12 mm from one end to the other
    // 113 mm/s, but always 20 mm from the place where its measure started
    CHECK(ticks_of_swing(0.9, 0.02) == 45);
    CHECK(ticks_of_swing(4, 0.006) == 45); // 150 mm/s
}

TEST_CASE("an island sleeps and wakes as a whole and its neighbour stays asleep") {
    World w = made(World::create(drowsy_def()));
    add_floor(w);
    std::vector<BodyId> tower, other;
    for (int i = 0; i < 4; ++i) tower.push_back(crate_at(w, 0, 0.5 + i));
    for (int i = 0; i < 3; ++i) other.push_back(crate_at(w, 4, 0.5 + i));
    run(w, 90);
    REQUIRE(w.awake_count() == 0);
    done(w.add_impulse(tower[3], vec(0, 10, 0)));
    CHECK(w.is_awake(tower[0])); // at once, by the command
    w.tick();
    for (BodyId b : tower) {
        CHECK(w.is_awake(b));
        CHECK(events_of(w, EventKind::body_wake, b) == 1);
    }
    for (BodyId b : other) CHECK(!w.is_awake(b));
    w.tick();
    CHECK(events_of(w, EventKind::body_wake, tower[0]) == 0);
    CHECK(ticks_to_sleep(w, tower[0], 200) < 200);
}

TEST_CASE("a body that falls on a sleeper wakes it in the tick of the touch and it moves as if it had never "
          "slept") {
    WorldDef sleepless_def = drowsy_def();
    sleepless_def.sleeping = 0;
    const auto start = [](const WorldDef& def) {
        World w = made(World::create(def));
        add_floor(w);
        add(w, {.pose = at(0, 0.5, 0), .user_key = 1}, {.geometry = box(real(0.5), real(0.5), real(0.5))});
        return w;
    };
    World w = start(drowsy_def()), sleepless = start(sleepless_def);
    run(w, 60), run(sleepless, 60);
    const BodyId crate = [&] {
        for (BodyId b : w.bodies())
            if (w.user_key(b) == 1) return b;
        return BodyId{};
    }();
    REQUIRE(!w.is_awake(crate));
    for (World* each : {&w, &sleepless})
        add(*each, {.pose = at(0.2, 3, 0), .linear_velocity = vec(0, -6, 0)},
            {.geometry = sphere(real(0.4))});
    int woken_at = -1;
    for (int i = 0; i < 60; ++i) {
        w.tick(), sleepless.tick();
        if (woken_at < 0 && w.is_awake(crate)) woken_at = i;
    }
    CHECK(woken_at > 10);
    const Vec3 off = w.pose(crate).position - sleepless.pose(crate).position;
    CHECK(length(off) < real(0.01)); // sleep removed a velocity below 0.05 m/s
}

TEST_CASE(
    "a joint and a kinematic body that starts and a floor that is destroyed wake the bodies that they hold") {
    World w = made(World::create(drowsy_def()));
    const BodyId floor = add_floor(w);
    const BodyId lift = add(w, {.kind = BodyKind::kinematic, .pose = at(-4, 0.25, 0)},
                            {.geometry = box(real(1), real(0.25), real(1))});
    const BodyId rider = crate_at(w, -4, 1.0);
    const BodyId a = crate_at(w, 3, 0.5), b = crate_at(w, 6, 0.5);
    const JointId rope = made(w.create_joint(rope_joint(real(4)), a, b, at(4.5, 0.5, 0)));
    run(w, 90);
    REQUIRE(w.awake_count() == 0);

    done(w.set_velocity(lift, vec(0, 0.02, 0), vec(0, 0, 0)));
    CHECK(w.is_awake(rider));
    run(w, 120);
    CHECK(w.is_awake(rider)); // slower than the sleep speed, but on a moving lift
    done(w.set_velocity(lift, vec(0, 0, 0), vec(0, 0, 0)));
    run(w, 60);
    CHECK(!w.is_awake(rider));

    done(w.add_impulse(a, vec(0, 5, 0)));
    CHECK(w.is_awake(b)); // joined bodies sleep and wake together
    run(w, 90);
    CHECK(!w.is_awake(a));
    done(w.destroy(rope));
    CHECK(w.is_awake(a));
    run(w, 90);
    REQUIRE(w.awake_count() == 0);

    done(w.destroy(floor));
    CHECK(w.is_awake(a));
    CHECK(w.is_awake(b));
    run(w, 30);
    CHECK(w.pose(a).position.y < real(0));
    CHECK(w.pose(rider).position.y > real(0.5)); // still on the lift
}

TEST_CASE(
    "changes of gravity or fields or filters or materials or shapes or static bodies wake affected bodies") {
    const auto woken_by = [](auto&& command) {
        World w = made(World::create(drowsy_def()));
        const BodyId floor = add_floor(w);
        const BodyId crate = crate_at(w, 0, 0.5);
        const BodyId far = crate_at(w, 20, 0.5);
        run(w, 90);
        REQUIRE(w.awake_count() == 0);
        command(w, floor, crate);
        const bool at_once = w.is_awake(crate);
        w.tick();
        return std::tuple(at_once, w.is_awake(crate), w.is_awake(far));
    };
    using Woken = std::tuple<bool, bool, bool>;
    CHECK(woken_by([](World& w, BodyId, BodyId) { done(w.set_gravity(vec(1, -9, 0))); }) ==
          Woken{true, true, true});
    CHECK(woken_by([](World& w, BodyId, BodyId) { made(w.create_field({.strength = Real(1)})); }) ==
          Woken{true, true, true});
    CHECK(woken_by([](World& w, BodyId, BodyId c) {
              done(w.set_filter({w.shapes(c)[0], 2, 2, 0}));
          }) == Woken{true, true, false});
    CHECK(woken_by([](World& w, BodyId f, BodyId) {
              done(w.set_material({w.shapes(f)[0], Real(0), Real(0), Real(0), {}}));
          }) == Woken{true, true, true}); // both rest on it
    CHECK(woken_by([](World& w, BodyId, BodyId c) { done(w.set_pose(c, at(0, 2, 0))); }) ==
          Woken{true, true, false});
    CHECK(woken_by([](World& w, BodyId f, BodyId c) { done(w.set_pair_filter(f, c, false)); }) ==
          Woken{true, true, true});
    CHECK(woken_by([](World& w, BodyId, BodyId c) { done(w.wake_body(c)); }) == Woken{true, true, false});
    // A wall that appears inside a sleeper wakes it when the next tick finds their overlap. A wall that appears
    // elsewhere does not.
    CHECK(woken_by([](World& w, BodyId, BodyId) { add_wall(w, at(0.7, 0.5, 0), vec(0.3, 0.5, 0.5)); }) ==
          Woken{false, true, false});
    CHECK(woken_by([](World& w, BodyId, BodyId) { add_wall(w, at(8, 0.5, 0), vec(0.3, 0.5, 0.5)); }) ==
          Woken{false, false, false});
}

TEST_CASE("an awake body that comes near without a touch does not wake a sleeper") {
    World w = made(World::create(drowsy_def()));
    add_floor(w);
    const BodyId crate = crate_at(w, 0, 0.5);
    run(w, 90);
    REQUIRE(!w.is_awake(crate));
    add(w, {.pose = at(-6, 0.5, 1.2), .linear_velocity = vec(4, 0, 0)}, {.geometry = sphere(real(0.5))});
    run(w, 120);
    CHECK(!w.is_awake(crate));
    add(w, {.pose = at(-6, 0.5, 0.3), .linear_velocity = vec(4, 0, 0)}, {.geometry = sphere(real(0.5))});
    run(w, 120);
    CHECK(w.pose(crate).position.x > real(0.01));
}

TEST_CASE("contacts of sleepers are kept so that a tower wakes upright without a begin or end event") {
    World w = made(World::create(drowsy_def()));
    add_floor(w);
    std::vector<BodyId> tower;
    for (int i = 0; i < 6; ++i) tower.push_back(crate_at(w, 0, 0.5 + i));
    run(w, 90);
    REQUIRE(w.awake_count() == 0);
    std::size_t touches = 0;
    const double top = to_double(w.pose(tower[5]).position.y);
    for (int round = 0; round < 5; ++round) {
        done(w.wake_body(tower[0]));
        for (int i = 0; i < 45; ++i) {
            w.tick();
            for (const Event& e : w.events()) touches += e.kind <= EventKind::contact_end ? 1 : 0;
        }
        CHECK(!w.is_awake(tower[0]));
    }
    CHECK(touches == 0);
    CHECK(std::abs(to_double(w.pose(tower[5]).position.y) - top) < 1e-5);
}

namespace {

BodyId sleeper_at(World& w, double x, double y, std::uint32_t awake = 0) {
    return add(w, {.pose = at(x, y, 0), .awake = awake}, {.geometry = box(real(0.5), real(0.5), real(0.5))});
}

/// Returns an error sentence unless the body, which hangs in the air, sleeps there.
std::string sleeper_fault(World& w, BodyId body) {
    const Transform before = w.pose(body);
    for (int i = 0; i < 100; ++i) {
        w.tick();
        if (!w.events().empty()) return "there is an event";
    }
    if (w.is_awake(body) || w.awake_count() != 0) return "it is awake";
    return w.pose(body) == before ? "" : "it has moved";
}

} // namespace

TEST_CASE("a body that is created asleep keeps still with its shapes and is part of casts and images") {
    World w = made(World::create(drowsy_def()));
    const BodyId crate = sleeper_at(w, 0, 5);
    made(w.create_shape(crate, {.geometry = sphere(real(0.25)), .local = at(1, 0, 0)}));
    CHECK(!w.is_awake(crate));
    CHECK(w.body(crate).awake == 0);
    CHECK(w.mass(crate) > Real(1000)); // of both shapes
    CHECK(sleeper_fault(w, crate) == "");
    const auto hit = w.cast_ray({vec(0, 9, 0), vec(0, -9, 0)});
    REQUIRE(hit);
    CHECK(hit->body == crate);
    World other = made(World::create(drowsy_def()));
    done(other.restore_portable(w.save_portable()));
    CHECK(difference(w, other) == "");
    CHECK(sleeper_fault(other, crate) == "");
}

TEST_CASE("planted: the test detects a body that starts awake and a body that was woken") {
    World w = made(World::create(drowsy_def()));
    CHECK(sleeper_fault(w, sleeper_at(w, 0, 5, 1)) == "it is awake");
    World woken = made(World::create(drowsy_def()));
    const BodyId crate = sleeper_at(woken, 0, 5);
    done(woken.wake_body(crate));
    CHECK(sleeper_fault(woken, crate) == "there is an event");
}

TEST_CASE("a ball wakes a pile that was created asleep from body to body and the pile then behaves like any "
          "other") {
    World w = made(World::create(drowsy_def()));
    add_floor(w);
    std::vector<BodyId> pile;
    for (int i = 0; i < 3; ++i) pile.push_back(sleeper_at(w, 0, 0.5 + i));
    run(w, 10);
    CHECK(w.awake_count() == 0);
    add(w, {.pose = at(0, 4, 0), .linear_velocity = vec(0, -2, 0)}, {.geometry = sphere(real(0.25))});
    std::size_t woken = 0;
    for (int i = 0; i < 60; ++i) {
        w.tick();
        for (const BodyId body : pile) woken += events_of(w, EventKind::body_wake, body);
    }
    CHECK(woken == 3);
    for (std::size_t i = 0; i < pile.size(); ++i)
        CHECK(abs(w.pose(pile[i]).position.y - real(0.5 + static_cast<double>(i))) < real(0.02));
    run(w, 300);
    CHECK(w.awake_count() == 0);
    made(w.create_shape(pile[0], {.geometry = sphere(real(0.5))})); // it has been awake: a new shape wakes it
    CHECK(w.is_awake(pile[0]));
}

TEST_CASE("only a dynamic body without velocity in a world with sleeping starts asleep") {
    World w = made(World::create(drowsy_def()));
    for (const BodyDef& moving : {BodyDef{.linear_velocity = vec(0, 1, 0), .awake = 0},
                                  BodyDef{.angular_velocity = vec(0, 0, 1), .awake = 0}})
        CHECK(w.create_body(moving).error().message == "create_body: awake is 0, but linear_velocity or "
                                                       "angular_velocity is not: what sleeps does not move");
    CHECK(w.create_body({.awake = 2}).error().message == "create_body: awake is 2, must be 0 or 1");
    const BodyId drifting =
        made(w.create_body({.kind = BodyKind::kinematic, .linear_velocity = vec(1, 0, 0), .awake = 0}));
    run(w, 60);
    CHECK(w.pose(drifting).position.x > real(0.9));
    CHECK(w.body(drifting).awake == 1);
    const BodyId pushed = sleeper_at(w, 0, 50);
    done(w.add_impulse(pushed, vec(1000, 0, 0)));
    CHECK(w.is_awake(pushed));
    World sleepless = made(World::create(small_def()));
    REQUIRE(sleepless.def().sleeping == 0);
    CHECK(sleepless.is_awake(sleeper_at(sleepless, 0, 5)));
}
