// Fast spinning bodies: heavy tops on joints and tumbling about a fixed point against closed forms; the energy of
// spinning bodies that hit the floor.
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <numbers>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double g = 9.81;

D3 cross(D3 a, D3 b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec3 vec3(D3 v) { return vec(v[0], v[1], v[2]); }

/// A disc of 2 kg at the end of a tilted rod whose foot is a pivot.
struct Top {
    static constexpr double arm = 0.1, tilt = std::numbers::pi / 3, mass = 2, radius = 0.2,
                            half_height = 0.02;
    World w = made(World::create(small_def()));
    BodyId disc;
    double rate = 0; ///< of precession without nutation [rad/s]

    static double own_moment() { return mass * radius * radius / 2; }
    static double cross_moment() { return mass * (radius * radius / 4 + half_height * half_height / 3); }
    static D3 axis() { return {std::sin(tilt), std::cos(tilt), 0}; }
    static Quat rotation() { return turned(axis_z, -tilt * 180 / std::numbers::pi); }
};

/// The slow root of I cos t W^2 - L W + m g l = 0.    source: Goldstein, Classical Mechanics, 5.7
///   I: moment about the pivot across the axis, L: angular momentum along the axis, t: tilt
double precession(double across, double along, double load) {
    const double p = across * std::cos(Top::tilt);
    return (along - std::sqrt(along * along - 4 * p * load)) / (2 * p);
}

BodyId add_disc(World& w, D3 velocity, D3 spin, std::uint32_t gyroscopic) {
    const BodyId disc = add(w,
                            {.pose = {vec3(Top::arm * Top::axis()), Top::rotation()},
                             .linear_velocity = vec3(velocity),
                             .angular_velocity = vec3(spin),
                             .mass = real(Top::mass),
                             .gyroscopic = gyroscopic},
                            {.geometry = cylinder(real(Top::radius), real(Top::half_height))});
    return disc;
}

/// The disc alone, jointed to the pivot. `slower`: its spin, relative to the one for which `rate` holds.
Top lone_top(double own, double slower = 1, std::uint32_t gyroscopic = 1) {
    Top top;
    const double across = Top::cross_moment() + Top::mass * Top::arm * Top::arm;
    top.rate = precession(across, Top::own_moment() * own, Top::mass * g * Top::arm);
    const D3 spin = D3{0, top.rate, 0} + (own * slower - top.rate * std::cos(Top::tilt)) * Top::axis();
    top.disc = add_disc(top.w, cross(spin, Top::arm * Top::axis()), spin, gyroscopic);
    made(top.w.create_joint(ball_joint(), {}, top.disc, at(0, 0, 0)));
    return top;
}

/// The disc turns on a rod, and the rod is jointed to the pivot: a tree of two joints.
Top wheel_on_rod(double own, double slower = 1) {
    constexpr double rod_mass = 0.2, rod_half = Top::arm / 2, thick = 0.02;
    const double rod_across = rod_mass * ((rod_half * rod_half + thick * thick) / 3 + rod_half * rod_half);
    Top top;
    top.rate = precession(Top::cross_moment() + Top::mass * Top::arm * Top::arm + rod_across,
                          Top::own_moment() * own, (Top::mass * Top::arm + rod_mass * rod_half) * g);
    const D3 turn = D3{0, top.rate, 0} + (-top.rate * std::cos(Top::tilt)) * Top::axis();
    const BodyId rod = add(top.w,
                           {.pose = {vec3(rod_half * Top::axis()), Top::rotation()},
                            .linear_velocity = vec3(cross(turn, rod_half * Top::axis())),
                            .angular_velocity = vec3(turn),
                            .mass = real(rod_mass)},
                           {.geometry = box(real(thick), real(rod_half), real(thick))});
    top.disc = add_disc(top.w, cross(turn, Top::arm * Top::axis()), turn + (own * slower) * Top::axis(), 1);
    made(top.w.create_joint(ball_joint(), {}, rod, at(0, 0, 0)));
    const Quat x_along_axis = turned(axis_z, 90 - Top::tilt * 180 / std::numbers::pi);
    made(top.w.create_joint(hinge_joint(), rod, top.disc, {vec3(Top::arm * Top::axis()), x_along_axis}));
    return top;
}

struct Precession {
    double rate_off; ///< error of the rate, relative
    double tilt_off; ///< largest error of the tilt [degrees]
};
Precession watch(Top& top, int seconds) {
    double angle = 0, last = 0, worst = 0;
    for (int t = 0; t < 60 * seconds; ++t) {
        top.w.tick();
        const D3 x = position(top.w, top.disc);
        const double now = std::atan2(-x[2], x[0]);
        angle += std::remainder(now - last, 2 * std::numbers::pi);
        last = now;
        worst = std::max(worst, std::abs(std::acos(x[1] / length(x)) - Top::tilt));
    }
    return {std::abs(angle / (top.rate * seconds) - 1), worst * 180 / std::numbers::pi};
}

/// Returns an error sentence unless the rate is right to 0.2 % and the tilt to 0.3 degrees.
std::string astray(Top top, int seconds) {
    const Precession found = watch(top, seconds);
    if (found.rate_off > 0.002) return "the rate";
    if (found.tilt_off > 0.3) return "the tilt";
    return {};
}

/// A tumbling box, fixed at its centre of mass. Moments, divided by a third of its mass, and spin are in its axes.
struct Tumbler {
    static constexpr D3 half{0.1, 0.2, 0.4}, moments{0.04 + 0.16, 0.01 + 0.16, 0.01 + 0.04};
    World w = made(World::create(weightless()));
    BodyId box;

    explicit Tumbler(double speed, std::uint32_t gyroscopic) {
        box = add(w, {.angular_velocity = vec(0.2 * speed, speed, 0.1 * speed), .gyroscopic = gyroscopic},
                  {.geometry = lockstone::box(real(half[0]), real(half[1]), real(half[2]))});
        made(w.create_joint(ball_joint(), {}, box, at(0, 0, 0)));
    }
    D3 inside() const {
        return to_double(rotate(conjugate(w.pose(box).rotation), to<Real>(w.angular_velocity(box))));
    }
    D3 momentum() const {
        const D3 s = inside();
        return to_double(
            rotate(w.pose(box).rotation, vec(moments[0] * s[0], moments[1] * s[1], moments[2] * s[2])));
    }
    double energy() const {
        const D3 s = inside();
        return moments[0] * s[0] * s[0] + moments[1] * s[1] * s[1] + moments[2] * s[2] * s[2];
    }
};

/// A step of Euler's equations by the classical fourth-order Runge-Kutta method.
D3 euler_step(D3 w, double h) {
    const D3& m = Tumbler::moments;
    const auto rate = [&](D3 s) {
        return D3{(m[1] - m[2]) / m[0] * s[1] * s[2], (m[2] - m[0]) / m[1] * s[2] * s[0],
                  (m[0] - m[1]) / m[2] * s[0] * s[1]};
    };
    const D3 k1 = rate(w), k2 = rate(w + (h / 2) * k1), k3 = rate(w + (h / 2) * k2), k4 = rate(w + h * k3);
    return w + (h / 6) * (k1 + 2 * k2 + 2 * k3 + k4);
}

/// Counts how often the spin along the middle axis changes its direction.
struct FlipCount {
    double half_speed, side = 1;
    int flips = 0;
    void see(D3 spin) {
        if (spin[1] * side < -half_speed) side = -side, ++flips;
    }
};

/// Returns an error sentence unless a body with that speed [rad/s] keeps its energy, momentum and flip rate for 20
/// seconds.
std::string astray(double speed, double energy_most, std::uint32_t gyroscopic = 1) {
    Tumbler t(speed, gyroscopic);
    const D3 l0 = t.momentum();
    const double e0 = t.energy();
    D3 spin = t.inside();
    FlipCount flips{speed / 2}, expected{speed / 2};
    for (int tick = 0; tick < 1200; ++tick) {
        t.w.tick();
        flips.see(t.inside());
        for (int i = 0; i < 40; ++i) spin = euler_step(spin, 1.0 / 2400), expected.see(spin);
        if (std::abs(t.energy() / e0 - 1) > energy_most) return "energy";
        if (length(t.momentum() - l0) > 1e-4 * length(l0)) return "momentum";
    }
    return std::abs(flips.flips - expected.flips) > 1 ? "rhythm" : "";
}

/// Twenty boxes and cylinders fall on a floor, with a spin of about `speed` [rad/s]. Returns their greatest energy
/// relative to the initial one. `given`: energy that is added after half a second, relative to the initial energy.
double most_energy(double speed, double friction, double given = 0) {
    double most = 0;
    for (int k = 0; k < 20; ++k) {
        World w = made(World::create(small_def()));
        add_floor(w, {.friction = real(friction)});
        const Geometry shape =
            k % 2 != 0 ? box(real(0.2), real(0.1), real(0.3)) : cylinder(real(0.15), real(0.3));
        const D3 spin{speed * std::sin(k), speed * std::cos(k), speed / 2 * std::sin(3 * k)};
        const BodyId b =
            add(w,
                {.pose = at(0, 0.6, 0, normalized(turned(axis_x, 17 * k) * turned(axis_z, 31 * k))),
                 .angular_velocity = vec3(spin)},
                {.geometry = shape, .friction = real(friction)});
        const double mass = to_double(w.mass(b));
        const auto energy = [&] { return to_double(w.kinetic_energy()) + mass * g * position(w, b)[1]; };
        const double first = energy();
        for (int t = 0; t < 120; ++t) {
            if (t == 30 && given > 0) {
                const double now = to_double(w.linear_velocity(b).y), more = 2 * given * first / mass;
                done(w.set_velocity(b, vec(0, std::sqrt(now * now + more), 0),
                                    to<Real>(w.angular_velocity(b))));
            }
            w.tick();
            most = std::max(most, energy() / first);
        }
    }
    return most;
}

} // namespace

