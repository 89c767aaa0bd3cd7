// Joints in packs have the same bits in lanes of every width: every kind of joint; their inverses on hostile numbers too.
#include "scenes/scenes.h"
#include "solve/joints/joint_point.h"
#include "solve/kernels/kernels.h"
#include "support/rigs/joint_scenes.h"

#include "lockstone/simd.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

std::vector<std::uint64_t> hashes_of(Simd level) {
    const auto game = made(make_scene("joint-grid", {}));
    World w = made(game->start());
    REQUIRE(w.set_simd(level));
    std::vector<std::uint64_t> hashes;
    for (int t = 0; t < 120; ++t) {
        REQUIRE(game->advance(w, {}).ok());
        hashes.push_back(w.hash());
    }
    return hashes;
}

/// Rows of all sizes, some of which depend on each other; shares of all ratios of masses.
struct HostilePack {
    solve::JointPack pack{};
    solve::TurnPack turn{};
    std::mt19937_64 random;

    explicit HostilePack(std::uint64_t seed) : random(seed) {
        pack.count = solve::pack_lanes, pack.hinges = true;
        for (std::uint32_t lane = 0; lane < solve::pack_lanes; ++lane) {
            pack.stale[lane] = random() % 8 != 0, turn.generic[lane] = random() % 8 == 0 ? -1 : 0;
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
    /// Returns how many inverses the kernel left.
    int invert_by(const solve::JointKernel& kernel) {
        const solve::JointPassData data{nullptr, &pack, &turn, 0, 0, 0, 0};
        kernel.invert(data, 0, 1);
        int left = 0;
        for (std::uint32_t lane = 0; lane < solve::pack_lanes; ++lane) {
            left += (pack.left[lane] & 1) + (pack.left[lane] >> 1);
            solve::invert_left(pack, &turn, lane);
        }
        return left;
    }
    void invert_one_by_one() {
        using namespace solve;
        for (std::uint32_t lane = 0; lane < pack_lanes; ++lane) {
            if (pack.stale[lane] == 0) continue;
            pack.left[lane] = turn.generic[lane] == 0 ? point_left | hinge_left : point_left;
            invert_left(pack, &turn, lane);
        }
    }
};

bool are_same(const solve::PackInverse& a, const solve::PackInverse& b) {
    return std::equal(&a.m[0][0], &a.m[0][0] + 6 * solve::pack_lanes, &b.m[0][0]) &&
           std::ranges::equal(a.shift, b.shift) && std::ranges::equal(a.half, b.half) &&
           std::ranges::equal(a.odd, b.odd);
}

} // namespace

TEST_CASE("inverses of packed joints are those of plain integers in lanes of every width") {
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
        CHECK(left > packs / 8);     // what is left is tried as well
        CHECK(left < packs * 8 / 2); // and lanes do most
    }
}

TEST_CASE("every instruction set gives the bits of plain integers, with joints of every kind") {
    const std::vector<std::uint64_t> plain = hashes_of(Simd::scalar);
    for (const Simd level : every_simd) {
        if (level == Simd::scalar || !has_simd(level)) continue;
        INFO(std::string(name_of(level)));
        CHECK(hashes_of(level) == plain);
    }
}
