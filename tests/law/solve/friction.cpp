// Friction: the tangents in which its impulses are stored, and its bound by the normal impulse.
#include "solve/contacts/contact.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <random>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

using Frame = solve::Tangents (*)(UnitVec3);

UnitVec3 unit(D3 v) { return normalized(vec(v[0], v[1], v[2])); }

/// Returns the largest change of a tangent between two normals that are about 1e-6 apart. Half of the normals lie along
/// axes, as most normals of resting bodies do.
double jump(Frame frame) {
    std::mt19937 random(5);
    std::normal_distribution<double> any;
    double most = 0;
    for (int i = 0; i < 20000; ++i) {
        D3 n{any(random), any(random), any(random)};
        if (i % 2 == 0) n = {0, 0, 0}, n[static_cast<std::size_t>(i / 2 % 3)] = i % 4 == 0 ? 1 : -1;
        n = (1 / length(n)) * n;
        const D3 by{1e-6 * any(random), 1e-6 * any(random), 1e-6 * any(random)};
        const solve::Tangents here = frame(unit(n)), there = frame(unit(n + by));
        most = std::max(most, length(to_double(here.first) - to_double(there.first)));
        most = std::max(most, length(to_double(here.second) - to_double(there.second)));
    }
    return most;
}

/// The frame from the smallest component of the normal.
solve::Tangents jumping(UnitVec3 n) {
    const UnitVec3 first = any_perpendicular(n);
    return {first, cross<Unit>(n, first)};
}

/// A domino leans on another one and pushes it over. Returns the energy of both after 52 ticks [J/kg].
double energy_left(std::uint32_t substeps, double friction) {
    WorldDef def = small_def();
    def.substeps = substeps;
    World w = made(World::create(def));
    add_floor(w, {.friction = real(0.81 / friction)}); // the geometric mean of a pair holds the feet
    std::vector<BodyId> dominoes;
    for (int i = 0; i < 2; ++i) {
        BodyDef body{.pose = at(0.7 * i, 0.5, 0)};
        if (i == 0) body.linear_velocity = vec(0.5, 0.06, 0), body.angular_velocity = vec(0, 0, -1);
        dominoes.push_back(
            add(w, body, {.geometry = box(real(0.06), real(0.5), real(0.25)), .friction = real(friction)}));
    }
    for (int t = 0; t < 52; ++t) w.tick();
    double sum = 0;
    for (BodyId b : dominoes) {
        const double inertia = (1 + 0.12 * 0.12) / 12, turn = length(spin(w, b)),
                     speed = length(velocity(w, b));
        sum += 0.5 * speed * speed + 0.5 * inertia * turn * turn + 9.81 * position(w, b)[1];
    }
    return sum;
}

/// A tent of two cards at 25 degrees, after 10 s. Returns how far the first card moved [m].
double tent_drift(double friction) {
    World w = made(World::create(small_def()));
    add_floor(w, {.friction = real(friction)});
    const double a = 25 * 3.14159265358979323846 / 180, s = std::sin(a), c = std::cos(a);
    const double across = 0.01 * c + 0.25 * s, up = 0.01 * s + 0.25 * c;
    std::vector<BodyId> cards;
    for (double side : {-1.0, 1.0})
        cards.push_back(
            add(w, {.pose = at(side * across, up, 0, turned(axis_z, side * 25))},
                {.geometry = box(real(0.01), real(0.25), real(0.2)), .friction = real(friction)}));
    const D3 start = position(w, cards[0]);
    for (int t = 0; t < 600; ++t) w.tick();
    return length(position(w, cards[0]) - start);
}

} // namespace

TEST_CASE("the tangents of a normal are perpendicular unit vectors and turn with it without a jump") {
    std::mt19937 random(3);
    std::normal_distribution<double> any;
    for (int i = 0; i < 20000; ++i) {
        // Half of the normals are close to the seam of the frame.
        const D3 n = i % 2 == 0 ? D3{any(random), any(random), any(random)}
                                : D3{-2 + 0.5 * any(random), -3 + 0.5 * any(random), -6 + 0.5 * any(random)};
        const UnitVec3 normal = unit(n);
        const solve::Tangents t = solve::tangents_of(normal);
        const D3 d = to_double(normal), p = to_double(t.first), q = to_double(t.second);
        const double bound = dot(d, {2, 3, 6}) < -3.5 ? 5e-7 : 2e-8; // the jacobians have 28 bits
        REQUIRE(std::abs(length(p) - 1) < bound);
        REQUIRE(std::abs(length(q) - 1) < bound);
        REQUIRE(std::abs(dot(d, p)) < bound);
        REQUIRE(std::abs(dot(d, q)) < bound);
        REQUIRE(std::abs(dot(p, q)) < bound);
    }
    const double steady = jump(solve::tangents_of), planted = jump(jumping);
    std::printf("  tangents of normals 1e-6 apart: off by %.2g; by the smallest component by %.2g\n", steady,
                planted);
    CHECK(steady < 1e-3);
    CHECK_FALSE(planted < 1e-3);
}

TEST_CASE("friction takes the same energy from a leaning domino in 4 substeps and in 16") {
    const double coarse = energy_left(4, 0.25), fine = energy_left(16, 0.25), rough = energy_left(16, 0.5);
    std::printf("  two dominoes keep %.3f J/kg with 4 substeps, %.3f with 16; rougher ones %.3f\n", coarse,
                fine, rough);
    CHECK(std::abs(coarse - fine) < 0.05);
    CHECK_FALSE(std::abs(coarse - rough) < 0.05);
}

TEST_CASE("two cards lean on each other along their edges for ten seconds") {
    const double held = tent_drift(0.7), slippery = tent_drift(0.15);
    std::printf("  a tent of cards: %.2f mm off; on a smooth floor %.0f mm\n", held * 1e3, slippery * 1e3);
    CHECK(held < 1e-3);
    CHECK_FALSE(slippery < 1e-3);
}
