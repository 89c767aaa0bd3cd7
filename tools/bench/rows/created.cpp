// Rows of bodies that are created and destroyed, and of a world of many static bodies.
#include "bench/rows/rows.h"

namespace lockstone::bench::rows {
namespace {

/// Before each tick one half of all bodies is replaced, the other half before the next; the measured time includes it.
BenchScene churn(Size size) {
    const int count = size == Size::full ? 2000 : 40;
    BenchScene made = begin_row("churn", "1,000 of 2,000 bodies replaced in each tick", 120, 10);
    made.scene.add(engines::slab());
    for (int i = 0; i < count; ++i)
        made.scene.add(solid(engines::mixed_shape(i), place_on_grid(i, count, 1.5, 0.6)));
    made.act = [count, bodies = made.scene.bodies](Engine& engine, int tick) {
        for (int i = 0; i < count / 2; ++i) {
            const int number = 1 + (tick % 2) * (count / 2) + i;
            engine.replace(number, bodies[static_cast<std::size_t>(number)]);
        }
        engine.advance(1);
    };
    made.floor = -20;
    return made;
}

/// Static boxes, and 100 dynamic boxes on some of them.
BenchScene still_world(const char* name, const char* about, Size size) {
    const int count = size == Size::full ? 40000 : 400;
    BenchScene made = begin_row(name, about, 1, 0);
    for (int i = 0; i < count; ++i)
        made.scene.add({.shape = box({0.9, 0.5, 0.9}), .position = place_on_grid(i, count, 2, -0.5)});
    for (int i = 0; i < 100; ++i) made.scene.add(solid(box({0.4, 0.4, 0.4}), place_on_grid(i, 100, 4, 0.4)));
    made.landed_after = 0;
    return made;
}

BenchScene first_tick(Size size) {
    BenchScene made = still_world("static-first", "40,000 static boxes: the first tick", size);
    made.warm = 0, made.counted = 1;
    return made;
}

BenchScene one_more(Size size) {
    BenchScene made =
        still_world("static-creation", "40,000 static boxes: ticks in which one body is created", size);
    made.ticks = made.judged_after = 60, made.settle = 10, made.counted_from = 10, made.scene.room = 100;
    made.act = [room = made.scene.room](Engine& engine, int tick) {
        if (tick < room)
            engine.add(solid(box({0.3, 0.3, 0.3}), {4.0 * (tick % 10) - 18, 3, 4.0 * (tick / 10) - 16}));
        engine.advance(1);
    };
    return made;
}

/// Creates bodies in a world that holds only a floor; no tick follows.
BenchScene creation(Size size) {
    const int count = size == Size::full ? 10000 : 100;
    BenchScene made = begin_row("creation", "10,000 bodies are created", 1, 0);
    made.scene.add(engines::slab());
    std::vector<Body> bodies;
    for (int i = 0; i < count; ++i)
        bodies.push_back(solid(engines::mixed_shape(i), place_on_grid(i, count, 1.5, 2)));
    made.act = [bodies = std::move(bodies)](Engine& engine, int tick) {
        if (tick != 0) return; // the capacity is used up
        for (const Body& body : bodies) engine.add(body);
    };
    made.scene.room = count;
    made.warm = 0, made.counted = 1, made.landed_after = 0;
    return made;
}

} // namespace

std::span<const Maker> created_rows() {
    static constexpr Maker list[] = {{"churn", churn},
                                     {"static-first", first_tick},
                                     {"static-creation", one_more},
                                     {"creation", creation}};
    return list;
}

} // namespace lockstone::bench::rows
