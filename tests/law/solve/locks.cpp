// Locked axes: a body gets no velocity along or about them, by any source of velocity.
#include "lockstone/testing.h"
#include "support/random.h"
#include "support/sim_scenes.h"
#include "world/data.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// The distance that the centre of mass moved along locked axes, and the spin about locked axes.
struct Leak {
    double way = 0, spin = 0;
};
Leak leak_of(const World& w, BodyId b, D3 start, std::uint32_t locks) {
    Leak leak;
    const D3 way = position(w, b) - start, turns = spin(w, b);
    for (std::size_t i = 0; i < 3; ++i) {
        if (locks >> i & 1u) leak.way = std::max(leak.way, std::abs(way[i]));
        if (locks >> (3 + i) & 1u) leak.spin = std::max(leak.spin, std::abs(turns[i]));
    }
    return leak;
}
Leak after_a_second(World& w, BodyId b, std::uint32_t locks) {
    const D3 start = position(w, b);
    for (int t = 0; t < 60; ++t) w.tick();
    return leak_of(w, b, start, locks);
}

const Vec3 fast = vec(3, 4, 5), turning = vec(2, 1, 3);

/// A body with motion along all axes, from one of the sources of velocity.
BodyId thrown(World& w, std::uint32_t locks, int way) {
    BodyDef def{.locks = locks};
    if (way == 0) def.linear_velocity = fast, def.angular_velocity = turning;
    if (way == 2) def.locks = 0, def.linear_velocity = fast, def.angular_velocity = turning;
    const BodyId b =
        add(w, def, {.geometry = box(real(0.5), real(0.4), real(0.3)), .local = at(0.2, 0.1, 0.3)});
    if (way == 1) done(w.set_velocity(b, fast, turning));
    if (way == 2) done(w.set_body_parameters({b, Real{}, Real{}, Real(1), locks, 1, 0}));
    if (way == 3) done(w.add_impulse(b, vec(900, 800, 700), vec(100, 90, 80)));
    if (way == 4) done(w.add_force(b, vec(9000, 8000, 7000), vec(1000, 900, 800)));
    if (way == 5) { // the centre of mass moves within a turning body
        done(w.set_velocity(b, fast, turning));
        made(w.create_shape(b, {.geometry = sphere(real(0.3)), .local = at(1, 1, 1), .density = real(5000)}));
    }
    return b;
}

/// The vertical speed of a crate that falls at 3 m/s and is hit 0.45 m off its centre, after that tick [m/s].
double speed_after_hit(std::uint32_t locks) {
    World w = made(World::create(weightless()));
    add_wall(w, at(0.9, -1, 0), vec(0.5, 1, 1));
    BodyDef def{.locks = locks};
    def.pose = at(0, 0.5, 0), def.linear_velocity = vec(0, -3, 0);
    const BodyId crate = add(w, def, {.geometry = box(vec(0.5, 0.5, 0.5))});
    w.tick();
    return velocity(w, crate)[1];
}

} // namespace

// A body that may turn keeps moving: it turns about the point of the hit.
TEST_CASE("a hit off the centre stops a body that may not turn but not a body that may turn") {
    CHECK(std::abs(speed_after_hit(lock_angular_x | lock_angular_y | lock_angular_z)) < 0.05);
    CHECK(std::abs(speed_after_hit(lock_angular_z)) < 0.05);
    CHECK(speed_after_hit(lock_angular_x | lock_angular_y) < -0.5); // negative control
}

TEST_CASE("a body has no motion along or about locked axes however it gets its velocity") {
    for (std::uint32_t locks = 0; locks < 64; ++locks)
        for (int way = 0; way < 6; ++way) {
            World w = made(World::create(weightless()));
            const BodyId b = thrown(w, locks, way);
            CHECK(leak_of(w, b, position(w, b), locks).spin == 0);
            const Leak leak = after_a_second(w, b, locks);
            INFO("locks ", locks, ", way ", way);
            CHECK(leak.way == 0);
            CHECK(leak.spin == 0);
        }
}

TEST_CASE("a locked body keeps to its axes in gravity and wind and a spring field and contacts by every "
          "integrator") {
    for (std::uint32_t scheme = 0; scheme < 4; ++scheme)
        for (const std::uint32_t locks : {1u, 2u, 4u, 5u, 7u, std::uint32_t{lock_planar_xy}, 63u}) {
            WorldDef def = small_def();
            def.gravity = vec(1, -9, 2), def.integrator = static_cast<Integrator>(scheme);
            World w = made(World::create(def));
            add_floor(w);
            made(w.create_field(wind(vec(6, 3, 9))));
            made(w.create_field({.kind = FieldKind::spring, .center = vec(3, 3, 3), .strength = real(5)}));
            const BodyId b = thrown(w, locks, 0);
            std::vector<std::pair<BodyId, D3>> locked{{b, position(w, b)}};
            const Geometry shapes[] = {sphere(real(0.4)), box(real(0.4), real(0.3), real(0.5)),
                                       capsule(real(0.2), real(0.3))};
            for (int i = 0; i < 12; ++i) { // some have locks too, and all touch each other
                const std::uint32_t own = i % 3 != 0 ? locks : 0;
                const BodyDef body{.locks = own,
                                   .pose = at(0.5 * (i % 8) - 2, 1 + 0.3 * i, 0.4 * (i % 8) - 1),
                                   .linear_velocity = own == 0 ? vec(-1, -2, 1) : Vec3{}};
                const BodyId other = add(
                    w, body, {.geometry = shapes[i / 2 % 3], .friction = real(1), .restitution = real(0.3)});
                if (own != 0) locked.emplace_back(other, position(w, other));
            }
            INFO("integrator ", scheme, ", locks ", locks);
            for (int t = 0; t < 120; ++t) {
                w.tick();
                for (const auto& [body, start] : locked) {
                    const Leak leak = leak_of(w, body, start, locks);
                    REQUIRE(leak.way == 0);
                    REQUIRE(leak.spin == 0);
                }
            }
        }
}

TEST_CASE("planted fault: a state's velocity along a locked axis is visible until the tick drops it") {
    World w = made(World::create(weightless()));
    const BodyId b = thrown(w, lock_planar_xy, 0);
    const auto& layout = w.state().layout();
    std::uint32_t column = 0;
    while (layout.columns()[column].name != "body.velocity") ++column;
    solve::Velocity bad{};
    bad.linear.z = Speed(5), bad.angular.x = Speed(2);
    const auto bytes = testing::state_of(w).edit_bytes(column, 0, 1);
    std::copy_n(reinterpret_cast<const std::byte*>(&bad), sizeof bad, bytes.begin());
    REQUIRE(velocity(w, b)[2] == 5);
    CHECK(leak_of(w, b, position(w, b), lock_planar_xy).spin == 2);
    const Leak leak = after_a_second(w, b, lock_planar_xy);
    CHECK(leak.way == 0);
    CHECK(leak.spin == 0);
}
