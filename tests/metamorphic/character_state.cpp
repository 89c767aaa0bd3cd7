// All that a character remembers lies in the world's state: a world saved and restored at any tick goes on to the same bits.
#include "lockstone/testing.h"
#include "support/character_course.h"

#include <doctest/doctest.h>

#include <functional>

using namespace lockstone;
using namespace lockstone::test::character;

namespace {

constexpr int run_length = 240;

/// Stairs, a ramp, a low beam, a lift, a turning disc, crates, a ball, and three characters among them.
World course() {
    World w = made(World::create(small_def()));
    add_floor(w);
    add_stairs(w, 5, 0.25, 0.3);
    add_wall(w, at(-3, 2.25, 0), vec(0.6, 1, 2)); // a beam 1.25 m above the ground
    add(w,
        {.kind = BodyKind::kinematic,
         .pose = at(-1, 0.1, 3),
         .linear_velocity = vec(0.5, 0.4, 0),
         .angular_velocity = vec(0, 1, 0)},
        {.geometry = box(1_r, 0.1_r, 1_r)});
    for (int i = 0; i < 3; ++i)
        add(w, {.pose = at(-1.2, 0.3 + 0.6 * i, -1.5), .mass = 25_r}, {.geometry = box(0.3_r, 0.3_r, 0.3_r)});
    add(w, {.pose = at(4, 0.4, -1.5), .linear_velocity = vec(-6, 0, 0)}, {.geometry = sphere(0.4_r)});
    add(w, {.kind = BodyKind::static_, .pose = at(-1, 1, -2)}, {.geometry = box(1_r, 1_r, 1_r), .sensor = 1});
    add_character(w, 0, 0.01, 0);
    add_character(w, -1, 0.5, 3);
    add_character(w, 0.3, 0.01, -1.6);
    return w;
}

/// Inputs of a tick: a pure function of it.
void step(World& w) {
    const auto t = static_cast<int>(w.tick_count());
    drive(w, w.character_at(0), t < 120 ? 3 : -3.5, 0, t % 50 == 40, t > 180);
    drive(w, w.character_at(1), t > 60 ? 1 : 0, t > 90 ? -2 : 0, t % 70 == 30);
    drive(w, w.character_at(2), -2, 0.2 * (t % 7 - 3), t == 100);
    w.tick();
}

std::vector<std::uint64_t> straight_run() {
    World w = course();
    std::vector<std::uint64_t> hashes{w.hash()};
    for (int t = 0; t < run_length; ++t) {
        step(w);
        hashes.push_back(w.hash());
    }
    return hashes;
}

/// Ticks one world, puts each of its states through `move`, and runs on from there for some ticks. The first tick at which
/// a hash differs, or -1.
int departs(const std::function<World(const World&)>& move, int ticks_after) {
    const std::vector<std::uint64_t> hashes = straight_run();
    World w = course();
    for (int t = 0; t < run_length; ++t) {
        World other = move(w);
        for (int i = t; i < std::min(t + ticks_after, run_length); ++i) {
            if (other.hash() != hashes[static_cast<std::size_t>(i)]) return i;
            step(other);
        }
        step(w);
    }
    return -1;
}

World restored(const World& from) {
    Image image;
    from.save(image);
    World w = course();
    for (int i = 0; i < 7; ++i) step(w); // caches of another time
    w.restore(image);
    return w;
}

World through_a_file(const World& from) {
    World w = course();
    done(w.restore_portable(from.save_portable()));
    return w;
}

} // namespace

TEST_CASE("the course has something of everything: steps, a ride, a crouch, pushes, jumps") {
    World w = course();
    bool crouched = false, rode = false, jumped = false, climbed = false, pushed = false;
    for (int t = 0; t < run_length; ++t) {
        step(w);
        for (std::uint32_t i = 0; i < 3; ++i) {
            const CharacterState s = w.character_state(w.character_at(i));
            crouched |= s.crouched != 0;
            rode |= s.ground_velocity != Vec3{};
            jumped |= s.has_jumped != 0;
            climbed |= stands(w, w.character_at(i)) && feet(w, w.character_at(i))[1] > 1;
            CHECK(overlap(w, w.character_at(i)) < 0.02);
        }
        for (std::uint32_t row = 0; row < w.body_count(); ++row)
            pushed |= w.mass(w.body_at(row)) == 25_r && std::abs(velocity(w, w.body_at(row))[0]) > 0.5;
    }
    CHECK(crouched);
    CHECK(rode);
    CHECK(jumped);
    CHECK(climbed);
    CHECK(pushed);
}

TEST_CASE("characters restored at any tick, or moved through a file, go on to the same hashes") {
    CHECK(departs(restored, 3) == -1);
    CHECK(departs(through_a_file, 2) == -1);
    CHECK(departs([](const World& w) { return w.clone(); }, 2) == -1);
}

TEST_CASE("planted: characters that lose what they remember go another way") {
    const auto forgetful = [](const World& from) {
        World w = from.clone();
        State& state = testing::state_of(w);
        const ColumnInfo* column = state.layout().find_column("character.row");
        REQUIRE(column != nullptr);
        // A new row with the ids, definition and input of the old one.
        const auto index = static_cast<std::uint32_t>(column - state.layout().columns().data());
        const std::size_t kept = sizeof(CharacterId) + sizeof(BodyId) + sizeof(ShapeId) +
                                 sizeof(CharacterDef) + sizeof(CharacterInput);
        for (std::uint32_t row = 0; row < w.character_count(); ++row) {
            const std::span<std::byte> bytes = state.edit_bytes(index, row, 1);
            std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(kept), bytes.end(), std::byte{});
        }
        return w;
    };
    World w = course();
    int other_ways = 0;
    for (int t = 0; t < run_length; ++t) {
        World other = forgetful(w);
        REQUIRE(same_motion(other, w));
        step(other), step(w);
        other_ways += same_motion(other, w) ? 0 : 1;
    }
    CHECK(other_ways > run_length / 4);
}

TEST_CASE("a file with a broken character is refused") {
    World w = course();
    step(w);
    const std::vector<std::byte> good = w.save_portable();
    const auto refused = [&](const std::function<void(State&)>& damage) {
        World bad = w.clone();
        damage(testing::state_of(bad));
        World into = course();
        const std::uint64_t before = into.hash();
        const Status status = into.restore_portable(bad.save_portable());
        CHECK((status.ok() || into.hash() == before));
        return !status.ok();
    };
    const auto at_byte = [](State& s, std::size_t offset, std::uint8_t value) {
        const ColumnInfo* column = s.layout().find_column("character.row");
        const auto index = static_cast<std::uint32_t>(column - s.layout().columns().data());
        s.edit_bytes(index, 0, 1)[offset] = std::byte{value};
    };
    CHECK(refused([&](State& s) { at_byte(s, 8, 0); }));                // another body: the floor
    CHECK(refused([&](State& s) { at_byte(s, 16, 200); }));             // a shape that is not there
    CHECK(refused([&](State& s) { at_byte(s, 12, 9); }));               // a body of another generation
    CHECK(refused([&](State& s) { at_byte(s, 24 + 36, 1); }) == false); // its mask may be anything
    World into = course();
    CHECK(into.restore_portable(good).ok());
}
