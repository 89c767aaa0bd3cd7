// Definitions with user keys, handed over in any order, make the same world.
#include "lockstone/assemble.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <cstdlib>
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

/// Of random kinds, shapes, masses, speeds and surfaces, with belts, sensors, filters, bullets, locked axes and platforms.
std::vector<Assembly> motley(unsigned seed) {
    std::mt19937 random(seed);
    const auto one_in = [&](unsigned n) { return random() % n == 0; };
    const auto between = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random() % 1024) / 1024;
    };
    const auto size = [&] { return real(between(0.1, 0.4)); };
    std::vector<Assembly> list;
    list.push_back({{.kind = BodyKind::static_, .user_key = ~std::uint64_t{0}}, {{.geometry = plane()}}});
    for (std::uint64_t i = 0; i < 40; ++i) {
        Assembly one;
        one.body.kind = one_in(6) ? BodyKind::kinematic : one_in(8) ? BodyKind::static_ : BodyKind::dynamic;
        one.body.pose = at(between(-2, 2), between(0.3, 5), between(-2, 2), turned(axis_z, between(0, 360)));
        if (one.body.kind != BodyKind::static_)
            one.body.linear_velocity = vec(between(-3, 3), 0, between(-3, 3));
        one.body.bullet = one_in(5) ? 1 : 0;
        one.body.locks = one_in(5) ? 0x8 : 0;
        one.body.user_key = (i * 0x9e3779b97f4a7c15u) ^ seed;
        for (std::uint64_t k = 0; k < 1 + random() % 3; ++k) {
            const Geometry kinds[] = {
                sphere(size()),          box(size(), size(), size()),
                capsule(size(), size()), cylinder(size(), size()),
                cone(size(), size()),    rounded(box(size(), size(), size()), real(0.05))};
            ShapeDef shape{.geometry = kinds[random() % 6], .local = at(between(-0.3, 0.3), 0, 0)};
            shape.density = real(between(200, 3000)), shape.restitution = real(between(0, 0.6));
            shape.sensor = one_in(7) ? 1 : 0;
            shape.group = one_in(5) ? -1 : 0;
            if (one_in(6)) shape.surface_velocity = vec(1, 0, 0);
            shape.user_key = ~k;
            one.shapes.push_back(shape);
        }
        list.push_back(one);
    }
    return list;
}

/// A world whose slots were used before, so that new ids fill gaps.
World used_world(bool holes) {
    WorldDef def = small_def();
    def.shapes_max = 256, def.contacts_max = 2048;
    World world = made(World::create(def));
    std::vector<BodyId> bodies;
    for (int i = 0; i < 12; ++i) bodies.push_back(add_crate(world, at(3.0 * i - 18, 0.5, 9)));
    for (std::size_t i = 0; holes && i < bodies.size(); i += 3) done(world.destroy(bodies[i]));
    world.tick();
    return world;
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

TEST_CASE("so they do in worlds of all kinds of bodies, and where ids fill the gaps that others left") {
    const unsigned worlds = std::getenv("LOCKSTONE_LONG") != nullptr ? 200 : 12;
    for (unsigned seed = 1; seed <= worlds; ++seed) {
        INFO("seed ", seed);
        std::vector<Assembly> list = motley(seed);
        const World empty = used_world(seed % 2 == 0);
        World expected = empty.clone();
        made(assemble(expected, list));
        const World later = after_a_second(expected.clone());
        CHECK(later.contacts().size() > 20);
        shuffle(list, seed + 1000);
        World world = empty.clone();
        made(assemble(world, list));
        CHECK(difference(expected, world) == "");
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
