// Rows of queries: rays, casts and overlaps in a world of bodies and on a mesh. A "tick" of such a row is 500 queries.
#include "bench/rows/rows.h"

namespace lockstone::bench::rows {
namespace {

enum class Kind { ray, cast, overlap };
struct Question {
    Kind kind;
    int probe; ///< index of the probe in the scene, for casts and overlaps
    V3 from, way;
};
using Questions = std::vector<Question>;

/// Returns the number of rays and casts that hit, plus the number of bodies that overlaps find.
int ask(const Engine& engine, const Questions& questions) {
    int found = 0;
    for (const Question& one : questions) switch (one.kind) {
        case Kind::ray:
            found += engine.cast_ray(one.from, one.way) < 1 ? 1 : 0;
            break;
        case Kind::cast:
            found += engine.cast(one.probe, one.from, one.way) < 1 ? 1 : 0;
            break;
        case Kind::overlap:
            found += engine.overlap(one.probe, one.from);
            break;
        }
    return found;
}

/// A world of bodies of three shapes, apart from each other in a cube of 60 m, or of hills. Gravity is off.
BenchScene asked_world(const char* name, const char* about, bool of_bodies, Size size) {
    const bool full = size == Size::full;
    BenchScene made = begin_row(name, about, 40, 10);
    made.scene.gravity = {};
    if (of_bodies) {
        Random random(41);
        for (int i = 0; i < (full ? 2000 : 30); ++i) {
            const auto place = [&](int cell) { return 4.6 * (cell - 6) + random.between(-1.5, 1.5); };
            Body body = solid(engines::mixed_shape(i), {place(i % 13), place(i / 13 % 13), place(i / 169)});
            body.rotation = random.turn();
            made.scene.add(body);
        }
    } else {
        made.scene.add({.shape = engines::hills(full ? 100 : 20, 1)});
        for (int i = 0; i < 30; ++i)
            made.scene.add({.shape = sphere(0.5), .position = place_on_grid(i, 30, 2, -20)});
    }
    made.landed_after = 0, made.floor = -1e9;
    return made;
}

/// Adds the queries to a scene. The script runs two ticks first, which build the structures that the queries search.
BenchScene asking(BenchScene made, const Questions& questions) {
    made.script = [](Engine& engine, int tick) {
        if (tick == 0) engine.advance(2);
    };
    made.act = [questions](Engine& engine, int) { static_cast<void>(ask(engine, questions)); };
    made.figure_name = "found by 500 questions";
    made.figure = [questions](const Engine& engine) { return ask(engine, questions); };
    return made;
}

/// Queries that start anywhere in the cube of 60 m and reach 40 m far.
Questions among_bodies(Kind kind, int probes) {
    Questions questions;
    Random random(42);
    for (int i = 0; i < 500; ++i) {
        const auto place = [&] { return random.between(-30, 30); };
        const V3 from{place(), place(), place()};
        questions.push_back({kind, probes == 0 ? 0 : i % probes, from, rotate(random.turn(), {40, 0, 0})});
    }
    return questions;
}

/// Casts and rays that start 5 m above the hills and slant down; overlaps of probes that lie in the surface.
Questions on_hills(Kind kind) {
    Questions questions;
    Random random(43);
    for (int i = 0; i < 500; ++i) {
        const double x = random.between(-40, 40), z = random.between(-40, 40);
        const V3 way{random.between(-8, 8), -10, random.between(-8, 8)};
        const double above = kind == Kind::overlap ? random.between(-1, 1) : 5;
        questions.push_back({kind, 0, {x, engines::hill(x, z) + above, z}, way});
    }
    return questions;
}

BenchScene body_rays(Size size) {
    return asking(asked_world("rays-bodies", "500 rays of 40 m into 2,000 bodies", true, size),
                  among_bodies(Kind::ray, 0));
}
BenchScene mesh_rays(Size size) {
    return asking(asked_world("rays-mesh", "500 rays into a mesh of 20,000 triangles", false, size),
                  on_hills(Kind::ray));
}
BenchScene with_probes(BenchScene made, std::vector<Shape> probes, const Questions& questions) {
    made.scene.probes = std::move(probes);
    return asking(std::move(made), questions);
}
BenchScene ball_casts(Size size) {
    return with_probes(asked_world("ball-cast-mesh",
                                   "500 casts of a ball of 0.5 m at a mesh of 20,000 triangles", false, size),
                       {sphere(0.5)}, on_hills(Kind::cast));
}
BenchScene box_casts(Size size) {
    return with_probes(
        asked_world("box-cast-mesh", "500 casts of a box of 1 m at a mesh of 20,000 triangles", false, size),
        {box({0.5, 0.5, 0.5})}, on_hills(Kind::cast));
}
BenchScene ball_overlaps(Size size) {
    return with_probes(asked_world("ball-overlap-mesh",
                                   "500 overlaps of a ball of 2 m with a mesh of 20,000 triangles", false,
                                   size),
                       {sphere(2)}, on_hills(Kind::overlap));
}
BenchScene box_overlaps(Size size) {
    return with_probes(asked_world("box-overlap-mesh",
                                   "500 overlaps of a box of 4 m with a mesh of 20,000 triangles", false,
                                   size),
                       {box({2, 2, 2})}, on_hills(Kind::overlap));
}
BenchScene body_casts(Size size) {
    return with_probes(
        asked_world("casts-bodies", "500 casts of a ball and a box by turns into 2,000 bodies", true, size),
        {sphere(0.5), box({0.5, 0.5, 0.5})}, among_bodies(Kind::cast, 2));
}
BenchScene body_overlaps(Size size) {
    return with_probes(asked_world("overlaps-bodies",
                                   "500 overlaps of a ball and a box by turns with 2,000 bodies", true, size),
                       {sphere(2), box({2, 2, 2})}, among_bodies(Kind::overlap, 2));
}

} // namespace

std::span<const Maker> asked_rows() {
    static constexpr Maker list[] = {
        {"rays-bodies", body_rays},           {"rays-mesh", mesh_rays},
        {"ball-cast-mesh", ball_casts},       {"box-cast-mesh", box_casts},
        {"ball-overlap-mesh", ball_overlaps}, {"box-overlap-mesh", box_overlaps},
        {"casts-bodies", body_casts},         {"overlaps-bodies", body_overlaps}};
    return list;
}

} // namespace lockstone::bench::rows
