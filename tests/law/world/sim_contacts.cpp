// Contacts against closed forms: bouncing, rolling, friction, momentum, energy.
#include "support/about.h"
#include "support/rigs/asked.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <cstdio>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double g = 9.81, degree = 3.14159265358979323846 / 180;

/// Kinetic and potential energy of all bodies, divided by their mass [J/kg].
double energy_per_mass(const World& w) {
    double potential = 0, mass = 0;
    for (BodyId b : w.bodies()) {
        potential += to_double(w.mass(b)) * g * position(w, b)[1];
        mass += to_double(w.mass(b));
    }
    return (to_double(w.kinetic_energy()) + potential) / mass;
}

D3 momentum(const World& w) {
    D3 sum{};
    for (BodyId b : w.bodies()) sum = sum + to_double(w.mass(b)) * velocity(w, b);
    return sum;
}

constexpr double substep = 1.0 / 480;
/// Contacts act at the ends of substeps, so a velocity is off by the speed that gravity gives in one substep.
constexpr double speed_of_substep = g * substep;

/// Bounds of the heights of the bounces of a ball dropped from 3 m, while the impacts are faster than
/// restitution_speed_min, 1 m/s. The speed of each impact and of each parting is off by at most half a substep of
/// gravity.
struct HeightRange {
    double least, most;
};
std::vector<HeightRange> bounces_expected(double restitution) {
    std::vector<HeightRange> heights;
    const auto next = [&](double height, double off) {
        const double in = std::sqrt(2 * g * height) + off, out = restitution * in + off;
        return std::pair(in, out * out / (2 * g));
    };
    HeightRange now{3, 3};
    while (heights.size() < 4 && next(now.least, -speed_of_substep / 2).first > 1) {
        now = {next(now.least, -speed_of_substep / 2).second, next(now.most, speed_of_substep / 2).second};
        heights.push_back(now);
    }
    return heights;
}

/// The heights of the lowest point of a ball dropped from 3 m, by bounce.
std::vector<double> bounces(double restitution, int count) {
    World w = made(World::create(small_def()));
    add_floor(w, {.restitution = real(restitution)});
    const BodyId ball = add_ball(w, at(0, 3.5, 0), 0.5, restitution);
    std::vector<double> heights;
    double top = 0;
    bool rises = false;
    for (int t = 0; t < 3000 && static_cast<int>(heights.size()) < count; ++t) {
        w.tick();
        const double y = position(w, ball)[1] - 0.5, v = velocity(w, ball)[1];
        if (v > 0) rises = true, top = y + v * v / (2 * g);
        if (v <= 0 && rises) heights.push_back(top), rises = false;
    }
    return heights;
}

/// Returns the speed after 2 s of a block of 1 m on a floor, under gravity tilted by `degrees` towards `direction`.
double slide_speed(double friction, double degrees, double direction) {
    WorldDef def = small_def();
    const double down = std::cos(degrees * degree), along = std::sin(degrees * degree);
    def.gravity = vec(g * along * std::cos(direction), -g * down, g * along * std::sin(direction));
    World w = made(World::create(def));
    add_floor(w, {.friction = real(friction)});
    // Flat enough that the block slides before it tips.
    const BodyId block = add(w, {.pose = at(0, 0.1, 0)},
                             {.geometry = box(real(0.5), real(0.1), real(0.5)), .friction = real(friction)});
    for (int t = 0; t < 120; ++t) w.tick();
    return std::hypot(velocity(w, block)[0], velocity(w, block)[2]);
}

/// The angle at which the block begins to slide, by bisection [degrees].
double slide_angle(double friction, double direction) {
    double low = 0, high = 80;
    while (high - low > 0.02) {
        const double middle = (low + high) / 2;
        (slide_speed(friction, middle, direction) > 0.02 ? high : low) = middle;
    }
    return (low + high) / 2;
}

} // namespace

TEST_CASE("a ball bounces to restitution squared times its height") {
    for (double e : {0.5, 0.8, 1.0}) {
        const std::vector<double> heights = bounces(e, 4);
        const std::vector<HeightRange> expected = bounces_expected(e);
        std::printf("  restitution %.1f from 3 m:", e);
        REQUIRE(heights.size() >= expected.size());
        for (std::size_t i = 0; i < expected.size(); ++i) {
            std::printf(" %.4f (%.4f to %.4f)", heights[i], expected[i].least, expected[i].most);
            CHECK(heights[i] > expected[i].least);
            CHECK(heights[i] < expected[i].most);
        }
        std::printf("\n");
    }
}

