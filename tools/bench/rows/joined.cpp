// Rows of joints with limits, springs and friction, as games use them.
#include "bench/rows/rows.h"

namespace lockstone::bench::rows {
namespace {

void note_energy(BenchScene& made) {
    made.figure_name = "energy at the end, kJ";
    made.figure = [scene = made.scene](const Engine& engine) { return 1e-3 * energy(scene, engine); };
}

/// Humans in five layers, so that they do not land all at once.
BenchScene rain(Size size) {
    const int count = size == Size::full ? 60 : 5;
    BenchScene made = begin_row("ragdoll-rain", "60 humans of make_ragdoll fall from 1 to 13 m", 300, 120);
    made.scene.add(engines::slab());
    Random random(31);
    for (int i = 0; i < count; ++i) {
        V3 at = place_on_grid(i % 12, 12, 1.6, 1 + 3.0 * (i / 12));
        at.x += random.between(-0.2, 0.2);
        add_human(made.scene, at, random.between(-engines::pi, engines::pi));
    }
    note_energy(made);
    return made;
}

BenchScene humans(Size size) {
    const int count = size == Size::full ? 50 : 4;
    BenchScene made = begin_row("ragdolls-50", "50 humans of make_ragdoll fall onto a floor", 300, 120);
    made.scene.add(engines::slab());
    Random random(32);
    for (int i = 0; i < count; ++i) {
        const V3 push{random.between(-1, 1), 0, random.between(-1, 1)};
        add_human(made.scene, place_on_grid(i, count, 1.5, 0.5 + 0.3 * (i % 4)),
                  random.between(-engines::pi, engines::pi), push);
    }
    note_energy(made);
    return made;
}

/// Chains that hang from the world and start in a horizontal position.
BenchScene chains(Size size) {
    constexpr int links = 12;
    const int count = size == Size::full ? 50 : 3;
    BenchScene made =
        begin_row("spring-chains", "50 chains of 12 links, joints with springs and friction", 300, 120);
    made.scene.add(engines::slab());
    for (int i = 0; i < count; ++i) {
        const V3 top = place_on_grid(i, count, 8, 9);
        for (int k = 0; k < links; ++k) {
            Body link = solid(capsule(0.1, 0.2), top + V3{0.3 + 0.6 * k, 0, 0});
            link.rotation = about({0, 0, 1}, engines::pi / 2);
            const int now = made.scene.add(link);
            made.scene.joints.push_back({.a = k == 0 ? -1 : now - 1,
                                         .b = now,
                                         .anchor = top + V3{0.6 * k, 0, 0},
                                         .axis = {1, 0, 0},
                                         .friction = 1,
                                         .spring_hertz = 1,
                                         .spring_damping = 0.3});
        }
    }
    note_energy(made);
    return made;
}

} // namespace

std::span<const Maker> joined_rows() {
    static constexpr Maker list[] = {
        {"ragdoll-rain", rain}, {"ragdolls-50", humans}, {"spring-chains", chains}};
    return list;
}

} // namespace lockstone::bench::rows
