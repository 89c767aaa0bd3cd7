// Characters and moving objects: platforms, doors, crates, balls, other characters.
#include "support/about.h"
#include "support/character_course.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::character;

namespace {

constexpr double skin = 0.004;

BodyId add_platform(World& w, const Transform& pose, Vec3 half, Vec3 velocity, Vec3 spin = {}) {
    return add(
        w, {.kind = BodyKind::kinematic, .pose = pose, .linear_velocity = velocity, .angular_velocity = spin},
        {.geometry = box(half)});
}

struct Crate {
    World w;
    CharacterId c;
    BodyId crate;
};
/// A character that is about to walk into a crate of 1 m with this mass and friction.
Crate crate_ahead(double mass, double friction, double push_force) {
    World w = made(World::create(small_def()));
    add_floor(w);
    const BodyId crate =
        add(w, {.pose = at(2, 0.5, 0), .mass = real(mass)},
            {.geometry = box(0.5_r, 0.5_r, 0.5_r), .friction = real(friction), .friction_mix = Mix::minimum});
    CharacterDef def;
    def.push_force = real(push_force);
    const CharacterId c = add_character(w, 0.5, 0.01, 0, def);
    run(w, 30);
    drive(w, c, 3, 0);
    return {std::move(w), c, crate};
}

} // namespace

TEST_CASE("a platform carries a character at its own speed horizontally and up and down") {
    for (const D3 velocity : {D3{2, 0, 0}, D3{0, 1.5, 0}, D3{0, -1.5, 0}, D3{-1, 1, 3}, D3{12, -4, 0}}) {
        World w = made(World::create(small_def()));
        const BodyId platform = add_platform(w, at(0, 5, 0), vec(2, 0.2, 2), {});
        const CharacterId c = add_character(w, 0.5, 5.21, 0.5);
        run(w, 20);
        done(w.set_velocity(platform, quantize<Real>(velocity), {}));
        const D3 before = feet(w, c) - position(w, platform);
        for (int i = 0; i < 120; ++i) {
            w.tick();
            CHECK(stands(w, c));
            CHECK(length(feet(w, c) - position(w, platform) - before) < 1e-4);
        }
        CHECK(w.character_state(c).ground_body == platform);
    }
}

TEST_CASE("a turning platform carries a character around its axis and turns the character") {
    World w = made(World::create(small_def()));
    add_platform(w, at(0, 1, 0), vec(4, 0.2, 4), {}, vec(0, 1, 0));
    const CharacterId c = add_character(w, 3, 1.21, 0);
    run(w, 15);
    const D3 from = feet(w, c);
    const double angle_before = std::atan2(-from[2], from[0]);
    run(w, 120);
    const D3 to = feet(w, c);
    CHECK(std::hypot(to[0], to[2]) == test::about(std::hypot(from[0], from[2]), 0.001));
    CHECK(std::abs(std::remainder(std::atan2(-to[2], to[0]) - angle_before - 2.0, 6.283185307179586)) <
          0.001);
    const D3 facing = to_double(to_rotation(w.pose(w.body_of(c)).rotation).x);
    CHECK(std::hypot(facing[0], facing[2]) == test::about(1, 1e-6));
    CHECK(std::abs(to_double(w.angular_velocity(w.body_of(c)).y) - 1) < 1e-5);
}

TEST_CASE("a character that jumps off a platform keeps the platform's velocity") {
    World w = made(World::create(small_def()));
    const BodyId platform = add_platform(w, at(0, 5, 0), vec(2, 0.2, 2), {});
    CharacterDef def;
    def.air_acceleration = {};
    const CharacterId c = add_character(w, 0, 5.21, 0, def);
    run(w, 20);
    done(w.set_velocity(platform, vec(3, 1, 0), {}));
    run(w, 20);
    drive(w, c, 0, 0, true);
    w.tick();
    const D3 v = to_double(w.character_state(c).velocity);
    CHECK(v[0] == test::about(3, 0.001));
    CHECK(v[1] == test::about(5 + 1 - 9.81 / 60, 0.001));
}

