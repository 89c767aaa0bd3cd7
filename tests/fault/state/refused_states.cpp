// Inconsistent states, and states with values outside the range that commands allow: the world refuses each with a
// sentence about the cause, and does not change.
#include "model/contact_rows.h"
#include "model/manifest.h"
#include "scenes/scenes.h"
#include "support/character_course.h"
#include "support/rigs/joint_scenes.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <vector>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

using M = sim::Manifest;
using Damage = std::function<void(State&, const M&)>;

struct Row {
    std::string words; ///< part of the sentence; empty: accepted
    Damage damage;
};

/// Loads the world's own state with some damage. Returns the error sentence, or an empty string if the world accepts
/// it.
std::string said_of(const World& world, const Damage& damage) {
    World w = world.clone();
    State state = w.state();
    damage(state, sim::make_manifest(w.def(), w.schema()));
    const std::uint64_t hash = w.hash();
    const Status status = w.restore_portable(state.save_portable());
    if (status) return "";
    return w.hash() == hash ? status.error().message : "the world changed";
}

void check(const World& world, const std::vector<Row>& rows) {
    CHECK(said_of(world, [](State&, const M&) {}) == ""); // negative control
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::string said = said_of(world, rows[i].damage);
        INFO("row ", i, ": '", rows[i].words, "' is expected, '", said, "' is said");
        CHECK(said.empty() == rows[i].words.empty());
        CHECK(said.find(rows[i].words) != std::string::npos);
    }
}

/// Two equal boxes and a ball on a plane, touching. A third box was destroyed, so that there are free rows.
World touching() {
    World w = made(World::create({}));
    add_floor(w);
    const auto put = [&](Real x, const Geometry& geometry, Real rolling) {
        return add(w, {.pose = {.position = {x, 0.5_r, 0_r}}},
                   {.geometry = geometry, .rolling_resistance = rolling});
    };
    put(0_r, box(0.5_r, 0.5_r, 0.5_r), 0_r), put(3_r, box(0.5_r, 0.5_r, 0.5_r), 0_r);
    const BodyId ball = put(6_r, sphere(0.5_r), 0.1_r);
    done(w.destroy(put(9_r, box(0.5_r, 0.25_r, 0.5_r), 0_r)));
    done(w.set_velocity(ball, {1_r, 0_r, 0_r}, {0_r, 0_r, -2_r}));
    for (int i = 0; i < 20; ++i) w.tick();
    done(w.add_force(ball, {1_r, 0_r, 0_r}));
    return w;
}

/// Four crates in a row on a floor, joined, asleep; and a pair in the air, joined and awake.
World joined() {
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

World walking() {
    World w = made(World::create(small_def()));
    add_floor(w);
    test::character::add_character(w, 0, 0.01, 0);
    w.tick();
    return w;
}

/// A free row of the table of body traits.
std::uint32_t free_row(const State& s, const M& m) { return s.rows(m.header)[0].body_traits_free - 1; }
auto& uses_of_first(State& s, const M& m) {
    return s.edit_row(m.body_traits.uses, s.rows(m.body_info)[1].traits);
}
auto& body_like_first(State& s, const M& m) {
    return s.edit_row(m.body_traits.row, s.rows(m.body_info)[1].traits);
}
auto& shape_like_first(State& s, const M& m) {
    return s.edit_row(m.shape_traits.row, s.rows(m.shape)[1].traits);
}
sim::BodySleep& sleeper(State& s, const M& m) {
    for (sim::BodySleep& b : s.edit(m.body_sleep))
        if (b.next != 0) return b;
    throw std::runtime_error("no body sleeps");
}
/// Makes the lowest member of a ring lead to the third one, so that it never reaches the second.
void join_rings(State& s, const M& m) {
    std::vector<std::uint32_t> slots;
    for (std::uint32_t i = 0; i < s.count(m.bodies); ++i)
        if (s.rows(m.body_sleep)[i].next != 0) slots.push_back(s.rows(m.body_info)[i].id.index);
    std::ranges::sort(slots);
    if (slots.size() < 3) throw std::runtime_error("no ring of three");
    s.edit_row(m.body_sleep, s.rows(m.body_slot)[slots[0] - 1].row).next = slots[2];
}
/// Gives the first contact a second row, a copy without contact_touching, and changes the flags of the copy.
void add_row(State& s, const M& m, std::uint32_t more_flags) {
    sim::ContactList list;
    sim::read_contacts(s, m.contacts, list);
    list.keys.insert(list.keys.begin(), list.keys[0]);
    list.memories.insert(list.memories.begin(), list.memories[0]);
    list.memories[1].flags = (list.memories[1].flags & ~std::uint32_t{solve::contact_touching}) ^ more_flags;
    sim::write_contacts(s, m.contacts, list);
}
void add_flags(State& s, const M& m, std::uint16_t flags) { s.edit_row(m.contacts.memory, 0).flags ^= flags; }
/// Gives a velocity to all sleeping dynamic bodies, or to the awake ones.
void push(State& s, const M& m, bool resting) {
    for (std::uint32_t i = 0; i < s.count(m.bodies); ++i)
        if (s.rows(m.body_info)[i].kind == BodyKind::dynamic &&
            (i >= s.rows(m.header)[0].bodies_awake) == resting)
            s.edit_row(m.body_velocity, i).linear.y = Speed(1);
}

} // namespace

