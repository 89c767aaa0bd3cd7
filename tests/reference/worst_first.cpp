// The order of the resolver (section 4.3.2, listing 8): the worst contact first, ties by id.
#include "reference/scene.h"
#include "reference/scenes.h"
#include "reference/side_by_side.h"
#include "support/about.h"

#include <doctest/doctest.h>

using namespace reference_tests;
using reference::Engine, reference::Resolved;

namespace {

/// Pairs of balls far from each other, with these overlaps.
Stage overlapping(std::initializer_list<Real> depths) {
    Stage stage(weightless());
    Real z{};
    for (const Real depth : depths) {
        stage.add({.pose = at(0_r, 0_r, z)}, {.geometry = sphere(0.5_r)});
        stage.add({.pose = at(1_r - depth, 0_r, z)}, {.geometry = sphere(0.5_r)});
        z += 4_r;
    }
    return stage;
}

std::vector<int> order_of(std::span<const Resolved> log, bool velocity) {
    std::vector<int> order;
    for (const Resolved& done : log)
        if (done.velocity == velocity) order.push_back(done.contact);
    return order;
}

/// The first of the deepest contacts, by id; the last one for the negative control.
int deepest_of(std::span<const reference::Contact> contacts, bool last) {
    int found = 0;
    for (int i = 1; i < static_cast<int>(contacts.size()); ++i) {
        const double here = contacts[static_cast<std::size_t>(i)].depth,
                     best = contacts[static_cast<std::size_t>(found)].depth;
        if (here > best || (last && here == best)) found = i;
    }
    return found;
}

} // namespace

TEST_CASE(
    "the reference engine resolves the deepest contact first and equal contacts in the order of their ids") {
    const Stage stage = overlapping({0.01_r, 0.03_r, 0.02_r, 0.03_r});
    reference::Settings settings = strict();
    settings.position_epsilon = 1e-6;
    Engine engine = Engine::create(stage.world, settings).value();
    engine.tick();
    REQUIRE(engine.contacts().size() == 4);
    REQUIRE(engine.contacts()[1].depth == engine.contacts()[3].depth); // a tie of equal bits
    CHECK(order_of(engine.resolved(), false) == std::vector<int>{1, 3, 2, 0});
}

TEST_CASE("the reference engine resolves the fastest approach first after it has resolved all positions") {
    Stage stage(weightless());
    Real z{};
    for (const Real speed : {1_r, 3_r, 2_r, 3_r}) {
        stage.add({.pose = at(0_r, 0_r, z), .linear_velocity = {speed, 0_r, 0_r}},
                  {.geometry = sphere(0.5_r)});
        stage.add({.pose = at(1_r, 0_r, z)}, {.geometry = sphere(0.5_r)});
        z += 4_r;
    }
    reference::Settings settings = strict();
    settings.position_epsilon = settings.velocity_epsilon = 1e-6;
    Engine engine = Engine::create(stage.world, settings).value();
    engine.tick();
    CHECK(order_of(engine.resolved(), true) == std::vector<int>{1, 3, 2, 0});
    CHECK(order_of(engine.resolved(), false) ==
          std::vector<int>{1, 3, 2, 0}); // the fastest ones are the deepest by now
    CHECK(
        std::ranges::is_partitioned(engine.resolved(), [](const Resolved& done) { return !done.velocity; }));
}

TEST_CASE("in a pile the deepest contact is resolved first and taking the last of equal contacts changes the "
          "order") {
    auto both =
        reference::SideBySide::create(reference::make_compare_scene("pile", {.size = 30}).value()).value();
    Stage tied = overlapping({0.02_r, 0.02_r});
    int checked = 0;
    for (int i = 0; i < 90; ++i) {
        both.tick().value();
        const std::vector<int> order = order_of(both.theirs().resolved(), false);
        if (order.empty()) continue;
        CHECK(order[0] == deepest_of(both.theirs().contacts(), false));
        ++checked;
    }
    CHECK(checked > 20);
    Engine twin = Engine::create(tied.world, strict()).value();
    twin.tick();
    CHECK(order_of(twin.resolved(), false)[0] != deepest_of(twin.contacts(), true));
}

TEST_CASE("iterations end when no contact is above epsilon or at the iteration limit") {
    const Stage stage = overlapping({0.01_r, 0.03_r, 0.02_r, 0.03_r});
    reference::Settings settings = strict();
    settings.position_epsilon = 0.015;
    Engine engine = Engine::create(stage.world, settings).value();
    engine.tick();
    CHECK(order_of(engine.resolved(), false) == std::vector<int>{1, 3, 2});
    settings.position_iterations = 2;
    Engine hurried = Engine::create(stage.world, settings).value();
    hurried.tick();
    CHECK(order_of(hurried.resolved(), false) == std::vector<int>{1, 3});
}

TEST_CASE("the reference engine updates a contact that another contact has moved") {
    // Three balls in a row, the middle one squeezed: resolving one side deepens the other.
    Stage stage(weightless());
    for (const Real x : {0_r, 0.96_r, 1.9_r})
        stage.add({.pose = at(x, 0_r, 0_r)}, {.geometry = sphere(0.5_r)});
    reference::Settings settings = strict();
    settings.position_epsilon = 1e-6;
    Engine engine = Engine::create(stage.world, settings).value();
    engine.tick();
    const std::span<const Resolved> log = engine.resolved();
    REQUIRE(log.size() >= 2);
    CHECK(log[0].contact == 1);
    CHECK(log[0].magnitude == lockstone::test::about(0.06, 1e-6));
    CHECK(log[1].contact == 0);
    CHECK(log[1].magnitude == lockstone::test::about(0.04 + 0.03, 1e-6)); // half of 0.06 was added
}
