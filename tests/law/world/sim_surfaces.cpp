// The surfaces and the partners of shapes: conveyors, rolling resistance, mixing rules, one-way shapes, filters, and
// masses set by command.
#include "support/about.h"
#include "support/sim_scenes.h"
#include "world/data.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// A crate slides over a floor; a mixing rule combines these two friction coefficients. Returns its speed after a
/// second.
double speed_after_sliding(Mix rule, double crate, double floor) {
    World w = made(World::create(small_def()));
    add_floor(w, {.friction = real(floor), .friction_mix = rule});
    const BodyId b = add(w, {.pose = at(0, 0.5, 0), .linear_velocity = vec(10, 0, 0)},
                         {.geometry = box(0.5_r, 0.5_r, 0.5_r), .friction = real(crate)});
    for (int t = 0; t < 60; ++t) w.tick();
    return velocity(w, b)[0];
}

/// A ball rolls over a floor at 2 m/s. Returns its speed after two seconds.
double speed_after_rolling(double resistance, double radius) {
    World w = made(World::create(small_def()));
    add_floor(w);
    const BodyId b = add(w,
                         {.pose = at(0, radius, 0),
                          .linear_velocity = vec(2, 0, 0),
                          .angular_velocity = vec(0, 0, -2 / radius)},
                         {.geometry = sphere(real(radius)), .rolling_resistance = real(resistance)});
    for (int t = 0; t < 120; ++t) w.tick();
    return velocity(w, b)[0];
}

} // namespace

TEST_CASE("a conveyor carries a crate at its speed and in its direction until the speed is set to zero") {
    World w = made(World::create(small_def()));
    const BodyId belt = add(w, {.kind = BodyKind::static_, .pose = at(0, -0.5, 0, turned(axis_y, 90))},
                            {.geometry = box(50_r, 0.5_r, 50_r), .surface_velocity = vec(3, 0, 0)});
    const BodyId crate = add_crate(w, at(0, 0.5, 0));
    for (int t = 0; t < 120; ++t) w.tick();
    // The belt's own x axis, turned by 90 degrees about y, is the world's -z.
    CHECK(velocity(w, crate)[2] == test::about(-3, 0.002));
    CHECK(std::abs(velocity(w, crate)[0]) < 0.01);
    done(w.set_material({w.shapes(belt).front(), 0.6_r, Real{}, Real{}, Vec3{}}));
    for (int t = 0; t < 120; ++t) w.tick();
    CHECK(std::abs(velocity(w, crate)[2]) < 0.001);
}

TEST_CASE("rolling resistance brakes a ball like the torque coefficient * weight and holds it on a slope") {
    // For a solid ball that rolls: (7/5) m a = -c m g / r.
    for (const auto& [resistance, radius] : {std::pair(0.01, 0.5), {0.02, 0.5}, {0.005, 0.1}}) {
        const double slower = resistance * 9.81 / radius * 5 / 7 * 2;
        CHECK(speed_after_rolling(resistance, radius) == test::about(2 - slower, 0.02));
    }
    CHECK(speed_after_rolling(0, 0.5) == test::about(2, 0.001)); // nothing brakes it

    // The ball stays on a slope while tan(angle) < coefficient / radius.
    World w = made(World::create(small_def()));
    add(w, {.kind = BodyKind::static_, .pose = at(0, 0, 0, turned(axis_z, -3))},
        {.geometry = plane(), .rolling_resistance = 0.04_r});
    const BodyId b = add_ball(w, at(0, 0.5 / std::cos(0.0524), 0));
    for (int t = 0; t < 300; ++t) w.tick();
    CHECK(std::abs(position(w, b)[0]) < 0.01);
    CHECK(length(spin(w, b)) < 0.002);
}

TEST_CASE("a pair with two different mixing rules uses the rule that is later in the list") {
    const auto slowed = [](double coefficient) { return 10 - coefficient * 9.81; };
    const double a = 0.6, b = 0.1; // the crate's rule is always the geometric mean, the lowest in the list
    CHECK(speed_after_sliding(Mix::geometric_mean, a, b) == test::about(slowed(std::sqrt(a * b)), 0.01));
    CHECK(speed_after_sliding(Mix::average, a, b) == test::about(slowed((a + b) / 2), 0.01));
    CHECK(speed_after_sliding(Mix::minimum, a, b) == test::about(slowed(b), 0.01));
    CHECK(speed_after_sliding(Mix::multiply, a, b) == test::about(slowed(a * b), 0.01));
    CHECK(speed_after_sliding(Mix::maximum, a, b) == test::about(slowed(a), 0.01));
}

