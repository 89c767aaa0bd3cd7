#include "math_oracle.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>

using namespace lockstone;
using namespace oracle;

namespace {

/// Chi-square of counts against equal shares: the distance from its mean, in standard deviations.
template <std::size_t N> double unevenness(const std::array<long, N>& counts, long total) {
    const double expected = static_cast<double>(total) / static_cast<double>(N);
    double sum = 0;
    for (long c : counts)
        sum += (static_cast<double>(c) - expected) * (static_cast<double>(c) - expected) / expected;
    const double degrees = static_cast<double>(N - 1);
    return (sum - degrees) / std::sqrt(2 * degrees);
}

/// The next-state map of xoshiro256 as a matrix over bits: column i is the image of bit i.
using Words = std::array<std::uint64_t, 4>;
using BitMatrix = std::vector<Words>;

Words image_of(const BitMatrix& m, const Words& s) {
    Words sum{};
    for (std::size_t i = 0; i < 256; ++i)
        if (((s[i / 64] >> (i % 64)) & 1u) != 0)
            for (std::size_t k = 0; k < 4; ++k) sum[k] ^= m[i][k];
    return sum;
}
BitMatrix one_draw() {
    BitMatrix m(256);
    for (std::size_t i = 0; i < 256; ++i) {
        Random r{};
        r.state[i / 64] = std::uint64_t{1} << (i % 64);
        r.next_u64();
        m[i] = r.state;
    }
    return m;
}

} // namespace

TEST_CASE("the generator draws the values of the reference implementation of xoshiro256**") {
    Random r{{1, 2, 3, 4}};
    const std::uint64_t expected[] = {11520,
                                      0,
                                      1509978240,
                                      1215971899390074240u,
                                      1216172134540287360u,
                                      607988272756665600u,
                                      16172922978634559625u,
                                      8476171486693032832u,
                                      10595114339597558777u,
                                      2904607092377533576u};
    for (std::uint64_t e : expected) CHECK(r.next_u64() == e);
    std::uint64_t seed = 1234567;
    for (std::uint64_t e : {6457827717110365317u, 3203168211198807973u, 9817491932198370423u,
                            4593380528125082431u, 16408922859458223821u})
        CHECK(split_mix(seed) == e);
}

TEST_CASE("jump() equals 2^128 draws by the transition matrix that is squared 128 times") {
    BitMatrix m = one_draw();
    for (int square = 0; square < 128; ++square) {
        BitMatrix next(256);
        for (std::size_t i = 0; i < 256; ++i) next[i] = image_of(m, m[i]);
        m = next;
    }
    Random r = Random::seeded(99);
    const Words expected = image_of(m, r.state);
    r.jump();
    CHECK(r.state == expected);
    r.next_u64();
    CHECK(r.state != expected); // planted fault: one draw more
}

TEST_CASE("every kind of draw returns its recorded values on every processor") {
    Random r = Random::seeded(2026, 3);
    CHECK(r.next_u64() == 16873736849583921343u);
    CHECK(r.next_u32() == 3129625585u);
    CHECK(r.uniform().raw == 38942798);
    CHECK(r.range(-5_r, 10_r).raw == -6985330545);
    CHECK(r.range(1, 6) == 4);
    CHECK(r.unit_vector().z.raw == 651715916);
    CHECK(r.chance(0.5_r));
    CHECK(r.split(7).next_u64() == 2867250695925930599u);
    std::array<int, 8> items = {0, 1, 2, 3, 4, 5, 6, 7};
    r.shuffle(std::span(items));
    CHECK(items == std::array<int, 8>{5, 0, 2, 4, 6, 3, 7, 1});
}

TEST_CASE("a copy of a generator continues with the same draws and a state of zeros acts as seed 0") {
    Random a = Random::seeded(5), b{};
    a.unit_vector();
    Random copy = a;
    for (int i = 0; i < 100; ++i) CHECK(a.range(0, 1000) == copy.range(0, 1000));
    CHECK(a == copy);
    Random zero = Random::seeded(0);
    CHECK(b.next_u64() == zero.next_u64());
    CHECK(b == zero);
    CHECK(Random{}.split(3) == Random::seeded(0).split(3));
    CHECK_FALSE(Random{}.split(3) == Random{}.split(4));
}

TEST_CASE("seeds and streams and splits draw different numbers and a split does not change its parent") {
    std::vector<std::uint64_t> first;
    Random parent = Random::seeded(1);
    const Random before = parent;
    for (std::uint64_t i = 0; i < 1000; ++i) {
        first.push_back(Random::seeded(i).next_u64());
        first.push_back(Random::seeded(1, i + 1).next_u64());
        first.push_back(parent.split(i).next_u64());
        if (i == 0) CHECK(parent == before);
    }
    std::sort(first.begin(), first.end());
    CHECK(std::adjacent_find(first.begin(), first.end()) == first.end());
    parent.next_u64();
    CHECK(parent.split(0) != before.split(0));
}

