// Events: one per transition, in their documented order; and the pairs that filters allow.
#include "support/about.h"
#include "support/contact_points.h"
#include "support/sim_script.h"

#include <doctest/doctest.h>

#include <map>
#include <tuple>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

const char* name_of(EventKind kind) {
    static constexpr const char* names[] = {"contact_begin", "contact_end", "sensor_begin", "sensor_end"};
    return names[static_cast<std::uint32_t>(kind)];
}

/// Returns an error sentence unless the events are in the order of event.h, each pair, joint or body once per kind.
std::string out_of_order(std::span<const Event> events) {
    // The test repeats the order here: a call of `precedes` would accept a wrong one.
    const auto order = [](const Event& e) {
        return std::tie(e.kind, e.shape_a, e.shape_b, e.joint, e.body_a, e.body_b);
    };
    for (std::size_t i = 1; i < events.size(); ++i)
        if (order(events[i - 1]) >= order(events[i]))
            return "event " + std::to_string(i) + " is before its predecessor or is it again";
    for (const Event& e : events)
        if (e.kind <= EventKind::contact_end && !(e.shape_a < e.shape_b))
            return "a contact's shapes are swapped";
    return {};
}

/// The kinds of the events of one tick, as text.
std::string kinds(const World& w) {
    std::string text;
    for (const Event& e : w.events()) text += (text.empty() ? "" : " ") + std::string(name_of(e.kind));
    return text;
}

/// Ticks until there are events, at most `limit` ticks. Returns their kinds.
std::string next_events(World& w, int limit = 200) {
    for (int t = 0; t < limit; ++t) {
        w.tick();
        if (!w.events().empty()) return kinds(w);
    }
    return "none";
}

bool touching_in_space(const ShapeDef& a, const ShapeDef& b) {
    World w = made(World::create(weightless()));
    add(w, {.pose = at(0, 0, 0)}, a);
    add(w, {.pose = at(0.9, 0, 0)}, b);
    w.tick();
    return !w.events().empty();
}

std::size_t count_of(std::span<const Event> events, EventKind kind) {
    return static_cast<std::size_t>(std::ranges::count(events, kind, &Event::kind));
}

/// In every tick two crates fall asleep and a character hops. Sometimes two joints break together, or a sleeper is hit.
struct EventfulWorld {
    World w = made(World::create(roomy()));
    CharacterId hopper;
    std::vector<BodyId> crates;

    static WorldDef roomy() {
        WorldDef def = drowsy_def();
        def.bodies_max = def.shapes_max = 512, def.contacts_max = 4096, def.joints_max = 64;
        return def;
    }
    EventfulWorld() {
        add_floor(w);
        hopper = made(w.create_character({.position = vec(0, 1, -5)}));
        done(w.set_character_input(hopper, {.jump = 1}));
    }
    void step() {
        const int t = static_cast<int>(w.tick_count());
        for (int i = 0; i < 2; ++i) crates.push_back(add_crate(w, at(2 * t - 100, 0.2, 2 * i), 0.2));
        if (t % 10 == 5)
            for (int i = 0; i < 2; ++i) {
                const BodyId hung = add_crate(w, at(2 * t - 100, 3, 2 * i + 5), 0.2);
                JointDef weak = weld_joint();
                weak.break_force = real(1);
                made(w.create_joint(weak, {}, hung, at(2 * t - 100, 3.5, 2 * i + 5)));
            }
        if (t > 60 && t % 10 == 0)
            for (std::size_t i = 0; i < 4; ++i)
                done(w.add_impulse(crates[crates.size() - 110 + i], vec(0, 200, 0)));
        done(w.set_character_input(hopper, {.jump = static_cast<std::uint32_t>(t % 2)}));
        w.tick();
    }
};

} // namespace

TEST_CASE("a contact begins once when bodies meet and ends once when they part") {
    World w = made(World::create(small_def()));
    const BodyId floor = add_floor(w);
    const BodyId ball = add_ball(w, at(0, 2, 0));
    CHECK(next_events(w) == "contact_begin");
    const Event begin = w.events()[0];
    CHECK(begin.body_a == floor);
    CHECK(begin.body_b == ball);
    CHECK(begin.tick == w.tick_count() - 1);
    CHECK(to_double(begin.normal.y) == test::about(1));
    CHECK(to_double(begin.approach_speed) == test::about(std::sqrt(2 * 9.81 * 1.5), 0.05));
    CHECK(std::abs(to_double(begin.point.y)) < 0.1);
    CHECK(next_events(w, 120) == "none");
    done(w.add_impulse(ball, {Real{}, w.mass(ball) * Real(3), Real{}}));
    CHECK(next_events(w) == "contact_end");
    CHECK(w.events()[0].point == Vec3{});
    CHECK(next_events(w) == "contact_begin");
}

