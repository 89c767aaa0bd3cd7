// Many bodies in a closed box: the time to rest, the overlap, and energy gains.
#include "engines/pieces.h"
#include "quality/row.h"

#include <algorithm>

namespace quality {

namespace {

/// Planes around |x|, |z| <= half and y >= 0, and y <= 2 half when closed.
void add_walls(Scene& scene, double half, bool closed, double friction, double restitution) {
    const auto wall = [&](V3 position, V3 axis, double angle) {
        Body body = ground(friction, restitution);
        body.position = position;
        body.rotation = about(axis, angle);
        scene.add(body);
    };
    scene.add(ground(friction, restitution));
    wall({-half, 0, 0}, {0, 0, 1}, -pi / 2);
    wall({half, 0, 0}, {0, 0, 1}, pi / 2);
    wall({0, 0, -half}, {1, 0, 0}, pi / 2);
    wall({0, 0, half}, {1, 0, 0}, -pi / 2);
    if (closed) wall({0, 2 * half, 0}, {1, 0, 0}, pi);
}

Scene pile_scene(int layers, double restitution, std::uint64_t seed = 7) {
    Random random(seed);
    Scene scene;
    add_walls(scene, 2.2, false, 0.6, restitution);
    for (int layer = 0; layer < layers; ++layer)
        for (int i = 0; i < 9; ++i) {
            const double x = 1.3 * (i % 3 - 1) + random.between(-0.1, 0.1);
            const double z = 1.3 * (i / 3 - 1) + random.between(-0.1, 0.1);
            const V3 at{x, 1 + 1.2 * layer, z};
            const double size = random.between(0.25, 0.4);
            Body body = solid(box({size, random.between(0.2, 0.4), random.between(0.2, 0.4)}), at);
            body.rotation = random.turn();
            body.restitution = restitution;
            scene.add(body);
        }
    return scene;
}

double fastest(const Scene& scene, const Engine& engine) {
    double most = 0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (scene.bodies[i].mass == 0) continue;
        const State s = engine.state(static_cast<int>(i));
        most = std::max({most, length(s.velocity), 0.3 * length(s.spin)});
    }
    return most;
}

/// The deepest overlap of a box with the floor or a wall [m].
double pile_overlap(const Scene& scene, const Engine& engine) {
    double most = 0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const Body& body = scene.bodies[i];
        if (body.mass == 0) continue;
        const State s = engine.state(static_cast<int>(i));
        for (const Body& wall : scene.bodies) {
            if (wall.mass != 0) break; // walls come first
            const V3 normal = rotate(wall.rotation, {0, 1, 0}), d = rotate_inverse(s.rotation, normal);
            const V3 h = body.shape.half;
            const double reach = std::abs(d.x) * h.x + std::abs(d.y) * h.y + std::abs(d.z) * h.z;
            most = std::max(most, reach - dot(normal, s.position - wall.position));
        }
    }
    return most;
}

/// Drops a pile. Returns the time until all bodies are slower than 0.1 m/s [s], and the deepest overlap with a wall
/// then [mm].
std::pair<double, double> rest_of_pile(const Contestant& contestant, const Plan& plan, std::uint64_t seed,
                                       double& tick_time) {
    Scene scene = pile_scene(plan.quick ? 4 : 16, 0, seed);
    scene.sleeping = true; // as in a game: a heap near its tipping point falls in minutes or never
    if (plan.plants(0))
        for (Body& body : scene.bodies) body.restitution = 0.98, body.friction = 0;
    if (plan.plants(1))
        for (Body& body : scene.bodies)
            if (body.mass != 0) body.position.y -= 0.95;
    const auto engine = make_engine(contestant, scene);
    int rest = 0;
    const int ticks = plan.plants(1) ? 1 : 1200;
    for (int tick = 1; tick <= ticks; ++tick) {
        engine->advance(1);
        if (fastest(scene, *engine) > 0.1) rest = tick;
    }
    tick_time = std::max(tick_time, engine->seconds_per_tick());
    return {rest / static_cast<double>(contestant.rate), pile_overlap(scene, *engine) * 1e3};
}

