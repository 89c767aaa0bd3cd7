// The scene "cars" is driven by its script for a while: everybody gets about, nobody leaves the world.
#include "lockstone/math/convert.h"
#include "scenes/scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdlib>
#include <vector>

using namespace lockstone;

TEST_CASE("four cars and a tank drive about for twenty seconds") {
    const auto game = make_scene("cars", {.players = 4});
    REQUIRE(game.ok());
    World world = (*game)->start().value();
    REQUIRE(world.vehicle_count() == 5);
    const int ticks = std::getenv("LOCKSTONE_LONG") != nullptr ? 6000 : 1200;
    std::vector<double> way(5);
    std::vector<std::vector<std::byte>> bytes(4, std::vector<std::byte>((*game)->input_size()));
    for (int t = 0; t < ticks; ++t) {
        std::vector<PlayerInput> inputs;
        for (std::uint32_t p = 0; p < 4; ++p) {
            scripted_input(**game, 7, world.tick_count(), p, bytes[p]);
            inputs.push_back({bytes[p], InputStatus::confirmed});
        }
        REQUIRE((*game)->advance(world, inputs).ok());
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
