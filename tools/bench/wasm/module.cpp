// The scenes of `lockstone bench` for a host in JavaScript. The module returns the content of a scene, runs it in
// Lockstone, and measures the quality of the poses of any engine. One instance of the module holds one scene. Numbers
// are passed in arrays of doubles, which stay valid until the next call.
#include "bench/clock.h"
#include "bench/quality.h"
#include "bench/scenes.h"
#include "engines/lockstone_engine.h"

#include <string>

namespace {

using namespace lockstone;
using namespace lockstone::bench;
using namespace engines;

/// A stand-in for an engine of the host. It returns the poses that the host has written and collects the kicks of the
/// script.
class Stranger final : public Engine {
  public:
    std::vector<engines::State> states = {};
    std::vector<double> kicks = {}; ///< four numbers each: body, x, y, z [m/s]
    engines::State state(int body) const override { return states[static_cast<std::size_t>(body)]; }
    void kick(int body, V3 change) override {
        kicks.insert(kicks.end(), {static_cast<double>(body), change.x, change.y, change.z});
    }

  private:
    void tick() override {}
};

struct Stage {
    BenchScene scene = {};
    std::unique_ptr<Engine> engine = nullptr; ///< Lockstone
    Stranger stranger = {};
    std::vector<double> answer = {};
    std::vector<Image> images = std::vector<Image>(16);

    World& world() { return world_of(*engine); }
    void open(const std::string& name) {
        scene = make_bench_scene(name);
        engine = make_lockstone({}, scene.scene);
    }
    void script(int tick) {
        if (scene.script) scene.script(*engine, tick);
    }
};
Stage stage;

constexpr std::size_t numbers_of_pose = 7; // position, rotation

const double* answer_with(std::vector<double> numbers) {
    stage.answer = std::move(numbers);
    return stage.answer.data();
}

} // namespace

#define LOCKSTONE_EXPORT(name) extern "C" [[gnu::used, clang::export_name(#name)]]

/// Opens scene "S<number>". Returns the number of bodies.
LOCKSTONE_EXPORT(open) int open_scene(int number) {
    stage.open("S" + std::to_string(number));
    return static_cast<int>(stage.scene.scene.bodies.size());
}

/// [4]: the number of timed ticks, the tick after which quality is measured, the tick from which rollbacks are timed,
/// and 1 if sway is measured.
LOCKSTONE_EXPORT(facts) const double* facts() {
    const BenchScene& s = stage.scene;
    return answer_with({static_cast<double>(s.ticks), static_cast<double>(s.judged_after),
                        static_cast<double>(s.counted_from), s.stands ? 1.0 : 0.0});
}

/// A body: engines::Kind, three half extents, position, rotation, mass [kg], friction. Every body starts at rest.
LOCKSTONE_EXPORT(body) const double* body(int index) {
    const Body& b = stage.scene.scene.bodies[static_cast<std::size_t>(index)];
    const V3 h = b.shape.half, p = b.position;
    const Turn q = b.rotation;
    return answer_with({static_cast<double>(b.shape.kind), h.x, h.y, h.z, p.x, p.y, p.z, q.x, q.y, q.z, q.w,
                        b.mass, b.friction});
}

/// The kicks of the script before a tick: their number, then body, x, y, z [m/s] of each.
LOCKSTONE_EXPORT(kicks) const double* kicks(int tick) {
    stage.stranger.kicks = {0};
    if (stage.scene.script) stage.scene.script(stage.stranger, tick);
    stage.stranger.kicks[0] = static_cast<double>(stage.stranger.kicks.size() / 4);
    return answer_with(stage.stranger.kicks);
}

/// The processor time of the host's thread [us]. Node has no clock for it.
LOCKSTONE_EXPORT(thread_us) double thread_us_now() { return microseconds_of(CLOCK_THREAD_CPUTIME_ID); }

LOCKSTONE_EXPORT(script) void script(int tick) { stage.script(tick); }
LOCKSTONE_EXPORT(step) void step() { stage.world().tick(); }
LOCKSTONE_EXPORT(hash) std::uint64_t hash() { return stage.world().hash(); }
LOCKSTONE_EXPORT(save) void save(int slot) {
    stage.world().save(stage.images[static_cast<std::size_t>(slot)]);
}
LOCKSTONE_EXPORT(restore) void restore(int slot) {
    stage.world().restore(stage.images[static_cast<std::size_t>(slot)]);
}
LOCKSTONE_EXPORT(image_bytes) std::size_t image_bytes(int slot) {
    return stage.images[static_cast<std::size_t>(slot)].size();
}
LOCKSTONE_EXPORT(set_simd) int set_simd(int level) {
    return stage.world().set_simd(static_cast<Simd>(level)) ? 1 : 0;
}
/// Fault on purpose: adds 2^-16 m/s to a body's velocity, so that hashes must differ from then on.
LOCKSTONE_EXPORT(plant) void plant(int body) { stage.engine->kick(body, {0, 0x1p-16, 0}); }

/// An array for the poses of all bodies, which the host fills: position, rotation.
LOCKSTONE_EXPORT(room_for_poses) double* room_for_poses() {
    stage.answer.assign(numbers_of_pose * stage.scene.scene.bodies.size(), 0);
    return stage.answer.data();
}

/// Lockstone's own poses: position, rotation of each body.
LOCKSTONE_EXPORT(poses) const double* poses() {
    std::vector<double> numbers;
    for (std::size_t i = 0; i < stage.scene.scene.bodies.size(); ++i) {
        const engines::State s = stage.engine->state(static_cast<int>(i));
        numbers.insert(numbers.end(), {s.position.x, s.position.y, s.position.z, s.rotation.x, s.rotation.y,
                                       s.rotation.z, s.rotation.w});
    }
    return answer_with(std::move(numbers));
}

/// The quality of the poses in the array of room_for_poses: overlap, overlap with static bodies, sway [mm], fallen,
/// lost.
LOCKSTONE_EXPORT(judge) const double* judge() {
    stage.stranger.states.clear();
    for (std::size_t i = 0; i < stage.answer.size(); i += numbers_of_pose) {
        const double* p = &stage.answer[i];
        stage.stranger.states.push_back({.position = {p[0], p[1], p[2]},
                                         .velocity = {},
                                         .spin = {},
                                         .rotation = {p[3], p[4], p[5], p[6]}});
    }
    const Quality q = quality_of(stage.scene, stage.stranger);
    return answer_with({q.overlap_mm, q.overlap_static_mm, q.sway_mm, static_cast<double>(q.fallen),
                        static_cast<double>(q.lost)});
}