TEST_CASE("integer ranges are even and closed even for counts at which a remainder would be biased") {
    Random r = Random::seeded(6);
    std::array<long, 6> dice{};
    const long throws = points(600000);
    for (long i = 0; i < throws; ++i) ++dice[static_cast<std::size_t>(r.range(1, 6) - 1)];
    CHECK(std::fabs(unevenness(dice, throws)) < 6);
    // 3 * 2^30 outcomes from 2^32: a plain remainder would make each value of the first third twice as likely as the
    // others.
    std::array<long, 3> thirds{}, biased{};
    const std::uint32_t count = 3u << 30;
    for (long i = 0; i < throws; ++i) {
        ++thirds[r.below(count) >> 30];
        ++biased[(r.next_u32() % count) >> 30];
    }
    CHECK(std::fabs(unevenness(thirds, throws)) < 6);
    CHECK(unevenness(biased, throws) > 1000); // planted fault: the remainder
    CHECK(r.range(5, 5) == 5);
    CHECK(r.range(5, 4) == 5);
    CHECK(r.below(0) == 0);
    constexpr std::int32_t low = std::numeric_limits<std::int32_t>::min(),
                           high = std::numeric_limits<std::int32_t>::max();
    bool negative = false, positive = false;
    for (int i = 0; i < 100; ++i) (r.range(low, high) < 0 ? negative : positive) = true;
    CHECK((negative && positive));
    for (int i = 0; i < 100; ++i) CHECK(r.range(high - 1, high) >= high - 1);
}

TEST_CASE("uniform and real ranges are even and half open") {
    Random r = Random::seeded(7);
    std::array<long, 64> bins{}, range_bins{};
    long outside = 0;
    const long draws = points(600000);
    for (long i = 0; i < draws; ++i) {
        const Real u = r.uniform(), v = r.range(-1.5_r, 2.5_r);
        outside += u < 0_r || u >= 1_r || v < -1.5_r || v >= 2.5_r ? 1 : 0;
        ++bins[static_cast<std::size_t>(u.raw >> 26)];
        ++range_bins[static_cast<std::size_t>((v + 1.5_r).raw >> 28)];
    }
    CHECK(outside == 0);
    CHECK(std::fabs(unevenness(bins, draws)) < 6);
    CHECK(std::fabs(unevenness(range_bins, draws)) < 6);
    CHECK(r.range(2_r, 1_r) == 2_r);
    CHECK(r.range(2_r, 2_r) == 2_r);
    CHECK(r.range(Real::min(), Real::max()) < Real::max());
    for (int i = 0; i < 100; ++i) CHECK(r.range(1_r, 1_r + Real::step()) == 1_r);
}

TEST_CASE("chance() is never true at 0 and always at 1 and true in its share between them") {
    Random r = Random::seeded(8);
    long never = 0, always = 0, quarter = 0;
    for (int i = 0; i < 200000; ++i) {
        never += r.chance(0_r) || r.chance(-3_r) ? 1 : 0;
        always += r.chance(1_r) && r.chance(unit_one) ? 1 : 0;
        quarter += r.chance(decimal<Unit>("0.25")) ? 1 : 0;
    }
    CHECK(never == 0);
    CHECK(always == 200000);
    CHECK(std::abs(quarter - 50000) < 1200); // six standard deviations
}

TEST_CASE("unit vectors have length one and no preferred direction") {
    Random r = Random::seeded(9);
    std::array<long, 48> bins{}; // octant and six heights of equal area
    long bad = 0;
    const long draws = points(300000);
    for (long i = 0; i < draws; ++i) {
        const UnitVec3 v = r.unit_vector();
        bad += std::abs(dot(v, v).raw - unit_one.raw) > 2 ? 1 : 0;
        const std::size_t octant =
            (v.x.raw < 0 ? 1u : 0u) + (v.y.raw < 0 ? 2u : 0u) + (v.z.raw < 0 ? 4u : 0u);
        const std::int64_t height = std::int64_t{std::abs(v.z.raw)} * 6 >> 30;
        ++bins[octant * 6 + static_cast<std::size_t>(height > 5 ? 5 : height)];
    }
    CHECK(bad == 0);
    CHECK(std::fabs(unevenness(bins, draws)) < 6);
}

TEST_CASE("a shuffle returns every order equally often") {
    Random r = Random::seeded(10);
    std::array<long, 24> orders{};
    const long draws = points(240000);
    for (long i = 0; i < draws; ++i) {
        std::array<std::size_t, 4> items = {0, 1, 2, 3};
        r.shuffle(std::span(items));
        std::size_t index = 0; // Lehmer code
        for (std::size_t a = 0; a < 4; ++a) {
            std::size_t smaller = 0;
            for (std::size_t b = a + 1; b < 4; ++b) smaller += items[b] < items[a] ? 1u : 0u;
            index = index * (4 - a) + smaller;
        }
        ++orders[index];
    }
    CHECK(std::fabs(unevenness(orders, draws)) < 6);
    std::vector<int> none;
    r.shuffle(std::span(none));
}
