// The scenes of the benchmark have the contents that its tables state. A changed scene changes the meaning of old
// results.
#include "bench/rows/rows.h"
#include "bench/scenes.h"
#include "engines/lockstone_engine.h"

#include <doctest/doctest.h>

#include <algorithm>

using namespace lockstone::bench;

namespace {

/// The contents of a scene.
struct Count {
    const char* name;
    std::size_t dynamic, fixed, kinematic, ball_joints, hinges;
    int ticks;
};
constexpr Count counts[] = {
    {"S1", 820, 1, 0, 0, 0, 300},
    {"S2", 1000, 5, 0, 0, 0, 600},
    {"S3", 500, 5, 0, 0, 0, 600},
    {"S4", 550, 1, 0, 250, 250, 600},
    {"S5", 500, 1, 0, 0, 0, 600},
    {"S6", 72, 5, 0, 0, 0, 600},
    {"pyramids", 10780, 1, 0, 0, 0, 100},
    {"grid", 9966, 34, 0, 19800, 0, 120},
    {"drum", 8000, 0, 1, 0, 0, 300},
    {"S4-plane", 550, 1, 0, 250, 250, 600},
    {"trees", 1000, 1, 0, 0, 0, 40},
    {"logs", 40, 1, 0, 0, 0, 300},
    {"bullets", 164, 6, 0, 0, 0, 240},
    {"kinematic-drum", 600, 0, 1, 0, 0, 300},
    {"kinematic-drum-unswept", 600, 0, 1, 0, 0, 300},
    {"ragdoll-rain", 840, 1, 0, 420, 360, 300},
    {"ragdolls-50", 700, 1, 0, 350, 300, 300},
    {"spring-chains", 600, 1, 0, 600, 0, 300},
    {"tower", 20, 1, 0, 0, 0, 600},
    {"large-pyramid", 5050, 1, 0, 0, 0, 150},
    {"characters", 30, 5, 0, 0, 0, 600},
    {"vehicles", 44, 1, 0, 0, 0, 600},
    {"explosions", 300, 5, 0, 0, 0, 600},
    {"churn", 2000, 1, 0, 0, 0, 120},
    {"static-first", 100, 40000, 0, 0, 0, 1},
    {"static-creation", 100, 40000, 0, 0, 0, 60},
    {"creation", 0, 1, 0, 0, 0, 1},
    {"rays-bodies", 2000, 0, 0, 0, 0, 40},
    {"rays-mesh", 0, 31, 0, 0, 0, 40},
    {"ball-cast-mesh", 0, 31, 0, 0, 0, 40},
    {"box-cast-mesh", 0, 31, 0, 0, 0, 40},
    {"ball-overlap-mesh", 0, 31, 0, 0, 0, 40},
    {"box-overlap-mesh", 0, 31, 0, 0, 0, 40},
    {"casts-bodies", 2000, 0, 0, 0, 0, 40},
    {"overlaps-bodies", 2000, 0, 0, 0, 0, 40},
};

std::size_t bodies_that(const engines::Scene& scene, bool (*holds)(const engines::Body&)) {
    return static_cast<std::size_t>(std::ranges::count_if(scene.bodies, holds));
}

std::size_t joints_of(const engines::Scene& scene, engines::Link kind) {
    return static_cast<std::size_t>(std::ranges::count(scene.joints, kind, &engines::Joint::kind));
}

double largest_density_error(const engines::Scene& scene) {
    double most = 0;
    for (const engines::Body& body : scene.bodies)
        if (body.mass != 0)
            most = std::max(most, std::abs(body.mass / engines::solid_of(body.shape).volume - 1000));
    return most;
}

} // namespace

TEST_CASE("every benchmark scene has the bodies and joints of its table") {
    for (const Count& count : counts) {
        CAPTURE(count.name);
        const BenchScene made = make_bench_scene(count.name);
        CHECK(bodies_that(made.scene, [](const engines::Body& b) { return b.mass != 0; }) == count.dynamic);
        CHECK(bodies_that(made.scene, [](const engines::Body& b) { return b.mass == 0 && !b.moves; }) ==
              count.fixed);
        CHECK(bodies_that(made.scene, [](const engines::Body& b) { return b.moves; }) == count.kinematic);
        CHECK(joints_of(made.scene, engines::Link::ball) == count.ball_joints);
        CHECK(joints_of(made.scene, engines::Link::hinge) == count.hinges);
        CHECK(made.ticks == count.ticks);
        CHECK(made.judged_after >= made.ticks);
        CHECK(made.counted_from + made.counted <= made.settle + made.ticks);
    }
    CHECK(scene_names().size() == std::size(counts));
}

TEST_CASE("bodies of the benchmark have a density of 1000 kg per cubic metre") {
    for (const char* name : {"S1", "S2", "S3", "S5", "S6", "pyramids", "drum"}) {
        CAPTURE(name);
        CHECK(largest_density_error(make_bench_scene(name).scene) < 1e-6);
    }
}

TEST_CASE("each row of the benchmark has a bound for its instructions and for its ratio to Bullet's time") {
    for (const Maker& row : rows::makers()) {
        CAPTURE(row.name);
        const Target target = make_bench_scene(row.name).target;
        CHECK(target.instructions_must > 0);
        CHECK(target.instructions_goal > 0);
        CHECK(target.instructions_goal <= target.instructions_must);
        CHECK(target.ratio_must > 0);
        CHECK(target.ratio_goal >= target.ratio_must);
    }
}

TEST_CASE("the ragdolls of the benchmark have the bodies and joints of make_ragdoll()") {
    const engines::Scene scene = make_bench_scene("ragdolls-50", Size::quick).scene;
    const auto engine = engines::make_lockstone({}, scene);
    const lockstone::World& world = engines::world_of(*engine);
    CHECK(world.body_count() == scene.bodies.size());
    CHECK(world.joint_count() == scene.joints.size());
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const engines::State state = engine->state(static_cast<int>(i));
        CHECK(length(state.position - scene.bodies[i].position) < 1e-6);
        CHECK(engines::turned(state.rotation, scene.bodies[i].rotation) < 1e-4);
    }
    for (const engines::Joint& joint : scene.joints) CHECK(engines::gap(scene, *engine, joint) < 1e-6);
}

TEST_CASE("hulls of the benchmark have 12 to 24 corners and all corners lie on the hull") {
    for (const engines::Body& body : make_bench_scene("S3").scene.bodies) {
        if (body.mass == 0) continue;
        const std::size_t corners = body.shape.points.size();
        CHECK(corners >= 12);
        CHECK(corners <= 24);
        CHECK(body.shape.faces.size() == 2 * corners - 4); // Euler's formula, for triangles
    }
}

TEST_CASE("a quick benchmark scene is no larger than the full scene and has joints exactly if the full scene "
          "has them") {
    for (const std::string& name : scene_names()) {
        CAPTURE(name);
        const BenchScene full = make_bench_scene(name), quick = make_bench_scene(name, Size::quick);
        CHECK(quick.scene.bodies.size() <= full.scene.bodies.size());
        CHECK(quick.scene.joints.empty() == full.scene.joints.empty());
        CHECK(quick.scene.bodies.size() + static_cast<std::size_t>(quick.scene.room) > 20);
    }
}
