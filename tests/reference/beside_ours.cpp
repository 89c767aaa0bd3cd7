// Both engines from one start, and builds of one engine that diverge.
#include "reference/drift.h"
#include "reference/scene.h"
#include "reference/scenes.h"
#include "support/about.h"

#include <doctest/doctest.h>

using namespace reference_tests;
using reference::Build, reference::SideBySide;

TEST_CASE("two blocks fly alike within 1 cm in both engines until they touch something") {
    SideBySide both = SideBySide::create(reference::make_compare_scene("two-blocks").value()).value();
    std::uint64_t flown = 0;
    for (bool touched = false; !touched;) {
        both.tick().value();
        const reference::Sample sample = both.sample();
        touched = sample.ours_touched || sample.theirs_touched;
        if (touched) break;
        CHECK(sample.separation_max <= 0.01);
        flown = sample.tick;
        REQUIRE(flown < 200);
    }
    CHECK(flown > 20);
}

namespace {

/// In ticks without contact with the ground: the change of momentum, less that of gravity.
struct InTheAir {
    int ticks = 0, impacts = 0;
    double worst = 0;
    void note(const reference::Vec& before, const reference::Vec& after, double mass, bool impact) {
        const reference::Vec change = after - before - reference::Vec{0, -9.81 * mass / 60, 0};
        worst = std::max(worst, length(change));
        ++ticks, impacts += impact;
    }
};

} // namespace

TEST_CASE("two blocks that meet in the air keep their momentum in both engines") {
    bool their_ground = false, their_impact = false;
    const reference::Settings settings{.on_contacts = [&](std::vector<reference::Contact>& contacts) {
        for (const reference::Contact& c : contacts) (c.a == 0 ? their_ground : their_impact) = true;
    }};
    SideBySide both =
        SideBySide::create(reference::make_compare_scene("two-blocks").value(), settings).value();
    const BodyId ground = both.ours().bodies()[0];
    InTheAir ours, theirs;
    reference::Sample before = both.sample();
    for (int i = 0; i < 300; ++i) {
        their_ground = their_impact = false;
        both.tick().value();
        const reference::Sample now = both.sample();
        bool our_ground = false, our_impact = false;
        for (const World::ContactPoint& c : both.ours().contacts()) {
            const bool is_ground =
                both.ours().body_of(c.shape_a) == ground || both.ours().body_of(c.shape_b) == ground;
            (is_ground ? our_ground : our_impact) = true;
        }
        const bool moves = both.ours().awake_count() == 2; // gravity does not act on sleeping bodies
        if (i >= 6 && !our_ground && moves)
            ours.note(before.ours.momentum, now.ours.momentum, 20, our_impact);
        if (i >= 6 && !their_ground)
            theirs.note(before.theirs.momentum, now.theirs.momentum, 20, their_impact);
        before = now;
    }
    CHECK(theirs.impacts > 0);
    CHECK(ours.impacts > 0);
    CHECK(theirs.worst <= 1e-6); // the given gravity is 1e-10 off 9.81
    CHECK(ours.worst <= 1e-3);   // 20 kg times a few steps of a velocity, 2^-19 m/s
}

TEST_CASE("each scene of compare runs in both engines") {
    for (const reference::CompareScene& scene : reference::compare_scenes()) {
        CAPTURE(std::string(scene.name));
        SideBySide both = SideBySide::create(reference::make_compare_scene(scene.name).value()).value();
        both.tick().value();
        const reference::Sample sample = both.sample();
        CHECK(sample.separation_max <= 0.01);
        CHECK(sample.ours.energy() == lockstone::test::about(sample.theirs.energy(), 0.01));
    }
}

TEST_CASE("an unknown scene gives an error that names the known scenes") {
    const auto game = reference::make_compare_scene("orbitt");
    REQUIRE(!game);
    CHECK(game.error().message.find("two-blocks, stack, pile, domino, orbit, top, pyramid") !=
          std::string::npos);
}

TEST_CASE("a reference build with other flags diverges but an equal build and our engine do not") {
    const auto game = reference::make_compare_scene("two-blocks").value();
    const auto drift = [&](Build build, Build against) {
        return reference::drift_of(*game, {}, build, against, 120).value();
    };
    const reference::DriftLine fast = drift(Build::float_fast, Build::float_plain);
    REQUIRE(fast.parts_at);
    CHECK(fast.apart.back() > 1e-6);
    if (reference::is_available(Build::float_fused)) {
        CHECK(drift(Build::float_fused, Build::float_plain).parts_at);
        CHECK(drift(Build::double_fused, Build::double_plain).parts_at);
    }
    const reference::DriftLine twin = drift(Build::float_twin, Build::float_plain);
    CHECK(!twin.parts_at);
    CHECK(twin.apart.back() == 0);
    CHECK(!reference::our_drift(*game, 120).value().parts_at);
}

TEST_CASE("single precision diverges from double precision") {
    const auto game = reference::make_compare_scene("two-blocks").value();
    CHECK(reference::drift_of(*game, {}, Build::float_plain, Build::double_plain, 30).value().parts_at);
}
