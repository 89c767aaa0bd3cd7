// Nothing around the simulation matters to it: lanes, rounding modes, allocators; and every bit of its state counts.
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
    solve::SolverBodies bodies;
    std::vector<solve::ContactMemory> memory;
    std::uint64_t contacts;
};

/// The next tick of a world, by an instruction set: its bodies as the solver left them, and what contacts remember.
Solved solve_contacts(const World& w, Simd level) {
    sim::Data d(w.def(), w.schema(), w.assets_shared());
    d.state = w.state();
    sim::TickScratch& scratch = d.scratch;
    scratch.contact_scratch.pair_kernel = solve::kernels_of(level)->pairs;
    scratch.bodies.kernel = solve::kernels_of(level)->bodies;
    REQUIRE(scratch.contacts.use(level));
    sim::tick(d);
    Solved s{scratch.bodies, scratch.table.list.memories, scratch.found.contacts.size()};
    return s;
}

/// Empty when all velocities, moves and impulses have the same bits.
std::string lanes_differ(const Solved& a, const Solved& b) {
    for (std::size_t i = 0; i + 1 < a.bodies.body.size(); ++i) // the still entry takes what is written to it
        if (std::memcmp(&a.bodies.body[i], &b.bodies.body[i], sizeof(solve::SolverBody)) != 0)
            return "body row " + std::to_string(i);
    for (std::size_t i = 0; i < a.memory.size(); ++i)
        if (std::memcmp(&a.memory[i], &b.memory[i], sizeof(solve::ContactMemory)) != 0)
            return "contact row " + std::to_string(i);
    return {};
}

#if defined(__SSE2__)
constexpr unsigned flush_and_rounding[] = {0x8040, 0x8040 | 0x2000, 0x4000, 0x6000};
#endif

} // namespace

TEST_CASE("every instruction set gives the bits of plain integers, in piles, stacks and bouncing crowds") {
    std::uint64_t contacts = 0;
    int compared = 0;
    for (Scenery scenery : sceneries) {
        World w = start_script(scenery);
        for (int t = 0; t < 150; ++t) {
            step_script(w);
            const Solved plain = solve_contacts(w, Simd::scalar);
            contacts = std::max(contacts, plain.contacts);
            for (const Simd level : every_simd) {
                if (level == Simd::scalar || !has_simd(level)) continue;
                INFO(std::string(name_of(scenery)), ", tick ", t, ", ", std::string(name_of(level)));
                REQUIRE(lanes_differ(plain, solve_contacts(w, level)) == "");
                ++compared;
            }
        }
    }
    CHECK(contacts > 40); // enough for full packs
    std::printf("  %d ticks compared with those of plain integers\n", compared);
    CHECK((compared > 0 || best_simd() == Simd::scalar));
}

TEST_CASE("planted fault: an impulse that is off by one bit is found out by the comparison of lanes") {
    World w = start_script(Scenery::pile);
    for (int t = 0; t < 60; ++t) step_script(w);
    const Solved one = solve_contacts(w, Simd::scalar);
    Solved other = one;
    other.bodies.body[5].v[1] ^= 1;
    CHECK(lanes_differ(one, other) == "body row 5");
    other = one;
    other.memory[3].points[0].normal.raw ^= 1;
    CHECK(lanes_differ(one, other) == "contact row 3");
}

TEST_CASE("rounding modes and flushing of denormals around a tick change nothing and are left as they were") {
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

TEST_CASE("ticks, saves, hashes, restores and the commands of a tick do not allocate once a scene that "
          "reserved has "
          "warmed up") {
    for (Scenery scenery : sceneries) {
        INFO(std::string(name_of(scenery)));
        World w = start_script(scenery);
        const WorldDef& def = w.def();
        done(w.reserve({.bodies = def.bodies_max, .shapes = def.shapes_max, .contacts = def.contacts_max}));
        for (int t = 0; t < 120; ++t) step_script(w);
        Image image;
        w.save(image);
        for (int t = 0; t < 60; ++t) w.tick();
        const BodyId body = w.body_at(w.body_count() - 1);
        const Health health = w.read(health_column, body);
        w.restore(image);
        std::uint64_t sum = 0;
        const test::AllocationCounter counter;
        for (int t = 0; t < 60; ++t) {
            done(w.add_force(body, vec(1, 0, 0)));
            done(w.write(health_column, body, health));
            w.tick();
            w.save(image);
            sum += w.hash();
            if (t == 30) w.restore(image);
        }
        CHECK(counter.count() == 0);
        CHECK(sum != 0);
    }
}

TEST_CASE("worlds of every scene tick without allocating what they have ticked through twice") {
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
        run(), run(); // two: memory of the last tick and of this one change places
        CHECK(run() == 0);
    }
}

TEST_CASE("every bit of a small world's state changes its hash") {
    WorldDef def = small_def();
    World w = made(World::create(def, script_schema()));
    add_floor(w);
    add_something(w, 3, {.pose = at(0, 0.3, 0)});
    add_something(w, 0, {.pose = at(0, 0.9, 0)});
    made(w.create_field({.strength = real(0.1)}));
    done(w.destroy(add_crate(w, at(5, 5, 5))));
    for (int t = 0; t < 20; ++t) w.tick();
    State& s = testing::state_of(w);
    const std::uint64_t hash = s.hash();
    std::uint64_t bits = 0;
    for (std::uint32_t c = 0; c < s.layout().columns().size(); ++c) {
        INFO(s.layout().columns()[c].name);
        for (std::size_t byte = 0; byte < s.bytes(c).size(); ++byte)
            for (int bit = 0; bit < 8; ++bit, ++bits) {
                s.edit_bytes(c)[byte] ^= std::byte{1} << bit;
                const bool changed = s.hash() != hash;
                s.edit_bytes(c)[byte] ^= std::byte{1} << bit;
                if (!changed) FAIL_CHECK("a bit that does not count, of byte ", byte);
            }
    }
    CHECK(s.hash() == hash);
    CHECK(bits > 15000);
}
