// Quick paths of queries give the answers of plain ones.
#include "support/rigs/quick_queries.h"
#include "support/query_scene.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

TEST_CASE("a wide tree gives a query the proxies that a test of each gives") {
    std::size_t found = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) REQUIRE(wide_tree_fault(seed, found) == "");
    CHECK(found > 10000);
}

TEST_CASE("a wide tree is not made where its steps are as large as the leaves") {
    const auto box = [](std::int32_t at) {
        const Bound low = Bound::from_raw(at), high = Bound::from_raw(at + 65536);
        return collide::Bounds{{low, low, low}, {high, high, high}};
    };
    collide::BroadPhase phase(3);
    const auto is_made = [&phase] {
        phase.update_trees();
        for (int i = 0; i < 100; ++i)
            if (phase.prepare_query() != nullptr) return true;
        return false;
    };
    CHECK(!is_made()); // without leaves
    phase.set(0, box(0), true), phase.set(1, box(100'000), true);
    CHECK(is_made());
    phase.set(2, box(2'000'000'000), true);
    CHECK(!is_made());
    phase.remove(2);
    CHECK(is_made());
}

TEST_CASE("answers of queries do not depend on the number of queries before them") {
    const query::Assets assets;
    World asked = query::crowd(assets, 80);
    for (int t = 0; t < 30; ++t) asked.tick();
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
        const World fresh = asked.clone();
        const query::Answers first = query::ask(fresh, assets, seed, 4);
        query::ask(asked, assets, 0, 50);
        REQUIRE(query::ask(asked, assets, seed, 4) == first);
        if (seed % 4 == 0) asked.tick();
    }
}

TEST_CASE("a solid that is cast at a mesh gives the first hit of all triangles") {
    int hits = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) REQUIRE(cast_order_fault(seed, hits) == "");
    CHECK(hits > 500);
}

TEST_CASE("a ray hits a mesh at each triangle or before it") {
    for (std::uint64_t seed = 1; seed <= 200; ++seed) REQUIRE(ray_order_fault(seed) == "");
}

TEST_CASE("a solid that is cast past another one does not pass through it") {
    int hits = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) REQUIRE(cast_beside_fault(seed, hits) == "");
    CHECK(hits > 1000);
}
