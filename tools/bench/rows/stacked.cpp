// Rows of stacks: one tower, and a pyramid six times as large as that of S1.
#include "bench/rows/rows.h"

namespace lockstone::bench::rows {
namespace {

BenchScene tower(Size) {
    BenchScene made = begin_row("tower", "a tower of 20 boxes", 600, 300);
    made.scene.add(engines::slab());
    for (int i = 0; i < 20; ++i) made.scene.add(solid(box({0.5, 0.5, 0.5}), {0, i + 0.5, 0}));
    made.stands = true, made.landed_after = 0;
    return made;
}

BenchScene large_pyramid(Size size) {
    BenchScene made = begin_row("large-pyramid", "pyramid of 5,050 boxes, base 100", 150, 100);
    made.scene.add({.shape = box({100, 0.5, 50}), .position = {0, -0.5, 0}, .friction = 0.6});
    add_pyramid(made.scene, size == Size::full ? 100 : 8, {});
    made.stands = true, made.landed_after = 0;
    return made;
}

} // namespace

std::span<const Maker> stacked_rows() {
    static constexpr Maker list[] = {{"tower", tower}, {"large-pyramid", large_pyramid}};
    return list;
}

} // namespace lockstone::bench::rows
