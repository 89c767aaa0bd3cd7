// Structures that must stand: pyramid, tower, heavy on light, house of cards, arch.
#include "engines/pieces.h"
#include "quality/row.h"

#include <algorithm>

namespace quality {

namespace {

V3 tilted_gravity(double degrees_x, double degrees_z) {
    const double x = std::sin(radians(degrees_x)), z = std::sin(radians(degrees_z));
    return V3{x, -std::sqrt(1 - x * x - z * z), z} * 9.81;
}

// ---- pyramid -----------------------------------------------------------------------------------------------------

Scene pyramid_scene(int base, const Plan& plan) {
    const bool slippery = plan.plants(1) || plan.plants(2);
    const double friction = slippery ? 0.01 : 0.6;
    Scene scene;
    if (plan.plants(0)) scene.gravity = tilted_gravity(45, 0);
    if (plan.plants(1)) scene.gravity = tilted_gravity(0, 1);
    if (plan.plants(2)) scene.gravity = tilted_gravity(1, 0);
    scene.add(ground(friction));
    add_pyramid(scene, base, {}, friction);
    return scene;
}

Figures run_pyramid(const Contestant& contestant, const Plan& plan) {
    const Scene scene = pyramid_scene(plan.quick ? 10 : 40, plan);
    const auto engine = make_engine(contestant, scene);
    engine->advance(plan.quick ? 200 : 1200);
    double across = 0, along = 0;
    for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
        const V3 moved = engine->state(static_cast<int>(i)).position - scene.bodies[i].position;
        across = std::max(across, std::abs(moved.z));
        along = std::max(along, std::abs(moved.x));
    }
    const double fell = fallen(scene, *engine, 0.25);
    return {{fell, across * 1e3, along * 1e3}, engine->seconds_per_tick()};
}

// ---- tower -------------------------------------------------------------------------------------------------------

/// The deepest overlap of upright bodies in a stack, listed from the bottom, above y = 0 [m].
double deepest_overlap(const Scene& scene, const Engine& engine) {
    double below = 0, most = 0;
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        if (scene.bodies[i].mass == 0) continue;
        const double y = engine.state(static_cast<int>(i)).position.y, half = scene.bodies[i].shape.half.y;
        most = std::max(most, below - (y - half));
        below = y + half;
    }
    return most;
}

Figures run_tower(const Contestant& contestant, const Plan& plan) {
    Scene scene;
    if (plan.plants(0)) scene.gravity = tilted_gravity(30, 0);
    if (plan.plants(1)) scene.gravity = tilted_gravity(0.5, 0);
    const double friction = plan.plants(1) ? 0.005 : 0.6, step = plan.plants(2) ? 0.98 : 1;
    scene.add(ground(friction));
    for (int i = 0; i < (plan.quick ? 10 : 20); ++i)
        scene.add(solid(box({0.5, 0.5, 0.5}), {0, 0.5 + step * i, 0}, 1000, friction));
    const auto engine = make_engine(contestant, scene);
    engine->advance(plan.plants(2) ? 1 : plan.quick ? 300 : 1200);
    const double fell = fallen(scene, *engine, 0.25);
    return {{fell, drift(scene, *engine) * 1e3, deepest_overlap(scene, *engine) * 1e3},
            engine->seconds_per_tick()};
}

// ---- heavy on light ----------------------------------------------------------------------------------------------

Figures run_heavy_on_light(const Contestant& contestant, const Plan& plan) {
    Figures figures{{}, 0};
    double fell = 0;
    for (const double ratio : {10.0, 50.0, 100.0}) {
        Scene scene;
        const bool sunk = plan.planted >= 0 && plan.planted < 3;
        if (plan.plants(3)) scene.gravity = tilted_gravity(60, 0);
        scene.add(ground(0.6));
        scene.add(solid(box({0.5, 0.5, 0.5}), {0, 0.5, 0}, 100));
        scene.add(solid(box({0.5, 0.5, 0.5}), {0, sunk ? 1.48 : 1.5, 0}, 100 * ratio));
        const auto engine = make_engine(contestant, scene);
        engine->advance(sunk ? 1 : plan.quick ? 200 : 600);
        figures.values.push_back(deepest_overlap(scene, *engine) * 1e3);
        figures.seconds_per_tick = std::max(figures.seconds_per_tick, engine->seconds_per_tick());
        fell += fallen(scene, *engine, 0.25);
    }
    figures.values.push_back(fell);
    return figures;
}

// ---- house of cards ----------------------------------------------------------------------------------------------

