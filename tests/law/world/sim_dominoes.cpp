// A wave of dominoes has the same speed for every number of substeps.
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <cstdio>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr int count = 30;
constexpr double height = 1, thickness = 0.12, pitch = 0.45, leaning = 0.15; // `leaning` is in radians

/// Returns the time when each of 30 dominoes leans by 0.15 rad [ticks], linear between two ticks; 0: it never does.
std::vector<double> falls(std::uint32_t substeps, double friction) {
    WorldDef def = small_def();
    def.substeps = substeps;
    World w = made(World::create(def));
    add_floor(w, {.friction = real(0.81 / friction)}); // the geometric mean of a pair holds the feet
    std::vector<BodyId> dominoes;
    for (int i = 0; i < count; ++i) {
        BodyDef body{.pose = at(pitch * i, height / 2, 0)};
        if (i == 0) {
            body.angular_velocity = vec(0, 0, -1);
            body.linear_velocity = vec(height / 2, thickness / 2, 0);
        }
        dominoes.push_back(add(w, body,
                               {.geometry = box(real(thickness / 2), real(height / 2), real(0.25)),
                                .density = real(600),
                                .friction = real(friction)}));
    }
    std::vector<double> when(count), last(count);
    for (int t = 1; t < 240; ++t) {
        w.tick();
        for (std::size_t i = 0; i < count; ++i) {
            const double lean = -2 * std::asin(to_double(w.pose(dominoes[i]).rotation.z));
            if (when[i] == 0 && lean >= leaning) when[i] = t - (lean - leaning) / (lean - last[i]);
            last[i] = lean;
        }
    }
    return when;
}

/// Speed of the wave over its second half [m/s]; 0: the wave does not arrive.
double wave_speed(std::uint32_t substeps, double friction = 0.25) {
    const std::vector<double> when = falls(substeps, friction);
    const double ticks = when[count - 2] - when[count / 2];
    return ticks > 0 ? pitch * (count - 2 - count / 2) / ticks * 60 : 0;
}

} // namespace

TEST_CASE("a wave of dominoes moves as fast with 16 substeps as with 4") {
    const double coarse = wave_speed(4), fine = wave_speed(16), smooth = wave_speed(16, 0.21);
    std::printf("  wave of dominoes: %.4f m/s with 4 substeps, %.4f with 16; smoother ones %.4f\n", coarse,
                fine, smooth);
    REQUIRE(smooth > 0);
    CHECK(std::abs(fine / coarse - 1) < 0.02);
    CHECK_FALSE(std::abs(smooth / coarse - 1) < 0.02); // planted: other dominoes
}
