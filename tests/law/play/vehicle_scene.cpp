// The script drives the scene "cars" for a while: every player moves, and no player leaves the world.
#include "lockstone/math/convert.h"
#include "support/effort.h"
#include "support/scripted_inputs.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

using namespace lockstone;

TEST_CASE("four cars and a tank drive for twenty seconds and do not leave the world" *
          doctest::skip(lockstone::test::is_small_sample())) {
    const auto game = make_scene("cars", {.players = 4});
    REQUIRE(game.ok());
    World world = (*game)->start().value();
    REQUIRE(world.vehicle_count() == 5);
    const int ticks = std::getenv("LOCKSTONE_LONG") != nullptr ? 6000 : 1200;
    std::vector<double> way(5);
    test::ScriptedInputs inputs(**game, 7);
    for (int t = 0; t < ticks; ++t) {
        REQUIRE((*game)->advance(world, inputs.at(world.tick_count())).ok());
        for (std::uint32_t row = 0; row < 5; ++row) {
            const BodyId body = world.vehicle(world.vehicle_at(row)).chassis;
            const auto v = to_double(world.linear_velocity(body)), at = to_double(world.pose(body).position);
            way[row] += std::sqrt(v[0] * v[0] + v[2] * v[2]) / 60;
            REQUIRE(std::abs(at[0]) < 64);
            REQUIRE(std::abs(at[2]) < 64);
            REQUIRE(at[1] > -1);
            REQUIRE(at[1] < 12);
        }
    }
    for (const double metres : way) CHECK(metres > 15);
    CHECK(world.faults() == Faults{});
}