/// Cards of thickness t and height h. Two cards lean at 25 degrees to form a tent; tents are side by side, flat cards
/// are on top, and the next row of tents is on these. Edges meet exactly.
Scene card_scene(int levels, double friction) {
    constexpr double t = 0.02, h = 0.5, width = 0.4, gap = 0.002;
    const double a = radians(25), s = std::sin(a), c = std::cos(a);
    const V3 half{t / 2, h / 2, width / 2};
    const double across = t / 2 * c + h / 2 * s, up = t / 2 * s + h / 2 * c;
    const double spacing = 2 * (h * s + t * c) + gap;
    Scene scene;
    scene.add(ground(friction));
    double floor = 0;
    for (int level = 0; level < levels; ++level) {
        const int tents = levels - level;
        for (int i = 0; i < tents; ++i) {
            const double x = spacing * (i - 0.5 * (tents - 1));
            for (const double side : {-1.0, 1.0}) {
                Body card = solid(box(half), {x + side * across, floor + up, 0}, 800, friction);
                card.rotation = about({0, 0, 1}, side * a);
                scene.add(card);
            }
        }
        for (int i = 0; i + 1 < tents; ++i)
            scene.add(solid(box({(spacing - gap) / 2, t / 2, width / 2}),
                            {spacing * (i - 0.5 * (tents - 2)), floor + 2 * up + t / 2, 0}, 800, friction));
        floor += 2 * up + t;
    }
    return scene;
}

Figures run_cards(const Contestant& contestant, const Plan& plan) {
    const Scene scene = card_scene(plan.quick ? 2 : 4, plan.planted >= 0 ? 0.2 : 0.7);
    const auto engine = make_engine(contestant, scene);
    engine->advance(plan.quick ? 300 : 1200);
    const double fell = fallen(scene, *engine, 0.05);
    return {{fell, drift(scene, *engine) * 1e3}, engine->seconds_per_tick()};
}

// ---- arch --------------------------------------------------------------------------------------------------------

/// A stone between two radii and two angles from the x axis [rad].
Body voussoir(double inner, double outer, double from, double to, double depth) {
    Shape hull{.kind = Kind::hull};
    for (const double z : {-depth / 2, depth / 2})
        for (const auto& [r, angle] : {std::pair{inner, from}, {outer, from}, {outer, to}, {inner, to}})
            hull.points.push_back({r * std::cos(angle), r * std::sin(angle), z});
    hull.faces = {{0, 1, 2, 3}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};
    // The axes follow the stone's middle radius, so that products of inertia vanish.
    const double middle = (from + to) / 2;
    const Turn turn = about({0, 0, 1}, middle);
    for (V3& p : hull.points) p = rotate_inverse(turn, p);
    const V3 center = center_hull(hull);
    Body stone = solid(std::move(hull), rotate(turn, center), 2000, 0.8);
    stone.rotation = turn;
    return stone;
}

/// A semicircle of stones on two fixed ones. source: Heyman, The Stone Skeleton, 1995: it stands when its thickness is
/// more than 0.1075 of the middle radius. Planted: a smaller thickness.
Scene arch_scene(int stones, double thickness) {
    constexpr double radius = 5, depth = 2, foot = 0.2; // angle of a springer below the horizontal [rad]
    const double inner = radius - thickness / 2, outer = radius + thickness / 2, step = pi / stones;
    Scene scene;
    for (int i = 0; i < stones; ++i) scene.add(voussoir(inner, outer, i * step, (i + 1) * step, depth));
    for (const double from : {-foot, pi}) {
        Body springer = voussoir(inner, outer, from, from + foot, depth);
        springer.mass = 0;
        scene.add(springer);
    }
    return scene;
}

Figures run_arch(const Contestant& contestant, const Plan& plan) {
    const int stones = plan.quick ? 11 : 21;
    const Scene scene = arch_scene(stones, plan.planted >= 0 ? 0.35 : 1);
    const auto engine = make_engine(contestant, scene);
    engine->advance(plan.quick ? 300 : 1200);
    const double fell = fallen(scene, *engine, 0.25);
    const std::size_t crown = static_cast<std::size_t>(stones / 2);
    const double sag = scene.bodies[crown].position.y - engine->state(stones / 2).position.y;
    return {{fell, std::abs(sag) * 1e3}, engine->seconds_per_tick()};
}

} // namespace

std::vector<Row> stack_rows() {
    return {
        {"pyramid",
         "a wall of 820 boxes, base 40, after 1200 ticks",
         {{"fallen", "boxes", 0}, {"drift across", "mm", 1}, {"drift along", "mm", 20}},
         true,
         run_pyramid,
         true},
        {"tower",
         "20 boxes on each other, after 1200 ticks",
         {{"fallen", "boxes", 0}, {"drift", "mm", 2}, {"overlap", "mm", 5}},
         true,
         run_tower},
        {"heavy-on-light",
         "a box on one of the same size and a tenth, fiftieth, hundredth of the mass",
         {{"overlap 10:1", "mm", 5},
          {"overlap 50:1", "mm", 5},
          {"overlap 100:1", "mm", 5},
          {"fallen", "boxes", 0}},
         false,
         run_heavy_on_light,
         true},
        {"cards",
         "a house of 26 cards on 4 levels, after 1200 ticks",
         {{"fallen", "cards", 0}, {"drift", "mm", 10}},
         true,
         run_cards},
        {"arch",
         "a semicircle of 21 stones, a fifth of its radius thick, after 1200 ticks",
         {{"fallen", "stones", 0}, {"crown sinks", "mm", 10}},
         true,
         run_arch,
         true},
    };
}

} // namespace quality
