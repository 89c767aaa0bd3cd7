// A small state with every kind of leaf, for tests of the state layer: two tables with columns, one without, rows of
// one byte up to rows longer than a page of the hash tree.
#pragma once

#include "lockstone/state.h"
#include "support/split_mix.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <string>

namespace lockstone::test {

enum class Mood : std::uint8_t { calm, alert };

struct Health {
    Real shield;
    std::int32_t points;
    std::int16_t bonus;
    Mood mood;
    std::int8_t luck;
};
template <class Visit> constexpr void describe(Health& h, Visit&& visit) {
    visit("shield", h.shield);
    visit("points", h.points);
    visit("bonus", h.bonus);
    visit("mood", h.mood);
    visit("luck", h.luck);
}

struct Impulse {
    Speed normal;
    std::uint32_t feature;
};
template <class Visit> constexpr void describe(Impulse& i, Visit&& visit) {
    visit("normal", i.normal);
    visit("feature", i.feature);
}
struct Manifold {
    std::uint64_t key;
    std::array<Impulse, 2> points;
};
template <class Visit> constexpr void describe(Manifold& m, Visit&& visit) {
    visit("key", m.key);
    visit("points", m.points);
}

/// A row longer than a page of the hash tree.
struct Inventory {
    std::array<std::uint16_t, 2> head;
    std::uint32_t serial;
    std::array<std::uint64_t, 640> slots;
};
template <class Visit> constexpr void describe(Inventory& i, Visit&& visit) {
    visit("head", i.head);
    visit("serial", i.serial);
    visit("slots", i.slots);
}

/// The handles of the columns, and their layout.
struct Sample {
    std::shared_ptr<const StateLayout> layout;
    TableId body, contact, tag;
    Column<Transform> pose;
    Column<SpeedVec3> velocity;
    Column<Manifold> manifold;
    Column<Health> health;
    Column<std::uint8_t> flag;
};

/// `contact.manifold` has 24 bytes a row, so its pages hold 170 rows.
inline Sample make_sample(std::uint32_t body_capacity = 8, std::uint32_t contact_capacity = 400) {
    StateLayout layout;
    Sample s{};
    s.body = layout.add_table("body", body_capacity);
    s.contact = layout.add_table("contact", contact_capacity);
    s.tag = layout.add_table("tag", 100);
    s.pose = layout.add_column<Transform>(s.body, "body.pose", Group::motion);
    s.velocity = layout.add_column<SpeedVec3>(s.body, "body.velocity", Group::motion);
    s.manifold = layout.add_column<Manifold>(s.contact, "contact.manifold", Group::contact);
    s.health = layout.add_column<Health>(s.body, "game.health", Group::game);
    s.flag = layout.add_column<std::uint8_t>(s.body, "game.flag", Group::game);
    s.layout = std::move(layout).finished();
    return s;
}

/// Fills all live rows with random bytes.
inline void scramble(State& state, SplitMix& random) {
    for (std::uint32_t column = 0; column < state.layout().columns().size(); ++column)
        for (std::byte& byte : state.edit_bytes(column)) byte = static_cast<std::byte>(random.next() & 255u);
}

/// A state with these row counts and random rows.
inline State random_state(const Sample& s, std::uint32_t bodies, std::uint32_t contacts, std::uint32_t tags,
                          std::uint64_t seed) {
    State state(s.layout);
    SplitMix random(seed);
    state.resize(s.body, bodies);
    state.resize(s.contact, contacts);
    state.resize(s.tag, tags);
    scramble(state, random);
    return state;
}

/// A state with random counts within the capacities, and random rows.
inline State random_state(const Sample& s, std::uint64_t seed) {
    SplitMix random(seed);
    const std::uint32_t bodies = random.below(s.layout->tables()[s.body.index].capacity + 1);
    const std::uint32_t contacts = random.below(s.layout->tables()[s.contact.index].capacity + 1);
    const std::uint32_t tags = random.below(101);
    return random_state(s, bodies, contacts, tags, random.next());
}

inline bool same_bytes(std::span<const std::byte> a, std::span<const std::byte> b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
}

} // namespace lockstone::test