TEST_CASE("planted fault: the test distinguishes restitution 0.8 from 0.79 at the first bounce") {
    CHECK(bounces(0.79, 1)[0] < bounces_expected(0.8)[0].least);
}

TEST_CASE("a ball without restitution stays where it lands") {
    const auto highest_after = [](double restitution) {
        World w = made(World::create(small_def()));
        add_floor(w, {.restitution = real(restitution)});
        const BodyId ball = add_ball(w, at(0, 3.5, 0), 0.5, restitution);
        for (int fall = 0; fall < 48; ++fall)
            w.tick(); // the ball lands after 0.78 s, and a bounce of 1.1 m/s takes 0.23 s
        double highest = 0;
        for (int t = 0; t < 120; ++t) w.tick(), highest = std::max(highest, position(w, ball)[1] - 0.5);
        return highest;
    };
    CHECK(highest_after(0) < 1e-5);          // the rounding of a gap
    CHECK_FALSE(highest_after(0.15) < 1e-5); // planted: an impact at 7.7 m/s, a rebound at 1.2
}

TEST_CASE("a ball rolls down a plane of any direction without slipping at 5/7 of g sin(angle)") {
    for (double angle : {5.0, 15.0, 30.0})
        for (double yaw : {0.0, 30.0}) {
            INFO(angle, " degrees, turned by ", yaw);
            const Quat rotation = normalized(turned(axis_y, yaw) * turned(axis_z, -angle));
            const D3 down = to_double(rotate(rotation, vec(1, 0, 0))),
                     aside = to_double(rotate(rotation, vec(0, 0, 1)));
            World w = made(World::create(small_def()));
            add(w, {.kind = BodyKind::static_, .pose = {{}, rotation}}, {.geometry = plane()});
            const BodyId ball = add(w, {.pose = {rotate(rotation, vec(0, 0.5, 0)), Quat::identity()}},
                                    {.geometry = sphere(real(0.5))});
            for (int t = 0; t < 120; ++t) w.tick();
            const double expected = 5.0 / 7 * g * std::sin(angle * degree) * 2,
                         speed = dot(velocity(w, ball), down);
            std::printf("  ball on %.0f degrees after 2 s: %.4f m/s (%.4f)\n", angle, speed, expected);
            // The first substep may pass before the contact acts.
            CHECK(speed == test::about(expected, substep / 2));
            CHECK(dot(spin(w, ball), aside) * -0.5 == test::about(speed, substep / 2));
            // one step of a speed per substep
            CHECK(std::abs(dot(velocity(w, ball), aside)) < 960 * speed_step);
        }
}

TEST_CASE("a block holds on an incline of up to atan(friction) in every direction") {
    for (double friction : {0.2, 0.6, 1.0})
        for (double direction : {0.0, 45.0, 73.0}) {
            const double angle = slide_angle(friction, direction * degree);
            const double expected = std::atan(friction) / degree;
            std::printf("  friction %.1f towards %.0f degrees: slides from %.2f degrees (%.2f)\n", friction,
                        direction, angle, expected);
            // A speed of 0.02 m/s after 2 s means an acceleration of g sin(excess) / cos(atan(friction)). Half of the
            // last interval is added.
            const double excess = 0.02 / 2 / g * std::cos(expected * degree) / degree;
            CHECK(angle > expected - 0.01);
            CHECK(angle < expected + excess + 0.01);
        }
}

TEST_CASE("a sliding block slows down by friction times g") {
    World w = made(World::create(small_def()));
    add_floor(w, {.friction = real(0.3)});
    const BodyId block = add(w, {.pose = at(0, 0.1, 0), .linear_velocity = vec(6, 0, 3)},
                             {.geometry = box(real(0.5), real(0.1), real(0.5)), .friction = real(0.3)});
    for (int t = 0; t < 60; ++t) w.tick();
    const double expected = std::hypot(6, 3) - 0.3 * g;
    const D3 v = velocity(w, block);
    std::printf("  sliding block after 1 s: %.4f m/s (%.4f), %.4f rad/s of turn\n", std::hypot(v[0], v[2]),
                expected, spin(w, block)[1]);
    CHECK(std::abs(std::hypot(v[0], v[2]) - expected) <
          0.3 * speed_of_substep);                           // the first substep's friction
    CHECK(std::abs(v[0] - 2 * v[2]) < 480 * 3 * speed_step); // a step along each axis per substep
}

