// Heavy bodies that drop onto light ones. For the tests and for the planted faults.
#pragma once

#include "support/sim_scenes.h"
#include "support/split_mix.h"

#include <cmath>
#include <string>

namespace lockstone::test {

/// Drops a box of up to 10,000 times the mass by up to 10 cm onto light boxes or balls, side by side on a floor or
/// stacked. Returns a sentence if the heavy box rises above its start, if it is awake after 4 s, or if it is then more
/// than 5 mm deep.
inline std::string heavy_load_fault(std::uint64_t seed) {
    SplitMix random(seed);
    const auto drawn = [&](double low, double high) {
        return low + (high - low) * static_cast<double>(random.below(1u << 20)) / (1u << 20);
    };
    constexpr std::uint32_t rates[] = {60, 60, 120};
    WorldDef def = random.below(2) == 0 ? WorldDef{} : WorldDef::precise();
    def.tick_rate = rates[random.below(3)];
    World w = scene::made(World::create(def));
    if (random.below(2) == 0)
        scene::add_floor(w);
    else
        scene::add_wall(w, scene::at(0, -1, 0), scene::vec(10, 1, 10));
    const double ratio = std::pow(10.0, drawn(0, 4)), light = drawn(0.1, 10), half = drawn(0.05, 0.5);
    const std::uint32_t levels = 1 + random.below(3), legs = 1 + 3 * random.below(2);
    for (std::uint32_t level = 0; level < levels; ++level)
        for (std::uint32_t leg = 0; leg < legs; ++leg) {
            const double x = legs == 1 ? 0 : (leg % 2 == 0 ? -2 : 2) * half,
                         z = legs == 1 ? 0 : (leg < 2 ? -2 : 2) * half;
            BodyDef body{.pose = scene::at(x, half * (2 * level + 1), z)};
            body.mass = scene::real(light);
            scene::add(w, body, {.geometry = box(scene::real(half), scene::real(half), scene::real(half))});
        }
    const double wide = legs == 1 ? half : 3.2 * half, tall = drawn(0.1, 0.5), fall = drawn(0, 0.1);
    const double rest = 2 * half * levels + tall;
    BodyDef load{.pose = scene::at(0, rest + fall, 0)};
    load.mass = scene::real(light * ratio);
    const BodyId heavy =
        scene::add(w, load, {.geometry = box(scene::real(wide), scene::real(tall), scene::real(wide))});
    const auto about = [&](const std::string& fault) {
        return "seed " + std::to_string(seed) + ": " + std::to_string(ratio) + " times the mass on " +
               std::to_string(levels) + " levels of " + std::to_string(legs) + " boxes of " +
               std::to_string(2 * half) + " m: " + fault;
    };
    for (std::uint32_t t = 0; t < 4 * def.tick_rate; ++t) {
        w.tick();
        const double above = scene::position(w, heavy)[1] - rest - fall;
        if (above > 0.0005)
            return about("it rises above its start of " + std::to_string(fall) + " m by " +
                         std::to_string(above));
    }
    if (w.is_awake(heavy)) return about("it is awake");
    const double deep = rest - scene::position(w, heavy)[1];
    return deep <= 0.005 * levels ? "" : about("it is " + std::to_string(deep) + " m deep");
}

/// A heavy box hits a row of light boxes without support. Returns a sentence if the total momentum changes.
inline std::string free_row_fault(std::uint64_t seed) {
    SplitMix random(seed);
    World w = scene::made(World::create(scene::weightless()));
    const double ratio = std::pow(10.0, static_cast<double>(random.below(4000)) / 1000),
                 speed = 1 + random.below(8);
    const std::uint32_t count = 1 + random.below(4);
    const auto add = [&](double x, double mass, double vx) {
        BodyDef body{.pose = scene::at(x, 0, 0), .linear_velocity = scene::vec(vx, 0, 0)};
        body.mass = scene::real(mass);
        return scene::add(w, body, {.geometry = box(0.5_r, 0.5_r, 0.5_r)});
    };
    std::vector<std::pair<BodyId, double>> all{{add(0, ratio, speed), ratio}};
    for (std::uint32_t i = 0; i < count; ++i) all.emplace_back(add(1.2 + 1.0 * i, 1, 0), 1);
    for (int t = 0; t < 60; ++t) w.tick();
    double momentum = 0;
    for (const auto& [body, mass] : all) momentum += mass * scene::velocity(w, body)[0];
    const double off = std::abs(momentum - ratio * speed) / (ratio * speed);
    return off <= 1e-4
               ? ""
               : "seed " + std::to_string(seed) + ": " + std::to_string(ratio) + " times the mass into " +
                     std::to_string(count) + " boxes: momentum is off by " + std::to_string(off);
}

} // namespace lockstone::test
