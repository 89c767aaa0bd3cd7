// Laws over objects of any proportion: a falling object gains no energy, and comes to rest on the floor.
#include "law/zoo/object.h"
#include "support/effort.h"
#include "support/rigs/stopped_fall.h"
#include "support/rigs/sunk_hull.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>

using namespace lockstone;
using namespace lockstone::zoo;
using namespace lockstone::test;

TEST_CASE("objects of any proportion gain no energy in any fall") {
    const int count = is_long_run() ? 100'000 : tries(300);
    int faults = 0;
    for (int seed = 1; seed <= count; ++seed) {
        const Drop drop = draw_drop(static_cast<std::uint64_t>(seed));
        const std::string fault = energy_fault(drop, play(drop));
        if (fault.empty()) continue;
        ++faults;
        MESSAGE(drop.about(), ": ", fault);
    }
    CHECK(faults <= count / 20'000); // pushing out a depth of metres at 30 Hz adds energy
}

TEST_CASE("a prism whose sides are flat to micrometres comes to rest on every floor and sleeps") {
    const int count = is_long_run() ? 20'000 : tries(140);
    for (int seed = 1; seed <= count; ++seed) {
        const Drop drop = draw_flat_prism(static_cast<std::uint64_t>(seed));
        const Outcome out = play(drop);
        INFO(drop.about());
        CHECK(energy_fault(drop, out) == "");
        CHECK(rest_fault(drop, out) == "");
    }
}

TEST_CASE("a ball that the sweep stops has the speed of the distance that it fell") {
    for (int seed = 1; seed <= tries(300); ++seed)
        CHECK(stopped_fall_fault(static_cast<std::uint64_t>(seed)) == "");
}

TEST_CASE("a hull in a floor has a contact point as deep as its deepest corner") {
    const int count = is_long_run() ? 100'000 : tries(400);
    for (int seed = 1; seed <= count; ++seed) CHECK(sunk_hull_fault(static_cast<std::uint64_t>(seed)) == "");
}

TEST_CASE("a beam of any length that falls onto its edge rolls onto a side and sleeps") {
    for (const bool precise : {false, true})
        for (const double length : {0.15, 0.5, 1.0, 2.0, 3.0, 4.4, 8.0, 15.0})
            for (const double yaw : {0.0, 17.0})
                for (const double friction : {0.2, 0.6})
                    CHECK(beam_fault({length, yaw, friction, precise}) == "");
}

TEST_CASE("a pole that falls from 6 m never rises above its start") {
    const auto highest = [](const Geometry& pole, double size, std::uint64_t seed, const WorldDef& def) {
        SplitMix random(seed);
        World w = World::create(def).value();
        scene::add_floor(w);
        const auto part = [&] { return 2.0 * static_cast<double>(random.below(1000)) / 999 - 1; };
        const Quat turn =
            normalized(scene::turned(scene::axis_z, 90 * part()) * scene::turned(scene::axis_x, 90 * part()));
        const BodyId body = scene::add(w, {.pose = scene::at(0, 6 + size, 0, turn)}, {.geometry = pole});
        double most = 0;
        for (int t = 0; t < 400; ++t) w.tick(), most = std::max(most, scene::position(w, body)[1] - 6 - size);
        return most;
    };
    for (const bool precise : {false, true})
        for (std::uint64_t seed = 1; seed <= 12; ++seed) {
            CAPTURE(seed);
            const WorldDef def = precise ? WorldDef::precise() : WorldDef{};
            CHECK(highest(capsule(0.005_r, 2.5_r), 2.5, seed, def) <= 0);
            CHECK(highest(box(1_r, 0.013_r, 0.013_r), 1, seed, def) <= 0);
            CHECK(highest(cylinder(0.004_r, 0.4_r), 0.4, seed, def) <= 0);
        }
}
