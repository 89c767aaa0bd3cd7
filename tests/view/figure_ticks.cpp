// The moments of the four pictures have the properties that their captions claim, by the world's contacts, heights and
// speeds. A run without such moments is refused.
#include "view/figure_ticks.h"
#include "scenes/scenes.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

using namespace lockstone;
using namespace lockstone::demo;
using namespace lockstone::test::scene;

namespace {

/// A run of two blocks, which can restart any number of times.
struct Run {
    std::function<World()> start;
    std::function<void(World&)> tick = [](World& world) { world.tick(); };

    World at(std::uint64_t time) const {
        World world = start();
        while (world.tick_count() < time) tick(world);
        return world;
    }
    Result<FigureTicks> figures(std::uint64_t ticks) const {
        World world = start();
        Result<FigureFinder> finder = FigureFinder::create(world);
        if (!finder) return finder.error();
        while (!finder->done() && world.tick_count() < ticks) tick(world), finder->after_tick(world);
        return finder->ticks();
    }
};

Run two_blocks() {
    std::shared_ptr<const Game> game = std::move(make_scene("two-blocks")).value();
    return {[game] { return game->start().value(); },
            [game](World& world) { REQUIRE(game->advance(world, {}).ok()); }};
}

/// Blocks that fall from these places, without an initial velocity.
Run dropped(std::vector<Transform> places) {
    return {[places] {
        World world = made(World::create(small_def()));
        add_floor(world);
        for (const Transform& place : places) add_crate(world, place);
        return world;
    }};
}

std::vector<BodyId> blocks_of(const World& world) {
    std::vector<BodyId> blocks;
    for (const BodyId body : world.bodies())
        if (world.kind(body) == BodyKind::dynamic) blocks.push_back(body);
    return blocks;
}

/// Returns whether two bodies pushed each other in the last tick, or overlapped before it.
bool touch(const World& world, BodyId a, BodyId b) {
    return std::ranges::any_of(world.contacts(), [&](const World::ContactPoint& contact) {
        const BodyId one = world.body_of(contact.shape_a), other = world.body_of(contact.shape_b);
        const bool both = (one == a && other == b) || (one == b && other == a);
        return both && (contact.impulse > Speed{} || contact.separation < Separation{});
    });
}
bool touches_ground(const World& world, BodyId block) {
    return std::ranges::any_of(world.bodies(), [&](BodyId body) {
        return world.kind(body) == BodyKind::static_ && touch(world, body, block);
    });
}
bool all_free(const World& world) {
    const std::vector<BodyId> b = blocks_of(world);
    return !touch(world, b[0], b[1]) && !touches_ground(world, b[0]) && !touches_ground(world, b[1]);
}
/// The number of times in [from, to] at which `holds` is true.
std::size_t count(const Run& run, std::uint64_t from, std::uint64_t to,
                  const std::function<bool(const World&)>& holds) {
    std::size_t times = 0;
    for (World world = run.at(from); world.tick_count() <= to; run.tick(world))
        times += holds(world) ? 1U : 0U;
    return times;
}

/// The numbers of the figures whose captions are false at these ticks.
std::vector<int> false_claims(const Run& run, const FigureTicks& ticks) {
    std::vector<int> wrong;
    const std::vector<BodyId> b = blocks_of(run.start());
    const auto meet = [&](const World& world) { return touch(world, b[0], b[1]); };
    const auto lands = [&](std::size_t i) {
        return [&b, i](const World& world) { return touches_ground(world, b[i]); };
    };
    if (count(run, 1, ticks.in_the_air, std::not_fn(all_free)) != 0) wrong.push_back(1);

    const std::uint64_t before = ticks.meeting - 1;
    const bool one_bounced =
        (count(run, 1, ticks.meeting, lands(0)) != 0) != (count(run, 1, ticks.meeting, lands(1)) != 0);
    if (!one_bounced || count(run, 1, before, meet) != 0 || !meet(run.at(ticks.meeting))) wrong.push_back(2);

    const World apart = run.at(ticks.apart);
    const D3 way = position(apart, b[1]) - position(apart, b[0]);
    const D3 speed = velocity(apart, b[1]) - velocity(apart, b[0]);
    if (!all_free(apart) || test::scene::dot(way, speed) <= 0 || ticks.apart <= ticks.meeting)
        wrong.push_back(3);

    const auto again = [&](std::size_t i, std::uint64_t until) {
        return count(run, ticks.apart, until, lands(i)) != 0;
    };
    const bool both = again(0, ticks.landing) && again(1, ticks.landing);
    const bool only_now = !again(0, ticks.landing - 1) || !again(1, ticks.landing - 1);
    if (!both || !only_now || count(run, ticks.apart, ticks.landing, meet) != 0) wrong.push_back(4);
    return wrong;
}

} // namespace

TEST_CASE("the four pictures of two-blocks show what they claim") {
    const Run run = two_blocks();
    const Result<FigureTicks> ticks = run.figures(600);
    REQUIRE_MESSAGE(ticks.ok(), ticks.error().message);
    INFO(ticks->in_the_air, " ", ticks->meeting, " ", ticks->apart, " ", ticks->landing);
    CHECK(ticks->in_the_air > 0);
    CHECK(false_claims(run, *ticks) == std::vector<int>{});
}

TEST_CASE("planted: the test detects each picture that is a moment too early or too late") {
    const Run run = two_blocks();
    const FigureTicks right = run.figures(600).value();
    FigureTicks late_1 = right, early_2 = right, early_3 = right, early_4 = right, late_2 = right;
    late_1.in_the_air = right.meeting;
    early_2.meeting -= 1;
    late_2.meeting += 1;
    early_3.apart = right.meeting;
    early_4.landing -= 1;
    CHECK(false_claims(run, late_1) == std::vector<int>{1});
    CHECK(false_claims(run, early_2) == std::vector<int>{2});
    CHECK(false_claims(run, late_2) == std::vector<int>{2});
    CHECK(false_claims(run, early_3) == std::vector<int>{3, 4});
    CHECK(false_claims(run, early_4) == std::vector<int>{4});
}

TEST_CASE("figures() rejects runs without the four moments and names the reason") {
    const auto refusal = [](const Run& run, std::uint64_t ticks) {
        const Result<FigureTicks> found = run.figures(ticks);
        return found.ok() ? std::string("found") : found.error().message;
    };
    CHECK(refusal(two_blocks(), 20) == "no bodies touch within 20 ticks");
    CHECK(refusal(dropped({at(0, 2, 0), at(5, 3, 0)}), 600) == "the blocks never meet within 600 ticks");
    CHECK(refusal(dropped({at(0, 2, 0)}), 600) == "the figures need two dynamic bodies; it has 1");
    CHECK(refusal({[] { return two_blocks().at(10); }}, 600).starts_with("it begins at tick 10"));
}
