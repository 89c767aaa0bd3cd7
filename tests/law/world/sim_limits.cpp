// Extreme values: the world clamps values outside of the documented range and counts them, and no sequence of commands
// breaks it.
#include "support/about.h"
#include "support/rigs/scale_field.h"
#include "support/sim_script.h"
#include "support/split_mix.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <cstdlib>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// Random numbers: mostly ordinary, often extreme.
Real number(test::SplitMix& r) {
    switch (r.below(40)) {
    case 0:
        return Real::from_raw(static_cast<std::int64_t>(r.next()));
    case 1:
        return r.one_in(2) ? Real::max() : Real::min();
    case 2:
        return Real(static_cast<int>(r.below(2'000'000'000)) - 1'000'000'000);
    case 3:
        return Real{};
    case 4:
        return Real::from_raw(static_cast<std::int64_t>(r.below(5)) - 2);
    default:
        return Real::from_raw((static_cast<std::int64_t>(r.below(2'000'000)) - 1'000'000) * (1 << 14)); // 4
    }
}
Vec3 vector(test::SplitMix& r) {
    const Real x = number(r), y = number(r), z = number(r);
    return {x, y, z};
}
Quat rotation(test::SplitMix& r) {
    if (r.one_in(10)) return {Unit::from_raw(static_cast<std::int32_t>(r.next())), Unit{}, Unit{}, Unit{}};
    const UnitVec3 axis = normalized_or(vector(r), axis_y);
    return from_axis_angle(axis, Real::from_raw(static_cast<std::int64_t>(r.next() >> 28)));
}
Transform pose(test::SplitMix& r) {
    const Vec3 p = vector(r);
    return {p, rotation(r)};
}
std::uint32_t flag(test::SplitMix& r, std::uint32_t valid) {
    return r.one_in(12) ? r.below(1000) : r.below(valid);
}

template <class Tag> Id<Tag> some_id(test::SplitMix& r) { return {r.below(40), r.below(3)}; }
BodyId some_body(test::SplitMix& r, const World& w) {
    return w.body_count() == 0 || r.one_in(12) ? some_id<BodyTag>(r) : w.body_at(r.below(w.body_count()));
}
ShapeId some_shape(test::SplitMix& r, const World& w) {
    const BodyId b = some_body(r, w);
    if (!w.is_alive(b) || w.shapes(b).empty()) return some_id<ShapeTag>(r);
    return w.shapes(b)[r.below(static_cast<std::uint32_t>(w.shapes(b).size()))];
}

BodyDef body_def(test::SplitMix& r) {
    BodyDef d;
    d.kind = static_cast<BodyKind>(r.one_in(2) ? 2 : flag(r, 3));
    d.locks = r.one_in(3) ? flag(r, 64) : 0;
    d.pose = pose(r);
    if (r.one_in(2)) d.linear_velocity = vector(r);
    if (r.one_in(2)) d.angular_velocity = vector(r);
    if (r.one_in(4)) d.linear_damping = number(r);
    if (r.one_in(4)) d.gravity_scale = number(r);
    if (r.one_in(2)) d.mass = abs(number(r));
    d.gyroscopic = flag(r, 2);
    d.bullet = r.one_in(6) ? flag(r, 2) : 0;
    return d;
}
ShapeDef shape_def(test::SplitMix& r) {
    ShapeDef d;
    d.geometry = {static_cast<ShapeKind>(flag(r, 11)), to<Length>(abs(number(r))), to<Length>(vector(r))};
    if (r.one_in(4)) d.geometry.scale = to<Length>(vector(r));
    if (r.one_in(4)) d.geometry.asset.value = r.next();
    const Real size = Real::from_raw(static_cast<std::int64_t>(r.next() >> 29) + 10737419);
    if (r.one_in(2)) d.geometry = sphere(size);
    if (r.one_in(2)) d.geometry = box(size, half(size), shift_right(size, 2));
    if (r.one_in(4)) d.geometry = cylinder(size, half(size));
    if (r.one_in(4)) d.geometry = cone(size, size);
    if (r.one_in(4)) d.geometry = rounded(d.geometry, shift_right(size, 3));
    if (r.one_in(4)) d.geometry = plane();
    if (r.one_in(8)) d.geometry = test::with_scale(d.geometry, Real(1 << r.below(4)));
    if (r.one_in(3)) d.local = pose(r);
    if (r.one_in(3)) d.density = abs(number(r));
    if (r.one_in(3)) d.friction = abs(number(r));
    d.restitution = r.one_in(3) ? Real(1) : Real{};
    if (r.one_in(4)) d.rolling_resistance = abs(number(r));
    if (r.one_in(4)) d.surface_velocity = vector(r);
    d.friction_mix = static_cast<Mix>(flag(r, 5));
    d.one_way = r.one_in(8) ? flag(r, 2) : 0;
    d.sensor = r.one_in(6) ? flag(r, 2) : 0;
    return d;
}

FieldDef field_def(test::SplitMix& r) {
    FieldDef d;
    d.kind = static_cast<FieldKind>(flag(r, 4));
    d.center = vector(r), d.strength = number(r), d.softening = abs(number(r));
    d.acceleration = vector(r), d.velocity = vector(r);
    d.density = abs(number(r)), d.drag_linear = abs(number(r));
    d.drag_quadratic = abs(number(r)), d.drag_angular = abs(number(r));
    d.priority = static_cast<std::int32_t>(flag(r, 3));
    d.region.kind = static_cast<RegionKind>(flag(r, 3));
    d.region.pose = pose(r);
    d.region.half_extent = {abs(number(r)), abs(number(r)), abs(number(r))};
    return d;
}

ExplosionDef explosion_def(test::SplitMix& r) {
    return {vector(r),  abs(number(r)), number(r), abs(number(r)), static_cast<Falloff>(flag(r, 3)),
            0xffffffffu};
}

Command some_command(test::SplitMix& r, const World& w) {
    const BodyId body = some_body(r, w);
    const Vec3 a = vector(r), b = vector(r);
    switch (r.below(27)) {
    case 0:
    case 1:
    case 2:
        return CreateBody{body_def(r)};
    case 3:
    case 4:
    case 5:
        return CreateShape{body, shape_def(r)};
    case 6:
        return r.one_in(3) ? Command{DestroyBody{body}} : Command{SetGravity{a}};
    case 7:
        return DestroyShape{some_shape(r, w)};
    case 8:
        return CreateField{field_def(r)};
    case 9:
        return DestroyField{some_id<FieldTag>(r)};
    case 10:
    case 11:
        return SetPose{body, pose(r)};
    case 12:
    case 13:
        return SetVelocity{body, a, b};
    case 14:
        return AddForce{body, a, b};
    case 15:
        return AddForceAt{body, a, b};
    case 16:
        return AddImpulse{body, a, b};
    case 17:
        return AddImpulseAt{body, a, b};
    case 18:
        return SetBodyParameters{body, abs(a.x), abs(a.y), a.z, flag(r, 64), flag(r, 2), flag(r, 2)};
    case 19:
        return SetMaterial{some_shape(r, w), abs(a.x), abs(a.y), abs(a.z), b};
    case 20:
        return WriteGame{flag(r, 2), flag(r, 65), body, flag(r, 16), {}};
    case 21:
        return SetFilter{some_shape(r, w), flag(r, 4), flag(r, 4), 0};
    case 22:
        return SetPairFilter{body, some_body(r, w), flag(r, 2)};
    case 24:
        return Explode{explosion_def(r)};
    case 25:
        return SetField{some_id<FieldTag>(r), field_def(r)};
    case 23:
        return SetMass{body, abs(number(r)), a, abs(b), rotation(r)};
    default:
        return SetPose{body, {vec(0.3, 0.2 * r.below(20), 0.1), rotation(r)}}; // into the crowd
    }
}

/// Returns whether the world's state is valid, as the loader of portable images decides.
bool sound(const World& w, World& loader) { return loader.restore_portable(w.save_portable()).ok(); }

} // namespace

TEST_CASE("the tick clamps a velocity beyond the limit to 500 m/s and counts a fault") {
    World w = made(World::create(small_def()));
    const BodyId b =
        add(w, {.linear_velocity = vec(500, 0, 0), .mass = Real(1)}, {.geometry = sphere(real(0.5))});
    done(w.add_impulse(b, vec(1e9, 1e9, 0), vec(0, 1e9, 0)));
    w.tick();
    CHECK(length(velocity(w, b)) < 500.01);
    CHECK(w.faults().speed_clamped > 0);
    done(w.add_force(b, vec(-2e9, 2e9, 2e9), vec(2e9, 2e9, -2e9)));
    for (int t = 0; t < 60; ++t) w.tick();
    CHECK(length(velocity(w, b)) < 500.01);
    CHECK(length(spin(w, b)) * 0.5 * std::sqrt(0.4) < 170.1);
}

TEST_CASE(
    "a contact on long arms of bodies beyond every speed limit stays within the range of the arithmetic") {
    // Rows and velocities at their largest, all of one sign: without the limits their product would not fit 64 bits.
    World w = made(World::create(weightless()));
    const Vec3 tip = vec(0, 20, -20), apart = vec(0.25, 0.25, 0.25);
    const auto add_arm = [&](Vec3 center, Vec3 arm, double speed) {
        const BodyId b = made(w.create_body({.pose = {center, Quat::identity()}, .mass = Real(1)}));
        made(w.create_shape(b, {.geometry = box(real(2), real(2), real(2))}));
        made(w.create_shape(
            b, {.geometry = sphere(real(0.5)), .local = {arm, Quat::identity()}, .density = 0.01_r}));
        done(w.set_velocity(b, {}, vec(4095, -4095, -4095)));
        done(w.add_impulse(b, vec(speed, speed, speed)));
        return b;
    };
    add_arm(tip + tip, -tip, -1e9);
    const BodyId b = add_arm(apart, tip, 1e9);
    for (int t = 0; t < 10; ++t) {
        w.tick();
        if (t == 0) CHECK(w.contacts().size() == 1);
    }
    CHECK(w.faults().speed_clamped > 0);
    CHECK(length(velocity(w, b)) < 500.01);
}

TEST_CASE("the tick clamps a position to a thousand million metres and counts a fault") {
    World w = made(World::create(weightless()));
    const BodyId b = add(w, {.pose = at(999'999'990, -999'999'990, 0), .linear_velocity = vec(300, -300, 0)},
                         {.geometry = sphere(real(0.5))});
    for (int t = 0; t < 60; ++t) w.tick();
    CHECK(w.center_of_mass(b).x == Real(1'000'000'000));
    CHECK(w.center_of_mass(b).y == Real(-1'000'000'000));
    CHECK(w.faults().position_clamped > 0);
}

TEST_CASE("a quiet world counts no faults") {
    World w = start_script(Scenery::pile);
    for (int t = 0; t < 200; ++t) w.tick();
    CHECK(w.faults() == Faults{});
}

TEST_CASE("bodies beyond every mass limit still collide with impulse shares that add up") {
    World w = made(World::create(weightless()));
    const ShapeDef huge{
        .geometry = box(real(50), real(50), real(50)), .density = Real(100000), .restitution = Real(1)};
    const BodyId a = add(w, {.pose = at(-51, 0, 0), .linear_velocity = vec(5, 0, 0)}, huge);
    const BodyId b = add(w, {.pose = at(51, 0, 0), .linear_velocity = vec(-5, 0, 0)}, huge);
    CHECK(w.mass(a) == Real(1'000'000'000));
    for (int t = 0; t < 60; ++t) w.tick();
    CHECK(velocity(w, a)[0] == test::about(-5, 0.02));
    CHECK(velocity(w, b)[0] == test::about(5, 0.02));
}

TEST_CASE("a world applies each of thousands of random commands or rejects it with an error and no change") {
    const std::uint64_t seeds = std::getenv("LOCKSTONE_LONG") != nullptr ? 400 : 20;
    std::uint64_t applied = 0, refused = 0, contacts = 0;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        test::SplitMix r(seed);
        WorldDef def = small_def();
        def.bodies_max = def.shapes_max = 32, def.contacts_max = 60;
        def.integrator = static_cast<Integrator>(seed % 4);
        def.tick_rate = seed % 5 == 0 ? 1 : seed % 5 == 1 ? 1000 : 60;
        def.bounds_shift = static_cast<std::uint32_t>(seed % 9);
        World w = made(World::create(def, script_schema())), twin = w.clone();
        World loader = w.clone();
        Image image;
        for (int t = 0; t < 60; ++t) {
            for (std::uint32_t i = 0; i < 12; ++i) {
                const Command c = some_command(r, w);
                const std::uint64_t before = w.hash();
                const Result<World::Applied> result = w.apply(c);
                INFO("seed ", seed, ", tick ", t, ", ", std::string(name_of(c)));
                REQUIRE(twin.apply(c).ok() == result.ok());
                ++(result ? applied : refused);
                if (result) continue;
                REQUIRE(!result.error().message.empty());
                REQUIRE(w.hash() == before);
            }
            w.tick();
            // The twin's caches come from a different tick each time.
            twin.save(image), twin.tick(), twin.restore(image), twin.tick();
            INFO("seed ", seed, ", tick ", t, ", ", difference(w, twin));
            REQUIRE(w.hash() == twin.hash());
            contacts += w.contacts().size();
            // An elastic impact with a heavier body doubles a speed; the next tick clamps it.
            for (const BodyId b : w.bodies()) REQUIRE(length(velocity(w, b)) < 1000.1);
            if (t % 20 == 19) REQUIRE(sound(w, loader));
        }
    }
    std::printf("  random commands: %llu applied, %llu refused, %llu contact points\n",
                static_cast<unsigned long long>(applied), static_cast<unsigned long long>(refused),
                static_cast<unsigned long long>(contacts));
    CHECK(applied > seeds * 100);
    CHECK(refused > seeds * 100);
    CHECK(contacts > seeds * 100);
}