TEST_CASE("two bodies that collide in space keep their momentum and elastic bodies also keep their energy") {
    for (double e : {0.0, 0.5, 1.0}) {
        World w = made(World::create(weightless()));
        add(w, {.pose = at(-2, 0, 0), .linear_velocity = vec(5, 0, 0), .mass = Real(3)},
            {.geometry = sphere(real(0.5)), .friction = Real{}, .restitution = real(e)});
        add(w, {.pose = at(2, 0.3, 0), .linear_velocity = vec(-4, 0, 0), .mass = Real(1)},
            {.geometry = sphere(real(0.5)), .friction = Real{}, .restitution = real(e)});
        const D3 before = momentum(w);
        const double energy = to_double(w.kinetic_energy());
        for (int t = 0; t < 60; ++t) w.tick();
        CHECK(length(momentum(w) - before) <
              4 * speed_step * std::sqrt(3.0)); // a step along each axis of 4 kg
        // The impact is along the line of centres. That line is 0.3 aside over a distance between 1, at the touch, and
        // a tick's motion more, where the contact is found.
        const auto left_at = [&](double distance) {
            const double sine = 0.3 / distance, normal_speed = 9 * std::sqrt(1 - sine * sine), reduced = 0.75;
            return energy - reduced / 2 * normal_speed * normal_speed * (1 - e * e);
        };
        std::printf("  collision, restitution %.1f: momentum off by %.2g, energy %.4f J (%.4f to %.4f)\n", e,
                    length(momentum(w) - before), to_double(w.kinetic_energy()), left_at(1 + 9.0 / 60),
                    left_at(1));
        CHECK(to_double(w.kinetic_energy()) > left_at(1 + 9.0 / 60) - energy * 1e-5);
        CHECK(to_double(w.kinetic_energy()) < left_at(1) + energy * 1e-5);
    }
}

TEST_CASE("elastic balls that fly about a closed box gain no energy") {
    // the most that the energy rises above an earlier minimum, relative to the initial energy
    const auto rise = [](int boosted_at) {
        WorldDef def = weightless();
        def.bodies_max = def.shapes_max = 70, def.contacts_max = 4096;
        World w = made(World::create(def));
        const Transform walls[] = {at(0, 0, 0),
                                   at(0, 6, 0, turned(axis_x, 180)),
                                   at(-3, 0, 0, turned(axis_z, -90)),
                                   at(3, 0, 0, turned(axis_z, 90)),
                                   at(0, 0, -3, turned(axis_x, 90)),
                                   at(0, 0, 3, turned(axis_x, -90))};
        for (const Transform& wall : walls)
            add(w, {.kind = BodyKind::static_, .pose = wall},
                {.geometry = plane(), .friction = Real{}, .restitution = Real(1)});
        std::vector<BodyId> balls;
        for (int i = 0; i < 64; ++i) {
            const D3 speed{i * 37 % 17 * 0.5 - 4, i * 53 % 19 * 0.45 - 4, i * 29 % 23 * 0.36 - 4};
            balls.push_back(
                add(w,
                    {.pose = at(1.4 * (i % 4 - 1.5), 0.9 + 1.4 * (i / 4 % 4), 1.4 * (i / 16 - 1.5)),
                     .linear_velocity = vec(speed[0], speed[1], speed[2])},
                    {.geometry = sphere(real(0.3)), .friction = Real{}, .restitution = Real(1)}));
        }
        const double first = to_double(w.kinetic_energy());
        double least = first, most = 0;
        for (int t = 0; t < 600; ++t) {
            if (t == boosted_at)
                REQUIRE(w.add_impulse(balls[0], vec(30 * to_double(w.mass(balls[0])), 0, 0)).ok());
            w.tick();
            const double now = to_double(w.kinetic_energy());
            most = std::max(most, now - least), least = std::min(least, now);
        }
        return most / first;
    };
    const double clean = rise(-1), planted = rise(45);
    std::printf("  64 elastic balls: energy grows by %.2g of itself, with one pushed by %.2g\n", clean,
                planted);
    // The rounding of a bounce at 4 m/s to a step of a speed: twice a step over 4 m/s of the energy of two of 64 balls,
    // and some bounces in a tick.
    const double rounding = 2 * speed_step / 4;
    CHECK(clean < rounding);
    CHECK_FALSE(planted < rounding);
}

