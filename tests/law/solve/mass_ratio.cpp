// The lightest bodies between the heaviest: a ratio of 10^12.
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <random>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// What is hit by something far heavier leaves at most twice as fast; 1 m/s for what pushes overlap out.
std::string flies_off(double light, double heavy, const Faults& faults) {
    const bool is_told = !(faults == Faults{});
    return light <= 2 * heavy + 1 || is_told
               ? ""
               : "leaves at " + std::to_string(light) + " m/s, and no fault is counted";
}

} // namespace

TEST_CASE("a body of 1 g between boxes of 10^9 kg does not fly off, or a fault is counted") {
    std::mt19937 random(5);
    const auto between = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random() % 4096) / 4096;
    };
    for (int i = 0; i < 40; ++i) {
        World w = made(World::create(small_def()));
        add_floor(w);
        const double half = between(0.3, 5), size = between(0.02, 1), x = between(-half, half);
        const auto cube = [](double h) { return box(real(h), real(h), real(h)); };
        add(w, {.pose = at(0, half, 0), .mass = Real(1000000000)}, {.geometry = cube(half)});
        const BodyId light =
            add(w, {.pose = at(x, 2 * half + size, 0, turned(axis_z, between(0, 90))), .mass = real(0.001)},
                {.geometry = i % 2 == 0 ? cube(size) : sphere(real(size))});
        const double above = between(0, 3), speed = between(0, 30);
        const BodyId heavy =
            add(w,
                {.pose = at(0.2, 3 * half + 2 * size + above, 0, turned(axis_x, between(0, 20))),
                 .linear_velocity = vec(0, -speed, 0),
                 .mass = Real(1000000000)},
                {.geometry = cube(half)});
        double light_max = 0, heavy_max = 0;
        for (int t = 0; t < 180; ++t) {
            w.tick();
            light_max = std::max(light_max, length(velocity(w, light)));
            heavy_max = std::max(heavy_max, length(velocity(w, heavy)));
        }
        INFO("try ", i);
        CHECK(flies_off(light_max, heavy_max, w.faults()) == "");
    }
}

TEST_CASE("planted fault: one that leaves at 300 m/s is noticed, unless a fault was counted") {
    Faults clamped{};
    clamped.impulse_clamped = 1;
    CHECK(flies_off(300, 9, Faults{}) != "");
    CHECK(flies_off(300, 9, clamped) == "");
}
