// The scene of the thesis' figures 1 to 4, as a sequence of events.
#include "scenes/scenes.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

namespace lockstone::test {
namespace {

//        fig. 1            fig. 2              fig. 3             fig. 4
//          [2]
//                                               [2] ^
//          [1]          [1][2] v                      [1] v      [1]   [2]
//      -----------     ---^--------       ----------------     -----------
struct Hit {
    std::string who; ///< "1-ground", "1-2", "2-ground"
    std::uint64_t tick;
};

std::string actor(const World& world, BodyId body) {
    const Look look = look_of(world.user_key(body));
    return look.role == Role::terrain ? "ground" : std::to_string(look.number + 1);
}

std::vector<Hit> hits_of(const Game& game, World& world, std::uint64_t ticks) {
    std::vector<Hit> hits;
    while (world.tick_count() < ticks) {
        REQUIRE(game.advance(world, {}).ok());
        for (const Event& e : world.events()) {
            if (e.kind != EventKind::contact_begin) continue;
            std::string a = actor(world, e.body_a), b = actor(world, e.body_b);
            if (b < a) std::swap(a, b);
            hits.push_back({a + "-" + b, e.tick});
        }
    }
    return hits;
}

std::uint64_t tick_of(const std::vector<Hit>& hits, const std::string& who, std::uint64_t after) {
    for (const Hit& hit : hits)
        if (hit.who == who && hit.tick > after) return hit.tick;
    return ~std::uint64_t{0};
}

} // namespace

TEST_CASE("two blocks fall and meet above the ground and bounce apart and land again and settle") {
    const auto game = std::move(make_scene("two-blocks")).value();
    World world = game->start().value();
    const std::vector<Hit> hits = hits_of(*game, world, 600);
    for (const Hit& hit : hits) INFO(hit.tick, " ", hit.who);

    REQUIRE_FALSE(hits.empty());
    CHECK(hits[0].who == "1-ground"); // figure 2: the first block bounces off the ground
    const std::uint64_t meeting = tick_of(hits, "1-2", hits[0].tick);
    CHECK(meeting < 120);
    CHECK(tick_of(hits, "2-ground", 0) > meeting); // figure 3: the second block turns back in the air
    CHECK(tick_of(hits, "1-ground", meeting) != ~std::uint64_t{0}); // figure 4: both land again
    CHECK(tick_of(hits, "2-ground", meeting) != ~std::uint64_t{0});
    CHECK(world.kinetic_energy() < 0.001_r); // and settle
}

} // namespace lockstone::test
