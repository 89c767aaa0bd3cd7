// The thesis' engine against its closed forms. The bounds follow from the time step h and the rounding of double
// precision (1e-9 leaves six digits of it).
#include "reference/scene.h"
#include "support/about.h"

#include <doctest/doctest.h>

using namespace reference_tests;
using reference::Engine;

TEST_CASE("two equal spheres that meet head-on part at the coefficient of restitution times their speed") {
    for (const double e : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        CAPTURE(e);
        Stage stage(weightless());
        const ShapeDef ball{.geometry = sphere(0.5_r), .restitution = quantize<Real>(e)};
        stage.add({.pose = at(-0.6_r, 0_r, 0_r), .linear_velocity = {2_r, 0_r, 0_r}}, ball);
        stage.add({.pose = at(0.6_r, 0_r, 0_r), .linear_velocity = {-2_r, 0_r, 0_r}}, ball);
        Engine engine = Engine::create(stage.world, strict()).value();
        for (int i = 0; i < 30; ++i) engine.tick();
        CHECK(engine.bodies()[0].velocity.x == lockstone::test::about(-2 * e, 1e-9));
        CHECK(engine.bodies()[1].velocity.x == lockstone::test::about(2 * e, 1e-9));
        CHECK(length(engine.momentum()) <= 1e-6);
    }
}

TEST_CASE("the reference engine moves two overlapping balls apart by their inverse masses (formula 4)") {
    Stage stage(weightless());
    stage.add({.pose = at(0_r, 0_r, 0_r)}, {.geometry = sphere(0.5_r), .density = 1000_r});
    stage.add({.pose = at(0.9_r, 0_r, 0_r)}, {.geometry = sphere(0.5_r), .density = 3000_r});
    Engine engine = Engine::create(stage.world, strict()).value();
    const double before_a = engine.bodies()[0].center.x, before_b = engine.bodies()[1].center.x;
    engine.tick();
    const double p = 1 - (before_b - before_a); // the sum of the radii less the distance
    CHECK(before_a - engine.bodies()[0].center.x == lockstone::test::about(0.75 * p, 1e-6));
    CHECK(engine.bodies()[1].center.x - before_b == lockstone::test::about(0.25 * p, 1e-6));
}

TEST_CASE("a box that is dropped flat comes to rest flat") {
    Stage stage;
    stage.ground();
    stage.add({.pose = at(0_r, 1.5_r, 0_r)}, {.geometry = box(0.5_r, 0.5_r, 0.5_r)});
    const reference::Settings settings;
    Engine engine = Engine::create(stage.world, settings).value();
    for (int i = 0; i < 180; ++i) engine.tick();
    const reference::Body& body = engine.bodies()[1];
    // The speed of one step of free fall, and the remainder of the epsilons.
    const double h = 1.0 / 240, speed = 9.81 * h + settings.velocity_epsilon;
    CHECK(std::abs(body.center.y - 0.5) <= settings.position_epsilon + speed * h);
    CHECK(length(body.velocity) <= 2 * speed);
    // The engine resolves corners one by one, so the box turns a little; a depth of v h moves it sideways by less than
    // that.
    CHECK(std::hypot(body.center.x, body.center.z) <= std::sqrt(2 * 9.81) * h);
    // It leans by at most such a depth on either side, a metre apart. About the vertical axis there is no restoring
    // torque.
    CHECK(2 * std::hypot(body.pose.rotation.x, body.pose.rotation.z) <=
          2 * (settings.position_epsilon + speed * h));
}

namespace {

/// Returns the height to which a box rebounds after it falls flat by `height` [m].
double rebound(double e, double height, bool box_ground) {
    Stage stage;
    stage.ground();
    stage.add({.pose = at(0_r, quantize<Real>(height + 0.5), 0_r)},
              {.geometry = box(0.5_r, 0.5_r, 0.5_r), .restitution = quantize<Real>(e)});
    Engine engine = Engine::create(stage.world, {.box_ground = box_ground}).value();
    double top = 0;
    bool rises = false;
    for (int i = 0; i < 240; ++i) {
        engine.tick();
        const reference::Body& body = engine.bodies()[1];
        if (rises && body.velocity.y < 0) break;
        rises = rises || body.velocity.y > 0.5;
        if (rises) top = std::max(top, body.center.y - 0.5);
    }
    return top;
}

} // namespace

TEST_CASE(
    "a box that is dropped flat rebounds to e^2 of its height from one contact point and to less from four") {
    for (const double e : {0.3, 0.5, 0.8}) {
        CAPTURE(e);
        // The impact is detected up to a step late, and Euler-Cromer rises v h / 2 less than a parabola.
        const double height = 2, v = std::sqrt(2 * 9.81 * height), h = 1.0 / 240, bound = 2 * e * v * h;
        CHECK(std::abs(rebound(e, height, false) - e * e * height) <= bound);
        // Corners are resolved one by one, so each turns the box and reduces the rebound of the next (section 5).
        CHECK(rebound(e, height, true) <= e * e * height + bound);
    }
}

