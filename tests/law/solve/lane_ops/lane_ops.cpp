// Every instruction set computes each lane operation as plain integers do, over the whole range of 64-bit numbers: a
// shortcut that is right for small numbers gives other bits in a world whose velocities reach the end of their range.
#include "lane_ops.h"

#include "solve/lanes/scalar.h"
#include "support/effort.h"

#include "lockstone/simd.h"

#include <doctest/doctest.h>

#include <random>

namespace lockstone::test {
namespace {

constexpr unsigned lanes_max = 8;

struct Set {
    Simd simd;
    const LaneOps* ops;
};
std::vector<Set> sets_of_this_machine() {
    std::vector<Set> out;
    for (const Set& set : {Set{Simd::sse41, sse41_lane_ops}, Set{Simd::avx2, avx2_lane_ops},
                           Set{Simd::avx512, avx512_lane_ops}, Set{Simd::neon, neon_lane_ops},
                           Set{Simd::wasm128, wasm128_lane_ops}})
        if (set.ops != nullptr && has_simd(set.simd)) out.push_back(set);
    return out;
}

/// A number of a random width, close to the end of that width in half of the cases.
std::int64_t draw_number(std::mt19937_64& random) {
    const std::uint64_t bits = random();
    const auto width = static_cast<unsigned>(random() % 64);
    const std::uint64_t end = std::uint64_t{1} << width;
    const std::uint64_t size = random() % 2 == 0 ? bits & (end - 1) : end - 2 + bits % 4;
    return static_cast<std::int64_t>(random() % 2 == 0 ? size : ~size);
}
/// Pairs with equal high halves and pairs with equal low halves are frequent.
std::int64_t draw_beside(std::mt19937_64& random, std::int64_t a) {
    constexpr std::uint64_t low = 0xffffffffu;
    const auto x = static_cast<std::uint64_t>(a), y = static_cast<std::uint64_t>(draw_number(random));
    switch (random() % 4) {
    case 0:
        return static_cast<std::int64_t>((x & ~low) | (y & low));
    case 1:
        return static_cast<std::int64_t>((x & low) | (y & ~low));
    case 2:
        return random() % 2 == 0 ? a : static_cast<std::int64_t>(~x);
    default:
        return static_cast<std::int64_t>(y);
    }
}

/// Plain integers, lane by lane.
void run_plain(LaneOp op, unsigned lanes, const std::int64_t* a, const std::int64_t* b, const std::int64_t* c,
               std::int64_t* out) {
    std::int64_t bits = 0, all = 1;
    for (unsigned i = 0; i < lanes; ++i) {
        LaneRunner<solve::Scalar>::run(op, a + i, b + i, c + i, out + i);
        bits |= (out[i] & 1) << i, all &= out[i];
    }
    if (op == LaneOp::lanes_of) out[0] = bits;
    if (op == LaneOp::all_within) out[0] = all;
}

TEST_CASE("every instruction set computes lane operations like plain integers over all 64-bit numbers") {
    const int rounds = tries(20'000);
    const std::vector<Set> sets = sets_of_this_machine();
    std::mt19937_64 random(7);
    int compared = 0;
    for (int round = 0; round < rounds; ++round) {
        std::int64_t a[lanes_max], b[lanes_max], c[lanes_max];
        for (unsigned i = 0; i < lanes_max; ++i) {
            a[i] = draw_number(random), b[i] = draw_beside(random, a[i]);
            c[i] = static_cast<std::int64_t>(random() % 64);
        }
        for (const Set& set : sets)
            for (unsigned op = 0; op < static_cast<unsigned>(LaneOp::count); ++op) {
                std::int64_t expected[lanes_max], out[lanes_max];
                run_plain(static_cast<LaneOp>(op), set.ops->lanes, a, b, c, expected);
                set.ops->run(static_cast<LaneOp>(op), a, b, c, out);
                const bool is_one_number = op >= static_cast<unsigned>(LaneOp::lanes_of);
                const unsigned numbers = is_one_number ? 1 : set.ops->lanes;
                for (unsigned i = 0; i < numbers; ++i) {
                    ++compared;
                    if (out[i] == expected[i]) continue;
                    INFO(name_of(set.simd), ", operation ", op, " of ", a[i], " and ", b[i], " by ", c[i]);
                    REQUIRE(out[i] == expected[i]);
                }
            }
    }
    CHECK(compared >= static_cast<int>(sets.size()) * rounds);
}

} // namespace
} // namespace lockstone::test
