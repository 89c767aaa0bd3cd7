// Rows that are games: characters, cars, explosions.
#include "bench/rows/rows.h"

namespace lockstone::bench::rows {
namespace {

BenchScene characters(Size) {
    constexpr int count = 8;
    BenchScene made = begin_row("characters", "8 characters walk among 30 bodies", 600, 200);
    engines::add_pit(made.scene, 12, 6);
    for (int i = 0; i < 30; ++i) {
        Body body = solid(engines::mixed_shape(i), place_on_grid(i, 30, 3, 1), 100);
        body.rotation = about({0, 1, 0}, 0.7 * i);
        made.scene.add(body);
    }
    for (int i = 0; i < count; ++i)
        made.scene.walkers.push_back(
            {10 * std::cos(engines::pi * i / 4), 0.05, 10 * std::sin(engines::pi * i / 4)});
    made.script = [](Engine& engine, int tick) {
        for (int i = 0; i < count; ++i) {
            const double angle = engines::pi * (i / 4.0 + 1) + 0.015 * tick * (1 + i / 8.0);
            engine.walk(i, V3{std::cos(angle), 0, std::sin(angle)} * 4);
        }
    };
    made.half_side = 12;
    return made;
}

BenchScene cars(Size) {
    constexpr int count = 4;
    BenchScene made =
        begin_row("vehicles", "4 cars drive among 40 bodies on hills, a mesh of 100 x 100 quads", 600, 200);
    made.scene.add({.shape = engines::hills(100, 1)});
    for (int i = 0; i < 40; ++i) {
        V3 at = place_on_grid(i, 40, 6, 0);
        at.y = engines::hill(at.x, at.z) + 1;
        made.scene.add(solid(engines::mixed_shape(i), at, 100));
    }
    for (int i = 0; i < count; ++i) {
        V3 at{8.0 * i - 13, 0, i % 2 == 0 ? -3.0 : 3.0};
        at.y = engines::hill(at.x, at.z) + 1.5;
        Body chassis = solid(box({0.85, 0.25, 2}), at);
        chassis.mass = 1300, chassis.friction = 0.3;
        made.scene.cars.push_back({made.scene.add(chassis), {0.78, -0.25, 1.35}});
    }
    made.script = [](Engine& engine, int tick) {
        for (int i = 0; i < count; ++i)
            engine.drive(i, 0.6, (i % 2 == 0 ? 0.5 : -0.5) + 0.3 * std::sin(0.02 * tick));
    };
    made.half_side = 50;
    return made;
}

BenchScene explosions(Size size) {
    const int count = size == Size::full ? 300 : 30;
    BenchScene made = begin_row("explosions", "300 bodies, an explosion among them every 30 ticks", 600, 300);
    engines::add_pit(made.scene, 15, 30);
    for (int i = 0; i < count; ++i)
        made.scene.add(solid(engines::mixed_shape(i), place_on_grid(i % 100, 100, 2, 1 + 1.3 * (i / 100))));
    made.script = [count](Engine& engine, int tick) {
        if (tick % 30 != 15) return;
        constexpr int walls = 5;
        constexpr double reach = 6;
        const double angle = 0.07 * tick;
        const V3 center{7 * std::cos(angle), 0, 7 * std::sin(angle)};
        for (int i = walls; i < walls + count; ++i) {
            const V3 away = engine.state(i).position - center;
            const double distance = length(away);
            if (distance < reach && distance > 0.1)
                engine.kick(i, away * (10 * (1 - distance / reach) / distance));
        }
    };
    made.half_side = 15;
    return made;
}

} // namespace

std::span<const Maker> played_rows() {
    static constexpr Maker list[] = {
        {"characters", characters}, {"vehicles", cars}, {"explosions", explosions}};
    return list;
}

} // namespace lockstone::bench::rows
