// Packed joints have equal bits in lanes of every width, for every kind of joint; so have their inverses, for hostile
// numbers too.
#include "scenes/scenes.h"
#include "solve/joints/pack/joint_point.h"
#include "solve/kernels/kernels.h"
#include "support/rigs/joint_scenes.h"

#include "lockstone/simd.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

std::vector<std::uint64_t> hashes_of(const char* scene, std::uint32_t size, int ticks, Simd level) {
    const auto game = made(make_scene(scene, {.size = size}));
    World w = made(game->start());
    REQUIRE(w.set_simd(level));
    std::vector<std::uint64_t> hashes;
    for (int t = 0; t < ticks; ++t) {
        REQUIRE(game->advance(w, {}).ok());
        hashes.push_back(w.hash());
    }
    return hashes;
}

/// Rows of all sizes; some are linearly dependent. Shares of all mass ratios.
struct HostilePack {
    solve::JointPack pack{};
    solve::TurnPack turn{};
    std::mt19937_64 random;

    explicit HostilePack(std::uint64_t seed) : random(seed) {
        pack.count = solve::pack_lanes, pack.hinges = true;
        const std::uint64_t stale = random() % 2 == 0 ? 7 : 2; // of eight lanes: nearly all or few
        for (std::uint32_t lane = 0; lane < solve::pack_lanes; ++lane) {
            pack.stale[lane] = random() % 8 < stale ? -1 : 0, turn.generic[lane] = random() % 8 == 0 ? -1 : 0;
            pack.one[lane] = static_cast<std::int32_t>(std::int64_t{1} << random() % 29);
            for (solve::PackSide* side : {&pack.a, &pack.b}) {
                fill_rows(side->x, lane, 3);
                side->share[lane] =
                    random() % 8 == 0 ? 0 : (1 << 29) + static_cast<std::int32_t>(random() % (1 << 29));
                side->shift[lane] = random() % 3 == 0 ? static_cast<std::int64_t>(random() % 62) : 0;
                side->shifts = side->shifts || side->shift[lane] != 0;
            }
            fill_rows(turn.ja, lane, 2), fill_rows(turn.jb, lane, 2);
        }
    }
    void fill_rows(std::int32_t (&x)[3][3][solve::pack_lanes], std::uint32_t lane, int rows) {
        const std::uint64_t drop = random() % 4 == 0 ? random() % 29 : 0;
        const bool same = random() % 6 == 0;
        for (int r = 0; r < rows; ++r)
            for (int i = 0; i < 3; ++i) {
                const auto size = static_cast<std::int32_t>((random() % (1u << 29)) >> drop);
                x[r][i][lane] = same && r > 0 ? x[0][i][lane] : random() % 2 == 0 ? size : -size;
            }
    }
    /// Returns the number of inverses that the kernel left to the scalar code.
    int invert_by(const solve::JointKernel& kernel) {
        const solve::JointPassData data{nullptr, &pack, &turn, nullptr, nullptr, nullptr,
                                        nullptr, 0,     0,     0,       0};
        kernel.invert(data, 0, 1);
        std::uint32_t left = 0;
        for (std::uint32_t lane = 0; lane < solve::pack_lanes; ++lane) {
            left += ((pack.points_left >> lane) & 1u) + ((pack.hinges_left >> lane) & 1u);
            solve::invert_left(pack, &turn, lane);
        }
        return static_cast<int>(left);
    }
    void invert_one_by_one() {
        using namespace solve;
        for (std::uint32_t lane = 0; lane < pack_lanes; ++lane) {
            if (pack.stale[lane] == 0) continue;
            pack.points_left |= 1u << lane;
            if (turn.generic[lane] == 0) pack.hinges_left |= 1u << lane;
            invert_left(pack, &turn, lane);
        }
    }
};

bool are_same(const solve::PackInverse& a, const solve::PackInverse& b) {
    return std::equal(&a.m[0][0], &a.m[0][0] + 6 * solve::pack_lanes, &b.m[0][0]) &&
           std::ranges::equal(a.shift, b.shift) && std::ranges::equal(a.half, b.half) && a.odd == b.odd;
}

/// Four bodies with joints that have moved and turned and spin at all sizes, and the poses that a kernel computes.
struct TurnedFour {
    std::vector<solve::SolverBody> bodies{solve::pack_lanes};
    solve::HeldBodies held{};
    solve::TurnedBody turned[1 + solve::pack_lanes]{};
    std::uint8_t seen[1 + solve::pack_lanes]{};

