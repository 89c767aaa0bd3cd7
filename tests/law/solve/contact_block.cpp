// Contacts at rest: their symmetry, and their impulses by the rules of statics.
#include "solve/contacts/contact.h"
#include "support/sim_scenes.h"
#include "world/data.h"

#include <doctest/doctest.h>

#include <algorithm>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double g = 9.81, degree = 3.14159265358979323846 / 180;

// ---- symmetry -------------------------------------------------------------------------------------------------------

/// The symmetric rows of a tower must not push it to a side. Only the rounding of positions remains.
constexpr double off_axis_max = 1e-6;

/// A tower of ten flush boxes, all upright on one axis.
struct Tower {
    World w = made(World::create(small_def()));
    std::vector<BodyId> boxes;

    Tower() {
        add_floor(w);
        boxes = add_stack(w, 10);
    }
    /// The farthest that a box is off the axis [m], or the fastest that it turns [rad/s], after so many ticks.
    double off_axis_after(int ticks) {
        for (int t = 0; t < ticks; ++t) w.tick();
        double most = 0;
        for (const BodyId b : boxes) {
            const D3 p = position(w, b), s = spin(w, b);
            most = std::max({most, std::abs(p[0]), std::abs(p[2]), length(s)});
        }
        return most;
    }
};

/// A plank on two posts with a load at +x or at -x. Returns the places of plank and load after 2 s, mirrored to +x. The
/// floor under the post away from the load is lower by `hollow` [m].
std::array<D3, 2> loaded_plank(double side, double hollow = 0) {
    World w = made(World::create(small_def()));
    for (const double x : {-1.5, 1.5}) {
        add_wall(w, at(x, x * side < 0 ? -0.5 - hollow : -0.5, 0), vec(1, 0.5, 1));
        add_crate(w, at(x, 0.5, 0));
    }
    const BodyId plank =
        add(w, {.pose = at(0, 1.1, 0), .mass = real(200)}, {.geometry = box(real(2), real(0.1), real(0.5))});
    const BodyId load = add(w, {.pose = at(side, 1.6, 0), .mass = real(500)},
                            {.geometry = box(real(0.4), real(0.4), real(0.4))});
    for (int t = 0; t < 120; ++t) w.tick();
    std::array<D3, 2> out{position(w, plank), position(w, load)};
    for (D3& p : out) p[0] *= side;
    return out;
}

/// The difference between a load on the right and one on the left, mirrored. The floor under the left load's far post
/// is lower by `hollow` [m].
double mirror_error(double hollow = 0) {
    const auto right = loaded_plank(1), left = loaded_plank(-1, hollow);
    return std::max(length(right[0] - left[0]), length(right[1] - left[1]));
}
constexpr double mirror_max = 5e-5; ///< [m]

} // namespace

TEST_CASE("a tower of flush boxes stays on its axis without tilt") {
    CHECK(Tower().off_axis_after(240) < off_axis_max);
}
TEST_CASE("planted fault: the test detects a tower in which a box is pushed aside at 1 cm/s") {
    Tower tower;
    REQUIRE(tower.off_axis_after(120) < off_axis_max);
    done(tower.w.add_impulse(tower.boxes[1], {tower.w.mass(tower.boxes[1]) * 0.01_r, {}, {}}));
    CHECK_FALSE(tower.off_axis_after(120) < off_axis_max);
}

TEST_CASE("a load on the left has the mirrored effect of a load on the right") {
    CHECK(mirror_error() < mirror_max);
}
// Both planks begin in the same place. The far post sinks by the hollow and the plank's middle by half of it: 0.1 mm,
// twice the bound.
TEST_CASE("planted fault: the mirror test detects a floor that is 0.2 mm lower under the far post") {
    CHECK_FALSE(mirror_error(2e-4) < mirror_max);
}

// ---- statics --------------------------------------------------------------------------------------------------------

namespace {

/// The support of a box at rest by the floor's four points, under gravity that is tilted towards +x: the impulses along
/// the normal and along the floor, in units of the weight, and the centre of the normal impulses, in units of half an
/// edge. `least` is the least normal impulse of any point.
struct Support {
    double normal, along, centre, least;
};

Support support(double degrees) {
    WorldDef def = small_def();
    def.gravity = vec(g * std::sin(degrees * degree), -g * std::cos(degrees * degree), 0);
    World w = made(World::create(def));
    add_floor(w, {.friction = real(0.9)});
    add(w, {.pose = at(0, 0.5, 0)},
        {.geometry = box(real(0.5), real(0.5), real(0.5)), .friction = real(0.9)});
    for (int t = 0; t < 120; ++t) w.tick();
    // runs the next tick in data whose scratch the test can read
    sim::Data d(w.def(), w.schema(), w.assets_shared());
    d.state = w.state();
    sim::tick(d);
    const double unit = g / (def.tick_rate * def.substeps);
    Support s{0, 0, 0, 1};
    D3 friction{};
    for (const solve::Contact& c : d.scratch.found.contacts) {
        const solve::Tangents t = solve::tangents_of(c.normal);
        const auto& lever =
            to_double(c.normal.y) > 0 ? &solve::ContactPoint::lever_b : &solve::ContactPoint::lever_a;
        const solve::ContactMemory& m = d.scratch.table.list.memories[c.memory];
        friction = friction + (to_double(m.tangent_1) / unit) * to_double(t.first) +
                   (to_double(m.tangent_2) / unit) * to_double(t.second);
        for (std::uint32_t k = 0; k < c.count; ++k) {
            const double p = to_double(m.points[k].normal) / unit;
            s.normal += p;
            s.centre += p * to_double((c.points[k].*lever).x) / 0.5;
            s.least = std::min(s.least, p);
        }
    }
    s.along = length(friction);
    s.centre /= s.normal;
    return s;
}

/// Returns the largest difference between the support of a box and the result of statics at this tilt.
double support_error(double degrees, double claimed) {
    const Support s = support(degrees);
    const double a = claimed * degree;
    return std::max({std::abs(s.normal - std::cos(a)), std::abs(s.along - std::sin(a)),
                     std::abs(s.centre - std::tan(a)), std::max(-s.least, 0.0)});
}

} // namespace

TEST_CASE(
    "the contact points of a resting box carry and hold its weight where its weight line meets the floor") {
    for (const double degrees : {0.0, 5.0, 20.0, 35.0}) {
        CAPTURE(degrees);
        CHECK(support_error(degrees, degrees) < 2e-3);
    }
}
TEST_CASE("planted fault: the test detects a tilt that is half a degree more than claimed") {
    for (const double degrees : {5.0, 20.0, 35.0}) CHECK_FALSE(support_error(degrees + 0.5, degrees) < 2e-3);
}