TEST_CASE("shared rows: a world rejects broken indexes and counts and free lists and duplicates") {
    const World w = touching();
    const M of_w = sim::make_manifest(w.def(), {});
    REQUIRE(w.state().rows(of_w.header)[0].body_traits_free != 0);
    REQUIRE(w.state().rows(of_w.header)[0].shape_traits_free != 0);
    check(w, {{"does not exist", [](State& s, const M& m) { s.edit_row(m.body_info, 1).traits = 1000; }},
              {"does not exist", [](State& s, const M& m) { s.edit_row(m.shape, 1).traits = 0xffffffffu; }},
              {"not what it says",
               [](State& s, const M& m) { s.edit_row(m.body_info, 1).traits = free_row(s, m); }},
              {"is used 2 times, which is not what it says",
               [](State& s, const M& m) { ++uses_of_first(s, m).count; }},
              {"not what it says",
               [](State& s, const M& m) {
                   s.edit_row(m.shape_traits.uses, s.rows(m.shape)[1].traits).count = 0;
               }},
              {"the free list misses rows",
               [](State& s, const M& m) { s.edit_row(m.header, 0).body_traits_free = 0; }},
              {"the free list is broken",
               [](State& s, const M& m) {
                   s.edit_row(m.header, 0).body_traits_free = s.rows(m.body_info)[1].traits + 1;
               }},
              {"the free list is broken",
               [](State& s, const M& m) {
                   const std::uint32_t row = free_row(s, m);
                   s.edit_row(m.body_traits.uses, row).count = sim::SharedUses::is_free | (row + 1);
               }},
              {"is free, but not zero",
               [](State& s, const M& m) { s.edit_row(m.body_traits.row, free_row(s, m)).locks = 1; }},
              {"is the same as another",
               [](State& s, const M& m) {
                   const sim::ShapeTraits first = shape_like_first(s, m);
                   s.edit_row(m.shape_traits.row, s.rows(m.shape)[3].traits) = first;
               }},
              {"locks is 64", [](State& s, const M& m) { body_like_first(s, m).locks = 64; }},
              {"gyration", [](State& s, const M& m) { body_like_first(s, m).mass.gyration.x = Real(-1); }},
              {"gyration",
               [](State& s, const M& m) { body_like_first(s, m).mass.gyration.y = Real::from_raw(2); }},
              {"", [](State& s, const M& m) { body_like_first(s, m).mass.gyration.y = 0.001_r; }},
              {"friction", [](State& s, const M& m) { shape_like_first(s, m).friction = Real(-1); }}});
}