TEST_CASE("a one-way platform lets a crate up through it and carries it from above") {
    for (const bool one_way : {true, false}) {
        World w = made(World::create(small_def()));
        add_floor(w);
        add(w, {.kind = BodyKind::static_, .pose = at(0, 3, 0)},
            {.geometry = box(5_r, 0.1_r, 5_r), .one_way = one_way ? 1u : 0u});
        const BodyId b = add_crate(w, at(0, 0.5, 0), 0.4);
        done(w.set_velocity(b, vec(0, 12, 0), {}));
        double highest = 0;
        for (int t = 0; t < 240; ++t) {
            w.tick();
            highest = std::max(highest, position(w, b)[1]);
        }
        CHECK((highest > 5) == one_way);
        CHECK(position(w, b)[1] == test::about(one_way ? 3.5 : 0.4, 0.01)); // at rest on it, or below
    }
}

TEST_CASE("a pair filter stops contacts of two bodies until it is removed or a body is destroyed") {
    World w = made(World::create(small_def()));
    const BodyId floor = add_wall(w, at(0, -0.5, 0), vec(10, 0.5, 10));
    const BodyId ghost = add_crate(w, at(0, 2, 0)), crate = add_crate(w, at(3, 2, 0));
    done(w.set_pair_filter(floor, ghost, false));
    done(w.set_pair_filter(ghost, floor, false)); // the reversed pair again: no second entry
    CHECK(w.state().count(sim::make_manifest(w.def(), {}).pair_filters) == 1);
    for (int t = 0; t < 60; ++t) w.tick();
    CHECK(position(w, ghost)[1] < -1);
    CHECK(position(w, crate)[1] == test::about(0.5, 0.01));
    done(w.set_pose(ghost, at(0, 2, 0)));
    done(w.set_velocity(ghost, {}, {}));
    done(w.set_pair_filter(floor, ghost, true));
    for (int t = 0; t < 60; ++t) w.tick();
    CHECK(position(w, ghost)[1] == test::about(0.5, 0.01));
    done(w.set_pair_filter(ghost, crate, false));
    done(w.destroy(ghost));
    CHECK(w.state().count(sim::make_manifest(w.def(), {}).pair_filters) == 0);
    CHECK_FALSE(w.set_pair_filter(crate, crate, false));
}

TEST_CASE("set_filter() changes a shape's filter at once") {
    World w = made(World::create(small_def()));
    add_floor(w);
    const BodyId b = add_crate(w, at(0, 0.5, 0));
    for (int t = 0; t < 10; ++t) w.tick();
    done(w.set_filter({w.shapes(b).front(), 1, 0, 0}));
    for (int t = 0; t < 60; ++t) w.tick();
    CHECK(position(w, b)[1] < -3);
}

TEST_CASE("set_mass() sets mass and centre and inertia and a zero mass returns to those of the shapes") {
    World w = made(World::create(weightless()));
    const BodyId b = add_crate(w, at(0, 0, 0));
    const Real before = w.mass(b);
    done(w.set_mass({b, Real(2), vec(0.25, 0, 0), vec(0.5, 0.25, 1), Quat::identity()}));
    CHECK(w.mass(b) == Real(2));
    CHECK(position(w, b)[0] == test::about(0.25));
    CHECK(std::abs(to_double(w.pose(b).position)[0]) < 1e-6); // the origin stays
    made(w.create_shape(b, {.geometry = sphere(0.3_r)}));     // a shape no longer changes the mass
    CHECK(w.mass(b) == Real(2));
    done(w.add_impulse(b, vec(4, 0, 0), vec(0, 1, 0)));
    CHECK(velocity(w, b)[0] == test::about(2));
    CHECK(spin(w, b)[1] == test::about(1 / (2 * 0.25 * 0.25)));
    done(w.set_mass({b, Real{}, {}, {}, Quat::identity()}));
    CHECK(w.mass(b) > before);
    CHECK_FALSE(w.set_mass({b, Real(-1), {}, vec(1, 1, 1), Quat::identity()}));
    CHECK_FALSE(w.set_mass({b, Real(1), {}, vec(0, 1, 1), Quat::identity()}));
}

TEST_CASE("a manifold is rebuilt only when its shapes have moved relative to each other") {
    World w = made(World::create(small_def()));
    add_floor(w);
    const std::vector<BodyId> stack = add_stack(w, 3);
    for (int t = 0; t < 120; ++t) w.tick();
    const sim::Manifest m = sim::make_manifest(w.def(), {});
    const auto made_at = [&] {
        std::vector<std::int64_t> at;
        for (const solve::ContactRow& row : w.state().rows(m.contacts.memory))
            at.push_back(row.made_position.y.raw);
        return at;
    };
    const auto before = made_at();
    REQUIRE(before.size() == 3);
    for (int t = 0; t < 10; ++t) w.tick();
    CHECK(made_at() == before);
    done(w.set_velocity(stack[2], vec(0, 1, 0), {}));
    w.tick(), w.tick();
    CHECK(made_at()[0] == before[0]);
    CHECK(made_at() != before);
}
