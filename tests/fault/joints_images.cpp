// Crafted images of worlds with joints and sleepers: whatever is broken in a list or a ring is refused with its
// sentence, and the world stays as it was.
#include "lockstone/testing.h"
#include "support/rigs/joint_scenes.h"
#include "world/world_impl.h"

#include <doctest/doctest.h>

#include <cstdlib>
#include <functional>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// Four crates in a row on a floor, joined, asleep; and a pair in the air, joined and awake.
World start() {
    WorldDef def = drowsy_def();
    def.joints_max = 16;
    World w = made(World::create(def));
    add_floor(w);
    BodyId before{};
    for (int i = 0; i < 4; ++i) {
        const BodyId crate = add_crate(w, at(1.5 * i, 0.5, 0));
        if (before) made(w.create_joint(ball_joint(), before, crate, at(1.5 * i - 0.75, 0.5, 0)));
        before = crate;
    }
    for (int t = 0; t < 90; ++t) w.tick();
    const BodyId a = add_crate(w, at(0, 50, 5)), b = add_crate(w, at(2, 50, 5));
    made(w.create_joint(weld_joint(), a, b, at(1, 50, 5)));
    made(w.create_joint(hinge_joint(), {}, b, at(2, 50, 5)));
    w.tick();
    return w;
}

template <class Row> std::span<Row> rows(State& s, const char* name) {
    const ColumnInfo* info = s.layout().find_column(name);
    REQUIRE(info != nullptr);
    REQUIRE(info->row_size == sizeof(Row));
    const std::span<std::byte> bytes =
        s.edit_bytes(static_cast<std::uint32_t>(info - s.layout().columns().data()));
    return {reinterpret_cast<Row*>(bytes.data()), bytes.size() / sizeof(Row)};
}

/// What restore_portable says of an image with `damage`; "accepted" when it takes it.
std::string verdict(const std::function<void(State&)>& damage) {
    World w = start(), damaged = start();
    damage(testing::state_of(damaged));
    const std::uint64_t hash = w.hash();
    const Status status = w.restore_portable(damaged.save_portable());
    if (status) return "accepted";
    return w.hash() == hash ? status.error().message : "the world changed";
}
bool says(const std::string& verdict, const char* words) { return verdict.find(words) != std::string::npos; }

using solve::BodyInfo;
using solve::BodySleep;
using solve::JointRow;

} // namespace

TEST_CASE("an image without damage is taken, and goes on like the world it came from") {
    CHECK(verdict([](State&) {}) == "accepted");
    World w = start(), other = start();
    REQUIRE(!w.is_awake(w.body_at(w.body_count() - 1)));
    done(other.restore_portable(w.save_portable()));
    for (int t = 0; t < 30; ++t) w.tick(), other.tick();
    CHECK(difference(w, other) == "");
}

TEST_CASE("broken joint lists are refused, and each sentence names the column") {
    CHECK(says(verdict([](State& s) {
                   for (BodyInfo& b : rows<BodyInfo>(s, "body.info"))
                       if (b.first_joint != 0) b.first_joint = 99;
               }),
               "body.info"));
    CHECK(says(verdict([](State& s) { // a list that leads back to itself
                   for (JointRow& j : rows<JointRow>(s, "joint.row")) j.next_a = j.next_b = j.id.index;
               }),
               "joint list"));
    CHECK(says(verdict([](State& s) { // a list that ends too early
                   for (JointRow& j : rows<JointRow>(s, "joint.row")) j.next_a = j.next_b = 0;
               }),
               "joints in no list"));
    CHECK(says(verdict([](State& s) { // two bodies exchange their lists
                   const auto info = rows<BodyInfo>(s, "body.info");
                   std::swap(info[0].first_joint, info[info.size() - 1].first_joint);
               }),
               "joint list"));
}

TEST_CASE("joints between bodies that do not exist, or that no command could make, are refused") {
    CHECK(says(verdict([](State& s) {
                   rows<JointRow>(s, "joint.row")[0].def.body_b = {40, 1};
               }),
               "do not exist"));
    CHECK(says(verdict([](State& s) { ++rows<JointRow>(s, "joint.row")[0].def.body_b.generation; }),
               "do not exist"));
    CHECK(says(verdict([](State& s) {
                   JointRow& j = rows<JointRow>(s, "joint.row")[0];
                   j.def.body_a = j.def.body_b;
               }),
               "joint.row"));
    CHECK(says(
        verdict([](State& s) { rows<JointRow>(s, "joint.row")[1].def.kind = static_cast<JointKind>(77); }),
        "kind is 77"));
    CHECK(says(verdict([](State& s) { rows<JointRow>(s, "joint.row")[1].def.axis[2].frequency = Real(-1); }),
               "frequency is -1"));
    CHECK(says(verdict([](State& s) { rows<JointRow>(s, "joint.row")[1].id.index = 12; }), "joint"));
}