TEST_CASE(
    "a world rejects contact rows and forces whose number differs from that of the contacts and bodies") {
    const World w = touching();
    const M of_w = sim::make_manifest(w.def(), {});
    REQUIRE(w.state().count(of_w.contacts.more) == 1);
    REQUIRE(w.state().count(of_w.contacts.points) == 9);
    REQUIRE(w.state().count(of_w.forces) == 1);
    check(w,
          {{"the contacts have 8 points",
            [](State& s, const M& m) { s.edit_row(m.contacts.memory, 0).count = 3; }},
           {"not one to 4 points", [](State& s, const M& m) { s.edit_row(m.contacts.memory, 0).count = 0; }},
           {"the contacts have 9 points", [](State& s, const M& m) { s.resize(m.contacts.points, 10); }},
           {"2 contacts have a row here",
            [](State& s, const M& m) { s.edit_row(m.contacts.memory, 0).flags |= solve::contact_has_more; }},
           {"has nothing in it", [](State& s, const M& m) { s.edit_row(m.contacts.beyond, 0) = {}; }},
           {"", [](State& s, const M& m) { add_row(s, m, 0); }},
           {"contact.memory row 1: a row after the first says that the pair touches",
            [](State& s, const M& m) { add_row(s, m, solve::contact_touching); }},
           {"the rows of a pair differ", [](State& s, const M& m) { add_row(s, m, solve::contact_passing); }},
           {"the rows of a pair differ", [](State& s, const M& m) { add_row(s, m, solve::contact_flipped); }},
           {"none is a sensor", [](State& s, const M& m) { add_flags(s, m, solve::contact_sensor_is_b); }},
           {"unknown flags", [](State& s, const M& m) { add_flags(s, m, solve::contact_hit); }},
           {"unknown flags", [](State& s, const M& m) { add_flags(s, m, 256); }},
           {"a force on no body", [](State& s, const M& m) { s.edit_row(m.pushed, 0) = 1000; }},
           {"a force that is not there",
            [](State& s, const M& m) { *std::ranges::find(s.edit(m.body_push), 0u) = 2; }}});
}

TEST_CASE("a world rejects broken joint lists and joints that no command can make") {
    const auto leads_to = [](State& s, const M& m, bool itself) {
        for (sim::JointRow& j : s.edit(m.joint)) j.next_a = j.next_b = itself ? j.id.index : 0;
    };
    check(joined(),
          {{"body.info",
            [](State& s, const M& m) {
                for (sim::BodyInfo& b : s.edit(m.body_info))
                    if (b.first_joint != 0) b.first_joint = 99;
            }},
           {"joint list", [&](State& s, const M& m) { leads_to(s, m, true); }},
           {"joints in no list", [&](State& s, const M& m) { leads_to(s, m, false); }},
           {"joint list",
            [](State& s, const M& m) { // two bodies swap their lists
                const auto info = s.edit(m.body_info);
                std::swap(info[0].first_joint, info[info.size() - 1].first_joint);
            }},
           {"do not exist",
            [](State& s, const M& m) {
                s.edit_row(m.joint, 0).def.body_b = {40, 1};
            }},
           {"do not exist", [](State& s, const M& m) { ++s.edit_row(m.joint, 0).def.body_b.generation; }},
           {"joint.row",
            [](State& s, const M& m) {
                JointDef& def = s.edit_row(m.joint, 0).def;
                def.body_a = def.body_b;
            }},
           {"kind is 77",
            [](State& s, const M& m) { s.edit_row(m.joint, 1).def.kind = static_cast<JointKind>(77); }},
           {"frequency is -1",
            [](State& s, const M& m) { s.edit_row(m.joint, 1).def.axis[2].frequency = Real(-1); }},
           {"joint", [](State& s, const M& m) { s.edit_row(m.joint, 1).id.index = 12; }}});
}

