// Queries change no state, and their results depend on the state alone.
#include "lockstone/testing.h"
#include "support/about.h"
#include "support/query_scene.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::query;

namespace {

/// Returns the first tick at which the hashes of a world with queries and of one without differ; -1: none. `disturb`
/// plants a change of the state.
int first_difference(int ticks, int questions, bool disturb) {
    const Assets assets;
    World asked = crowd(assets, 60), silent = crowd(assets, 60);
    for (int t = 0; t < ticks; ++t) {
        ask(asked, assets, static_cast<std::uint64_t>(t), questions);
        if (disturb && t == 20) testing::state_of(asked).edit_bytes(0)[0] ^= std::byte{1};
        if (asked.hash() != silent.hash()) return t;
        asked.tick();
        silent.tick();
        if (asked.hash() != silent.hash()) return t;
    }
    return -1;
}

} // namespace

TEST_CASE("thousands of queries between all ticks change no hash") {
    CHECK(first_difference(samples(60, 600), samples(100, 400), false) == -1);
}

TEST_CASE("planted: the check finds a query that changes the state") {
    CHECK(first_difference(30, 8, true) == 20);
}

TEST_CASE("every tick gives the same answers after rollback and resimulation and restores elsewhere and in "
          "clones") {
    const Assets assets;
    World w = crowd(assets, 60);
    constexpr std::size_t ticks = 30;
    std::vector<Image> images(ticks);
    std::vector<Answers> answers;
    for (Image& image : images) {
        w.save(image);
        answers.push_back(ask(w, assets, 1, 100));
        w.tick();
    }
    for (std::size_t t = 1; t < ticks; ++t)
        CHECK(!(answers[t] == answers[t - 1])); // stale bounds would be visible
    CHECK(answers[0].bytes.size() > 1000);
    World other = crowd(assets, 10); // a tree of another shape, from another history
    for (int t = 0; t < 90; ++t) {
        other.tick();
        ask(other, assets, 3, 8);
    }
    for (std::size_t t = 0; t < ticks; ++t) {
        CAPTURE(t);
        other.restore(images[t]);
        CHECK(ask(other, assets, 1, 100) == answers[t]);
        CHECK(ask(other.clone(), assets, 1, 100) == answers[t]);
    }
    for (std::size_t depth = 1; depth <= 4; ++depth)
        for (std::size_t t = depth; t < ticks; ++t) {
            CAPTURE(depth);
            CAPTURE(t);
            w.restore(images[t]);
            CHECK(ask(w, assets, 1, 100) == answers[t]);
            w.restore(images[t - depth]);
            for (std::size_t again = 0; again < depth; ++again) w.tick();
            CHECK(ask(w, assets, 1, 100) == answers[t]);
        }
}

TEST_CASE("queries take the commands since the last tick into account") {
    World w = made(World::create(small_def()));
    const BodyId ball = add_ball(w, at(0, 0, 0));
    const Ray ray{vec(-5, 3, 0), vec(10, 0, 0)};
    CHECK(!w.cast_ray(ray));
    done(w.set_pose(ball, at(0, 3, 0)));
    REQUIRE(w.cast_ray(ray));
    CHECK(to_double(w.cast_ray(ray)->distance) == test::about(4.5));
    const BodyId wall = add_wall(w, at(-3, 3, 0), vec(0.1, 1, 1));
    CHECK(w.cast_ray(ray)->body == wall);
    done(w.destroy(wall));
    CHECK(w.cast_ray(ray)->body == ball);
    done(w.destroy(ball));
    CHECK(!w.cast_ray(ray));
}
