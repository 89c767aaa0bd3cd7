// A pit of bodies with features that the solver handles separately: rolling resistance, restitution, locked axes,
// moving surfaces. It runs in several modes at once.
#pragma once

#include "lockstone/math/random.h"
#include "lockstone/tasks.h"
#include "support/sim_scenes.h"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

namespace lockstone::test::features {

using namespace scene;

enum Feature : unsigned { rolls = 1, bounces = 2, locks = 4, slides = 8 };

/// Bodies that fall into a pit with four walls.
inline World pit(std::uint32_t bodies, unsigned features, std::uint64_t seed) {
    WorldDef def;
    def.bodies_max = def.shapes_max = bodies + 8;
    World w = made(World::create(def));
    add_floor(w);
    // Shallow pits, whose packs workers share by place, and deep ones, whose passes workers share by order.
    const double side = seed % 4 == 3 ? 1.5 + std::sqrt(bodies) / 8 : 1.5 + std::sqrt(bodies) / 5;
    for (int i = 0; i < 4; ++i) {
        const double x = i < 2 ? side * (2 * i - 1) : 0, z = i < 2 ? 0 : side * (2 * i - 5);
        add_wall(w, at(x, 5, z), i < 2 ? vec(0.5, 6, side) : vec(side, 6, 0.5));
    }
    lockstone::Random random = lockstone::Random::seeded(seed);
    const auto within = [&](double most) { return most * (random.below(2001) / 1000.0 - 1); };
    for (std::uint32_t i = 0; i < bodies; ++i) {
        BodyDef body;
        const double x = within(side - 0.9), z = within(side - 0.9);
        body.pose = at(x, 0.5 + 0.25 * i / (side * side), z); // layers a metre apart
        if ((features & locks) != 0 && random.below(10) == 0) body.locks = 1 + random.below(62);
        ShapeDef shape;
        switch (random.below(4)) {
        case 0:
            shape.geometry = box(0.3_r, 0.25_r, 0.35_r);
            break;
        case 1:
            shape.geometry = capsule(0.2_r, 0.25_r);
            break;
        case 2:
            shape.geometry = cylinder(0.3_r, 0.2_r);
            break;
        default:
            shape.geometry = sphere(0.3_r);
        }
        if ((features & rolls) != 0) shape.rolling_resistance = 0.05_r;
        if ((features & bounces) != 0) shape.restitution = 0.6_r;
        if ((features & slides) != 0 && random.below(4) == 0) shape.surface_velocity = vec(1, 0, 0.5);
        add(w, body, shape);
    }
    return w;
}

struct Mode {
    std::uint32_t workers;
    Simd simd;
};

/// Ticks worlds of one pit in all modes. The first one is the reference: one worker, plain integers. Returns the first
/// difference.
inline std::string first_difference(std::uint32_t bodies, unsigned features, std::uint64_t seed, int ticks) {
    std::vector<std::unique_ptr<Tasks>> pools;
    std::vector<World> worlds;
    std::vector<Mode> modes;
    const auto add_mode = [&](Mode mode) {
        World w = pit(bodies, features, seed);
        if (!w.set_simd(mode.simd)) return; // this machine lacks it
        if (mode.workers > 1) {
            pools.push_back(make_worker_pool(mode.workers));
            w.set_tasks(pools.back().get());
        }
        worlds.push_back(std::move(w)), modes.push_back(mode);
    };
    add_mode({1, Simd::scalar});
    for (const Simd simd : every_simd) add_mode({1, simd});
    for (const std::uint32_t workers : {2u, 3u, 4u, 8u})
        for (const Simd simd : {Simd::scalar, best_simd()}) add_mode({workers, simd});
    for (int t = 0; t < ticks; ++t) {
        for (World& w : worlds) w.tick();
        for (std::size_t i = 1; i < worlds.size(); ++i)
            if (worlds[i].hash() != worlds[0].hash())
                return "tick " + std::to_string(t) + ", " + std::to_string(modes[i].workers) +
                       " workers, instruction set " + std::string(name_of(modes[i].simd)) + ": " +
                       difference(worlds[0], worlds[i]);
    }
    return {};
}

} // namespace lockstone::test::features
