// Joints in packs have the same bits in lanes of every width: every kind of joint.
#include "scenes/scenes.h"
#include "support/joint_scenes.h"

#include "lockstone/simd.h"

#include <doctest/doctest.h>

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

} // namespace

TEST_CASE("every instruction set gives the bits of plain integers, with joints of every kind") {
    const std::vector<std::uint64_t> plain = hashes_of(Simd::scalar);
    for (const Simd level : every_simd) {
        if (level == Simd::scalar || !has_simd(level)) continue;
        INFO(std::string(name_of(level)));
        CHECK(hashes_of(level) == plain);
    }
}
