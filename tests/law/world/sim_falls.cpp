// A slab that falls over its edge, compared with the equivalent pendulum.
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <cstdio>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double height = 1, thickness = 0.12, g = 9.81;

enum class Ground { plane, static_box, heavy_box };

/// The angle from upright of an inverted pendulum with the slab's moment about its edge, pushed at 1 rad/s [rad].
double exact(double seconds) {
    const double moment = (height * height + thickness * thickness) / 3;
    double angle = 0, rate = 1;
    constexpr double h = 1e-5;
    for (int i = 0; i < static_cast<int>(seconds / h); ++i) {
        rate += h * g / 2 * (height * std::sin(angle) - thickness * std::cos(angle)) / moment;
        angle += h * rate;
    }
    return angle;
}

/// The angle of a slab on the ground after 20 ticks [rad]. Without friction its foot slips.
double fallen(Ground kind, double friction) {
    World w = made(World::create(small_def()));
    double top = 0;
    if (kind == Ground::plane)
        add_floor(w, {.friction = real(friction)});
    else {
        top = 1;
        const bool heavy = kind == Ground::heavy_box;
        if (heavy) add_floor(w);
        add(w,
            {.kind = heavy ? BodyKind::dynamic : BodyKind::static_,
             .pose = at(0, 0.5, 0),
             .mass = heavy ? 100000_r : Real{}},
            {.geometry = box(4_r, 0.5_r, 4_r), .friction = real(friction)});
    }
    const BodyId slab =
        add(w,
            {.pose = at(0, top + height / 2, 0),
             .linear_velocity = vec(height / 2, thickness / 2, 0),
             .angular_velocity = vec(0, 0, -1)},
            {.geometry = box(real(thickness / 2), real(height / 2), 0.25_r), .friction = real(friction)});
    for (int t = 0; t < 20; ++t) w.tick();
    const std::array<double, 4> q = to_double(w.pose(slab).rotation);
    return -2 * std::atan2(q[2], q[3]);
}

} // namespace

TEST_CASE("a slab that tips over its edge falls as fast as a pendulum") {
    const double should = exact(20.0 / 60);
    for (Ground kind : {Ground::plane, Ground::static_box, Ground::heavy_box}) {
        CAPTURE(static_cast<int>(kind));
        const double is = fallen(kind, 1), planted = fallen(kind, 0);
        std::printf("  a slab after 20 ticks: %.4f rad (%.4f), on ice %.4f\n", is, should, planted);
        // with the levers of the start of each tick it would be 0.0073 behind
        CHECK(std::abs(is - should) < 0.001);
        CHECK_FALSE(std::abs(planted - should) < 0.001);
    }
}
