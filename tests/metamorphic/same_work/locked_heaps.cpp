// Heaps of bodies with locked axes. The distribution of the bodies over packs of contacts, and so the width of lanes
// and the number of workers, changes no bit. The impulse that a hit passes on to other contacts is stopped at the locks
// of all lanes of its pack.
#include "lockstone/math/random.h"
#include "lockstone/tasks.h"
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// Balls, boxes and capsules that fall on each other. Each `step`th body has locks.
World heap(int bodies, std::uint32_t locks, int step, std::uint64_t seed) {
    World w = made(World::create({}));
    add_floor(w);
    Random random = Random::seeded(seed);
    for (int i = 0; i < bodies; ++i) {
        const Real shifted = Real(static_cast<std::int32_t>(random.below(100))) / 256_r;
        BodyDef body{.pose = {.position = {Real(i % 8 - 4) + shifted, Real(i / 8) * 1.3_r + 1_r, 0_r}}};
        if (i % step == 0)
            body.locks = locks;
        else
            body.pose.position.z = shifted / 2_r;
        ShapeDef shape{.geometry = box(0.4_r, 0.3_r, 0.4_r)};
        if (const std::uint32_t kind = random.below(3); kind != 0)
            shape.geometry = kind == 1 ? sphere(0.4_r) : capsule(0.25_r, 0.3_r);
        if (random.below(3) == 0) shape.restitution = 0.4_r;
        add(w, body, shape);
    }
    return w;
}

} // namespace

TEST_CASE("lanes of every width give the same bits to locked bodies") {
    for (const auto& [locks, step] : {std::pair{lock_planar_xy, 2}, std::pair{lock_linear_z, 1}})
        for (std::uint64_t seed = 1; seed <= 12; ++seed) {
            World plain = heap(40, locks, step, seed);
            REQUIRE(plain.set_simd(Simd::scalar));
            std::vector<World> others;
            for (const Simd level : every_simd)
                if (World other = heap(40, locks, step, seed); other.set_simd(level))
                    others.push_back(std::move(other));
            for (int t = 0; t < 180; ++t) {
                plain.tick();
                for (World& other : others) other.tick();
                if (t % 20 != 19) continue;
                for (const World& other : others) REQUIRE(difference(plain, other) == "");
            }
        }
}

TEST_CASE("workers give the same bits to locked bodies") {
    const auto pool = make_worker_pool(4);
    for (const auto& [locks, step] : {std::pair{lock_planar_xy, 2}, std::pair{lock_linear_z, 1}}) {
        World alone = heap(1200, locks, step, 1), shared = heap(1200, locks, step, 1);
        shared.set_tasks(pool.get());
        for (int t = 0; t < 100; ++t) alone.tick(), shared.tick();
        CHECK(difference(alone, shared) == "");
    }
}
