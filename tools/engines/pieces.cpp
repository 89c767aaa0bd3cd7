#include "engines/pieces.h"

#include <array>

namespace engines {

void add_pyramid(Scene& scene, int base, V3 at, double friction) {
    constexpr double gap = 0.001; // boxes of a row touch without being squeezed
    for (int row = 0; row < base; ++row)
        for (int i = 0; i < base - row; ++i)
            scene.add(solid(box({0.5, 0.5, 0.5}),
                            at + V3{(1 + gap) * (i - 0.5 * (base - row - 1)), row + 0.5, 0}, 1000, friction));
}

void add_ragdoll(Scene& scene, V3 at) {
    const auto limb = [&](V3 from, V3 to, double radius, double mass) {
        const V3 along = to - from;
        Body body{.shape = capsule(radius, length(along) / 2 - radius),
                  .position = at + (from + to) / 2,
                  .mass = mass};
        const V3 unit = along / length(along);
        body.rotation = about({0, 0, 1}, std::atan2(-unit.x, unit.y));
        return scene.add(body);
    };
    const auto join = [&](Link kind, int a, int b, V3 anchor, double limit) {
        scene.joints.push_back(
            {.kind = kind, .a = a, .b = b, .anchor = at + anchor, .axis = {1, 0, 0}, .limit = limit});
    };
    const int hips = limb({0, 0.85, 0}, {0, 1.15, 0}, 0.13, 15),
              chest = limb({0, 1.15, 0}, {0, 1.55, 0}, 0.15, 25);
    const int head = limb({0, 1.6, 0}, {0, 1.9, 0}, 0.1, 5);
    join(Link::hinge, hips, chest, {0, 1.15, 0}, 0.7);
    join(Link::ball, chest, head, {0, 1.58, 0}, 0);
    for (const double side : {-1.0, 1.0}) {
        const double hip = 0.12 * side, shoulder = 0.2 * side;
        const int thigh = limb({hip, 0.88, 0}, {hip, 0.45, 0}, 0.08, 8),
                  shin = limb({hip, 0.45, 0}, {hip, 0, 0}, 0.06, 5);
        const int upper = limb({shoulder, 1.5, 0}, {shoulder * 2.4, 1.5, 0}, 0.06, 3);
        const int lower = limb({shoulder * 2.4, 1.5, 0}, {shoulder * 3.8, 1.5, 0}, 0.05, 2);
        join(Link::ball, hips, thigh, {hip, 0.88, 0}, 0);
        join(Link::hinge, thigh, shin, {hip, 0.45, 0}, 1.2);
        join(Link::ball, chest, upper, {shoulder, 1.5, 0}, 0);
        join(Link::hinge, upper, lower, {shoulder * 2.4, 1.5, 0}, 1.2);
    }
}

void add_pit(Scene& scene, double half, double height, double friction) {
    const auto wall = [&](V3 size, V3 at) {
        scene.add({.shape = box(size), .position = at, .friction = friction});
    };
    const double side = half + 0.5, half_height = height / 2;
    wall({half + 1, 0.5, half + 1}, {0, -0.5, 0});
    for (const double sign : {-1.0, 1.0}) {
        wall({0.5, half_height, half + 1}, {sign * side, half_height, 0});
        wall({half, half_height, 0.5}, {0, half_height, sign * side});
    }
}

Shape mixed_shape(int i) {
    const std::array<Shape, 3> shapes{sphere(0.5), box({0.5, 0.5, 0.5}), capsule(0.3, 0.4)};
    return shapes[static_cast<std::size_t>(i % 3)];
}

Body slab() { return {.shape = box({50, 0.5, 50}), .position = {0, -0.5, 0}, .friction = 0.6}; }

double hill(double x, double z) {
    return 1.2 * std::sin(0.35 * x) * std::cos(0.3 * z) + 0.6 * std::sin(0.8 * x + 0.5 * z);
}

Shape hills(int quads, double spacing) {
    Shape mesh{.kind = Kind::mesh};
    const double half = 0.5 * quads * spacing;
    for (int row = 0; row <= quads; ++row)
        for (int column = 0; column <= quads; ++column) {
            const double x = spacing * column - half, z = spacing * row - half;
            mesh.points.push_back({x, hill(x, z), z});
        }
    for (int row = 0; row < quads; ++row)
        for (int column = 0; column < quads; ++column) {
            const int a = row * (quads + 1) + column, b = a + 1, c = a + quads + 1, d = c + 1;
            mesh.faces.push_back({a, d, b});
            mesh.faces.push_back({a, c, d});
        }
    return mesh;
}

Body turning_drum(double radius, double half_depth, double spin) {
    constexpr int walls = 32, paddles = 8;
    const double half_width = (radius + 1) * std::tan(pi / walls), end = half_depth + 0.5;
    Body drum{.shape = box({radius + 1, radius + 1, 0.5}),
              .position = {0, 0, -end},
              .spin = {0, 0, spin},
              .moves = true};
    const auto around = [&](Shape shape, double distance, double angle) {
        const V3 at{distance * std::cos(angle), distance * std::sin(angle), end};
        drum.parts.push_back({std::move(shape), at, about({0, 0, 1}, angle)});
    };
    for (int i = 0; i < walls; ++i)
        around(box({0.5, half_width, half_depth + 1}), radius + 0.5, 2 * pi * i / walls);
    for (int i = 0; i < paddles; ++i)
        around(box({1, 0.2, half_depth}), radius - 1, 2 * pi * (i + 0.5) / paddles);
    drum.parts.push_back({box({radius + 1, radius + 1, 0.5}), {0, 0, 2 * end}});
    return drum;
}

Shape random_hull(Random& random, int vertices, double radius) {
    const V3 axes{radius * random.between(0.6, 1), radius * random.between(0.6, 1),
                  radius * random.between(0.6, 1)};
    std::vector<V3> points;
    while (points.size() < static_cast<std::size_t>(vertices)) {
        const V3 p{random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
        const double size = length(p);
        if (size < 0.2 || size > 1) continue;
        const V3 unit = p / size, corner{unit.x * axes.x, unit.y * axes.y, unit.z * axes.z};
        bool is_near = false; // a face between two near points would be a splinter
        for (V3 other : points) is_near = is_near || length(other - corner) < 0.1 * radius;
        if (!is_near) points.push_back(corner);
    }
    return hull_of_points(std::move(points));
}

} // namespace engines
