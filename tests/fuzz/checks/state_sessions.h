// A state that a world accepted, played by sessions: with rollback, and sent to a spectator and to a joining machine.
// Sessions guarantee properties of events and hashes that a world alone does not.
#pragma once

#include "fuzz/state_worlds.h"
#include "lockstone/session.h"
#include "lockstone/session/join.h"
#include "lockstone/session/spectator.h"

namespace fuzz {

/// Rules for two players that only tick the world.
class Ticking final : public Game {
  public:
    explicit Ticking(std::size_t base_number) : number(base_number) {}
    std::string name() const override { return "ticking"; }
    std::uint64_t content_id() const override { return 1 + number; }
    std::uint32_t player_count() const override { return 2; }
    std::uint32_t input_size() const override { return 1; }
    Result<World> start() const override { return base_of(number).before.clone(); }
    Status advance(World& world, std::span<const PlayerInput>) const override {
        world.tick();
        return {};
    }

  private:
    std::size_t number;
};

/// Returns a sentence if the session found a desync, else an empty string.
inline std::string desync_of(Session& session) {
    while (const std::optional<Notice> notice = session.next_notice())
        if (std::holds_alternative<Desync>(*notice)) return "a session finds a desync";
    return {};
}

/// Plays ticks, and runs each of them again two ticks later.
inline std::string play_rolled_back(World& w, const Game& game) {
    WorldSimulation simulation(w, game);
    const std::unique_ptr<Session> session =
        lockstone::test::scene::made(make_sync_test_session(session_def(game, 0, {0, 0}), 2));
    SessionRunner runner(*session, simulation);
    const std::byte idle{};
    for (std::uint64_t frame = 1; frame <= 6; ++frame) {
        for (const std::uint32_t player : {0u, 1u}) session->add_local_input(player, {&idle, 1});
        runner.frame(frame * 16);
    }
    return desync_of(*session);
}

/// A host with this state offers it to a spectator or to a joining machine, and both continue. Sets `reached` to the
/// guest's next tick.
inline std::string play_from_host(const World& at, const Game& game, bool joins, std::uint64_t& reached) {
    struct Offered final : StateInspector {
        explicit Offered(World world) : w(std::move(world)) {}
        const State* state_after(std::uint64_t) override { return &w.state(); }
        Rerun run_again(std::uint64_t, std::span<const PlayerInput>) override { return {}; }
        World w;
    };
    SimulatedNetwork network(2, {}, 1);
    const SessionDef def = session_def(game, 0, {0, 1});
    SessionDef guest = def;
    guest.self = 1;
    Offered host_world(at.clone());
    SpectatorHost host(def, network.endpoint(0));
    host.set_states(&host_world);
    World w = lockstone::test::scene::made(game.start());
    WorldSimulation simulation(w, game);
    const std::unique_ptr<Session> session = lockstone::test::scene::made(
        joins ? make_join_session(guest, {}, network.endpoint(1))
              : make_spectator_session(guest, {.hosts = {0}, .from_state = true}, network.endpoint(1)));
    SessionRunner runner(*session, simulation);
    const std::byte idle{};
    const PlayerInput inputs[2] = {{{&idle, 1}}, {{&idle, 1}}};
    std::uint64_t tick = 0;
    const auto confirm = [&] { host.on_confirmed(tick++, inputs, host_world.w.hash()); };
    confirm();
    for (std::uint64_t frame = 1; frame <= 60; ++frame) {
        network.advance_to(frame * 100);
        if (frame > 45) host_world.w.tick(), confirm();
        host.poll();
        runner.frame(frame * 100);
    }
    reached = session->current_tick();
    return desync_of(*session);
}

/// Plays the state of `w` in sessions. `chosen` decides whether a spectator or a joining machine receives it too.
/// Returns an error sentence or an empty string.
inline std::string play_in_sessions(const World& w, World& scratch, std::size_t base, std::uint64_t chosen) {
    const Ticking game(base);
    if (const Status taken = scratch.restore_portable(w.save_portable()); !taken)
        return taken.error().message;
    if (std::string fault = play_rolled_back(scratch, game); !fault.empty()) return fault;
    // One state in 8 is transferred, because a transfer takes longer than the other checks together.
    std::uint64_t reached = 0;
    return chosen % 8 == 0 ? play_from_host(w, game, chosen % 16 == 0, reached) : "";
}

} // namespace fuzz
