// Pairs of shapes in lanes: every instruction set gives the bits of a single lane.
#include "lockstone/math/math.h"
#include "lockstone/math/random.h"
#include "support/pair_lanes.h"

#include <doctest/doctest.h>

#include <cstring>

using namespace lockstone;

namespace {

/// Numbers of all sizes, including the ends of their range.
std::int64_t any64(Random& random, int bits) {
    const std::uint64_t word = std::uint64_t{random.next_u32()} << 32 | random.next_u32();
    const int drop = 63 - static_cast<int>(random.next_u32() % static_cast<std::uint32_t>(bits));
    return static_cast<std::int64_t>(word) >> drop;
}
std::int32_t any32(Random& random, int bits = 31) { return static_cast<std::int32_t>(any64(random, bits)); }

Quat any_rotation(Random& random) {
    const auto part = [&] { return Unit::from_raw(any32(random, 29)); };
    return normalized(Quat{part(), part(), part(), Unit::from_raw(unit_one.raw / 2)});
}

/// Pairs as worlds have them, and with values that no world has: displacements of up to 2^63, speeds of up to 2^31.
struct Sample {
    static constexpr std::size_t count = 203; // no multiple of any lane width

    struct Pair {
        Quat rotation_a, rotation_b;
        Rotation axes;
        solve::Velocity velocity_a, velocity_b;
        solve::ContactMemory memory;
        solve::PairLane lane;
    };
    std::vector<Pair> pairs{count};
    std::vector<solve::PairRow> rows;

    explicit Sample(std::uint64_t seed) {
        Random random = Random::seeded(seed);
        for (Pair& pair : pairs) fill(pair, random), rows.push_back({&pair.lane, &pair.memory});
    }

  private:
    static void fill(Pair& p, Random& random) {
        p.rotation_a = any_rotation(random), p.rotation_b = any_rotation(random);
        p.axes = to_rotation(p.rotation_a);
        for (solve::Velocity* v : {&p.velocity_a, &p.velocity_b})
            for (int i = 0; i < 3; ++i) v->linear[i].raw = any32(random), v->angular[i].raw = any32(random);
        p.memory = {};
        p.memory.count = 1 + random.next_u32() % 4;
        p.memory.normal = normalized(UnitVec3{p.rotation_b.x, p.rotation_b.y, unit_one});
        for (solve::ContactPointMemory& point : p.memory.points) {
            for (int i = 0; i < 3; ++i) point.position[i].raw = any32(random);
            point.separation.raw = any32(random);
        }
        solve::PairLane& lane = p.lane = {};
        const bool near = random.next_u32() % 2 == 0; // near the place where the manifold was made
        for (int i = 0; i < 3; ++i) {
            lane.way.v[i] = any64(random, near ? 40 : 63), lane.way.u[i] = any64(random, 63);
            lane.kept.u[i] = random.next_u32() % 2 == 0 ? 0 : any32(random);
            lane.given.v[i] = any64(random, 38);
        }
        lane.rotation_a = &p.rotation_a, lane.rotation_b = &p.rotation_b, lane.axes_a = &p.axes;
        lane.velocity_a = &p.velocity_a, lane.velocity_b = &p.velocity_b;
        lane.limit = near ? 1 << 24 : any32(random), lane.reach = 1 << 20,
        lane.step_max = any32(random) & 0x7fffffff;
        const auto chance = [&] { return random.next_u32() % 2 == 0 ? -1 : 0; };
        lane.advances = chance(), lane.on_ground = chance();
        lane.is_given = random.next_u32() % 8 == 0 ? -1 : 0;
        p.memory.made_rotation = conjugate(p.rotation_a) * p.rotation_b;
        lane.made_rotation = &p.memory.made_rotation;
        solve::PairPlace place{};
        std::uint8_t serves = 0;
        solve::PairContact unused{};
        const solve::PairRow row{&lane, &p.memory};
        solve::kernels_of(Simd::scalar)
            ->pairs->find({solve::PairWork::place, &row, 1, unit_one, &place, &unused, &serves});
        for (int i = 0; i < 3; ++i)
            lane.kept.v[i] = near ? place.position[i] + any32(random, 20) : any64(random, 63);
    }
};

struct Found {
    std::vector<solve::PairPlace> places{Sample::count};
    std::vector<solve::PairContact> contacts{Sample::count};
    std::vector<std::uint8_t> serves = std::vector<std::uint8_t>(Sample::count);

    Found(const Sample& sample, solve::PairWork work, Simd level) {
        solve::kernels_of(level)->pairs->find({work, sample.rows.data(), Sample::count,
                                               Unit::from_raw(unit_one.raw / 120), places.data(),
                                               contacts.data(), serves.data()});
    }
};

/// Returns an empty string if both have equal bits.
std::string differ(const Sample& sample, const Found& a, const Found& b) {
    for (std::size_t i = 0; i < Sample::count; ++i) {
        if (std::memcmp(&a.places[i], &b.places[i], sizeof a.places[i]) != 0)
            return "place " + std::to_string(i);
        if (a.serves[i] != b.serves[i]) return "serves " + std::to_string(i);
        if (a.serves[i] == 0) continue;
        const std::size_t bytes = 16 + sizeof(solve::ContactPoint) * sample.pairs[i].memory.count;
        if (std::memcmp(&a.contacts[i], &b.contacts[i], bytes) != 0) return "contact " + std::to_string(i);
    }
    return {};
}

} // namespace

TEST_CASE("pairs in lanes get the same bits as in one lane") {
    using solve::PairWork;
    std::size_t served = 0, levels = 0;
    for (const Simd level : {Simd::sse41, Simd::avx2, Simd::avx512, Simd::neon, Simd::wasm128}) {
        if (solve::kernels_of(level) == nullptr) continue;
        ++levels;
        for (std::uint64_t seed = 1; seed <= 50; ++seed)
            for (const PairWork work : {PairWork::place, PairWork::recycle, PairWork::fresh}) {
                const Sample sample(seed);
                const Found one(sample, work, Simd::scalar), many(sample, work, level);
                CAPTURE(name_of(level));
                CAPTURE(seed);
                REQUIRE(differ(sample, one, many) == "");
                if (work == PairWork::recycle)
                    for (const std::uint8_t serves : one.serves) served += serves;
            }
    }
    if (levels == 0) MESSAGE("this machine has no lanes: nothing was compared");
    CHECK((levels == 0 || served > 1000 * levels)); // of 10,150 for each level
}

TEST_CASE("planted: the check finds one step of one number of a pair") {
    Sample sample(1);
    const Found before(sample, solve::PairWork::recycle, Simd::scalar);
    std::size_t at = 0;
    while (before.serves[at] == 0) ++at;
    sample.pairs[at].memory.points[0].position.x.raw += 1 << 8;
    CHECK(differ(sample, before, Found(sample, solve::PairWork::recycle, Simd::scalar)) ==
          "contact " + std::to_string(at));
}
