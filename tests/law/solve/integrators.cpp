// Each integrator has the order that its documentation states, by measurement. The file also measures its error on an
// orbit.
#include "support/about.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <cstdio>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr Integrator integrators[] = {Integrator::semi_implicit_euler, Integrator::verlet,
                                      Integrator::velocity_verlet, Integrator::runge_kutta_4};
constexpr double claimed_order[] = {1, 2, 2, 4};

struct Motion {
    D3 x, v;
};

/// One body in one field. The body is far out and fast, so the resolution of a stored velocity (2e-6 m/s) is below the
/// measured errors.
struct Problem {
    const char* name;
    FieldDef field;
    Motion start;
    double seconds;
    std::vector<std::uint32_t> rates[2]; ///< [ticks/s] for order 1 and 2; for order 4
};

const Problem spring{"spring",
                     {.kind = FieldKind::spring, .strength = Real(1)},
                     {{50, 0, 0}, {0, 20, 10}},
                     6,
                     {{8, 16, 32, 64}, {4, 6, 8}}};
const Problem gravity{
    "point gravity", {.strength = Real(20000)}, {{50, 0, 0}, {0, 17, 0}}, 10, {{8, 16, 32, 64}, {4, 6, 8}}};

D3 acceleration(const Problem& p, D3 x) {
    const double strength = to_double(p.field.strength);
    if (p.field.kind == FieldKind::spring) return -strength * x;
    const double r = length(x);
    return (-strength / (r * r * r)) * x;
}

/// The reference motion: the classical Runge-Kutta method at 1/8192 s in double precision.
Motion reference(const Problem& p, double seconds) {
    const double h = 1.0 / 8192;
    Motion m = p.start;
    for (int i = 0; i < static_cast<int>(seconds / h + 0.5); ++i) {
        const D3 k1 = acceleration(p, m.x), v1 = m.v;
        const D3 k2 = acceleration(p, m.x + (h / 2) * v1), v2 = m.v + (h / 2) * k1;
        const D3 k3 = acceleration(p, m.x + (h / 2) * v2), v3 = m.v + (h / 2) * k2;
        const D3 k4 = acceleration(p, m.x + h * v3), v4 = m.v + h * k3;
        m.x = m.x + (h / 6) * (v1 + 2.0 * v2 + 2.0 * v3 + v4);
        m.v = m.v + (h / 6) * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
    }
    return m;
}

World world_of(const Problem& p, Integrator integrator, std::uint32_t rate, BodyId& body) {
    WorldDef def = weightless();
    def.integrator = integrator;
    def.tick_rate = rate;
    def.substeps = 1;
    World w = made(World::create(def));
    made(w.create_field(p.field));
    body = made(w.create_body({.pose = {quantize<Real>(p.start.x), Quat::identity()},
                               .linear_velocity = quantize<Real>(p.start.v)}));
    return w;
}

/// |x error| + |v error| * 1 s
double error_at(const Problem& p, Integrator integrator, std::uint32_t rate, const Motion& exact) {
    BodyId body;
    World w = world_of(p, integrator, rate, body);
    for (int t = 0; t < static_cast<int>(p.seconds * rate + 0.5); ++t) w.tick();
    return length(position(w, body) - exact.x) + length(velocity(w, body) - exact.v);
}

/// Measures the order between each rate and the next. Returns the last of these orders.
double measured_order(const Problem& p, Integrator integrator) {
    const Motion exact = reference(p, p.seconds);
    double before = 0, order = 0, rate_before = 0;
    std::printf("  %s, %s: error", p.name, name_of(integrator));
    for (std::uint32_t rate : p.rates[integrator == Integrator::runge_kutta_4]) {
        const double error = error_at(p, integrator, rate, exact);
        if (before != 0) order = std::log(before / error) / std::log(rate / rate_before);
        before = error, rate_before = rate;
        std::printf(" %.3g", error);
    }
    std::printf(", order %.2f\n", order);
    return order;
}

struct Orbit {
    double swing_first, swing_last; ///< of the energy within a revolution, relative
    double drift;                   ///< of the mean energy per revolution, relative
    double miss;                    ///< distance to the exact motion after one revolution [m]
};