/// The median of nine piles, because rounding decides when a pile near its tipping point slips, and the deepest overlap
/// of all. Planted: high restitution; a start within the floor.
Figures run_pile(const Contestant& contestant, const Plan& plan) {
    std::vector<double> rests;
    double overlap = 0, tick_time = 0;
    for (std::uint64_t seed = 7; seed < (plan.quick ? 8u : 16u); ++seed) {
        const auto [rest, deepest] = rest_of_pile(contestant, plan, seed, tick_time);
        rests.push_back(rest), overlap = std::max(overlap, deepest);
    }
    std::nth_element(rests.begin(), rests.begin() + static_cast<std::ptrdiff_t>(rests.size() / 2),
                     rests.end());
    return {{rests[rests.size() / 2], overlap}, tick_time};
}

/// The greatest rise of the energy above an earlier value, relative to the initial energy [%].
double energy_rise(const Contestant& contestant, const Scene& scene, double floor, int ticks,
                   double& tick_time) {
    const auto engine = make_engine(contestant, scene);
    const double first = energy(scene, *engine) - floor;
    double least = first, rise = 0;
    for (int tick = 0; tick < ticks; ++tick) {
        engine->advance(1);
        const double now = energy(scene, *engine) - floor;
        rise = std::max(rise, now - least);
        least = std::min(least, now);
    }
    tick_time = std::max(tick_time, engine->seconds_per_tick());
    return rise / first * 100;
}

/// Balls that fly in a closed box without gravity.
Scene gas_scene(double restitution) {
    Random random(11);
    Scene scene;
    scene.gravity = {};
    add_walls(scene, 3, true, 0, restitution);
    for (int i = 0; i < 64; ++i) {
        Body ball =
            solid(sphere(0.3), {1.4 * (i % 4 - 1.5), 0.9 + 1.4 * (i / 4 % 4), 1.4 * (i / 16 - 1.5)}, 1000, 0);
        ball.velocity = {random.between(-4, 4), random.between(-4, 4), random.between(-4, 4)};
        ball.restitution = restitution;
        scene.add(ball);
    }
    return scene;
}

/// A dropped pile, a bouncing one, and a gas of elastic balls. Planted: a floor that moves like a belt.
Figures run_energy(const Contestant& contestant, const Plan& plan) {
    Figures figures{{}, 0};
    const int ticks = plan.quick ? 240 : 600, layers = plan.quick ? 3 : 8;
    for (const double restitution : {0.0, 0.5}) {
        Scene scene = pile_scene(layers, restitution);
        if (plan.planted >= 0) scene.bodies[0].surface_velocity = {20, 0, 0};
        figures.values.push_back(energy_rise(contestant, scene, 0, ticks, figures.seconds_per_tick));
    }
    Scene gas = gas_scene(1);
    if (plan.planted >= 0) {
        for (Body& body : gas.bodies) body.friction = 0.6;
        gas.bodies[0].surface_velocity = {20, 0, 0};
    }
    figures.values.push_back(energy_rise(contestant, gas, 0, ticks, figures.seconds_per_tick));
    return figures;
}

} // namespace

std::vector<Row> pile_rows() {
    return {
        {"pile",
         "144 boxes dropped into a box without a lid: the middle of nine such piles",
         {{"at rest after", "s", 8}, {"overlap", "mm", 5}},
         true,
         run_pile,
         true},
        {"energy",
         "the most by which energy rises again in a closed box, of what was there at first",
         {{"dropped, e = 0", "%", 0.1}, {"dropped, e = 0.5", "%", 0.1}, {"elastic balls", "%", 0.1}},
         false,
         run_energy},
    };
}

} // namespace quality
