// Spectators: machines that watch a match without effect on it.
//
//   a player's machine:  SpectatorHost host(session_def, transport_to_watchers);       // its own endpoint
//                        SessionRunner runner(*session, simulation, {.sink = &host});
//                        each frame: runner.frame(now); host.poll();
//   a watching machine:  auto session = make_spectator_session(session_def, host_peer, transport).value();
//                        SessionRunner runner(*session, simulation);  // same start as the players
//                        each frame: runner.frame(now);
//
// A spectator receives confirmed ticks with their hashes, and compares the hashes with its own. A late
// spectator runs from the start, several ticks in a frame, or from a recent state that the host sends in
// chunks (WatchDef::from_state). To join as a player see lockstone/session/join.h.
#pragma once

#include "lockstone/session.h"

namespace lockstone {

/// Settings of a SpectatorHost.
struct SpectatorHostDef {
    std::uint32_t delay_ticks = 0;     ///< delay of spectators behind the players [ticks], against cheating
    std::uint32_t watchers_max = 32;   ///< limit of spectators; others get no answer
    std::uint64_t silence_polls = 600; ///< a spectator is removed after this silence [polls]
};

/// Stores the confirmed timeline, some bytes for each tick, and sends it to spectators: in each poll a packet
/// of ticks and two packets of a state for each. It must receive every tick from its first one on; otherwise
/// the program ends.
class SpectatorHost final : public ConfirmedSink {
  public:
    /// `next`: a further sink, such as a recorder; null: none. It and the transport are not owned.
    SpectatorHost(const SessionDef& def, Transport& transport, SpectatorHostDef host = {},
                  ConfirmedSink* next = nullptr);
    ~SpectatorHost() override;
    SpectatorHost(const SpectatorHost&) = delete;
    SpectatorHost& operator=(const SpectatorHost&) = delete;

    /// Stores a tick and passes it to `next`.
    void on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash) override;
    /// Source of states for late spectators: SessionRunner::inspector() of the player's runner. Not owned.
    /// Null (default): they run from the first tick.
    void set_states(StateInspector* states);
    /// Receives and sends. Call it in each frame after SessionRunner::frame().
    void poll();
    std::uint32_t watchers() const;   ///< Number of spectators.
    std::uint64_t bytes_sent() const; ///< Bytes sent since the start.

  private:
    struct Impl;
    std::unique_ptr<Impl> impl;
};

/// Settings of a spectator.
struct WatchDef {
    /// Machines with a SpectatorHost, at least one. The spectator requests the match from the first, and
    /// hashes from the others to compare them. It changes to the next one if a host has no ticks, sends wrong
    /// hashes, or sends nothing new for three seconds. It stops (MatchStopped) if no host has its next tick
    /// any more.
    std::vector<PeerId> hosts;
    std::uint32_t ticks_per_frame = 4; ///< maximum ticks in a frame during catch-up, 1..64
    /// True: begin at a recent state in place of the first tick. The state is accepted if most hosts report
    /// its hash, at least one besides its sender if another answers within three seconds; else it is refused
    /// (StateRefused).
    bool from_state = false;
    std::uint32_t state_bytes_max = 16u << 20; ///< larger states are refused [bytes], 1..64 MiB
};

/// A session that watches a match: no prediction, no Save, no Load. `def`: as on the players' machines;
/// `self` is ignored. A different hash gives the notice Desync with the host. The transport is not owned.
/// Errors: a field out of range.
Result<std::unique_ptr<Session>> make_spectator_session(const SessionDef& def, WatchDef watch,
                                                        Transport& transport);
/// A session that watches a match from one host, from its first tick.
Result<std::unique_ptr<Session>> make_spectator_session(const SessionDef& def, PeerId host,
                                                        Transport& transport,
                                                        std::uint32_t ticks_per_frame = 4);

} // namespace lockstone