/// 20 revolutions of an ellipse of eccentricity 0.28 with a half axis of 39 m.
Orbit orbit(Integrator integrator, std::uint32_t rate) {
    BodyId body;
    World w = world_of(gravity, integrator, rate, body);
    const double strength = 20000;
    const auto energy = [&] {
        const D3 x = position(w, body), v = velocity(w, body);
        return dot(v, v) / 2 - strength / length(x);
    };
    const double start = energy(), half_axis = -strength / (2 * start);
    const double period = 2 * 3.14159265358979323846 * std::sqrt(std::pow(half_axis, 3) / strength);
    const int ticks = static_cast<int>(period * rate + 0.5);
    Orbit o{};
    double mean_first = 0, mean_last = 0;
    for (int revolution = 0; revolution < 20; ++revolution) {
        double low = 1e9, high = -1e9, sum = 0;
        for (int t = 0; t < ticks; ++t) {
            w.tick();
            const double e = energy() / start;
            low = std::min(low, e), high = std::max(high, e), sum += e;
        }
        o.swing_last = high - low, mean_last = sum / ticks;
        if (revolution == 0) {
            o.swing_first = o.swing_last, mean_first = mean_last;
            const D3 back = reference(gravity, ticks / double(rate)).x;
            o.miss = length(position(w, body) - back);
        }
    }
    o.drift = (mean_last - mean_first) / 19;
    return o;
}

} // namespace

TEST_CASE("each integrator has its claimed order in a spring field and in point gravity") {
    for (const Problem* p : {&spring, &gravity})
        for (int i = 0; i < 4; ++i) {
            INFO(std::string(p->name), ", ", std::string(name_of(integrators[i])));
            const double order = measured_order(*p, integrators[i]);
            CHECK(order > claimed_order[i] - 0.15);
            CHECK(order < claimed_order[i] + 0.35);
        }
}

TEST_CASE("planted fault: the order test detects an integrator that claims a higher order") {
    CHECK(measured_order(spring, Integrator::semi_implicit_euler) < 2 - 0.15);
    CHECK(measured_order(gravity, Integrator::velocity_verlet) < 4 - 0.15);
}

TEST_CASE("on an orbit the energy of symplectic integrators swings but does not drift") {
    const double swing_bound[] = {1e-2, 3e-5, 6e-5, 5e-6}, miss_bound[] = {0.1, 0.02, 0.02, 1e-3};
    for (int i = 0; i < 4; ++i) {
        const Orbit o = orbit(integrators[i], 60);
        std::printf("  orbit, %s: energy swings %.3g, drifts %.3g per revolution, misses by %.3g m\n",
                    name_of(integrators[i]), o.swing_first, o.drift, o.miss);
        INFO(std::string(name_of(integrators[i])));
        CHECK(o.swing_first < swing_bound[i]);
        CHECK(o.swing_last < 1.1 * o.swing_first + 2e-6);
        CHECK(std::abs(o.drift) < 1e-6); // the rounding of stored velocities is a random walk
        CHECK(o.miss < miss_bound[i]);
    }
}

TEST_CASE("in coarse steps the energy of the fourth-order method drifts but that of Verlet does not") {
    const Orbit fourth = orbit(Integrator::runge_kutta_4, 4), second = orbit(Integrator::verlet, 4);
    std::printf("  orbit at 4 ticks/s: energy drifts %.3g per revolution (fourth order), %.3g (Verlet, "
                "swings %.3g)\n",
                fourth.drift, second.drift, second.swing_first);
    CHECK(std::abs(fourth.drift) > 10 * std::abs(second.drift));
    CHECK(second.swing_last < 1.2 * second.swing_first);
}

TEST_CASE("all integrators agree with the closed form of free fall to their order") {
    // Semi-implicit Euler falls g h t / 2 too far; the others are exact for a constant acceleration.
    for (int i = 0; i < 4; ++i) {
        WorldDef def = small_def();
        def.integrator = integrators[i];
        World w = made(World::create(def));
        const BodyId ball = made(w.create_body({.pose = at(3, 100, -2), .linear_velocity = vec(4, 2, 0)}));
        const double h = 1.0 / (def.tick_rate * def.substeps);
        for (int t = 1; t <= 180; ++t) {
            w.tick();
            // In each tick the change of speed is rounded to 1.9e-6 m/s, always in one direction.
            const double s = t / 60.0, fall = 9.81 / 2 * (s * s + (i == 0 ? h * s : 0));
            REQUIRE(position(w, ball)[0] == test::about(3 + 4 * s, 1e-7));
            REQUIRE(std::abs(position(w, ball)[1] - (100 + 2 * s - fall)) < 1e-6 + 1e-8 * t * t);
            REQUIRE(std::abs(velocity(w, ball)[1] - (2 - 9.81 * s)) < 1e-6 * (t + 1));
        }
    }
}