TEST_CASE("a sensor reports the bodies that enter and leave and stops none of them") {
    World w = made(World::create(small_def()));
    const BodyId ball = add_ball(w, at(0, 3, 0), 0.25);
    const BodyId gate = made(w.create_body({.kind = BodyKind::static_}));
    made(w.create_shape(gate, {.geometry = box(real(1), real(0.5), real(1)), .sensor = 1}));
    CHECK(next_events(w) == "sensor_begin");
    CHECK(w.events()[0].body_a == gate);
    CHECK(w.events()[0].body_b == ball);
    CHECK(w.events()[0].normal == UnitVec3{});
    CHECK(next_events(w) == "sensor_end");
    CHECK(velocity(w, ball)[1] == test::about(-9.81 * static_cast<double>(w.tick_count()) / 60, 1e-4));
}

TEST_CASE("destroying a touching shape or body ends its contacts and sensor overlaps") {
    World w = made(World::create(small_def()));
    add_floor(w);
    const BodyId gate = made(w.create_body({.kind = BodyKind::static_}));
    made(w.create_shape(gate, {.geometry = box(real(1), real(1), real(1)), .sensor = 1}));
    const BodyId ball = add_ball(w, at(0, 0.5, 0));
    CHECK(next_events(w) == "contact_begin sensor_begin");
    for (int t = 0; t < 30; ++t) w.tick();
    const ShapeId shape = w.shapes(ball)[0];
    done(w.destroy(shape));
    w.tick();
    CHECK(kinds(w) == "contact_end sensor_end");
    CHECK((w.events()[0].shape_b == shape));
    CHECK(w.events()[0].body_b == BodyId{});
    w.tick();
    CHECK(kinds(w) == "");
    // A new shape takes the slot, at the same place: its contact is new, too.
    const ShapeId again = made(w.create_shape(ball, {.geometry = sphere(real(0.5))}));
    CHECK(again.index == shape.index);
    CHECK(again.generation != shape.generation);
    CHECK(next_events(w) == "contact_begin sensor_begin");
    done(w.destroy(ball));
    w.tick();
    CHECK(kinds(w) == "contact_end sensor_end");
}

TEST_CASE(
    "a shape that replaces a touching one in its slot ends one contact and begins another in the same tick") {
    World w = made(World::create(small_def()));
    add_floor(w);
    const BodyId ball = add_ball(w, at(0, 0.5, 0));
    for (int t = 0; t < 30; ++t) w.tick();
    done(w.destroy(w.shapes(ball)[0]));
    made(w.create_shape(ball, {.geometry = sphere(real(0.5))}));
    w.tick();
    CHECK(kinds(w) == "contact_begin contact_end");
}

TEST_CASE("events keep their order and alternate per pair and balance in all sceneries") {
    for (Scenery scenery : sceneries) {
        INFO(std::string(name_of(scenery)));
        World w = start_script(scenery);
        std::map<std::pair<ShapeId, ShapeId>, bool> touching;
        int begun = 0, ended = 0;
        for (int t = 0; t < 400; ++t) {
            step_script(w);
            REQUIRE(out_of_order(w.events()) == "");
            for (const Event& e : w.events()) {
                if (e.kind > EventKind::sensor_end) continue;
                const bool begin = e.kind == EventKind::contact_begin || e.kind == EventKind::sensor_begin;
                bool& now = touching[{e.shape_a, e.shape_b}];
                REQUIRE(now != begin);
                now = begin;
                ++(begin ? begun : ended);
            }
        }
        CHECK(ended > 10);
        CHECK(begun - ended == std::ranges::count_if(touching, [](const auto& pair) { return pair.second; }));
    }
}

TEST_CASE("sleep and wake and break and landing in one tick are reported in the order of kinds and joints "
          "and bodies") {
    EventfulWorld e;
    std::array<std::size_t, 4> most{};
    int both = 0;
    for (int t = 0; t < 160; ++t) {
        e.step();
        REQUIRE(out_of_order(e.w.events()) == "");
        const auto count = [&](EventKind kind) { return count_of(e.w.events(), kind); };
        most = {std::max(most[0], count(EventKind::joint_break)),
                std::max(most[1], count(EventKind::body_wake)),
                std::max(most[2], count(EventKind::body_sleep)),
                std::max(most[3], count(EventKind::character_landed))};
        both += count(EventKind::body_sleep) > 0 && count(EventKind::character_landed) > 0 ? 1 : 0;
    }
    CHECK(most[0] >= 2);
    CHECK(most[1] >= 2);
    CHECK(most[2] >= 2);
    CHECK(most[3] == 1);
    CHECK(both > 0);
}

