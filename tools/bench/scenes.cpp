#include "bench/scenes.h"

#include "bench/rows/rows.h"

#include "engines/pieces.h"

#include <array>

namespace lockstone::bench {
namespace {

using namespace engines;

/// The start of the i-th body: layers of `side` x `side`, each body a little off its grid place.
V3 place_in_layers(int i, int side, double across, double up, Random& random) {
    const int layer = i / (side * side), column = i % side, row = i / side % side;
    const double middle = 0.5 * (side - 1);
    return {across * (column - middle) + random.between(-0.05, 0.05), 1 + up * layer,
            across * (row - middle) + random.between(-0.05, 0.05)};
}

BenchScene pyramid(Size) {
    BenchScene made{.name = "S1", .about = "pyramid of 820 boxes, base 40"};
    made.scene.add(slab());
    add_pyramid(made.scene, 40, {});
    made.ticks = 300, made.judged_after = 1200, made.counted_from = 100, made.stands = true;
    made.landed_after = 0;
    made.target = {.ratio_must = 2.0,
                   .ratio_goal = 3.0,
                   .instructions_must = 30,
                   .instructions_goal = 20,
                   .overlap_mm = 7,
                   .sway_mm = 20,
                   .heap_mb = 9.0};
    return made;
}

BenchScene pile(Size) {
    BenchScene made{.name = "S2",
                    .about = "1000 spheres, boxes and capsules dropped into a pit of 10 x 10 m"};
    Random random(2);
    add_pit(made.scene, 5, 40);
    for (int i = 0; i < 1000; ++i) {
        Body body = solid(mixed_shape(i), place_in_layers(i, 8, 1.22, 1.3, random));
        body.rotation = about({0, 1, 0}, random.between(-0.3, 0.3));
        made.scene.add(body);
    }
    made.counted_from = 400, made.half_side = 5;
    made.target = {.ratio_must = 2.5,
                   .ratio_goal = 3.7,
                   .instructions_must = 30,
                   .instructions_goal = 20,
                   .overlap_mm = 40,
                   .heap_mb = 10.4};
    return made;
}

BenchScene hulls(Size) {
    BenchScene made{.name = "S3",
                    .about = "500 random hulls of 12 to 24 vertices dropped into a pit of 10 x 10 m"};
    Random random(3);
    add_pit(made.scene, 5, 40);
    for (int i = 0; i < 500; ++i) {
        Body body = solid(random_hull(random, 12 + i % 13, 0.5), place_in_layers(i, 8, 1.15, 1.15, random));
        body.rotation = random.turn();
        made.scene.add(body);
    }
    made.half_side = 5;
    made.target = {.ratio_must = 4.9,
                   .ratio_goal = 7.3,
                   .instructions_must = 24,
                   .instructions_goal = 16,
                   .overlap_mm = 3,
                   .overlap_with_static = true,
                   .heap_mb = 9.0};
    return made;
}

/// A scene without bounds.
BenchScene fallen_ragdolls(const char* name, const char* about, Body floor) {
    BenchScene made{.name = name, .about = about};
    Random random(4);
    made.scene.add(std::move(floor));
    for (int i = 0; i < 50; ++i) {
        const std::size_t first = made.scene.bodies.size();
        add_ragdoll(made.scene, {2.0 * (i % 7 - 3), 0.5 + 0.3 * (i % 4), 1.0 * (i / 7 - 3)});
        const V3 push{random.between(-1, 1), 0, random.between(-1, 1)};
        for (std::size_t k = first; k < made.scene.bodies.size(); ++k) made.scene.bodies[k].velocity = push;
    }
    for (Body& body : made.scene.bodies) body.friction = 0.6;
    return made;
}

BenchScene ragdolls(Size) {
    BenchScene made =
        fallen_ragdolls("S4", "50 ragdolls of 11 capsules and 10 joints fall onto a floor", slab());
    made.target = {.ratio_must = 1.7,
                   .ratio_goal = 2.6,
                   .instructions_must = 18,
                   .instructions_goal = 12,
                   .overlap_mm = 15,
                   .joint_mm = 15,
                   .heap_mb = 5.0};
    return made;
}

BenchScene ragdolls_on_plane(Size) {
    return fallen_ragdolls("S4-plane", "the ragdolls of S4 fall onto a plane", ground(0.6));
}

BenchScene terrain(Size) {
    BenchScene made{.name = "S5",
                    .about = "500 boxes and spheres on hills, a mesh of 100 x 100 quads of 1 m"};
    Random random(5);
    made.scene.add({.shape = hills(100, 1)});
    for (int i = 0; i < 500; ++i) {
        const double x = 3.2 * (i % 23 - 11), z = 3.2 * (i / 23 - 10.5);
        Body body = solid(i % 2 == 0 ? box({0.5, 0.5, 0.5}) : sphere(0.5), {x, hill(x, z) + 2, z});
        body.rotation = random.turn();
        made.scene.add(body);
    }
    made.half_side = 50;
    made.target = {.ratio_must = 2.0,
                   .ratio_goal = 3.0,
                   .instructions_must = 24,
                   .instructions_goal = 16,
                   .overlap_mm = 20};
    return made;
}

BenchScene rollback(Size) {
    BenchScene made{.name = "S6",
                    .about = "a game: 64 mixed bodies, 8 spheres that a script drives among them"};
    Random random(6);
    add_pit(made.scene, 12, 6);
    for (int i = 0; i < 64; ++i) {
        Body body = solid(mixed_shape(i), {2.0 * (i % 8 - 3.5), 1, 2.0 * (i / 8 - 3.5)});
        body.rotation = about({0, 1, 0}, random.between(-pi, pi));
        made.scene.add(body);
    }
    const int first = static_cast<int>(made.scene.bodies.size());
    for (int i = 0; i < 8; ++i)
        made.scene.add(solid(sphere(0.5), {10.0 * std::cos(pi * i / 4), 0.5, 10.0 * std::sin(pi * i / 4)}));
    made.script = [first](Engine& engine, int tick) {
        for (int i = 0; i < 8; ++i) {
            const double angle = pi * (i / 4.0 + 1) + 0.02 * tick * (1 + i / 8.0);
            engine.kick(first + i, V3{std::cos(angle), 0, std::sin(angle)} * 0.12);
        }
    };
    made.counted_from = 200, made.half_side = 12;
    made.landed_after = 60;
    made.target = {.ratio_must = 1.8,
                   .ratio_goal = 2.6,
                   .instructions_must = 1.3,
                   .instructions_goal = 0.9,
                   .overlap_mm = 3};
    return made;
}

BenchScene many_pyramids(Size size) {
    const int side = size == Size::full ? 14 : 2;
    BenchScene made{.name = "pyramids", .about = "196 pyramids of base 10: 10,780 boxes"};
    made.scene.add(ground(0.6));
    for (int i = 0; i < side * side; ++i)
        add_pyramid(made.scene, 10,
                    {12.0 * (i % side - 0.5 * (side - 1)), 0, 4.0 * (i / side - 0.5 * (side - 1))});
    made.ticks = made.judged_after = 100, made.landed_after = 0, made.counted_from = 60, made.stands = true;
    return made;
}

/// A curtain of balls. Every third ball of the top row is static, so that no joint connects two static balls.
BenchScene joint_grid(Size size) {
    const int side = size == Size::full ? 100 : 10;
    BenchScene made{.name = "grid", .about = "a curtain of 10,000 balls and 19,800 ball joints"};
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) {
            Body ball = solid(sphere(0.4), {column - 0.5 * (side - 1), -1.0 * row, 0});
            if (row == 0 && column % 3 == 0) ball.mass = 0;
            const int now = made.scene.add(ball);
            const auto join = [&](int other) {
                const V3 a = made.scene.bodies[static_cast<std::size_t>(other)].position;
                made.scene.joints.push_back({.a = other, .b = now, .anchor = (a + ball.position) / 2});
            };
            if (column > 0) {
                // The adapters need the moving body as the last argument.
                if (ball.mass != 0)
                    join(now - 1);
                else
                    made.scene.joints.push_back(
                        {.a = now, .b = now - 1, .anchor = ball.position - V3{0.5, 0, 0}});
            }
            if (row > 0) join(now - side);
        }
    for (int i = 0; i < side * side; ++i) // a gust of wind
        if (Body& ball = made.scene.bodies[static_cast<std::size_t>(i)]; ball.mass != 0)
            ball.velocity = {0, 0, 2};
    made.ticks = made.judged_after = 120, made.landed_after = 0, made.counted_from = 80, made.floor = -300;
    made.target.instructions_must = 6000e-6 * 19800; // 6,000 instructions a joint
    return made;
}

BenchScene drum(Size size) {
    const bool full = size == Size::full;
    const double radius = full ? 16 : 5, half_depth = 2;
    const int columns = full ? 32 : 6, rows = full ? 32 : 6, deep = 8, count = full ? 8000 : 200;
    BenchScene made{.name = "drum", .about = "8000 cubes of 0.4 m in a turning drum of 32 m with paddles"};
    Body turning = turning_drum(radius, half_depth, 0.436); // 25 degrees a second
    made.scene.add(std::move(turning));
    for (int i = 0; i < count; ++i) {
        const int column = i % columns, layer = i / columns % deep, row = i / (columns * deep);
        made.scene.add(
            solid(box({0.2, 0.2, 0.2}), {0.5 * (column - 0.5 * (columns - 1)), 0.5 * (row - 0.5 * (rows - 1)),
                                         0.47 * (layer - 0.5 * (deep - 1))}));
    }
    made.ticks = made.judged_after = 300, made.counted_from = 250, made.floor = -radius - 2;
    made.target.p99_per_mean = 3, made.target.near_points = 35000;
    return made;
}

constexpr Maker makers[] = {{"S1", pyramid},
                            {"S2", pile},
                            {"S3", hulls},
                            {"S4", ragdolls},
                            {"S5", terrain},
                            {"S6", rollback},
                            {"pyramids", many_pyramids},
                            {"grid", joint_grid},
                            {"drum", drum},
                            {"S4-plane", ragdolls_on_plane}};

} // namespace

std::vector<std::string> scene_names() {
    std::vector<std::string> names;
    for (const Maker& maker : makers) names.emplace_back(maker.name);
    for (const Maker& maker : rows::makers()) names.emplace_back(maker.name);
    return names;
}

BenchScene make_bench_scene(const std::string& name, Size size) {
    for (const Maker& maker : makers)
        if (name == maker.name) return rows::bounded(maker.make(size));
    for (const Maker& maker : rows::makers())
        if (name == maker.name) return rows::bounded(maker.make(size));
    return {};
}

BenchScene resting_boxes(int count) {
    BenchScene made{.name = "boxes", .about = "boxes at rest on a plane"};
    const int side = static_cast<int>(std::ceil(std::sqrt(count)));
    made.scene.add(ground(0.6));
    for (int i = 0; i < count; ++i)
        made.scene.add(solid(box({0.5, 0.5, 0.5}), {2.0 * (i % side - 0.5 * (side - 1)), 0.5,
                                                    2.0 * (i / side - 0.5 * (side - 1))}));
    made.ticks = made.judged_after = 40, made.landed_after = 0, made.stands = true;
    return made;
}

} // namespace lockstone::bench
