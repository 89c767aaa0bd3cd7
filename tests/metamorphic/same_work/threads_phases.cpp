// Phases that the built-in scenes hardly share among workers: hundreds of fast bodies, vehicles on common ground, trees
// of joints that hang on one moving body.
#include "support/task_worlds.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;
using namespace lockstone::test::scene;

namespace {

/// Shots through a hall of thin walls and sweeping plates. Every fifth shot is a bullet.
World volley(bool continuous = true) {
    WorldDef def = small_def();
    def.bodies_max = def.shapes_max = 256, def.contacts_max = 4096;
    def.continuous = continuous ? 1 : 0;
    World w = made(World::create(def));
    add_floor(w);
    for (int i = 0; i < 8; ++i) {
        add_wall(w, at(6.0 * i, 3, 0), vec(0.02, 3, 20));
        add(w,
            {.kind = BodyKind::kinematic,
             .pose = at(6.0 * i + 3, 2, 0),
             .linear_velocity = vec(0, 0, i % 2 == 0 ? 20 : -20),
             .angular_velocity = vec(0, 6, 0)},
            {.geometry = box(real(1.5), real(1), real(0.02))});
    }
    for (int i = 0; i < 160; ++i) {
        const Vec3 way = vec(60 + i % 7 * 20, 3 - i % 5, i % 11 * 4 - 20);
        add(w,
            {.pose = at(-3.0 + 6 * (i % 8), 1 + i / 40, i % 40 * 0.9 - 18),
             .linear_velocity = way,
             .bullet = i % 5 == 0 ? 1u : 0u},
            {.geometry = i % 3 == 0 ? box(real(0.1), real(0.15), real(0.1)) : sphere(real(0.15))});
    }
    return w;
}

struct Motorcade {
    World w;
    std::vector<BodyId> alone, rafting;
};
/// Cars on the floor, and pairs of cars on rafts that slide on it.
Motorcade motorcade(bool last_first = false) {
    WorldDef def = small_def();
    def.bodies_max = def.shapes_max = 64, def.contacts_max = 1024;
    Motorcade m{made(World::create(def)), {}, {}};
    add_floor(m.w);
    const auto add_chassis = [&](double x, double y, double z) {
        return add(m.w, {.pose = at(x, y, z), .mass = real(1200)},
                   {.geometry = box(real(0.8), real(0.3), real(2))});
    };
    for (int i = 0; i < 6; ++i) m.alone.push_back(add_chassis(6.0 * i, 0.8, 0));
    for (int i = 0; i < 4; ++i) {
        add(m.w, {.pose = at(9.0 * i, 0.2, 20), .mass = real(900)},
            {.geometry = box(real(3), real(0.2), real(6)), .friction = real(0.1)});
        for (double side : {-1.5, 1.5}) m.rafting.push_back(add_chassis(9.0 * i + side, 1.2, 20));
    }
    std::vector<BodyId> all = m.alone;
    all.insert(all.end(), m.rafting.begin(), m.rafting.end());
    if (last_first) std::reverse(all.begin(), all.end());
    for (BodyId chassis : all) {
        const VehicleId id = made(m.w.create_vehicle(four_wheels(chassis, {0.75_r, -0.3_r, 1.4_r})));
        const Real steer = real(0.1 * static_cast<double>(chassis.index % 5) - 0.2);
        done(m.w.set_vehicle_input(id, {.throttle = 1_r, .steer = steer, .gear = 1}));
    }
    return m;
}

/// Chains of six links: half of them on one moving kinematic beam, half on the world. Every third chain ends in a
/// spinning wheel.
World curtain() {
    WorldDef def = small_def();
    def.bodies_max = def.shapes_max = 256, def.joints_max = 256, def.contacts_max = 4096;
    World w = made(World::create(def));
    const BodyId beam = add(w,
                            {.kind = BodyKind::kinematic,
                             .pose = at(7, 6, 0),
                             .linear_velocity = vec(1, 0.5, 0),
                             .angular_velocity = vec(0, 0.5, 0)},
                            {.geometry = box(real(8), real(0.1), real(0.1))});
    for (int i = 0; i < 16; ++i) {
        BodyId before = i % 2 == 0 ? beam : BodyId{};
        for (int k = 0; k < 6; ++k) {
            const BodyId link =
                add(w, {.pose = at(i, 5.8 - 0.4 * k, 0), .linear_velocity = vec(0.1 * i, 0, 0.2 * k)},
                    {.geometry = capsule(real(0.05), real(0.12)), .group = -1});
            const JointDef kind = k % 2 == 0 ? ball_joint() : hinge_joint();
            const Transform place = at(i, 6 - 0.4 * k, 0);
            made(before ? w.create_joint(kind, before, link, place) : w.create_joint(kind, {}, link, place));
            before = link;
        }
        if (i % 3 != 0) continue;
        const BodyId wheel = add(w, {.pose = at(i, 3.5, 0), .angular_velocity = vec(0, 40, 1)},
                                 {.geometry = cylinder(real(0.2), real(0.03)), .group = -1});
        made(w.create_joint(ball_joint(), before, wheel, at(i, 3.6, 0)));
    }
    return w;
}

std::string departure(const World& start, std::span<Tasks* const> tasks, int ticks) {
    return first_departure(start, tasks, ticks, [](World& w, Tasks*) { w.tick(); });
}

/// Runs tasks that leave an item out, twelve times. Returns how many of these runs the test detects.
int noticed(const World& start, int ticks) {
    FaultyTasks sound(FaultyTasks::Fault::leaves_out, ~std::uint64_t{0});
    REQUIRE(departure(start, std::array<Tasks*, 1>{&sound}, ticks) == "");
    int found = 0;
    for (std::uint64_t run = sound.runs / 2; run < sound.runs / 2 + 12; ++run) {
        FaultyTasks leaves_out(FaultyTasks::Fault::leaves_out, run);
        found += departure(start, std::array<Tasks*, 1>{&leaves_out}, ticks) != "" ? 1 : 0;
    }
    return found;
}

} // namespace

