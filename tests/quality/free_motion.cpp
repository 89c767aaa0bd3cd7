// Free bodies: spin about an unstable axis, nutation, orbits.
#include "quality/row.h"

#include <algorithm>

namespace quality {

namespace {

// ---- spin --------------------------------------------------------------------------------------------------------

/// Free rotation in the body's axes by a fourth-order method: the reference for a spinning body.
class EulerTop {
  public:
    EulerTop(V3 moments, V3 spin) : inertia(moments), w(spin) {}

    /// How often the spin about y changed its sign within `time` [s].
    int flips(double time) {
        constexpr double h = 1e-3;
        int count = 0;
        const auto steps = static_cast<long>(time / h);
        for (long i = 0; i < steps; ++i) {
            const double before = w.y;
            const V3 k1 = rate(w), k2 = rate(w + k1 * (h / 2)), k3 = rate(w + k2 * (h / 2)),
                     k4 = rate(w + k3 * h);
            w += (k1 + 2 * (k2 + k3) + k4) * (h / 6);
            if ((before < 0) != (w.y < 0)) ++count;
        }
        return count;
    }

  private:
    V3 rate(V3 s) const {
        return {(inertia.y - inertia.z) / inertia.x * s.y * s.z,
                (inertia.z - inertia.x) / inertia.y * s.z * s.x,
                (inertia.x - inertia.y) / inertia.z * s.x * s.y};
    }
    V3 inertia, w;
};

/// A box that spins about its middle axis and flips repeatedly. Planted: a spin that is 5 % off, or in another
/// direction.
Figures run_flip(const Contestant& contestant, const Plan& plan) {
    const int seconds = plan.quick ? 60 : 600;
    const V3 spin{0.6, 6, 0.6};
    Scene scene;
    scene.gravity = {};
    Body body = solid(box({0.15, 0.1, 0.05}), {}); // moments: least about x, middle about y, greatest about z
    const V3 momentum = angular_momentum(body, {{}, {}, spin, {}});
    const double energy_at_first = dot(momentum, spin) / 2;
    body.spin = plan.plants(2) ? spin + V3{0.6, 0, 0} : plan.planted >= 0 ? spin * 1.05 : spin;
    const int spinner = scene.add(body);
    const auto engine = make_engine(contestant, scene);
    double worst_energy = 0, worst_size = 0, worst_turn = 0;
    int flips = 0;
    bool was_negative = false;
    for (int tick = 0; tick < seconds * contestant.rate; ++tick) {
        engine->advance(1);
        const State s = engine->state(spinner);
        const V3 now = angular_momentum(body, s);
        worst_energy = std::max(worst_energy, std::abs(dot(now, s.spin) / 2 / energy_at_first - 1));
        worst_size = std::max(worst_size, std::abs(length(now) / length(momentum) - 1));
        worst_turn = std::max(worst_turn, std::atan2(length(cross(now, momentum)), dot(now, momentum)));
        const bool negative = rotate_inverse(s.rotation, s.spin).y < 0;
        if (negative != was_negative) ++flips;
        was_negative = negative;
    }
    const int right = EulerTop(solid_of(body.shape).inertia, spin).flips(seconds);
    return {{worst_energy * 100, worst_size * 100, worst_turn * 180 / pi,
             std::abs(flips - right) / static_cast<double>(right) * 100},
            engine->seconds_per_tick()};
}

/// A disc that wobbles: its axis rotates about its angular momentum at |L| / (moment across). Planted: 1 % faster and a
/// third flatter.
Figures run_wobble(const Contestant& contestant, const Plan& plan) {
    const int seconds = plan.quick ? 60 : 600;
    const Shape right = cylinder(0.3, 0.05), wrong = cylinder(0.3, 0.03);
    Scene scene;
    scene.gravity = {};
    Body body = solid(right, {});
    body.spin = {2, 9, 0};
    const V3 momentum = angular_momentum(body, {{}, {}, body.spin, {}});
    const double across = solid_of(right).inertia.x * body.mass;
    if (plan.planted >= 0) body.shape = wrong, body.spin = body.spin * 1.01;
    const int disc = scene.add(body);
    const auto engine = make_engine(contestant, scene);
    const V3 up = momentum / length(momentum);
    const V3 first = V3{0, 1, 0} - up * up.y;
    const double cone = std::acos(up.y);
    double angle = 0, worst_cone = 0;
    V3 last = first;
    for (int tick = 0; tick < seconds * contestant.rate; ++tick) {
        engine->advance(1);
        const V3 axis = rotate(engine->state(disc).rotation, {0, 1, 0});
        worst_cone = std::max(worst_cone, std::abs(std::acos(std::clamp(dot(axis, up), -1.0, 1.0)) - cone));
        const V3 now = axis - up * dot(axis, up);
        angle += std::atan2(dot(up, cross(last, now)), dot(last, now));
        last = now;
    }
    const double expected = length(momentum) / across * seconds;
    return {{std::abs(angle / expected - 1) * 100, worst_cone * 180 / pi}, engine->seconds_per_tick()};
}

// ---- orbits ------------------------------------------------------------------------------------------------------

/// An ellipse of semi-major axis 10 m and period 10 s about the origin, from its nearest point.
struct Orbit {
    static constexpr double axis = 10, period = 10,
                            attraction = 4 * pi * pi * axis * axis * axis / (period * period);
    double eccentricity;

