// Kernels drop old impacts and find hits of elastic contacts with equal results whether they process the lanes of a
// pack at once or one by one.
#include "lockstone/math/random.h"
#include "solve/kernels/kernels.h"

#include <doctest/doctest.h>

#include <cstring>
#include <type_traits>
#include <vector>

using namespace lockstone;
using namespace lockstone::solve;

namespace {

/// A pack whose solving changes no velocity: all responses are zero. Its impacts are below those that joints keep (1
/// m/s).
template <unsigned N> ContactPack<N> pack_of(Random& random) {
    ContactPack<N> pack{};
    const auto within = [&](std::int32_t limit) {
        return static_cast<std::int32_t>(random.below(2 * static_cast<std::uint32_t>(limit) + 1)) - limit;
    };
    pack.movable_a = pack.movable_b = (1u << N) - 1, pack.impacts = 1;
    pack.point_count = 1 + static_cast<std::int32_t>(random.below(4));
    for (unsigned lane = 0; lane < N; ++lane) {
        pack.body_a[lane] = 2 * lane, pack.body_b[lane] = 2 * lane + 1;
        pack.several[lane] = pack.point_count > 1 ? -1 : 0;
        pack.friction[lane] = 1 << row_bits, pack.push[lane] = -(1 << speed_bits);
        pack.share_a[lane] = within(1 << 30), pack.share_b[lane] = within(1 << 30);
        for (int r = 0; r < 3; ++r) {
            for (int i = 0; i < 3; ++i)
                for (auto* rows : {&pack.d, &pack.normal_a, &pack.normal_b, &pack.slide_a, &pack.slide_b})
                    (*rows)[r][i][lane] = within(1 << 28);
            pack.slide[r][lane] = r == 2 && pack.point_count == 1 ? 0 : within(1 << 12);
        }
        for (int k = 0; k < pack.point_count; ++k) {
            PointLanes<N>& point = pack.points[k];
            point.gap0[lane] = point.gap[lane] = 1 << gap_bits, point.reach[lane] = 1 << unit_bits;
            point.impulse[lane] = (1 << 17) + static_cast<std::int32_t>(random.below(1 << 17));
            point.impact[lane] = within(1 << 18);
            if (pack.point_count > 1)
                for (int i = 0; i < 2; ++i) point.arm[i][lane] = within(1 << 30);
        }
    }
    return pack;
}

template <unsigned N> void compare(const ContactKernel& kernel) {
    Random random = Random::seeded(N);
    int taken = 0, changed = 0, wrapped = 0;
    for (int round = 0; round < 2000; ++round) {
        ContactPack<N> at_once = pack_of<N>(random), one_by_one = at_once;
        // this forces the path that handles lanes one by one; no impact is large enough to be kept
        one_by_one.keeps = (1u << N) - 1;
        const ContactPack<N> before = at_once;
        std::vector<solve::SolverBody> bodies(2 * N, solve::SolverBody{});
        std::vector<WarmStart> warm(2 * N, WarmStart{}), other = warm, arrival = warm;
        // Velocities close to the end of the range: sums wrap, in both paths alike.
        for (WarmStart& start : warm) start.v[0] = random.below(2) == 0 ? INT64_MAX - 5 : INT64_MIN + 5;
        other = warm;
        const std::int64_t start = warm[0].v[0];
        const PassSettings settings{240, 1 << gap_bits, 1 << speed_bits, false};
        kernel.solve(&at_once, 0, 1, {bodies.data(), warm.data(), arrival.data()}, settings);
        kernel.solve(&one_by_one, 0, 1, {bodies.data(), other.data(), arrival.data()}, settings);
        wrapped += (warm[0].v[0] < 0) != (start < 0);
        REQUIRE(std::memcmp(warm.data(), other.data(), warm.size() * sizeof(WarmStart)) == 0);
        for (int k = 0; k < 4; ++k)
            REQUIRE(std::memcmp(at_once.points[k].impulse, one_by_one.points[k].impulse,
                                sizeof at_once.points[k].impulse) == 0);
        REQUIRE(std::memcmp(at_once.slide, one_by_one.slide, sizeof at_once.slide) == 0);
        taken += std::memcmp(at_once.points[0].impulse, before.points[0].impulse,
                             sizeof before.points[0].impulse) != 0;
        changed += std::memcmp(at_once.slide, before.slide, sizeof before.slide) != 0;
    }
    // Half of the impacts are above zero, and half of the sums wrap.
    CHECK(taken > 800);
    CHECK(changed > 800);
    CHECK(wrapped > 200);
}

/// Contacts of two points beside one of four: the two missing points change nothing, at any speed.
template <unsigned N> void compare_lacking(const ContactKernel& kernel) {
    Random random = Random::seeded(200 + N);
    constexpr std::int32_t far_away = INT32_MAX, a_second = 240;
    const PassSettings settings{a_second, (impulse_limit / a_second) << (gap_bits - speed_bits),
                                1 << speed_bits, false};
    int moved = 0;
    for (int round = 0; round < 2000; ++round) {
        ContactPack<N> alone = pack_of<N>(random);
        alone.point_count = 2, alone.impacts = 0;
        for (unsigned lane = 0; lane < N; ++lane) {
            alone.several[lane] = -1;
            for (int k = 0; k < 2; ++k) {
                PointLanes<N>& point = alone.points[k];
                point.gap0[lane] = point.gap[lane] = point.impact[lane] = 0;
                point.arm[0][lane] = k == 0 ? 1 << unit_bits : -(1 << unit_bits), point.arm[1][lane] = 0;
                point.fit[0][lane] = 1 << (fit_bits - 1),
                point.fit[1][lane] = k == 0 ? 1 << (fit_bits - 1) : -(1 << (fit_bits - 1));
                point.kappa[lane] = 1 << (kappa_bits - 2);
            }
            alone.response[0][lane] = alone.response[2][lane] = 1 << response_bits;
            alone.inverse[0][lane] = alone.inverse[2][lane] = 1 << inverse_bits;
        }
        ContactPack<N> beside = alone;
        beside.point_count = 4;
        for (int k = 2; k < 4; ++k) {
            beside.points[k] = {};
            for (unsigned lane = 0; lane < N; ++lane)
                beside.points[k].gap0[lane] = beside.points[k].gap[lane] = far_away;
        }
        std::vector<solve::SolverBody> bodies(2 * N, solve::SolverBody{});
        for (solve::SolverBody& body : bodies)
            for (std::int64_t& x : body.v)
                x = static_cast<std::int64_t>(random.next_u64()) >> (62 - accumulator_bits - 11);
        std::vector<WarmStart> warm(2 * N, WarmStart{}), other = warm, arrival = warm, other_arrival = warm;
        std::vector<solve::SolverBody> other_bodies = bodies;
        kernel.solve(&alone, 0, 1, {bodies.data(), warm.data(), arrival.data()}, settings);
        kernel.solve(&beside, 0, 1, {other_bodies.data(), other.data(), other_arrival.data()}, settings);
        REQUIRE(std::memcmp(warm.data(), other.data(), warm.size() * sizeof(WarmStart)) == 0);
        REQUIRE(std::memcmp(bodies.data(), other_bodies.data(), bodies.size() * sizeof(solve::SolverBody)) ==
                0);
        for (int k = 0; k < 2; ++k)
            REQUIRE(std::memcmp(alone.points[k].impulse, beside.points[k].impulse,
                                sizeof alone.points[k].impulse) == 0);
        moved += alone.points[0].impulse[0] != 0;
    }
    CHECK(moved > 200);
}

template <unsigned N> void compare_hits(const ContactKernel& kernel) {
    Random random = Random::seeded(100 + N);
    int struck = 0, missed = 0;
    for (int round = 0; round < 2000; ++round) {
        ContactPack<N> pack = pack_of<N>(random);
        for (unsigned lane = 0; lane < N; ++lane) {
            if (random.below(4) != 0) pack.bounces[lane] = -1, ++pack.bounce_count;
            for (int k = 0; k < pack.point_count; ++k) {
                // From a deep overlap to a gap that no speed closes. No impulse moves a quarter of the points.
                pack.points[k].gap[lane] =
                    static_cast<std::int32_t>(random.next_u64() >> 32) >> static_cast<int>(random.below(12));
                pack.points[k].kappa[lane] = random.below(4) == 0 ? 0 : 1 << (kappa_bits - 2);
            }
        }
        // From speeds that the rows hold to speeds beyond the range of every row: 2^17 m/s.
        const int bits = accumulator_bits - 1 + static_cast<int>(random.below(17));
        std::vector<solve::SolverBody> bodies(2 * N, solve::SolverBody{});
        for (solve::SolverBody& body : bodies)
            for (int i = 0; i < 3; ++i)
                for (std::int64_t* x : {&body.v[i], &body.u[i]})
                    *x = static_cast<std::int64_t>(random.next_u64()) >> (63 - bits);
        const PassSettings settings{240, (impulse_limit / 240) << (gap_bits - speed_bits), 1 << speed_bits,
                                    true};
        ContactPack<N> other = pack;
        const bool any = kernel.find_hits(&pack, 1, {bodies.data(), nullptr, nullptr}, settings);
        find_hits<N>(other, bodies.data(), settings);
        REQUIRE((pack.bounce_count == 0 || pack.struck == other.struck));
        REQUIRE(any == (pack.bounce_count != 0 && other.struck != 0));
        for (unsigned lane = 0; lane < N; ++lane) {
            const bool hits = ((other.struck >> lane) & 1u) != 0;
            REQUIRE((!hits || pack.bounces[lane] != 0));
            ++(hits ? struck : missed);
        }
    }
    CHECK(struck > 400);
    CHECK(missed > 400);
}

template <class Check> void for_each_set(Check&& check) {
    for (const Simd level :
         {Simd::scalar, Simd::sse41, Simd::avx2, Simd::avx512, Simd::neon, Simd::wasm128}) {
        const Kernels* kernels = kernels_of(level);
        if (kernels == nullptr) continue;
        const ContactKernel& kernel = *kernels->contacts;
        INFO("lanes: ", kernel.lanes);
        if (kernel.lanes == 1) check(std::integral_constant<unsigned, 1>{}, kernel);
        if (kernel.lanes == 2) check(std::integral_constant<unsigned, 2>{}, kernel);
        if (kernel.lanes == 4) check(std::integral_constant<unsigned, 4>{}, kernel);
        if (kernel.lanes == 8) check(std::integral_constant<unsigned, 8>{}, kernel);
    }
}

} // namespace

TEST_CASE("kernels drop the same impacts whether they process lanes at once or one by one") {
    for_each_set([](auto width, const ContactKernel& kernel) { compare<width()>(kernel); });
}

TEST_CASE("kernels find the same hits of elastic contacts whether they process lanes at once or one by one") {
    for_each_set([](auto width, const ContactKernel& kernel) { compare_hits<width()>(kernel); });
}

TEST_CASE("missing points of a contact change nothing regardless of the other contacts in the pack") {
    for_each_set([](auto width, const ContactKernel& kernel) { compare_lacking<width()>(kernel); });
}
