// Free motion: forces, damping, locks, kinds of bodies, and spin without torque.
#include "support/about.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <cstdio>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double tick_time = 1.0 / 60;

/// A box of these half extents and density 1: its mass and moments of inertia in closed form.
struct Block {
    D3 half;
    double mass() const { return 8 * half[0] * half[1] * half[2]; }
    D3 inertia() const {
        const auto term = [&](double a, double b) { return mass() * (a * a + b * b) / 3; };
        return {term(half[1], half[2]), term(half[0], half[2]), term(half[0], half[1])};
    }
    ShapeDef shape() const { return {.geometry = box(quantize<Real>(half)), .density = Real(1)}; }
};

/// The body's axes in the world.
std::array<D3, 3> axes_of(const World& w, BodyId b) {
    const Rotation r = to_rotation(w.pose(b).rotation);
    return {to_double(r.x), to_double(r.y), to_double(r.z)};
}
D3 body_spin(const World& w, BodyId b) {
    const std::array<D3, 3> axes = axes_of(w, b);
    return {dot(axes[0], spin(w, b)), dot(axes[1], spin(w, b)), dot(axes[2], spin(w, b))};
}
D3 angular_momentum(const World& w, BodyId b, const Block& block) {
    const D3 inertia = block.inertia(), s = body_spin(w, b);
    const std::array<D3, 3> axes = axes_of(w, b);
    return inertia[0] * s[0] * axes[0] + inertia[1] * s[1] * axes[1] + inertia[2] * s[2] * axes[2];
}
double spin_energy(const World& w, BodyId b, const Block& block) {
    return dot(spin(w, b), angular_momentum(w, b, block)) / 2;
}

BodyId add_block(World& w, const Block& block, BodyDef body = {}) { return add(w, body, block.shape()); }

} // namespace

TEST_CASE("a force changes momentum by force times time regardless of the mass and acts for one tick") {
    for (double scale : {0.1, 1.0, 30.0}) {
        World w = made(World::create(weightless()));
        const Block block{{0.5 * scale, 0.25 * scale, 1.0 * scale}};
        const BodyId b = add_block(w, block);
        const double m = block.mass();
        REQUIRE(to_double(w.mass(b)) == test::about(m, 1e-6));
        done(w.add_force(b, vec(6 * m, -12 * m, 3 * m)));
        w.tick();
        CHECK(length(velocity(w, b) - D3{0.1, -0.2, 0.05}) < 2e-6);
        w.tick(); // a force acts for one tick
        CHECK(length(velocity(w, b) - D3{0.1, -0.2, 0.05}) < 2e-6);
    }
}

TEST_CASE("a torque about a principal axis changes the spin by torque over inertia") {
    const Block block{{0.5, 0.25, 1.0}};
    for (int axis = 0; axis < 3; ++axis)
        for (bool turned_body : {false, true}) {
            World w = made(World::create(weightless()));
            const Quat rotation = turned_body ? turned(axis_z, 40) * turned(axis_x, 70) : Quat::identity();
            const BodyId b = add_block(w, block, {.pose = {{}, normalized(rotation)}});
            const D3 direction = axes_of(w, b)[static_cast<std::size_t>(axis)];
            done(w.add_force(b, {}, quantize<Real>(3.0 * direction)));
            w.tick();
            const double expected = 3 * tick_time / block.inertia()[static_cast<std::size_t>(axis)];
            INFO("axis ", axis, turned_body ? ", turned" : ", upright");
            CHECK(length(spin(w, b) - expected * direction) < 1e-5 * expected + 4e-6);
        }
}

TEST_CASE("a force at a point equals the force at the centre with its torque about the centre") {
    World left = made(World::create(weightless())), right = made(World::create(weightless()));
    const Block block{{0.5, 0.25, 1.0}};
    const BodyDef body{.pose = at(7, 8, 9)};
    const BodyId a = add_block(left, block, body), b = add_block(right, block, body);
    done(left.add_force_at(a, vec(1, 2, 3), vec(7.5, 8.25, 10)));
    done(right.add_force(b, vec(1, 2, 3), vec(0.25 * 3 - 1 * 2, 1 * 1 - 0.5 * 3, 0.5 * 2 - 0.25 * 1)));
    left.tick(), right.tick();
    CHECK(difference(left, right) == "");
}

TEST_CASE("an impulse changes velocity at once by impulse over mass and spin by its moment over inertia") {
    World w = made(World::create(weightless()));
    const Block block{{0.5, 0.25, 1.0}};
    const BodyId b = add_block(w, block, {.pose = at(1, 1, 1)});
    done(w.add_impulse_at(b, vec(0, 2, 0), vec(1.5, 1, 1)));
    CHECK(length(velocity(w, b) - D3{0, 2 / block.mass(), 0}) < 2e-6);
    CHECK(length(spin(w, b) - D3{0, 0, 0.5 * 2 / block.inertia()[2]}) < 4e-6);
    done(w.add_impulse(b, vec(0, -2, 0), vec(0, 0, -1)));
    CHECK(length(velocity(w, b)) < 4e-6);
    CHECK(length(spin(w, b)) < 8e-6);
}

TEST_CASE("damping reduces speed and spin as exp(-damping t) to first order in the substep") {
    World w = made(World::create(weightless()));
    const BodyId b = add(w,
                         {.linear_velocity = vec(10, 0, 0),
                          .angular_velocity = vec(0, 5, 0),
                          .linear_damping = real(0.5),
                          .angular_damping = real(2)},
                         {.geometry = sphere(real(0.5))});
    for (int t = 0; t < 120; ++t) w.tick();
    // 1 / (1 + d h) per substep instead of exp(-d h): relative error d^2 h t / 2.
    const double h = 1.0 / 480;
    CHECK(velocity(w, b)[0] == test::about(10 * std::exp(-1.0), 0.25 * h * 2 / 2 + 1e-5));
    CHECK(spin(w, b)[1] == test::about(5 * std::exp(-4.0), 4 * h * 2 / 2 + 1e-4));
}

