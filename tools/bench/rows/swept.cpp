// Rows in which sweeps (continuous collision) cost most: large bodies of many parts, long bodies, fast bodies, a
// turning drum.
#include "bench/rows/rows.h"

namespace lockstone::bench::rows {
namespace {

/// Adds a ring of quads between two heights of a tree's mesh. A radius of 0 makes a tip.
void add_ring(Shape& mesh, V3 foot, double low, double low_radius, double high, double high_radius) {
    constexpr int sides = 8;
    const int first = static_cast<int>(mesh.points.size());
    for (int i = 0; i < sides; ++i) {
        const double angle = 2 * engines::pi * i / sides, x = std::cos(angle), z = std::sin(angle);
        mesh.points.push_back(foot + V3{low_radius * x, low, low_radius * z});
        mesh.points.push_back(foot + V3{high_radius * x, high, high_radius * z});
    }
    for (int i = 0; i < sides; ++i) {
        const int a = first + 2 * i, b = first + 2 * ((i + 1) % sides);
        mesh.faces.push_back({a, a + 1, b});
        if (high_radius > 0) mesh.faces.push_back({b, a + 1, b + 1});
    }
}

/// Hills with fir trees of 6 m on them, in one mesh.
Shape forest(int quads, double spacing, int trees) {
    Shape mesh = engines::hills(quads, spacing);
    for (int i = 0; i < trees; ++i) {
        V3 foot = place_on_grid(i, trees, quads * spacing / std::sqrt(trees), 0);
        foot.y = engines::hill(foot.x, foot.z) - 0.3;
        add_ring(mesh, foot, 0, 0.25, 2, 0.2);
        for (const double low : {1.5, 3.0, 4.5}) add_ring(mesh, foot, low, 1.5 - 0.25 * low, low + 1.5, 0);
    }
    return mesh;
}

/// A box as a hull whose points are in the axes of its body, as tools write it that cut a mesh into convex parts.
Shape block(V3 center, V3 half) {
    Shape made{.kind = engines::Kind::hull};
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            for (const double z : {-1.0, 1.0})
                made.points.push_back(center + V3{x * half.x, y * half.y, z * half.z});
    made.faces = {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}};
    return made;
}

/// A trunk of three parts and eight branches: eleven hulls around one centre of mass, 6 m high.
Body tree(V3 at) {
    Body made{.shape = block({}, {0.15, 1, 0.15}), .position = at};
    for (const double side : {-1.0, 1.0}) {
        made.parts.push_back({block({0, 2 * side, 0}, {0.12, 1, 0.12})});
        for (const double height : {-1.5, 1.5}) {
            made.parts.push_back({block({0.7 * side, height, 0}, {0.55, 0.06, 0.06})});
            made.parts.push_back({block({0, height, 0.7 * side}, {0.06, 0.06, 0.55})});
        }
    }
    made.mass = 600 * solid_of(made).volume;
    return made;
}

/// Four layers of trees; only the lowest layer comes near the ground.
BenchScene trees(Size size) {
    const bool full = size == Size::full;
    const int count = full ? 1000 : 25, layer = full ? 250 : 9;
    BenchScene made = begin_row(
        "trees", "1,000 trees of 11 hulls fall on a mesh of 94,400 triangles, hills and trees", 40, 20);
    made.scene.add({.shape = full ? forest(200, 0.25, 450) : forest(20, 0.5, 4)});
    Random random(21);
    for (int i = 0; i < count; ++i) {
        Body body = tree(place_on_grid(i % layer, layer, 3, 10 + 7.0 * (i / layer)));
        body.rotation = about({0, 1, 0}, random.between(-engines::pi, engines::pi));
        body.velocity = {random.between(-1, 1), random.between(-11, -9), random.between(-1, 1)};
        made.scene.add(body);
    }
    made.warm = 1, made.counted = 1, made.landed_after = 30;
    return made;
}

BenchScene logs(Size) {
    BenchScene made = begin_row("logs", "40 logs of 12 m fall on hills, a mesh of 100 x 100 quads", 300, 60);
    made.scene.add({.shape = engines::hills(100, 1)});
    Random random(22);
    for (int i = 0; i < 40; ++i) {
        Body log = solid(capsule(0.3, 5.7), place_on_grid(i, 40, 5, 5 + 0.7 * (i % 5)), 600);
        log.rotation = about({0, 1, 0}, random.between(-engines::pi, engines::pi)) *
                       about({0, 0, 1}, engines::pi / 2 + random.between(-0.4, 0.4));
        made.scene.add(log);
    }
    made.half_side = 50;
    return made;
}

/// Bullets (fast bodies with sweeps) to which the script gives a new direction every 40 ticks.
BenchScene bullets(Size) {
    constexpr int count = 64;
    BenchScene made = begin_row(
        "bullets", "64 bullets of 0.1 m at 120 m/s among 100 boxes in a closed room of 20 x 20 m", 240, 100);
    engines::add_pit(made.scene, 10, 8);
    made.scene.add({.shape = box({11, 0.5, 11}), .position = {0, 8.5, 0}, .friction = 0.6});
    for (int i = 0; i < 100; ++i)
        made.scene.add(
            solid(box({0.4, 0.4, 0.4}), place_on_grid(i % 50, 50, 2.4, 0.4 + 0.8 * (i / 50)), 300));
    for (Body& body : made.scene.bodies) body.restitution = 0.6;
    const int first = static_cast<int>(made.scene.bodies.size());
    for (int i = 0; i < count; ++i) {
        Body shot = solid(sphere(0.1), place_on_grid(i, count, 2, 4), 2000);
        shot.bullet = true, shot.restitution = 0.6;
        made.scene.add(shot);
    }
    made.script = [first](Engine& engine, int tick) {
        if (tick % 40 != 0) return;
        Random random(static_cast<std::uint64_t>(1000 + tick));
        for (int i = 0; i < count; ++i) {
            const V3 way = rotate(random.turn(), {120, 0, 0});
            engine.kick(first + i, way - engine.state(first + i).velocity);
        }
    };
    made.half_side = 10;
    return made;
}

BenchScene washer(const char* name, bool continuous, Size size) {
    BenchScene made =
        begin_row(name, "600 cubes of 0.4 m in a turning drum of 10 m, fast bodies are ", 300, 200);
    made.about += continuous ? "swept" : "not swept";
    made.scene.continuous = continuous;
    made.scene.add(engines::turning_drum(5, 2, 1));
    for (int i = 0; i < (size == Size::full ? 600 : 40); ++i)
        made.scene.add(solid(box({0.2, 0.2, 0.2}),
                             {0.5 * (i % 10 - 4.5), 0.5 * (i / 10 % 10 - 4.5), 0.5 * (i / 100 - 2.5)}));
    made.floor = -7;
    return made;
}

BenchScene swept_washer(Size size) { return washer("kinematic-drum", true, size); }
BenchScene plain_washer(Size size) { return washer("kinematic-drum-unswept", false, size); }

} // namespace

std::span<const Maker> swept_rows() {
    static constexpr Maker list[] = {{"trees", trees},
                                     {"logs", logs},
                                     {"bullets", bullets},
                                     {"kinematic-drum", swept_washer},
                                     {"kinematic-drum-unswept", plain_washer}};
    return list;
}

} // namespace lockstone::bench::rows
