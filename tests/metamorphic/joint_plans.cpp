// The plan of joints is reused from tick to tick while joints, bodies and rows do not change. Beside each world runs
// one whose scratch memory is overwritten before every tick, so that it makes a new plan each time: both must have
// equal states.
#include "support/rigs/joint_chains.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

TEST_CASE("a cached plan of joints equals a new plan after any change of joints and bodies") {
    const ChainRun kept = run_chains(400);
    CHECK(kept.parted_at == -1);
    CHECK(kept.kept > 100);
    CHECK(kept.anew > 20);
    CHECK(kept.asleep > 0);
}

TEST_CASE("worlds with a cached plan of joints continue alike after restores and in clones forwards and "
          "backwards") {
    JointChains c;
    std::vector<Image> images(60);
    std::vector<std::uint64_t> hashes;
    for (std::size_t t = 0; t < images.size(); ++t) {
        c.w.state.save(images[t]);
        hashes.push_back(c.w.state.hash());
        sim::tick(c.w);
    }
    for (std::size_t t = images.size() - 4; t-- > 0;) {
        c.w.state.restore(images[t]);
        sim::forget_derived(c.w);
        JointChains clone = c;
        for (std::size_t k = 1; k <= 3; ++k) {
            sim::tick(c.w), sim::tick(clone.w);
            REQUIRE(c.w.state.hash() == hashes[t + k]);
            REQUIRE(clone.w.state.hash() == hashes[t + k]);
        }
    }
}

TEST_CASE("planted fault: the check finds a plan that is kept although a joint or a body has changed") {
    const ChainRun kept = run_chains(400, [](sim::Data& w) {
        // Makes a new list, and the tick accepts it as that of the last tick.
        sim::list_joints(w, w.scratch.joints);
    });
    CHECK(kept.parted_at >= 0);
}