TEST_CASE("a hundred and sixty fast bodies stop at the same places on any workers") {
    ShuffledTasks shuffled(3), many(4, 64);
    UnsteadyTasks three(3, 5);
    CHECK(departure(volley(), std::array<Tasks*, 2>{&shuffled, &many}, 12) == "");
    CHECK(departure(volley(), std::array<Tasks*, 1>{&three}, 2) == "");
    World swept = volley(), passing = volley(false);
    int stopped = 0;
    for (int t = 0; t < 2; ++t) swept.tick(), passing.tick();
    for (BodyId b : swept.bodies()) stopped += swept.pose(b) != passing.pose(b) ? 1 : 0;
    CHECK(stopped > 40);
}

TEST_CASE("vehicles alone and on common ground drive alike on any workers") {
    ShuffledTasks shuffled(3), many(4, 64);
    UnsteadyTasks three(3, 5);
    const Motorcade start = motorcade();
    CHECK(departure(start.w, std::array<Tasks*, 2>{&shuffled, &many}, 60) == "");
    CHECK(departure(start.w, std::array<Tasks*, 1>{&three}, 2) == "");
}

TEST_CASE(
    "vehicles that share nothing do not depend on their order of creation and vehicles on one raft do") {
    Motorcade m = motorcade(), reversed = motorcade(true);
    for (int t = 0; t < 90; ++t) m.w.tick(), reversed.w.tick();
    for (BodyId b : m.alone) CHECK(m.w.pose(b) == reversed.w.pose(b));
    int differ = 0;
    for (BodyId b : m.rafting) differ += m.w.pose(b) != reversed.w.pose(b) ? 1 : 0;
    CHECK(differ > 0);
}

TEST_CASE("chains on one moving beam swing alike on any workers") {
    ShuffledTasks shuffled(3), many(4, 64);
    UnsteadyTasks three(3, 5);
    const World start = curtain();
    CHECK(departure(start, std::array<Tasks*, 2>{&shuffled, &many}, 40) == "");
    CHECK(departure(start, std::array<Tasks*, 1>{&three}, 2) == "");
}

TEST_CASE("planted fault: the check finds fast bodies or vehicles or chains that a worker leaves out") {
    CHECK(noticed(curtain(), 6) >= 2);
    CHECK(noticed(volley(), 6) >= 2);
    CHECK(noticed(motorcade().w, 20) >= 2);
}