TEST_CASE("a door pushes a character and does not push it into a wall") {
    World w = made(World::create(small_def()));
    add_floor(w);
    const BodyId door = add_platform(w, at(-3, 1, 0), vec(0.05, 0.99, 2), vec(6, 0, 0));
    const CharacterId c = add_character(w, 0, 0.01, 0);
    for (int i = 0; i < 60; ++i) {
        w.tick();
        CHECK(overlap(w, c) == 0);
        CHECK(feet(w, c)[0] > position(w, door)[0]);
    }
    CHECK(feet(w, c)[0] == test::about(3 + 0.05 + 0.3 + skin, 0.002));
    const BodyId wall = add_wall(w, at(6, 1, 0), vec(0.5, 1, 5));
    bool squeezed = false;
    for (int i = 0; i < 60; ++i) {
        w.tick();
        CHECK(feet(w, c)[0] < 5.5 - 0.3);
        squeezed |= w.character_state(c).squeezed != 0;
    }
    CHECK(w.is_alive(wall));
    CHECK(squeezed);
}

TEST_CASE("a character pushes a crate with at most push_force") {
    // Without friction: the acceleration is push_force / mass, until the crate is as fast as the character.
    for (const double mass : {50.0, 400.0}) {
        Crate k = crate_ahead(mass, 0, 300);
        double before = 0, most = 0;
        for (int i = 0; i < 90; ++i) {
            k.w.tick();
            const double now = velocity(k.w, k.crate)[0];
            most = std::max(most, (now - before) * 60 * mass);
            before = now;
        }
        INFO("mass ", mass);
        CHECK(most < 300 * 1.01);
        CHECK(most > 300 * 0.9);
        if (mass == 50) CHECK(before == test::about(3, 0.02));
        CHECK(overlap(k.w, k.c) < 0.006);
    }
    Crate strong = crate_ahead(50, 0, 3000); // negative control: more force, more acceleration
    double most = 0, before = 0;
    for (int i = 0; i < 60; ++i) {
        strong.w.tick();
        most = std::max(most, (velocity(strong.w, strong.crate)[0] - before) * 60 * 50);
        before = velocity(strong.w, strong.crate)[0];
    }
    CHECK(most > 400);
}

TEST_CASE("friction holds a crate if push_force is too weak") {
    Crate held = crate_ahead(100, 0.5, 400); // friction holds it with up to 490 N
    run(held.w, 240);
    CHECK(std::abs(position(held.w, held.crate)[0] - 2) < 0.002);
    CHECK(overlap(held.w, held.c) == 0);
    Crate moved = crate_ahead(100, 0.5, 600);
    run(moved.w, 240);
    CHECK(position(moved.w, moved.crate)[0] > 3);
}

TEST_CASE(
    "a light ball that hits a character stops without moving it and a heavy ball pushes the character") {
    for (const double mass : {1.0, 800.0}) {
        World w = made(World::create(small_def()));
        add_floor(w);
        const BodyId ball = add(w,
                                {.pose = at(-3, 0.9, 0),
                                 .linear_velocity = vec(8, 0, 0),
                                 .gravity_scale = {},
                                 .mass = real(mass)},
                                {.geometry = sphere(0.3_r), .friction = {}});
        CharacterDef def;
        def.push_force = {};
        const CharacterId c = add_character(w, 0, 0.01, 0, def);
        run(w, 22);
        const double after = velocity(w, ball)[0];
        INFO("mass ", mass);
        if (mass == 1) CHECK(std::abs(after) < 0.3);
        if (mass == 800) CHECK(after > 6);
        if (mass == 1) CHECK(std::abs(feet(w, c)[0]) < 0.02);
        if (mass == 800) CHECK(feet(w, c)[0] > 0.1);
        CHECK(overlap(w, c) < 0.02);
    }
}

