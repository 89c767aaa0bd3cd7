// The self test of the library: small worlds of this build against stored hashes, and a planted wrong hash.
#include "lockstone/prove.h"
#include "lockstone/testing.h"
#include "prove/random_world.h"
#include "prove/shuffled_tasks.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <set>
#include <thread>

using namespace lockstone;

namespace {

/// Counts properties that worlds of the self test have at some tick.
struct Seen {
    std::set<ShapeKind> shapes;
    std::set<JointKind> joints;
    std::set<FieldKind> fields;
    std::set<BodyKind> bodies;
    std::uint64_t locked = 0, bouncing = 0, rolling = 0, fallen_asleep = 0, woken = 0, broken = 0;
    std::uint32_t least = ~0u, most = 0; ///< bodies
    std::size_t packs = 0;               ///< worlds with enough contacts for the widest lanes

    void look(const World& world) {
        least = std::min(least, world.body_count()), most = std::max(most, world.body_count());
        for (const BodyId body : world.bodies()) {
            bodies.insert(world.kind(body));
            locked += world.body(body).locks != 0;
            for (const ShapeId id : world.shapes(body)) {
                const ShapeDef def = world.shape(id);
                shapes.insert(def.geometry.kind);
                bouncing += def.restitution > Real{}, rolling += def.rolling_resistance > Real{};
            }
        }
        for (std::uint32_t row = 0; row < world.joint_count(); ++row)
            joints.insert(world.joint(world.joint_at(row)).kind);
        for (std::uint32_t row = 0; row < world.field_count(); ++row)
            fields.insert(world.field(world.field_at(row)).kind);
    }
};

} // namespace

TEST_CASE("self_test() passes: small worlds have the stored hashes in every instruction set of the machine") {
    const Status same = self_test();
    const std::string sentence = same.ok() ? "" : same.error().message;
    INFO(sentence);
    INFO("where a change of behaviour is meant, tools/refresh rewrites src/prove/stored_hashes.h");
    CHECK(same.ok());
}

TEST_CASE(
    "planted fault: the self test reports a wrong stored hash with world and mode and tick and both hashes") {
    const std::vector<std::uint64_t> right = testing::self_test_hashes().value();
    REQUIRE(testing::self_test_against(right).ok());
    const auto sentence_of = [&](std::size_t place, std::uint64_t stored) {
        std::vector<std::uint64_t> hashes = right;
        hashes[place] = stored;
        const Status same = testing::self_test_against(hashes);
        return same.ok() ? std::string("agrees") : same.error().message;
    };
    char digits[17];
    std::snprintf(digits, sizeof digits, "%016llx",
                  static_cast<unsigned long long>(right[7 * testing::self_test_ticks + 2]));
    CHECK(sentence_of(7 * testing::self_test_ticks + 2, 0x4567) ==
          std::string("world 7, scalar, after tick 2: hash ") + digits +
              " against the stored 0000000000004567");
    CHECK(sentence_of(0, 0).starts_with("world 0, scalar, after tick 0: hash "));
    CHECK(sentence_of(right.size() - 1, 0).starts_with("world 19, scalar, after tick 2: hash "));
    CHECK(testing::self_test_against(std::span(right).first(7)).error().message ==
          "there are 7 stored hashes for 60 ticks; tools/refresh writes them");
}

TEST_CASE("the self test does not depend on earlier work or on repeated runs or on other threads") {
    const std::vector<std::uint64_t> first = testing::self_test_hashes().value();
    std::vector<std::uint64_t> backwards(first.size());
    for (std::uint32_t number = testing::self_test_worlds; number-- > 0;) {
        proofs::RandomWorld one = proofs::RandomWorld::make(number).value();
        for (std::uint32_t tick = 0; tick < testing::self_test_ticks; ++tick) {
            one.step().value();
            backwards[number * testing::self_test_ticks + tick] = one.world.hash();
        }
    }
    CHECK(backwards == first);
    bool other_agrees = false;
    std::thread other([&] { other_agrees = self_test().ok(); });
    CHECK(self_test().ok());
    other.join();
    CHECK(other_agrees);
    CHECK(testing::self_test_hashes().value() == first);
}

TEST_CASE("self test worlds have every primitive and nine joint kinds and all fields and locks and sleepers "
          "and commands") {
    Seen seen;
    proofs::ShuffledTasks tasks(1);
    for (std::uint32_t number = 0; number < testing::self_test_worlds; ++number) {
        proofs::RandomWorld one = proofs::RandomWorld::make(number).value();
        one.world.set_tasks(&tasks);
        std::size_t contacts = 0;
        for (std::uint32_t tick = 0; tick < testing::self_test_ticks; ++tick) {
            one.step().value();
            seen.look(one.world);
            std::set<std::pair<ShapeId, ShapeId>> pairs;
            for (const ContactPoint& point : one.world.contacts())
                pairs.emplace(point.shape_a, point.shape_b);
            contacts = std::max(contacts, pairs.size());
            for (const Event& event : one.world.events()) {
                seen.fallen_asleep += event.kind == EventKind::body_sleep,
                    seen.woken += event.kind == EventKind::body_wake;
                seen.broken += event.kind == EventKind::joint_break;
            }
        }
        seen.packs += contacts >= 8;
    }
    for (const ShapeKind kind : {ShapeKind::sphere, ShapeKind::capsule, ShapeKind::cylinder, ShapeKind::cone,
                                 ShapeKind::box, ShapeKind::plane})
        CHECK(seen.shapes.contains(kind));
    CHECK(seen.joints.size() == 9);
    CHECK(seen.fields.size() == 4);
    CHECK(seen.bodies.size() == 3);
    CHECK(seen.locked > 0);
    CHECK(seen.bouncing > 0);
    CHECK(seen.rolling > 0);
    CHECK(seen.fallen_asleep > 0);
    CHECK(seen.woken > 0);
    CHECK(seen.broken > 0);
    CHECK(seen.least >= 14);
    CHECK(seen.most <= 48);
    CHECK(seen.packs == testing::self_test_worlds);
    CHECK(tasks.parts > 0);
}
