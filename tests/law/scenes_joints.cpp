// What joints must not do in the built-in scenes: come apart, hand energy out, or reach the limits of speed.
#include "scenes/scenes.h"
#include "support/joint_scenes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

double energy_of(const World& w) {
    double sum = to_double(w.kinetic_energy());
    for (std::uint32_t row = 0; row < w.body_count(); ++row) {
        const BodyId b = w.body_at(row);
        if (w.kind(b) == BodyKind::dynamic) sum += to_double(w.mass(b)) * 9.81 * position(w, b)[1];
    }
    return sum;
}

double widest_gap(const World& w) {
    double widest = 0;
    for (std::uint32_t row = 0; row < w.joint_count(); ++row)
        widest = std::max(widest, length(offset_of(w, w.joint_at(row)).along));
    return widest;
}

/// Nothing drives these scenes: energy only falls, and the widest joint is narrower than `gap` [m].
std::string scene_fault(const char* name, std::uint32_t size, int ticks, double gap) {
    SceneOptions options;
    options.size = size;
    const auto game = made(make_scene(name, options));
    World w = made(game->start());
    double before = energy_of(w);
    for (int t = 0; t < ticks; ++t) {
        game->advance(w, {});
        const std::string when = std::string(name) + ", tick " + std::to_string(t) + ": ";
        const double now = energy_of(w), apart = widest_gap(w);
        if (now > 1.01 * before)
            return when + "energy grows from " + std::to_string(before) + " to " + std::to_string(now) + " J";
        if (apart > gap) return when + "a joint is apart by " + std::to_string(apart) + " m";
        if (w.faults().speed_clamped != 0) return when + "a speed was clamped";
        before = now;
    }
    return {};
}

} // namespace

TEST_CASE("the joints of bridges, chains and ragdolls hold, and hand out no energy") {
    CHECK(scene_fault("bridge", 40, 300, 0.001) == "");
    CHECK(scene_fault("wrecking-ball", 20, 400, 0.06) == "");
    CHECK(scene_fault("wrecking-ball", 30, 600, 0.06) == "");
    CHECK(scene_fault("ragdolls", 10, 200, 0.1) == "");
    CHECK(scene_fault("ragdolls", 20, 200, 0.2) ==
          ""); // a limb that is stopped on its way by the stairs is late by a tick
}

TEST_CASE("planted fault: joints that come apart by more than is asked are found") {
    CHECK(scene_fault("wrecking-ball", 20, 100, 0.001).find("a joint is apart") != std::string::npos);
}