TEST_CASE("a block slides v^2 / (2 mu g) far") {
    for (const double mu : {0.2, 0.4}) {
        CAPTURE(mu);
        Stage stage;
        const ShapeDef surface{.friction = quantize<Real>(mu)};
        stage.ground(surface);
        ShapeDef block = surface;
        block.geometry = box(0.5_r, 0.1_r, 0.5_r);
        stage.add({.pose = at(0_r, 0.1_r, 0_r), .linear_velocity = {4_r, 0_r, 0_r}}, block);
        Engine engine = Engine::create(stage.world).value();
        for (int i = 0; i < 300; ++i) engine.tick();
        const double distance = 16 / (2 * mu * 9.81);
        CHECK(std::abs(engine.bodies()[1].center.x - distance) <= 0.03 * distance);
        CHECK(std::abs(engine.bodies()[1].velocity.x) <= 0.05);
    }
}

namespace {

Stage spinning_box(Vec3 spin) {
    Stage stage(weightless());
    stage.add({.angular_velocity = spin}, {.geometry = box(0.2_r, 0.5_r, 1_r)});
    return stage;
}

double change_of_angular_momentum(Vec3 spin, const reference::Settings& settings) {
    Engine engine = Engine::create(spinning_box(spin).world, settings).value();
    const reference::Vec before = engine.measure().angular_momentum;
    for (int i = 0; i < 300; ++i) engine.tick();
    return length(engine.measure().angular_momentum - before) / length(before);
}

} // namespace

TEST_CASE("a box that spins about a principal axis keeps its angular momentum by every integrator") {
    using reference::Integrator;
    for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::verlet,
                                        Integrator::velocity_verlet, Integrator::runge_kutta_4}) {
        CHECK(change_of_angular_momentum({5_r, 0_r, 0_r}, {.integrator = integrator}) <= 1e-9);
        CHECK(change_of_angular_momentum({0_r, 0_r, 5_r}, {.integrator = integrator}) <= 1e-9);
    }
}

TEST_CASE(
    "a tumbling box keeps its angular momentum with the term w x I w but not with the thesis' listing") {
    const Vec3 spin{1_r, 4_r, 2_r};
    CHECK(change_of_angular_momentum(
              spin, {.integrator = reference::Integrator::runge_kutta_4, .gyroscopic = true}) <= 1e-4);
    CHECK(change_of_angular_momentum(spin, {}) >= 0.01); // listing 3 conserves the angular velocity instead
}

TEST_CASE("two boxes that meet off their centres keep momentum and angular momentum") {
    Stage stage(weightless());
    const ShapeDef box_shape{.geometry = box(0.5_r, 0.5_r, 0.5_r), .friction = 0.5_r, .restitution = 0.5_r};
    stage.add({.pose = at(-0.7_r, 0.3_r, 0_r),
               .linear_velocity = {2_r, 0_r, 0_r},
               .angular_velocity = {0_r, 1_r, 0_r}},
              box_shape);
    stage.add({.pose = at(0.7_r, -0.2_r, 0.2_r), .linear_velocity = {-3_r, 0_r, 0_r}}, box_shape);
    Engine engine = Engine::create(stage.world).value();
    const reference::Measures before = engine.measure();
    bool met = false;
    double deepest = 0;
    for (int i = 0; i < 120; ++i) {
        engine.tick();
        met = met || engine.touched();
        for (const reference::Contact& contact : engine.contacts())
            deepest = std::max(deepest, contact.depth);
    }
    REQUIRE(met);
    const reference::Measures after = engine.measure();
    CHECK(length(after.momentum - before.momentum) <= 1e-6);
    // Bodies that are moved apart by p carry their momentum with them: p m v, twice.
    const double p = deepest + 5 * 2.0 / 240;
    CHECK(length(after.angular_momentum - before.angular_momentum) <= 2 * p * 1000 * 3);
    CHECK(after.kinetic < before.kinetic);
}

TEST_CASE("in a fall Euler-Cromer and Verlet are off by g t h / 2 and the other integrators are exact") {
    using reference::Integrator;
    const double t = 1, h = 1.0 / 60, exact = -9.81 * t * t / 2;
    const auto fallen = [&](Integrator integrator) {
        Stage stage;
        stage.add({}, {.geometry = sphere(0.5_r)});
        Engine engine = Engine::create(stage.world, {.integrator = integrator, .substeps = 1}).value();
        for (int i = 0; i < 60; ++i) engine.tick();
        return engine.bodies()[0].center.y;
    };
    CHECK(fallen(Integrator::semi_implicit_euler) == lockstone::test::about(exact - 9.81 * t * h / 2, 1e-8));
    CHECK(fallen(Integrator::verlet) == lockstone::test::about(exact - 9.81 * t * h / 2, 1e-8));
    CHECK(fallen(Integrator::velocity_verlet) == lockstone::test::about(exact, 1e-8));
    CHECK(fallen(Integrator::runge_kutta_4) == lockstone::test::about(exact, 1e-8));
}

TEST_CASE("damping multiplies a velocity by exp(-damping) in a second") {
    Stage stage(weightless());
    stage.add({.linear_velocity = {3_r, 0_r, 0_r},
               .angular_velocity = {0_r, 2_r, 0_r},
               .linear_damping = 0.7_r,
               .angular_damping = 0.2_r},
              {.geometry = sphere(0.5_r)});
    Engine engine = Engine::create(stage.world).value();
    for (int i = 0; i < 60; ++i) engine.tick();
    CHECK(engine.bodies()[0].velocity.x == lockstone::test::about(3 * std::exp(-0.7), 1e-6));
    CHECK(engine.bodies()[0].rotation.y == lockstone::test::about(2 * std::exp(-0.2), 1e-6));
}