TEST_CASE(
    "planted fault: the test detects events that are published when they are found instead of in order") {
    EventfulWorld e;
    std::vector<Event> events;
    do {
        e.step();
        REQUIRE(e.w.tick_count() < 200);
        events.assign(e.w.events().begin(), e.w.events().end());
    } while (count_of(events, EventKind::body_sleep) < 2 ||
             count_of(events, EventKind::character_landed) == 0);
    REQUIRE(out_of_order(events) == "");
    std::vector<Event> late = events; // the solver finds sleep last
    std::stable_partition(late.begin(), late.end(),
                          [](const Event& x) { return x.kind != EventKind::body_sleep; });
    CHECK(out_of_order(late) != "");
    const auto sleeper = std::ranges::find(events, EventKind::body_sleep, &Event::kind);
    std::vector<Event> other = events; // swaps two bodies
    std::swap(other[static_cast<std::size_t>(sleeper - events.begin())],
              other[static_cast<std::size_t>(sleeper - events.begin()) + 1]);
    CHECK(out_of_order(other) != "");
    std::vector<Event> twice = events;
    twice.insert(twice.begin() + (sleeper - events.begin()), *sleeper);
    CHECK(out_of_order(twice) != "");
}

TEST_CASE("contacts() returns the points of the tick regardless of commands before the call") {
    for (const Scenery scenery : {Scenery::stack, Scenery::pile})
        CHECK_MESSAGE(late_points_difference(scenery, 400) == "", late_points_difference(scenery, 400));
    CHECK_MESSAGE(points_of_sleepers_difference(400) == "", points_of_sleepers_difference(400));
}

TEST_CASE("there are no events after a restore until the next tick") {
    World w = made(World::create(small_def()));
    add_floor(w);
    add_ball(w, at(0, 0.5, 0));
    w.tick();
    REQUIRE(!w.events().empty());
    Image image;
    w.save(image);
    w.restore(image);
    CHECK(w.events().empty());
    CHECK(w.contacts().empty());
}

TEST_CASE("two shapes touch when each one's category is in the other's mask") {
    const ShapeDef plain{};
    CHECK(touching_in_space(plain, plain));
    CHECK(touching_in_space({.category = 2, .mask = 4}, {.category = 4, .mask = 2}));
    CHECK(!touching_in_space({.category = 2, .mask = 4}, {.category = 4, .mask = 1}));
    CHECK(!touching_in_space({.category = 2, .mask = 1}, {.category = 4, .mask = 2}));
    CHECK(!touching_in_space({.category = 0}, plain));
}

TEST_CASE(
    "shapes in a common positive group always touch and in a negative one never and others use the masks") {
    const ShapeDef plain{};
    CHECK(touching_in_space({.category = 0, .mask = 0, .group = 3}, {.category = 0, .mask = 0, .group = 3}));
    CHECK(!touching_in_space({.group = -3}, {.group = -3}));
    CHECK(touching_in_space({.group = -3}, {.group = -4}));
    CHECK(!touching_in_space({.mask = 0, .group = 3}, {.group = 4}));
    CHECK(touching_in_space({.group = -3}, plain));
}

TEST_CASE("shapes of one body and two sensors and two static or kinematic bodies do not touch") {
    World w = made(World::create(weightless()));
    const BodyId pair = add(w, {}, {.geometry = sphere(real(0.5))});
    made(w.create_shape(pair, {.geometry = sphere(real(0.5)), .local = at(0.2, 0, 0)}));
    for (BodyKind kind : {BodyKind::static_, BodyKind::static_, BodyKind::kinematic, BodyKind::kinematic})
        add(w, {.kind = kind, .pose = at(9, 0, 0)}, {.geometry = sphere(real(0.5))});
    for (int i = 0; i < 2; ++i)
        add(w, {.pose = at(20 + 0.1 * i, 0, 0)}, {.geometry = sphere(real(0.5)), .sensor = 1});
    w.tick();
    CHECK(w.events().empty());
    // A kinematic body does trigger a static sensor.
    add(w, {.kind = BodyKind::static_, .pose = at(9, 0, 0)}, {.geometry = sphere(real(0.5)), .sensor = 1});
    w.tick();
    CHECK(kinds(w) == "sensor_begin sensor_begin");
}