    TurnedFour(std::uint64_t seed, const solve::JointKernel& kernel) {
        std::mt19937_64 random(seed);
        const auto any = [&](int bits) {
            const auto drop = random() % static_cast<unsigned>(bits);
            const auto size = static_cast<std::int64_t>((random() >> (64 - bits)) >> drop);
            return random() % 2 == 0 ? size : -size;
        };
        for (std::uint32_t lane = 0; lane < solve::pack_lanes; ++lane) {
            solve::SolverBody& b = bodies[lane];
            held.place[lane] = lane * static_cast<std::uint32_t>(sizeof(solve::SolverBody));
            for (auto& k : held.inverse) k[lane] = static_cast<std::int32_t>(any(30));
            const auto bits = static_cast<std::int64_t>(8 + random() % 51);
            held.spin_shift[lane] = bits, held.turn_shift[lane] = bits + 27 - solve::pack_angle_bits;
            held.strays[lane] = random() % 8 == 0 ? -1 : 0;
            for (int i = 0; i < 3; ++i) {
                held.packed_at[i][lane] = static_cast<std::int32_t>(any(30));
                held.alone_at[i][lane] = static_cast<std::int32_t>(any(30));
                b.v[i] = any(62), b.u[i] = any(62);
                b.shift[i] = random() % 4 == 0 ? 0 : static_cast<std::int32_t>(any(31));
                b.theta[i] = random() % 4 == 0 ? 0 : static_cast<std::int32_t>(any(31));
            }
        }
        kernel.turn({bodies.data(), nullptr, nullptr, nullptr, &held, turned, seen, 0, 0, 0, 0}, 0, 1);
    }
    bool operator==(const TurnedFour& o) const {
        const auto same = [](const auto& a, const auto& b) { return std::memcmp(&a, &b, sizeof a) == 0; };
        return same(held.packed_at, o.held.packed_at) && same(held.alone_at, o.held.alone_at) &&
               same(turned, o.turned) && same(seen, o.seen);
    }
    /// Returns how far the rows of the matrices are from an orthonormal basis, where theta describes the turn.
    double skew() const {
        double out = 0;
        for (std::uint32_t lane = 1; lane <= solve::pack_lanes; ++lane) {
            if ((seen[lane] & solve::seen_far) != 0) continue;
            const auto& m = turned[lane].turn;
            for (int r = 0; r < 3; ++r)
                for (int s = 0; s <= r; ++s) {
                    double dot = r == s ? -1 : 0;
                    for (int i = 0; i < 3; ++i) dot += m[r][i] * 0x1p-30 * m[s][i] * 0x1p-30;
                    out = std::max(out, std::abs(dot));
                }
        }
        return out;
    }
};

} // namespace

// source: the error of three terms of the series for a turn of 1 / 16 rad about each axis is 4e-11; rounding adds some
// 2^-30.
TEST_CASE("rotations turn held bodies to the same bits in lanes of every width") {
    for (const Simd level : every_simd) {
        if (!has_simd(level)) continue;
        INFO(std::string(name_of(level)));
        const solve::JointKernel &lanes = *solve::kernels_of(level)->joints,
                                 &plain = *solve::kernels_of(Simd::scalar)->joints;
        int far = 0, strayed = 0;
        double skew = 0;
        for (std::uint64_t seed = 0; seed < 20000; ++seed) {
            const TurnedFour now(seed, lanes);
            REQUIRE(now == TurnedFour(seed, plain));
            skew = std::max(skew, now.skew());
            for (const std::uint8_t seen : now.seen)
                far += (seen & solve::seen_far) != 0, strayed += (seen & solve::seen_strays_far) != 0;
        }
        CHECK(skew < 8 * 0x1p-30);
        CHECK(far > 5000); // each of these cases occurs
        CHECK(far < 75000);
        CHECK(strayed > 5000);
    }
}

TEST_CASE("inverses of packed joints equal those of plain integers in lanes of every width") {
    constexpr int packs = 20000;
    for (const Simd level : every_simd) {
        if (!has_simd(level)) continue;
        INFO(std::string(name_of(level)));
        const solve::JointKernel& kernel = *solve::kernels_of(level)->joints;
        int left = 0, other = 0;
        for (int seed = 0; seed < packs; ++seed) {
            HostilePack lanes(static_cast<std::uint64_t>(seed)), plain(static_cast<std::uint64_t>(seed));
            left += lanes.invert_by(kernel);
            plain.invert_one_by_one();
            other += are_same(lanes.pack.inverse, plain.pack.inverse) &&
                             are_same(lanes.turn.inverse, plain.turn.inverse)
                         ? 0
                         : 1;
        }
        CHECK(other == 0);
        CHECK(left > packs / 8);     // the scalar code handles some
        CHECK(left < packs * 8 / 2); // and the lanes handle most
    }
}

// The planks of the bridge turn fast enough to be followed. NEON once lost small changes of their velocities.
TEST_CASE(
    "every instruction set gives the bits of plain integers with joints of every kind and on a bridge") {
    struct Case {
        const char* scene;
        std::uint32_t size;
        int ticks;
    };
    for (const auto& [scene, size, ticks] : {Case{"joint-grid", 0, 120}, Case{"bridge", 40, 64}}) {
        const std::vector<std::uint64_t> plain = hashes_of(scene, size, ticks, Simd::scalar);
        for (const Simd level : every_simd) {
            if (level == Simd::scalar || !has_simd(level)) continue;
            INFO(scene, ", ", std::string(name_of(level)));
            CHECK(hashes_of(scene, size, ticks, level) == plain);
        }
    }
}
