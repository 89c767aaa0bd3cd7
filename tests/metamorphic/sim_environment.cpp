// The environment does not affect the simulation: lanes, rounding modes, allocators. Every bit of the state affects its
// hash.
#include "lockstone/testing.h"
#include "support/allocation_counter.h"
#include "support/sim_script.h"
#include "support/task_worlds.h"
#include "world/data.h"

#include <doctest/doctest.h>

#include <cfenv>
#include <cstdio>
#include <cstring>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

struct Solved {
    std::vector<solve::SolverBody> bodies;
    std::vector<solve::ContactMemory> memory;
    std::uint64_t contacts;
    std::uint64_t hash;
};

/// Runs the next tick of a world with an instruction set, and returns the solver's final data. `plant` may change the
/// kernels first.
template <class Plant> Solved tick_by(const World& w, Simd level, Plant&& plant) {
    sim::Data d(w.def(), w.schema(), w.assets_shared());
    d.state = w.state();
    sim::TickScratch& s = d.scratch;
    const solve::Kernels& kernels = *solve::kernels_of(level);
    s.bodies.kernel = kernels.bodies, s.contact_scratch.pair_kernel = kernels.pairs;
    d.placed.solids.use(kernels.hulls);
    REQUIRE(s.contacts.use(level));
    REQUIRE(s.joint_solver.use(kernels.joints));
    plant(s);
    sim::tick(d);
    return {s.bodies.body,
            {s.table.list.memories.begin(), s.table.list.memories.end()},
            s.found.contacts.size(),
            d.state.hash()};
}
Solved tick_by(const World& w, Simd level) {
    return tick_by(w, level, [](sim::TickScratch&) {});
}

/// Returns an empty string if all velocities, moves and impulses have equal bits.
std::string lanes_differ(const Solved& a, const Solved& b) {
    for (std::size_t i = 0; i + 1 < a.bodies.size(); ++i) // the last entry takes writes for static bodies
        if (std::memcmp(&a.bodies[i], &b.bodies[i], sizeof(solve::SolverBody)) != 0)
            return "body row " + std::to_string(i);
    if (a.memory.size() != b.memory.size()) return "how many contacts";
    for (std::size_t i = 0; i < a.memory.size(); ++i)
        if (std::memcmp(&a.memory[i], &b.memory[i], sizeof(solve::ContactMemory)) != 0)
            return "contact row " + std::to_string(i);
    return a.hash == b.hash ? "" : "hash";
}

/// The scalar kernels with two faults: one step of a velocity of body 5, and two micrometres of the first gap of each
/// pair.
std::uint32_t faster_by_a_step(const solve::BodyPass& pass, std::uint32_t* left) {
    const std::uint32_t count = solve::scalar_bodies.integrate_velocities(pass, left);
    if (pass.first <= 5 && 5 < pass.last) ++pass.bodies[5].v[1];
    return count;
}
void nearer(const solve::PairPass& pass) {
    solve::scalar_pairs.find(pass);
    for (std::uint32_t i = 0; pass.work != solve::PairWork::place && i < pass.count; ++i)
        if (pass.serves[i] != 0) pass.contact[i].points[0].separation.raw -= 1 << 8;
}

#if defined(__SSE2__)
constexpr unsigned flush_and_rounding[] = {0x8040, 0x8040 | 0x2000, 0x4000, 0x6000};
#endif

} // namespace

TEST_CASE("every instruction set gives the bits of plain integers in piles and stacks and bouncing crowds") {
    std::uint64_t contacts = 0;
    int compared = 0;
    for (Scenery scenery : sceneries) {
        World w = start_script(scenery);
        for (int t = 0; t < 150; ++t) {
            step_script(w);
            const Solved plain = tick_by(w, Simd::scalar);
            contacts = std::max(contacts, plain.contacts);
            for (const Simd level : every_simd) {
                if (level == Simd::scalar || !has_simd(level)) continue;
                INFO(std::string(name_of(scenery)), ", tick ", t, ", ", std::string(name_of(level)));
                REQUIRE(lanes_differ(plain, tick_by(w, level)) == "");
                ++compared;
            }
        }
    }
    CHECK(contacts >= 3 * 8); // enough for full packs of the widest lanes
    std::printf("  %d ticks compared with those of plain integers\n", compared);
    CHECK((compared > 0 || best_simd() == Simd::scalar));
}