TEST_CASE("a character loads the body under it with its weight and carries a crate on its head") {
    // A raft of 400 kg that floats in the air, and 80 kg on it.
    World w = made(World::create(small_def()));
    const BodyId cart = add(w, {.locks = 61, .pose = at(0, 5, 0), .gravity_scale = {}, .mass = real(400)},
                            {.geometry = box(2_r, 0.2_r, 2_r)});
    const CharacterId c = add_character(w, 0, 5.21, 0);
    run(w, 20);
    const double before = velocity(w, cart)[1];
    run(w, 30);
    CHECK((before - velocity(w, cart)[1]) * 2 == test::about(9.81 * 80 / 400, 0.01));
    CHECK(w.character_state(c).ground_body == cart);

    World head = made(World::create(small_def()));
    add_floor(head);
    const CharacterId below = add_character(head, 0, 0.01, 0);
    run(head, 20);
    const BodyId crate = add_crate(head, at(0, 2.4, 0), 0.5);
    run(head, 120);
    CHECK(position(head, crate)[1] > 2.25);
    CHECK(std::abs(feet(head, below)[1] - skin) < 1e-4);
}

TEST_CASE("characters are obstacles to each other") {
    World w = made(World::create(small_def()));
    add_floor(w);
    const CharacterId a = add_character(w, -2, 0.01, 0), b = add_character(w, 2, 0.01, 0.01);
    drive(w, a, 4, 0);
    drive(w, b, -4, 0);
    for (int i = 0; i < 90; ++i) {
        w.tick();
        const D3 apart = feet(w, a) - feet(w, b);
        CHECK(std::hypot(apart[0], apart[2]) > 0.6);
    }
    const CharacterId ghost = add_character(w, -4, 0.01, 0, {.mask = 2});
    run(w, 10);
    // negative control: it passes through shapes that its mask leaves out, the floor included
    CHECK_FALSE(stands(w, ghost));
}

TEST_CASE("the world stays valid after the destruction of a character's ground and of its own body") {
    World w = made(World::create(small_def()));
    const BodyId floor = add_wall(w, at(0, -0.5, 0), vec(5, 0.5, 5));
    const CharacterId a = add_character(w, 0, 0.01, 0), b = add_character(w, 1, 0.01, 0);
    run(w, 20);
    CHECK(stands(w, a));
    done(w.destroy(floor));
    run(w, 2);
    CHECK_FALSE(stands(w, a));
    CHECK_FALSE(w.destroy(w.shapes(w.body_of(b))[0]).ok());
    done(w.destroy(w.body_of(a)));
    CHECK_FALSE(w.is_alive(a));
    CHECK(w.is_alive(b));
    CHECK_FALSE(w.set_character_input(a, {}).ok());
    run(w, 5);
    done(w.destroy(b));
    CHECK(w.character_count() == 0);
    CHECK(w.body_count() == 0);
    CHECK_FALSE(w.create_character({.height = 0.1_r}).ok());
    CHECK_FALSE(w.create_character({.up = {}}).ok());
    w.tick();
}

TEST_CASE("a conveyor carries a character at its own velocity until a wall stops the character") {
    for (const double degrees : {0.0, 10.0}) {
        World w = made(World::create(small_def()));
        // The belt's x axis is the world's -z, turned up by degrees.
        const Quat pose = turned(axis_x, degrees) * turned(axis_y, 90);
        const BodyId belt = add(w, {.kind = BodyKind::static_, .pose = at(0, 0, 0, pose)},
                                {.geometry = box(30_r, 0.5_r, 5_r), .surface_velocity = vec(2, 0.7, 0)});
        const CharacterId c = add_character(w, 0, 0.53, 0);
        run(w, 30);
        const double rise = degrees * 3.14159265358979323846 / 180;
        for (int i = 0; i < 60; ++i) {
            const D3 before = feet(w, c);
            w.tick();
            CHECK(stands(w, c));
            const D3 way = feet(w, c) - before;
            // A velocity across the surface moves no character.
            CHECK(std::abs(way[0]) < 1e-4);
            CHECK(std::abs(way[1] - 2.0 / 60 * std::sin(rise)) < 1e-4);
            CHECK(std::abs(way[2] + 2.0 / 60 * std::cos(rise)) < 1e-4);
            CHECK(length(to_double(w.character_state(c).velocity)) < 1e-4);
        }
        CHECK(to_double(w.character_state(c).ground_velocity.z) == test::about(-2 * std::cos(rise), 1e-3));
        const double z = feet(w, c)[2];
        made(w.create_shape(belt, {.geometry = box(0.5_r, 5_r, 5_r),
                                   .local = {vec(-z / std::cos(rise) + 1.5, 0, 0), Quat::identity()}}));
        run(w, 120);
        CHECK(feet(w, c)[2] > z - 1);
        CHECK(w.character_state(c).squeezed == 0);
    }
}

