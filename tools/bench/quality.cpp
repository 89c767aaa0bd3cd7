#include "bench/quality.h"

#include "engines/lockstone_engine.h"
#include "lockstone/math/convert.h"

#include <algorithm>
#include <cmath>

namespace lockstone::bench {
namespace {

using namespace engines;

bool is_finite(V3 v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

bool is_lost(const BenchScene& scene, V3 at) {
    return !is_finite(at) || at.y < scene.floor || std::abs(at.x) > scene.half_side ||
           std::abs(at.z) > scene.half_side;
}

/// A copy of the scene with the current poses and without motion. Lost bodies are moved far away from all others.
/// Joints are kept, because the bodies that they connect may overlap.
Scene still_scene(const BenchScene& scene, const Engine& engine) {
    Scene still = scene.scene;
    still.gravity = {};
    for (std::size_t i = 0; i < still.bodies.size(); ++i) {
        Body& body = still.bodies[i];
        body.velocity = body.spin = {};
        if (body.mass == 0 && !body.moves) continue;
        const engines::State now = engine.state(static_cast<int>(i));
        const bool lost = is_lost(scene, now.position);
        body.position = lost ? V3{3.0 * static_cast<double>(i), 1e4, 1e4} : now.position;
        body.rotation = lost ? Turn{} : now.rotation;
    }
    still.humans.clear(); // their bodies and joints are also in the lists of the scene
    still.cars.clear(), still.walkers.clear(), still.probes.clear();
    for (Joint& joint : still.joints) {
        joint.limit = joint.motor_force = joint.friction = joint.spring_hertz = 0;
        joint.frames.reset();
        joint.anchor = still.bodies[static_cast<std::size_t>(joint.b)].position;
    }
    return still;
}

void measure_overlap(const BenchScene& scene, const Engine& engine, Quality& quality) {
    const auto measure = make_lockstone({}, still_scene(scene, engine));
    measure->advance(1); // its contacts belong to the poses at the begin of the tick
    const World& world = world_of(*measure);
    for (const World::ContactPoint& point : world.contacts()) {
        const double overlap = -1e3 * to_double(point.separation);
        const bool with_static = world.mass(world.body_of(point.shape_a)) == Real{} ||
                                 world.mass(world.body_of(point.shape_b)) == Real{};
        quality.overlap_mm = std::max(quality.overlap_mm, overlap);
        if (with_static) quality.overlap_static_mm = std::max(quality.overlap_static_mm, overlap);
    }
}

} // namespace

double widest_joint_mm(const Scene& scene, const Engine& engine) {
    double most = 0;
    for (const Joint& joint : scene.joints)
        if (joint.kind != Link::slider) most = std::max(most, gap(scene, engine, joint));
    return 1e3 * most;
}

Quality quality_of(const BenchScene& scene, const Engine& engine) {
    Quality quality{.sway_mm = 1e3 * drift(scene.scene, engine),
                    .fallen = fallen(scene.scene, engine, 0.25),
                    .joint_mm = widest_joint_mm(scene.scene, engine)};
    for (std::size_t i = 0; i < scene.scene.bodies.size(); ++i)
        if (scene.scene.bodies[i].mass != 0 && is_lost(scene, engine.state(static_cast<int>(i)).position))
            ++quality.lost;
    measure_overlap(scene, engine, quality);
    return quality;
}

} // namespace lockstone::bench