    Scene scene(double speed_factor) const {
        Scene s;
        s.gravity = {};
        s.attraction = attraction;
        Body body = solid(sphere(0.1), {axis * (1 - eccentricity), 0, 0});
        const double speed = std::sqrt(attraction / axis * (1 + eccentricity) / (1 - eccentricity));
        body.velocity = {0, 0, speed * speed_factor};
        s.add(body);
        return s;
    }
    /// By Kepler's equation.
    V3 position(double time) const {
        const double mean = 2 * pi * time / period, e = eccentricity;
        double anomaly = mean;
        for (int i = 0; i < 50; ++i)
            anomaly -= (anomaly - e * std::sin(anomaly) - mean) / (1 - e * std::cos(anomaly));
        return {axis * (std::cos(anomaly) - e), 0, axis * std::sqrt(1 - e * e) * std::sin(anomaly)};
    }
};

/// Energy and period of an orbit over many revolutions. Planted: it starts 1 % faster.
Figures run_orbit(const Contestant& contestant, const Plan& plan) {
    const Orbit orbit{0.5};
    const Scene scene = orbit.scene(plan.planted >= 0 ? 1.01 : 1);
    const auto engine = make_engine(contestant, scene);
    const double expected = -Orbit::attraction / (2 * Orbit::axis) * scene.bodies[0].mass;
    double worst = 0, first_time = 0, last_time = 0, last_radial = 0;
    int passes = 0;
    for (int tick = 1; tick <= (plan.quick ? 10 : 100) * 10 * contestant.rate; ++tick) {
        engine->advance(1);
        worst = std::max(worst, std::abs(energy(scene, *engine) / expected - 1));
        const State s = engine->state(0);
        const double radial = dot(s.position, s.velocity);
        if (last_radial < 0 && radial >= 0) { // the nearest point is between the last tick and this one
            last_time = (tick - radial / (radial - last_radial)) / contestant.rate;
            if (passes++ == 0) first_time = last_time;
        }
        last_radial = radial;
    }
    const double period = passes < 2 ? 0 : (last_time - first_time) / (passes - 1);
    return {{worst * 100, std::abs(period / Orbit::period - 1) * 100}, engine->seconds_per_tick()};
}

Row orbit_row(const char* name, Scheme scheme, double energy_bound, double period_bound) {
    return {std::string("orbit-") + name,
            std::string("100 revolutions, eccentricity 0.5, integrator ") + name,
            {{"energy", "%", energy_bound}, {"period", "%", period_bound}},
            scheme == Scheme::semi_implicit_euler,
            [scheme](const Contestant& contestant, const Plan& plan) {
                if (contestant.product != Product::lockstone && scheme != Scheme::semi_implicit_euler)
                    return Figures{};
                Contestant chosen = contestant;
                chosen.scheme = scheme;
                return run_orbit(chosen, plan);
            }};
}

/// Position after 2.8 s against Kepler's equation, at two rates. The figure is the difference of the error's order from
/// that of the method. Planted: another orbit, so that the error does not decrease.
Figures run_orders(const Contestant& contestant, const Plan& plan) {
    if (contestant.product != Product::lockstone) return {};
    const Orbit orbit{0.3};
    Figures figures{{}, 0};
    constexpr double promised[] = {1, 2, 2, 4};
    for (int scheme = 0; scheme < 4; ++scheme) {
        double error[2] = {};
        for (int fine = 0; fine < 2; ++fine) {
            Contestant chosen = contestant;
            chosen.scheme = static_cast<Scheme>(scheme);
            chosen.substeps = 1;
            chosen.rate = fine == 0 ? 5 : 10;
            const auto engine = make_engine(chosen, orbit.scene(plan.planted >= 0 ? 1.1 : 1));
            engine->advance(28 * chosen.rate / 10);
            error[fine] = length(engine->state(0).position - orbit.position(2.8));
            figures.seconds_per_tick = std::max(figures.seconds_per_tick, engine->seconds_per_tick());
        }
        figures.values.push_back(std::abs(std::log2(error[0] / error[1]) - promised[scheme]));
    }
    return figures;
}

} // namespace

std::vector<Row> free_motion_rows() {
    return {
        {"flip",
         "a box spins about its middle axis for 10 minutes and turns over about every 3 s",
         {{"energy", "%", 0.1}, {"momentum", "%", 0.1}, {"direction", "deg", 0.1}, {"flips", "%", 1}},
         false,
         run_flip},
        {"wobble",
         "a disc wobbles for 10 minutes: precession against L / I",
         {{"rate", "%", 0.1}, {"cone", "deg", 0.1}},
         false,
         run_wobble},
        orbit_row("euler", Scheme::semi_implicit_euler, 1, 0.1),
        orbit_row("verlet", Scheme::verlet, 0.1, 0.01),
        orbit_row("velocity-verlet", Scheme::velocity_verlet, 0.1, 0.01),
        orbit_row("rk4", Scheme::runge_kutta_4, 0.01, 0.01),
        {"orders",
         "error of position on an orbit, 5 against 10 steps a second: its order, off the promised one",
         {{"euler", "order", 0.2},
          {"verlet", "order", 0.2},
          {"velocity verlet", "order", 0.2},
          {"rk4", "order", 0.2}},
         true,
         run_orders},
    };
}

} // namespace quality
