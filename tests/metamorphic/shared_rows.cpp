// Rows that bodies and shapes share are state: which is taken follows from the state alone, in a world that was restored,
// loaded, or grown as in one that went on.
#include "lockstone/world.h"

#include <doctest/doctest.h>

using namespace lockstone;

namespace {

BodyId add(World& w, int kind, Real x) {
    const BodyId body =
        w.create_body({.pose = {.position = {x, 1_r, 0_r}}, .linear_damping = Real(kind % 7)}).value();
    w.create_shape(body, {.geometry = sphere(0.25_r), .friction = Real(kind) / Real(1000)}).value();
    return body;
}

/// Kinds come, change and go; more of them than rows are compared.
void churn(World& w, int from) {
    for (int i = 0; i < 90; ++i) add(w, (from + i * 5) % 400, Real(i % 40));
    const std::vector<BodyId> bodies = w.bodies();
    for (std::size_t i = 0; i < bodies.size(); i += 3) w.destroy(bodies[i]).value();
    for (std::size_t i = 1; i < bodies.size(); i += 3) {
        w.set_body_parameters({.body = bodies[i], .linear_damping = Real(static_cast<int>(i) % 5)}).value();
        w.add_force(bodies[i], {1_r, 0_r, 0_r}).value();
    }
    w.tick();
}

} // namespace

TEST_CASE(
    "shared rows: a world that is restored, loaded or has more memory takes the rows that the other takes") {
    World w = World::create({.bodies_max = 2000, .shapes_max = 2000}).value();
    for (int i = 0; i < 5; ++i) churn(w, i * 90);
    Image image;
    w.save(image);
    const std::vector<std::byte> portable = w.save_portable();
    for (int i = 5; i < 8; ++i) churn(w, i * 90);
    const std::uint64_t went_on = w.hash();

    w.restore(image);
    for (int i = 5; i < 8; ++i) churn(w, i * 90);
    CHECK(w.hash() == went_on);

    World loaded = World::create(w.def()).value();
    loaded.reserve({.bodies = 1500, .shapes = 1500, .contacts = 4000}).value();
    loaded.restore_portable(portable).value();
    for (int i = 5; i < 8; ++i) churn(loaded, i * 90);
    CHECK(loaded.hash() == went_on);
}