TEST_CASE("a cloud of bodies in space keeps its momentum through all collisions") {
    World w = made(World::create(weightless()));
    for (int i = 0; i < 40; ++i) {
        const Geometry shapes[] = {box(real(0.4), real(0.3), real(0.5)), sphere(real(0.35)),
                                   capsule(real(0.2), real(0.3))};
        const BodyDef body{.pose = at(i % 4 * 1.2, i / 4 % 4 * 1.2, i / 16 * 1.2, turned(axis_x, 31 * i)),
                           .linear_velocity = vec(3 - i % 4 * 2, 3 - i / 4 % 4 * 2, 2 - i / 16 * 2),
                           .angular_velocity = vec(i % 3, i % 5, i % 7)};
        add(w, body, {.geometry = shapes[i % 3], .restitution = real(0.5)});
    }
    const D3 before = momentum(w);
    double mass = 0;
    for (BodyId b : w.bodies()) mass += to_double(w.mass(b));
    for (int t = 0; t < 300; ++t) w.tick();
    std::printf("  cloud of 40: velocity of the whole off by %.2g m/s\n",
                length(momentum(w) - before) / mass);
    // Half a step of a speed for each body and pass, in random directions: the mean of 40 bodies over 16 passes in each
    // of 300 ticks, times three.
    CHECK(length(momentum(w) - before) / mass < 3 * speed_step / 2 * std::sqrt(16 * 300.0 / 40));
}

TEST_CASE("the contact points of a body are the points of the tick that name one of its shapes") {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) CHECK(test::body_points_fault(seed) == "");
}

namespace {

/// Pushing an overlap out lifts the bodies above it. In a tick that is at most the part of the overlap that the springs
/// of contacts with static bodies push out: w / (2 damping + w h) in a second, w their frequency and h a substep. At
/// most all bodies are lifted by that [J/kg].
double lifted(const WorldDef& def, double deepest) {
    const double w = 2 * 2 * 3.14159265358979323846 * to_double(def.contact_hertz), h = substep;
    return g * deepest / 60 * w / (2 * to_double(def.contact_damping) + w * h);
}
/// A body that rests at the end of a substep still falls in the next one. The bound is for all bodies, by the most that
/// all of them compress one contact together.
const double growth_max = g * 2 * 30 * g * give(small_def());

/// The deepest overlap at the start of the latest tick [m].
double deepest(const World& w) {
    double out = 0;
    for (const World::ContactPoint& point : w.contacts()) out = std::max(out, -to_double(point.separation));
    return out;
}
/// The energy of a crowd in a shaft [J/kg]: its most above the initial energy; the most that a tick raises it beyond
/// `lifted`; and its most above an earlier minimum once all have landed. At tick `pushed_at` one body gets 10 m/s.
struct Growth {
    double above_first = -1e9, unexplained = -1e9, landed = 0;
};
Growth growth_of_crowd(double restitution, int pushed_at) {
    World w = made(World::create(small_def()));
    add_floor(w);
    for (double x : {-2.5, 2.5}) add_wall(w, at(x, 5, 0), vec(0.5, 8, 3));
    for (double z : {-2.5, 2.5}) add_wall(w, at(0, 5, z), vec(3, 8, 0.5));
    BodyId last;
    for (int i = 0; i < 30; ++i) {
        const Geometry shapes[] = {box(real(0.4), real(0.3), real(0.5)), sphere(real(0.35)),
                                   capsule(real(0.2), real(0.3))};
        last = add(w, {.pose = at(i % 3 - 1, 1 + i / 3, i % 2 - 0.5, turned(axis_z, 23 * i))},
                   {.geometry = shapes[i % 3], .restitution = real(restitution)});
    }
    const double first = energy_per_mass(w);
    double before = first, least = 1e9;
    Growth out;
    for (int t = 0; t < 1200; ++t) {
        if (t == pushed_at) done(w.add_impulse(last, {{}, w.mass(last) * Real(10), {}}));
        w.tick();
        const double now = energy_per_mass(w), rises = now - before - lifted(small_def(), deepest(w));
        if (t >= 300) least = std::min(least, now); // a fall of ten metres takes 1.5 s
        out = {std::max(out.above_first, now - first), std::max(out.unexplained, rises),
               std::max(out.landed, now - least)};
        before = now;
    }
    std::printf("  closed scene, restitution %.1f: %.4f J/kg at first, at most %+.4f, landed %.4f\n",
                restitution, first, out.above_first, out.landed);
    return out;
}

} // namespace

TEST_CASE("energy never grows in a closed scene without motors or forces") {
    for (double restitution : {0.0, 0.5, 1.0}) {
        const Growth growth = growth_of_crowd(restitution, -1);
        CHECK(growth.above_first <= 0);
        CHECK(growth.unexplained < growth_max);
        CHECK(growth.landed < growth_max);
    }
}
TEST_CASE("planted fault: the energy of all thirty bodies reveals a push on one of them") {
    const Growth growth = growth_of_crowd(0, 600);
    CHECK_FALSE(growth.unexplained < growth_max);
    CHECK_FALSE(growth.landed < growth_max);
}
