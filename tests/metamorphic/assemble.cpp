// Definitions with user keys, handed over in any order, make the same world.
#include "lockstone/assemble.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <random>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

std::vector<Assembly> definitions() {
    std::vector<Assembly> list;
    list.push_back({{.kind = BodyKind::static_, .user_key = 1000}, {{.geometry = plane()}}});
    for (int i = 0; i < 20; ++i) {
        Assembly one;
        one.body.pose = at(0.3 * (i % 4), 0.6 + 0.7 * i, 0.2 * (i % 3));
        one.body.user_key = static_cast<std::uint64_t>(i * 37 % 101);
        one.shapes.push_back({.geometry = box(real(0.3), real(0.2), real(0.25)), .user_key = 2});
        one.shapes.push_back({.geometry = sphere(real(0.2)), .local = at(0.3, 0, 0), .user_key = 1});
        list.push_back(one);
    }
    return list;
}

void shuffle(std::vector<Assembly>& list, unsigned seed) {
    std::mt19937 random(seed);
    std::shuffle(list.begin(), list.end(), random);
    for (Assembly& one : list) std::shuffle(one.shapes.begin(), one.shapes.end(), random);
}

World after_a_second(World world) {
    for (int t = 0; t < 60; ++t) world.tick();
    return world;
}

} // namespace

TEST_CASE("definitions with user keys, handed over in any order, make the same world, tick for tick") {
    std::vector<Assembly> list = definitions();
    World expected = made(World::create(small_def()));
    made(assemble(expected, list));
    const World later = after_a_second(expected.clone());
    for (unsigned seed = 1; seed <= 6; ++seed) {
        shuffle(list, seed);
        World world = made(World::create(small_def()));
        const std::vector<BodyId> ids = made(assemble(world, list));
        CHECK(difference(expected, world) == "");
        for (std::size_t i = 0; i < list.size(); ++i) CHECK(world.user_key(ids[i]) == list[i].body.user_key);
        CHECK(difference(later, after_a_second(std::move(world))) == "");
    }
}

TEST_CASE("planted fault: bodies created in the order of a shuffled list are another world") {
    std::vector<Assembly> list = definitions();
    World expected = made(World::create(small_def())), world = expected.clone();
    made(assemble(expected, list));
    shuffle(list, 1);
    for (const Assembly& one : list) {
        const BodyId body = made(world.create_body(one.body));
        for (const ShapeDef& shape : one.shapes) made(world.create_shape(body, shape));
    }
    CHECK(difference(expected, world) != "");
}

TEST_CASE(
    "keys that stand twice, and definitions that are refused, leave the world as it was and are named") {
    World world = made(World::create(small_def()));
    add_floor(world);
    const std::uint64_t hash = world.hash();
    std::vector<Assembly> list = definitions();
    list[3].body.user_key = list[7].body.user_key;
    CHECK(assemble(world, list).error().message.find("two bodies have the user_key") != std::string::npos);
    list = definitions();
    list[5].shapes[0].user_key = 1;
    CHECK(assemble(world, list).error().message.find("two shapes of a body") != std::string::npos);
    list = definitions();
    list[20].shapes[0].density = Real(-1);
    const std::string key = std::to_string(list[20].body.user_key);
    CHECK(assemble(world, list).error().message.find("user_key " + key + ": ") != std::string::npos);
    CHECK(world.hash() == hash);
}
