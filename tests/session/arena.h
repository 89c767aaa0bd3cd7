// A small substitute for a world and its rules, fast enough for millions of ticks: agents on a line that players push.
// A State holds all its data, its ticks depend on every input, and agents that meet make events.
#pragma once

#include "lockstone/input.h"
#include "lockstone/math/random.h"
#include "lockstone/session.h"

#include "support/state_sample.h"

namespace lockstone::test {

struct Pad {
    std::int16_t push;
    std::uint16_t buttons;
};
template <class V> constexpr void describe(Pad& p, V&& v) { v("push", p.push), v("buttons", p.buttons); }

struct Agent {
    std::int32_t place;
    std::int32_t speed;
    std::uint32_t touching; ///< bit i: agent i touches another agent
    std::uint32_t owner;
};
template <class V> constexpr void describe(Agent& a, V&& v) {
    v("place", a.place), v("speed", a.speed), v("touching", a.touching), v("owner", a.owner);
}
struct Clock {
    std::uint64_t tick;
    std::uint64_t dice;
};
template <class V> constexpr void describe(Clock& c, V&& v) { v("tick", c.tick), v("dice", c.dice); }

struct ArenaColumns {
    std::shared_ptr<const StateLayout> layout;
    TableId agents, clocks;
    Column<Agent> agent;
    Column<Clock> clock;
};
inline const ArenaColumns& arena_columns() {
    static const ArenaColumns columns = [] {
        ArenaColumns c{};
        StateLayout layout;
        c.agents = layout.add_table("agents", 8);
        c.clocks = layout.add_table("clocks", 1);
        c.agent = layout.add_column<Agent>(c.agents, "agent.motion", Group::motion);
        c.clock = layout.add_column<Clock>(c.clocks, "game.clock", Group::game);
        c.layout = std::move(layout).finished();
        return c;
    }();
    return columns;
}

class Arena : public Simulation {
  public:
    explicit Arena(std::uint32_t players) : state_block(arena_columns().layout) {
        state_block.resize(arena_columns().agents, 8);
        state_block.resize(arena_columns().clocks, 1);
        shown.reserve(56);
        for (std::uint32_t i = 0; i < 8; ++i)
            agents()[i] = {static_cast<std::int32_t>(i) * 600, 0, 0, i % players};
    }

    void save(Image& image) const override { state_block.save(image); }
    void restore(const Image& image) override {
        state_block.restore(image);
        shown.clear();
    }
    std::uint64_t hash() const override { return state_block.hash(); }
    std::span<const Event> events() const override { return shown; }
    State& state() override { return state_block; }

    void advance(std::span<const PlayerInput> inputs) override {
        Clock& clock = state_block.edit_row(arena_columns().clock, 0);
        std::uint32_t gone = 0;
        for (const PlayerInput& input : inputs) gone += input.status == InputStatus::disconnected ? 1 : 0;
        const std::uint64_t noise = split_mix(clock.dice);
        for (Agent& agent : agents()) {
            const std::span<const std::byte> input = inputs[agent.owner].bytes;
            const std::size_t pad_size = std::min<std::size_t>(input.size(), input_size_of<Pad>);
            const Pad pad = decode_input<Pad>(input.first(pad_size));
            for (const std::byte noise_byte : input.subspan(pad_size))
                agent.speed += static_cast<std::int32_t>(std::to_integer<std::uint32_t>(noise_byte) & 1u);
            agent.speed += pad.push / 256 + static_cast<std::int32_t>(noise >> (60 - agent.owner) & 1u);
            agent.speed += static_cast<std::int32_t>(pad.buttons & 3u) - static_cast<std::int32_t>(gone);
            agent.speed -= agent.speed / 8;
            agent.place = (agent.place + agent.speed + 8000) % 8000;
        }
        meet(clock.tick);
        ++clock.tick;
    }

  protected:
    std::span<Agent> agents() { return state_block.edit(arena_columns().agent); }

  private:
    void meet(std::uint64_t tick) {
        shown.clear();
        for (std::uint32_t kind = 0; kind < 2; ++kind) { // begin, then end: the order of EventKind
            for (std::uint32_t a = 0; a < 8; ++a) {
                for (std::uint32_t b = a + 1; b < 8; ++b) meet_pair(static_cast<EventKind>(kind), a, b, tick);
            }
        }
        for (std::uint32_t a = 0; a < 8; ++a) {
            for (std::uint32_t b = a + 1; b < 8; ++b) {
                agents()[a].touching &= ~(1u << b);
                if (near_each_other(a, b)) agents()[a].touching |= 1u << b;
            }
        }
    }
    bool near_each_other(std::uint32_t a, std::uint32_t b) {
        const std::int32_t gap = agents()[a].place - agents()[b].place;
        return gap < 300 && gap > -300;
    }
    void meet_pair(EventKind kind, std::uint32_t a, std::uint32_t b, std::uint64_t tick) {
        const bool before = (agents()[a].touching >> b & 1u) != 0;
        const bool now = near_each_other(a, b);
        if (now == before || now != (kind == EventKind::contact_begin)) return;
        Event event{};
        event.kind = kind;
        event.shape_a = {a + 1, 1};
        event.shape_b = {b + 1, 1};
        event.body_a = {a + 1, 1};
        event.body_b = {b + 1, 1};
        event.tick = tick;
        shown.push_back(event);
    }

    State state_block;
    std::vector<Event> shown;
};

/// A pad that holds its values as players do: it changes every few ticks, at other ticks for each player.
inline Pad scripted_pad(std::uint32_t player, std::uint64_t tick) {
    test::SplitMix random((tick + player * 3) / 9 * 64 + player + 1);
    return {static_cast<std::int16_t>(random.next()), static_cast<std::uint16_t>(random.below(4))};
}

} // namespace lockstone::test