TEST_CASE("broken rings of sleepers are refused") {
    const auto sleeper = [](State& s) -> BodySleep& {
        for (BodySleep& b : rows<BodySleep>(s, "body.sleep"))
            if (b.next != 0) return b;
        throw std::runtime_error("nobody sleeps");
    };
    CHECK(says(verdict([&](State& s) { sleeper(s).next = 60; }), "its ring is broken"));
    CHECK(says(verdict([&](State& s) { sleeper(s).next = 1; }), "body.sleep")); // the floor
    CHECK(says(verdict([&](State& s) { sleeper(s).next = 0; }), "body.sleep"));
    CHECK(says(verdict([&](State& s) { sleeper(s).island = 0; }), "sleeps where it cannot"));
    CHECK(says(verdict([&](State& s) { sleeper(s).island = 1000; }), "body.sleep"));
    CHECK(says(verdict([&](State& s) { sleeper(s).moved.linear.y = Speed(1); }), "has moved in no tick"));
    CHECK(says(verdict([&](State& s) { rows<sim::Header>(s, "world.header")[0].bodies_awake = 900; }),
               "more is awake"));
    CHECK(says(verdict([&](State& s) { rows<sim::Header>(s, "world.header")[0].joints_awake = 900; }),
               "more is awake"));
    CHECK(says(verdict([&](State& s) { // an awake body in a ring
                   const auto sleep = rows<BodySleep>(s, "body.sleep");
                   sleep[0] = sleeper(s);
               }),
               "body.sleep"));
}

TEST_CASE(
    "joints on the wrong side of those that are awake are refused, and so are resting bodies that move") {
    const auto count_as_awake = [](int more) {
        return verdict([more](State& s) {
            std::uint32_t& awake = rows<sim::Header>(s, "world.header")[0].joints_awake;
            REQUIRE(awake == 2);
            awake = static_cast<std::uint32_t>(static_cast<int>(awake) + more);
        });
    };
    CHECK(count_as_awake(0) == "accepted");
    CHECK(
        says(count_as_awake(-1), "joint.row row 1: stands among resting joints, but a body of it is awake"));
    CHECK(says(count_as_awake(1), "joint.row row 2: stands among awake joints, but no body of it is awake"));
    const auto push = [](bool resting) {
        return verdict([resting](State& s) {
            for (std::size_t i = 0; i < rows<BodyInfo>(s, "body.info").size(); ++i) {
                if (rows<BodyInfo>(s, "body.info")[i].kind != BodyKind::dynamic) continue;
                if ((i >= rows<sim::Header>(s, "world.header")[0].bodies_awake) != resting) continue;
                rows<solve::Velocity>(s, "body.velocity")[i].linear.y = Speed(1);
            }
        });
    };
    CHECK(push(false) == "accepted");
    CHECK(says(push(true), "moves, but stands among resting bodies"));
}

TEST_CASE("random bytes in the columns of joints and sleepers: refused, or a world that ticks on") {
    Random random = Random::seeded(3);
    int refused = 0, ticked = 0;
    const World fresh = start();
    for (int i = 0; i < (std::getenv("LOCKSTONE_LONG") != nullptr ? 3000 : 150); ++i) {
        World damaged = fresh.clone(), w = fresh.clone();
        const char* const names[] = {"joint.row",  "joint.slot", "joint.memory",
                                     "body.sleep", "body.info",  "world.header"};
        State& s = testing::state_of(damaged);
        const ColumnInfo* info = s.layout().find_column(names[random.below(6)]);
        const std::span<std::byte> bytes =
            s.edit_bytes(static_cast<std::uint32_t>(info - s.layout().columns().data()));
        for (int k = 0; k < 3; ++k)
            bytes[random.below(static_cast<std::uint32_t>(bytes.size()))] ^=
                static_cast<std::byte>(1 + random.below(255));
        if (!w.restore_portable(damaged.save_portable())) {
            ++refused;
            continue;
        }
        for (int t = 0; t < 4; ++t) w.tick();
        for (std::uint32_t row = 0; row < w.body_count(); ++row)
            static_cast<void>(w.wake_body(w.body_at(row)).ok());
        for (int t = 0; t < 4; ++t) w.tick();
        ++ticked;
    }
    CHECK(refused > 20);
    CHECK(ticked > 20);
}