TEST_CASE("planted fault: the comparison of lanes finds a kernel with a small error") {
    World w = start_script(Scenery::pile);
    for (int t = 0; t < 60; ++t) step_script(w);
    const Solved plain = tick_by(w, Simd::scalar);
    REQUIRE(lanes_differ(plain, tick_by(w, Simd::scalar)) == "");
    solve::BodyKernel bodies = solve::scalar_bodies;
    bodies.integrate_velocities = faster_by_a_step;
    CHECK(lanes_differ(plain, tick_by(w, Simd::scalar, [&](sim::TickScratch& s) {
                           s.bodies.kernel = &bodies;
                       })) == "body row 5");
    const solve::PairKernel pairs{nearer};
    CHECK(lanes_differ(plain, tick_by(w, Simd::scalar, [&](sim::TickScratch& s) {
                           s.contact_scratch.pair_kernel = &pairs;
                       })) != "");
}

TEST_CASE("rounding modes and flushing of denormals do not change a tick and the tick does not change them") {
    for (Scenery scenery : sceneries) {
        INFO(std::string(name_of(scenery)));
        World usual = start_script(scenery), odd = start_script(scenery);
        const int modes[] = {FE_UPWARD, FE_DOWNWARD, FE_TOWARDZERO, FE_TONEAREST};
        for (unsigned t = 0; t < 80; ++t) {
            step_script(usual);
            std::fesetround(modes[t % 4]);
#if defined(__SSE2__)
            const unsigned before = _mm_getcsr();
            _mm_setcsr(before | flush_and_rounding[t % 4]);
#endif
            step_script(odd);
            const std::uint64_t hash = odd.hash();
#if defined(__SSE2__)
            CHECK((_mm_getcsr() & 0xe040u) == ((before | flush_and_rounding[t % 4]) & 0xe040u));
            _mm_setcsr(before);
#endif
            CHECK(std::fegetround() == modes[t % 4]);
            std::fesetround(FE_TONEAREST);
            INFO(difference(usual, odd));
            REQUIRE(hash == usual.hash());
        }
    }
}

TEST_CASE("a tick and its commands and saves and hashes and restores do not allocate after a reserved scene "
          "warmed up") {
    for (Scenery scenery : sceneries) {
        INFO(std::string(name_of(scenery)));
        World w = start_script(scenery);
        const WorldDef& def = w.def();
        done(w.reserve({.bodies = def.bodies_max, .shapes = def.shapes_max, .contacts = def.contacts_max}));
        for (int t = 0; t < 120; ++t) step_script(w);
        Image image;
        w.save(image);
        const BodyId body = w.body_at(w.body_count() - 1);
        const Health health = w.read(health_column, body);
        std::uint64_t sum = 0;
        const auto play = [&] {
            for (int t = 0; t < 60; ++t) {
                done(w.add_force(body, vec(1, 0, 0)));
                done(w.write(health_column, body, health));
                w.tick();
                w.save(image);
                sum += w.hash();
                if (t == 30) w.restore(image);
            }
        };
        const test::AllocationCounter counter;
        play();
        CHECK(counter.count() == 0);
        CHECK(sum != 0);
    }
}

TEST_CASE("a level that wakes and rests again does not allocate when it did so twice before") {
    WorldDef def = small_def();
    def.bodies_max = def.shapes_max = 400;
    World w = made(World::create(def));
    std::vector<BodyId> level;
    for (int i = 0; i < 300; ++i) {
        level.push_back(made(w.create_body({.kind = BodyKind::static_, .pose = at(i, 0, 0)})));
        made(w.create_shape(level.back(), {.geometry = box(0.5_r, 0.5_r, 0.5_r)}));
        if (i % 15 == 0) add_ball(w, at(i, 1, 0));
    }
    for (int t = 0; t < 30; ++t) w.tick();
    Image image;
    w.save(image);
    const auto run = [&] {
        w.restore(image);
        const test::AllocationCounter counter;
        for (int round = 0; round < 3; ++round) {
            for (int i = 0; i < 300; ++i)
                done(w.set_pose(level[static_cast<std::size_t>(i)], at(i, 0.01 * (round + 1), 0)));
            for (int t = 0; t < 3; ++t) w.tick();
        }
        return counter.count();
    };
    run(), run();
    CHECK(run() == 0);
}

TEST_CASE("worlds of every scene do not allocate in ticks that they ran twice before") {
    for (const SceneInfo& info : scenes()) {
        INFO(std::string(info.name));
        World w = test::small_scene(info)->start().value();
        Image image;
        w.save(image);
        const auto run = [&] {
            w.restore(image);
            const test::AllocationCounter counter;
            for (int t = 0; t < 60; ++t) w.tick();
            return counter.count();
        };
        run(), run(); // twice: the memory of the last tick and that of this one swap
        CHECK(run() == 0);
    }
}