TEST_CASE("the gravity scale multiplies gravity for one body by -1 or 0 or 3") {
    World w = made(World::create(small_def()));
    const double scales[] = {-1, 0, 3};
    for (double scale : scales) {
        const BodyId b = made(w.create_body({.gravity_scale = real(scale)}));
        for (int t = 0; t < 60; ++t) w.tick();
        CHECK(velocity(w, b)[1] == test::about(-9.81 * scale, 1e-5));
        done(w.destroy(b));
    }
}

TEST_CASE("static bodies never move under velocities or forces or impulses or a falling crate") {
    World w = made(World::create(small_def()));
    add_floor(w);
    const BodyId table = add_wall(w, at(0, 1, 0), vec(1, 0.2, 1));
    add_crate(w, at(0.6, 3, 0));
    done(w.set_velocity(table, vec(5, 5, 5), vec(1, 1, 1)));
    done(w.add_force(table, vec(1e6, 1e6, 0)));
    done(w.add_impulse(table, vec(1e6, 1e6, 0)));
    const Transform before = w.pose(table);
    for (int t = 0; t < 120; ++t) w.tick();
    CHECK(w.pose(table) == before);
    CHECK(w.mass(table) == Real{});
}

TEST_CASE("a kinematic body moves at its velocity without being pushed and carries a crate on it") {
    World w = made(World::create(small_def()));
    const BodyId lift = add(w, {.kind = BodyKind::kinematic, .pose = at(0, 0, 0)},
                            {.geometry = box(real(2), real(0.25), real(2))});
    const BodyId crate = add_crate(w, at(0, 0.75, 0));
    for (int t = 0; t < 60; ++t) w.tick();
    done(w.set_velocity(lift, vec(0.5, 1, -0.25), {}));
    const D3 start = position(w, crate);
    for (int t = 0; t < 120; ++t) w.tick();
    CHECK(length(position(w, lift) - D3{1, 2, -0.5}) < 1e-5);
    CHECK(length(velocity(w, lift) - D3{0.5, 1, -0.25}) == 0);
    // The crate slips until friction has accelerated it: 0.56 m/s at 0.6 g.
    CHECK(length(position(w, crate) - start - D3{1, 2, -0.5}) < 0.04);
    CHECK(length(velocity(w, crate) - D3{0.5, 1, -0.25}) < 0.005);
}

TEST_CASE("a crate on a kinematic turntable turns with it") {
    World w = made(World::create(small_def()));
    add(w, {.kind = BodyKind::kinematic, .angular_velocity = vec(0, 1, 0)},
        {.geometry = box(real(2), real(0.25), real(2))});
    const BodyId crate = add_crate(w, at(1, 0.5, 0), 0.25);
    for (int t = 0; t < 300; ++t) w.tick();
    const D3 p = position(w, crate);
    CHECK(std::hypot(p[0], p[2]) == test::about(1, 0.05));
    CHECK(spin(w, crate)[1] == test::about(1, 0.02));
    CHECK(std::hypot(velocity(w, crate)[0], velocity(w, crate)[2]) == test::about(1, 0.05));
}

TEST_CASE("each lock stops its own axis and no other") {
    for (std::uint32_t bit = 0; bit < 6; ++bit) {
        World w = made(World::create(weightless()));
        const BodyId b = add(w, {.locks = 1u << bit}, {.geometry = sphere(real(0.5)), .density = Real(1)});
        done(w.add_force(b, vec(1, 1, 1), vec(0.1, 0.1, 0.1)));
        w.tick();
        const D3 v = velocity(w, b), s = spin(w, b);
        for (std::uint32_t axis = 0; axis < 3; ++axis) {
            INFO("lock bit ", bit, ", axis ", axis);
            CHECK((v[axis] == 0) == (bit == axis));
            CHECK((s[axis] == 0) == (bit == axis + 3));
        }
    }
}

TEST_CASE("a torque-free top keeps its angular momentum and energy for a minute") {
    World w = made(World::create(weightless()));
    const Block block{{1.0, 0.2, 0.6}};
    const BodyId b = add_block(w, block, {.angular_velocity = vec(3, 2, 4)});
    const D3 momentum = angular_momentum(w, b, block);
    const double energy = spin_energy(w, b, block);
    double momentum_error = 0, energy_error = 0;
    for (int t = 0; t < 3600; ++t) {
        w.tick();
        momentum_error =
            std::max(momentum_error, length(angular_momentum(w, b, block) - momentum) / length(momentum));
        energy_error = std::max(energy_error, std::abs(spin_energy(w, b, block) / energy - 1));
    }
    std::printf("  torque-free top, 60 s: angular momentum off by %.3g, energy by %.3g\n", momentum_error,
                energy_error);
    CHECK(momentum_error < 1e-4);
    CHECK(energy_error < 5e-3);
}

TEST_CASE("planted fault: without the gyroscopic term a top does not keep its angular momentum") {
    World w = made(World::create(weightless()));
    const Block block{{1.0, 0.2, 0.6}};
    const BodyId b = add_block(w, block, {.angular_velocity = vec(3, 2, 4), .gyroscopic = 0});
    const D3 momentum = angular_momentum(w, b, block);
    double error = 0;
    for (int t = 0; t < 600; ++t) {
        w.tick();
        error = std::max(error, length(angular_momentum(w, b, block) - momentum) / length(momentum));
    }
    CHECK(error > 1e-2);
}