TEST_CASE("a world rejects broken rings of sleepers and rows in the wrong awake range and resting bodies "
          "that move") {
    const World w = joined();
    REQUIRE(!w.is_awake(w.body_at(w.body_count() - 1)));
    REQUIRE(w.state().rows(sim::make_manifest(w.def(), {}).header)[0].joints_awake == 2);
    check(w, {{"its ring is broken", [](State& s, const M& m) { sleeper(s, m).next = 60; }},
              {"its ring joins another", join_rings},
              {"body.sleep", [](State& s, const M& m) { sleeper(s, m).next = 1; }}, // the floor
              {"body.sleep", [](State& s, const M& m) { sleeper(s, m).next = 0; }},
              {"sleeps where it cannot", [](State& s, const M& m) { sleeper(s, m).island = 0; }},
              {"body.sleep", [](State& s, const M& m) { sleeper(s, m).island = 1000; }},
              {"has moved in no tick", [](State& s, const M& m) { sleeper(s, m).moved.linear.y = Speed(1); }},
              {"more is awake", [](State& s, const M& m) { s.edit_row(m.header, 0).bodies_awake = 900; }},
              {"more is awake", [](State& s, const M& m) { s.edit_row(m.header, 0).joints_awake = 900; }},
              {"body.sleep", // an awake body in a ring
               [](State& s, const M& m) { s.edit_row(m.body_sleep, 0) = sim::BodySleep(sleeper(s, m)); }},
              {"joint.row row 1: stands among resting joints, but a body of it is awake",
               [](State& s, const M& m) { --s.edit_row(m.header, 0).joints_awake; }},
              {"joint.row row 2: stands among awake joints, but no body of it is awake",
               [](State& s, const M& m) { ++s.edit_row(m.header, 0).joints_awake; }},
              {"", [](State& s, const M& m) { push(s, m, false); }},
              {"moves, but stands among resting bodies", [](State& s, const M& m) { push(s, m, true); }}});
}

TEST_CASE("a world rejects characters with a wrong body or shape and fields of an unknown kind") {
    check(walking(),
          {{"character.row", [](State& s, const M& m) { s.edit_row(m.character, 0).body.index = 0; }},
           {"character.row", [](State& s, const M& m) { s.edit_row(m.character, 0).shape.index = 200; }},
           {"character.row", [](State& s, const M& m) { s.edit_row(m.character, 0).body.generation = 9; }},
           {"", [](State& s, const M& m) { s.edit_row(m.character, 0).def.mask = 1; }}});
    check(made(made(make_scene("water", {.size = 2}))->start()),
          {{"field.row row 0: kind is 99",
            [](State& s, const M& m) { s.edit_row(m.field, 0).def.kind = static_cast<FieldKind>(99); }}});
}

TEST_CASE("a world rejects gravity and damping and masses and densities outside the ranges of the commands") {
    const auto gravity = [](Real y) {
        return [y](State& s, const M& m) { s.edit_row(m.header, 0).gravity.y = y; };
    };
    const auto body = [](Real sim::BodyTraits::*field, Real value) {
        return [=](State& s, const M& m) { body_like_first(s, m).*field = value; };
    };
    using T = sim::BodyTraits;
    check(touching(),
          {{"gravity", gravity(Real(1001))},
           {"", gravity(Real(-999))},
           {"world.config", [](State& s, const M& m) { s.edit_row(m.config, 0).gravity.y = Real(-999); }},
           {"linear_damping", body(&T::linear_damping, Real(1001))},
           {"linear_damping", body(&T::linear_damping, Real(-1))},
           {"", body(&T::linear_damping, Real(1000))},
           {"angular_damping", body(&T::angular_damping, Real(1001))},
           {"angular_damping", body(&T::angular_damping, Real(-1))},
           {"", body(&T::angular_damping, Real(1000))},
           {"gravity_scale", body(&T::gravity_scale, Real(101))},
           {"", body(&T::gravity_scale, Real(-100))},
           {"mass_override", body(&T::mass_override, Real(-1))},
           {"mass", [](State& s, const M& m) { body_like_first(s, m).mass.mass = Real{}; }},
           {"density", [](State& s, const M& m) { shape_like_first(s, m).density = Real{}; }}});
}