TEST_CASE("a character that jumps off a conveyor keeps its velocity and one that leaves it on foot brakes to "
          "rest") {
    World w = made(World::create(small_def()));
    add_floor(w);
    add(w, {.kind = BodyKind::static_, .pose = at(0, -0.4, 0)},
        {.geometry = box(2_r, 0.5_r, 5_r), .surface_velocity = vec(3, 0, 0)});
    CharacterDef def;
    def.air_acceleration = {};
    const CharacterId c = add_character(w, -1.5, 0.11, 0, def);
    run(w, 20);
    CHECK(to_double(w.character_state(c).ground_velocity.x) == test::about(3, 1e-3));
    World off = w.clone();
    drive(w, c, 0, 0, true);
    w.tick();
    CHECK(to_double(w.character_state(c).velocity.x) == test::about(3, 0.001));
    // Beyond the end of the belt it comes to rest within v^2 / 2a = 0.075 m, and a tick.
    run(off, 120);
    CHECK(feet(off, c)[0] > 2);
    CHECK(feet(off, c)[0] < 2 + 0.3 + 0.075 + 0.05);
    CHECK(length(to_double(off.linear_velocity(off.body_of(c)))) < 1e-4);
}

TEST_CASE("a mesh carries a character only on triangles whose material is a conveyor") {
    const std::vector<Vec3> vertices = {vec(-20, 0, -5), vec(-20, 0, 5), vec(0, 0, -5),
                                        vec(0, 0, 5),    vec(20, 0, -5), vec(20, 0, 5)};
    const std::vector<std::array<std::uint32_t, 3>> triangles = {{0, 1, 2}, {2, 1, 3}, {2, 3, 4}, {4, 3, 5}};
    const std::vector<std::uint16_t> materials = {7, 7, 8, 8};
    const std::vector<MaterialSurface> surfaces = {
        {.material = 7, .friction = 0.6_r, .surface_velocity = vec(2, 0, 0)}};
    AssetLibrary library;
    const AssetId asset = made(library.add(made(bake_mesh(
        {.vertices = vertices, .triangles = triangles, .materials = materials, .surfaces = surfaces}))));
    const Geometry ground = made(library.geometry(asset));
    World w = made(World::create(small_def(), {}, std::make_shared<const AssetLibrary>(std::move(library))));
    add(w, {.kind = BodyKind::static_}, {.geometry = ground});
    const CharacterId c = add_character(w, -3, 0.01, 0);
    run(w, 20);
    const double from = feet(w, c)[0];
    run(w, 60);
    CHECK(feet(w, c)[0] - from == test::about(2, 0.001));
    run(w, 120);
    CHECK(feet(w, c)[0] > 0);
    CHECK(feet(w, c)[0] < 0.3 + 2.0 * 2 / 120 + 0.07);
    CHECK(length(to_double(w.linear_velocity(w.body_of(c)))) < 1e-4);
}

TEST_CASE("a conveyor that starts at 100 m/s carries a character through no thin wall") {
    World w = made(World::create(small_def()));
    const BodyId belt = add_wall(w, at(0, -0.5, 0), vec(20, 0.5, 5));
    add_wall(w, at(1.63, 1, 0), vec(0.01, 1, 5));
    const CharacterId c = add_character(w, 0, 0.01, 0);
    run(w, 20);
    done(w.set_material({w.shapes(belt).front(), 0.6_r, Real{}, Real{}, vec(100, 0, 0)}));
    for (int i = 0; i < 10; ++i) {
        w.tick();
        CHECK(feet(w, c)[0] < 1.62 - 0.3);
    }
}
