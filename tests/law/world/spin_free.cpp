// Free bodies, thin and fast: kinetic energy and angular momentum stay constant, and a body of revolution precesses
// about its momentum at the closed form's rate.
#include "lockstone/tasks.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

D3 cross(D3 a, D3 b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A body with its squared radii of gyration about the axes of its shape.
struct Spinner {
    World w;
    BodyId body;
    D3 moments{};

    Spinner(const WorldDef& def, const Geometry& shape, D3 spin)
        : w(made(World::create(def))),
          body(add(w, {.angular_velocity = vec(spin[0], spin[1], spin[2])}, {.geometry = shape})) {
        const MassProperties mass = mass_properties(shape, Real(1000));
        moments = {to_double(mass.gyration_squared.x.x), to_double(mass.gyration_squared.y.y),
                   to_double(mass.gyration_squared.z.z)};
    }
    D3 momentum() const { // per unit of mass
        const Quat q = w.pose(body).rotation;
        const D3 s = to_double(rotate(conjugate(q), to<Real>(w.angular_velocity(body))));
        return to_double(rotate(q, vec(moments[0] * s[0], moments[1] * s[1], moments[2] * s[2])));
    }
    double energy() const { return to_double(w.kinetic_energy()); }
    D3 axis() const { return to_double(rotate(w.pose(body).rotation, vec(0, 1, 0))); }
};

WorldDef empty_def(std::uint32_t substeps) {
    WorldDef def = weightless();
    def.substeps = substeps;
    return def;
}

/// Returns an error sentence unless a free body keeps energy and angular momentum for five seconds, to a thousandth:
/// thirty times the accumulated rounding of angular velocities.
std::string astray(const Geometry& shape, D3 spin) {
    for (const std::uint32_t substeps : {4u, 8u}) {
        Spinner s(empty_def(substeps), shape, spin);
        const double e0 = s.energy();
        const D3 l0 = s.momentum();
        for (int t = 0; t < 300; ++t) {
            s.w.tick();
            if (std::abs(s.energy() / e0 - 1) > 0.001) return "energy";
            if (length(s.momentum() - l0) > 0.001 * length(l0)) return "momentum";
        }
    }
    return {};
}

/// Returns the largest distance of a body of revolution from the closed form within a second, relative to its turn
/// about the momentum.
///   rate about L: |L| / I across, the axis at a constant angle to L      source: Goldstein, Classical Mechanics, 5.6
double off_closed_form(const Geometry& shape, D3 spin) {
    Spinner s(empty_def(4), shape, spin);
    const D3 l = s.momentum();
    const double size = length(l), rate = size / s.moments[0];
    const D3 about = (1 / size) * l, axis = s.axis();
    const double along = axis[0] * about[0] + axis[1] * about[1] + axis[2] * about[2];
    const D3 out = axis - along * about, side = cross(about, out);
    double worst = 0;
    for (int t = 1; t <= 60; ++t) {
        s.w.tick();
        const double angle = rate * t / 60;
        const D3 expected = along * about + std::cos(angle) * out + std::sin(angle) * side;
        worst = std::max(worst, length(s.axis() - expected) / std::max(angle, 1.0));
    }
    return worst;
}

/// A spinning rod falls on a floor. Returns its greatest energy relative to the initial one.
double most_energy_on_floor(double radius, double half, double speed) {
    double most = 0;
    for (int k = 0; k < 6; ++k) {
        World w = made(World::create(small_def()));
        add_floor(w, {.friction = real(0.5)});
        const D3 spin{speed * std::sin(k), 0.3 * speed * std::cos(k), speed * std::cos(k)};
        const Quat q = normalized(turned(axis_x, 17 * k) * turned(axis_z, 31 * k));
        const BodyId b =
            add(w, {.pose = at(0, half + 0.2, 0, q), .angular_velocity = vec(spin[0], spin[1], spin[2])},
                {.geometry = capsule(real(radius), real(half)), .friction = real(0.5)});
        const double mass = to_double(w.mass(b));
        const auto energy = [&] { return to_double(w.kinetic_energy()) + mass * 9.81 * position(w, b)[1]; };
        const double first = energy();
        for (int t = 0; t < 180; ++t) w.tick(), most = std::max(most, energy() / first);
    }
    return most;
}

} // namespace

TEST_CASE("thin bodies that tumble freely keep energy and momentum") {
    CHECK(astray(capsule(real(0.02), real(1)), {15, 4.5, 0}) == "");
    CHECK(astray(capsule(real(0.02), real(1)), {50, 2.5, 0}) == "");
    CHECK(astray(capsule(real(0.05), real(1)), {40, 2, 0}) == "");
    CHECK(astray(capsule(real(0.01), real(0.15)), {75, 3.75, 0}) == "");
    CHECK(astray(capsule(real(0.02), real(1)), {1.5, 75, 0}) == "");
    CHECK(astray(box(real(0.02), real(0.04), real(1)), {30, 20, 3}) == "");
}

TEST_CASE("bodies that spin freely at up to two metres a tick keep energy and momentum") {
    for (const double speed : {300.0, 500.0})
        for (const D3 axis : {D3{1, 0.05, 0.05}, D3{0.05, 1, 0.05}, D3{0.05, 0.05, 1}}) {
            CAPTURE(speed);
            CHECK(astray(box(real(0.05), real(0.1), real(0.2)), speed * axis) == "");
        }
    CHECK(astray(cylinder(real(0.5), real(0.01)), {60, 300, 0}) == "");
}

TEST_CASE("a thin stick precesses about its momentum as in the closed form") {
    for (const D3 spin : {D3{15, 4.5, 0}, D3{3, 0.5, 0}, D3{0.5, 30, 0}, D3{60, 20, 0}}) {
        CAPTURE(spin[0]);
        CHECK(off_closed_form(capsule(real(0.02), real(0.4)), spin) < 0.002);
        CHECK(off_closed_form(cylinder(real(0.05), real(1)), spin) < 0.002);
    }
}

TEST_CASE("thin rods that hit the floor as they spin gain little energy") {
    for (const double speed : {3.0, 10.0, 30.0}) {
        CAPTURE(speed);
        CHECK(most_energy_on_floor(0.01, 0.4, speed) < 1.25);
        CHECK(most_energy_on_floor(0.02, 1, speed) < 1.25);
    }
}
