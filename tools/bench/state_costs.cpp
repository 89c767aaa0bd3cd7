#include "bench/state_costs.h"

#include "bench/clock.h"
#include "engines/lockstone_engine.h"

#include <algorithm>
#include <cstring>

namespace lockstone::bench {
namespace {

using namespace engines;

/// A scene in Lockstone that its script drives on.
struct Play {
    Play(const BenchScene& s, const Contestant& who)
        : scene(s), engine(make_lockstone(who, s.scene)), world(world_of(*engine)) {}
    void step() {
        if (scene.script) scene.script(*engine, static_cast<int>(world.tick_count()));
        world.tick();
    }

    const BenchScene& scene;
    std::unique_ptr<Engine> engine;
    World& world;
};

/// Medians of operations after a tick, when the caches hold other data [us].
struct MemoryCosts {
    std::size_t bytes = 0;
    double save = 0, restore = 0, hash = 0, copy = 0;
};

MemoryCosts memory_costs(Play& play, int repeats) {
    World& world = play.world;
    Image image;
    world.save(image); // allocates
    MemoryCosts costs{.bytes = image.size()};
    const std::vector<std::byte> from(costs.bytes, std::byte{1});
    std::vector<std::byte> to(costs.bytes);
    std::vector<double> save, restore, hash, copy;
    volatile std::uint64_t kept = 0; // keeps the compiler from removing the hashes
    for (int i = 0; i < repeats; ++i) {
        play.step();
        hash.push_back(wall_us([&] { kept = world.hash(); }));
        play.step();
        copy.push_back(wall_us([&] {
            std::memcpy(to.data(), from.data(), costs.bytes);
            kept = std::to_integer<std::uint64_t>(to[costs.bytes / 2]);
        }));
        play.step();
        save.push_back(wall_us([&] { world.save(image); }));
        play.step();
        restore.push_back(wall_us([&] { world.restore(image); }));
    }
    costs.save = percentile(std::move(save), 0.5), costs.restore = percentile(std::move(restore), 0.5);
    costs.hash = percentile(std::move(hash), 0.5), costs.copy = percentile(std::move(copy), 0.5);
    return costs;
}

/// Runs `depth` ticks, then the same ticks once more as a rollback: restores the start, and saves after each tick.
Json rollback_cost(Play& play, int depth, int repeats) {
    World& world = play.world;
    Image start;
    std::vector<Image> ring(static_cast<std::size_t>(depth));
    world.save(start);
    for (Image& image : ring) world.save(image);
    std::vector<double> plain, rollback;
    bool is_exact = true;
    for (int i = 0; i < repeats; ++i) {
        world.save(start);
        plain.push_back(thread_us([&] {
            for (int k = 0; k < depth; ++k) play.step();
        }));
        const std::uint64_t hash = world.hash();
        rollback.push_back(thread_us([&] {
            world.restore(start);
            for (Image& image : ring) {
                play.step();
                world.save(image);
            }
        }));
        is_exact = is_exact && world.hash() == hash;
    }
    const double steps = percentile(std::move(plain), 0.5), whole = percentile(std::move(rollback), 0.5);
    return {{"depth", depth},
            {"steps_us", steps},
            {"rollback_us", whole},
            {"ratio", whole / steps},
            {"is_exact", is_exact}};
}

} // namespace

Json state_costs(const BenchScene& scene, const Contestant& who, bool quick) {
    Play play(scene, who);
    for (int tick = 0; tick < (quick ? 3 : scene.counted_from); ++tick) play.step();
    const double bodies = play.world.body_count();
    const MemoryCosts costs = memory_costs(play, quick ? 3 : 31);
    Json rollbacks = Json::array();
    for (const int depth : {8, 60})
        if (!quick || depth == 8)
            rollbacks.push_back(rollback_cost(play, depth, quick ? 1 : depth == 8 ? 9 : 3));
    return {{"scene", scene.name},
            {"bodies", bodies},
            {"contacts", play.world.contacts().size()},
            {"bytes", costs.bytes},
            {"bytes_per_body", static_cast<double>(costs.bytes) / bodies},
            {"save_us", costs.save},
            {"restore_us", costs.restore},
            {"hash_us", costs.hash},
            {"memcpy_us", costs.copy},
            {"save_per_memcpy", costs.save / costs.copy},
            {"rollbacks", rollbacks}};
}

Json awake_costs(bool quick) {
    const int count = quick ? 50 : 2000;
    Json rows = Json::array();
    for (const double fraction : {1.0, 0.5, 0.1, 0.01, 0.0}) {
        BenchScene scene = resting_boxes(count);
        scene.scene.sleeping = true;
        const int awake = static_cast<int>(fraction * count);
        // Without kicks they would fall asleep after half a second.
        scene.script = [awake](Engine& engine, int) {
            for (int i = 1; i <= awake; ++i) engine.kick(i, {});
        };
        Play play(scene, {.name = "Lockstone"});
        for (int tick = 0; tick < 45; ++tick) play.step();
        std::vector<double> ticks;
        for (int tick = 0; tick < (quick ? 3 : 31); ++tick) {
            if (tick % 8 == 0) scene.script(*play.engine, 0);
            ticks.push_back(thread_us([&] { play.world.tick(); }));
        }
        const MemoryCosts costs = memory_costs(play, quick ? 3 : 31);
        rows.push_back({{"bodies", count},
                        {"awake", play.world.awake_count()},
                        {"tick_us", percentile(std::move(ticks), 0.5)},
                        {"save_us", costs.save},
                        {"restore_us", costs.restore},
                        {"hash_us", costs.hash}});
    }
    return rows;
}

} // namespace lockstone::bench