TEST_CASE("a heavy top on a ball joint precesses at the closed form's rate without nutation") {
    CHECK(astray(lone_top(30), 10) == "");
    CHECK(astray(lone_top(60), 10) == "");
}

TEST_CASE("a wheel that turns on a rod carries it around its pivot") {
    CHECK(astray(wheel_on_rod(30), 10) == "");
    CHECK(astray(wheel_on_rod(60), 10) == "");
}

TEST_CASE(
    "planted fault: the test detects a top or wheel that spins a tenth slower or lacks gyroscopic torque") {
    CHECK(astray(lone_top(30, 0.9), 10) != "");
    CHECK(astray(wheel_on_rod(30, 0.9), 10) != "");
    CHECK(astray(lone_top(30, 1, 0), 10) != "");
}

TEST_CASE("a body that tumbles about a fixed point keeps its energy and momentum and flip rate") {
    CHECK(astray(20, 0.0004) == "");
    CHECK(astray(40, 0.001) == "");
}

TEST_CASE("planted fault: the test detects a body that tumbles without gyroscopic torque") {
    CHECK(astray(20, 0.0004, 0) != "");
}

TEST_CASE("a body that hits the floor at a fast spin gains little energy") {
    for (const double friction : {0.0, 0.5}) {
        CHECK(most_energy(30, friction) < 1.05);
        CHECK(most_energy(80, friction) < 1.25);
    }
}

TEST_CASE("planted fault: the test detects energy that is added while bodies spin") {
    CHECK(most_energy(30, 0.5, 0.9) > 1.05);
    CHECK(most_energy(80, 0.5, 0.9) > 1.25);
}
