// Definitions with user keys make equal worlds in any order.
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

/// Bodies with random kinds, shapes, masses, speeds and surfaces, with belts, sensors, filters, bullets, locked axes
/// and platforms.
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

/// Chains, hinges on the world, cars, characters and fields among the bodies of `motley`.
Level motley_level(unsigned seed) {
    std::mt19937 random(seed);
    Level level;
    level.bodies = motley(seed);
    const auto key = [&](std::size_t i) { return level.bodies[i].body.user_key; };
    for (std::size_t i = 1; i + 1 < level.bodies.size(); i += 2) {
        JointAssembly joint{i % 3 == 0 ? hinge_joint() : ball_joint(), key(i), key(i + 1)};
        if (i % 7 == 0) joint.body_a.reset();
        joint.joint.frame_b.position = vec(0, 0.5, 0);
        joint.joint.user_key = (i * 0x9e3779b97f4a7c15u) ^ seed;
        level.joints.push_back(joint);
    }
    for (std::uint64_t i = 0; i < 3; ++i) {
        Assembly chassis{
            {.pose = at(6.0 + 3 * static_cast<double>(i), 1, 0), .user_key = random() + (i << 40)},
            {{.geometry = box(real(0.8), real(0.3), real(1.8))}}};
        VehicleAssembly car{four_wheels({}, vec(0.8, -0.3, 1.4)), chassis.body.user_key};
        car.vehicle.user_key = random();
        level.bodies.push_back(chassis), level.vehicles.push_back(car);
        CharacterDef hero;
        hero.position = vec(-4 - static_cast<double>(i), 0, 2), hero.user_key = random() + (i << 41);
        level.characters.push_back(hero);
        FieldAssembly field{
            i == 0 ? wind(vec(3, 0, 1)) : water({.kind = RegionKind::sphere, .pose = at(0, 1, 0)}), random()};
        field.field.region.half_extent = vec(static_cast<double>(i) + 1, 0, 0);
        level.fields.push_back(field);
    }
    return level;
}

void shuffle(Level& level, unsigned seed) {
    shuffle(level.bodies, seed);
    std::mt19937 random(seed + 1);
    std::shuffle(level.joints.begin(), level.joints.end(), random);
    std::shuffle(level.vehicles.begin(), level.vehicles.end(), random);
    std::shuffle(level.characters.begin(), level.characters.end(), random);
    std::shuffle(level.fields.begin(), level.fields.end(), random);
}

World after_a_second(World world) {
    for (int t = 0; t < 60; ++t) world.tick();
    return world;
}

} // namespace

TEST_CASE("assemble makes the same world at every tick from definitions with user keys in any order") {
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

TEST_CASE("assemble makes the same world from any order of all kinds of bodies and if ids fill gaps of other "
          "bodies") {
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

TEST_CASE("assemble makes the same world from any order of joints and vehicles and characters and fields by "
          "their keys") {
    const unsigned levels = std::getenv("LOCKSTONE_LONG") != nullptr ? 100 : 8;
    for (unsigned seed = 1; seed <= levels; ++seed) {
        INFO("seed ", seed);
        Level level = motley_level(seed);
        const World empty = used_world(seed % 2 == 0);
        World expected = empty.clone();
        made(assemble(expected, level));
        CHECK(expected.joint_count() == level.joints.size());
        CHECK(expected.vehicle_count() == 3);
        CHECK(expected.character_count() == 3);
        CHECK(expected.field_count() == 3);
        const World later = after_a_second(expected.clone());
        shuffle(level, seed);
        World world = empty.clone();
        const Assembled ids = made(assemble(world, level));
        CHECK(difference(expected, world) == "");
        for (std::size_t i = 0; i < level.joints.size(); ++i)
            CHECK(world.joint(ids.joints[i]).user_key == level.joints[i].joint.user_key);
        for (std::size_t i = 0; i < 3; ++i) {
            CHECK(world.vehicle(ids.vehicles[i]).user_key == level.vehicles[i].vehicle.user_key);
            CHECK(world.character(ids.characters[i]).user_key == level.characters[i].user_key);
            CHECK(world.field(ids.fields[i]).kind == FieldKind::fluid);
        }
        CHECK(difference(later, after_a_second(std::move(world))) == "");
    }
}

TEST_CASE(
    "planted fault: joints or vehicles or characters or fields in a shuffled order make another world") {
    for (int kind = 0; kind < 4; ++kind) {
        const Level level = motley_level(1);
        World expected = used_world(false), world = expected.clone();
        made(assemble(expected, level));
        // Two objects of one kind swap their keys, which is equivalent to creating them in another order.
        Level other = level;
        if (kind == 0) std::swap(other.joints[0].joint, other.joints[1].joint);
        if (kind == 1) std::swap(other.vehicles[0].chassis, other.vehicles[1].chassis);
        if (kind == 2) std::swap(other.characters[0].position, other.characters[1].position);
        if (kind == 3) std::swap(other.fields[0].field, other.fields[1].field);
        made(assemble(world, other));
        INFO("kind ", kind);
        CHECK(difference(expected, world) != "");
    }
}

TEST_CASE("a level with a repeated key or a missing body or a bad definition does not change the world or "
          "its journal") {
    struct Heard : Journal {
        int commands = 0;
        void on_command(std::uint64_t, const Command&) override { ++commands; }
        void on_tick(std::uint64_t, std::uint64_t) override {}
        void on_restore(std::uint64_t) override {}
    } heard;
    World world = used_world(true);
    world.set_journal(&heard);
    const std::uint64_t hash = world.hash();
    const auto refused = [&](const Level& level, const char* why) {
        const auto ids = assemble(world, level);
        return !ids && ids.error().message.find(why) != std::string::npos && world.hash() == hash;
    };
    const Level good = motley_level(3);
    Level level = good;
    level.joints[3].joint.user_key = level.joints[1].joint.user_key;
    CHECK(refused(level, "two joints have the user_key"));
    level = good, level.joints[2].body_b = 12345;
    CHECK(refused(level, "body_b names 12345"));
    level = good, level.joints[2].body_a = 54321;
    CHECK(refused(level, "body_a names 54321"));
    level = good, level.vehicles[1].chassis = 4;
    CHECK(refused(level, "chassis names 4"));
    level = good, level.fields[2].field.density = Real(-1);
    CHECK(refused(level, ("fields, user_key " + std::to_string(level.fields[2].user_key)).c_str()));
    level = good, level.characters[0].user_key = level.characters[2].user_key;
    CHECK(refused(level, "two characters"));
    CHECK(heard.commands == 0);
    CHECK(assemble(world, good));
    CHECK(heard.commands > 100);
}

TEST_CASE("planted fault: bodies created in the order of a shuffled list make another world") {
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

TEST_CASE("assemble names repeated keys and rejected definitions and leaves the world unchanged") {
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
