// Spectators: any number of machines that watch a match and touch nothing of it.
//
//   a player's machine:  SpectatorHost host(session_def, transport_to_watchers);       // its own endpoint
//                        SessionRunner runner(*session, simulation, {.sink = &host});
//                        each frame: runner.frame(now); host.poll();
//   a watching machine:  auto session = make_spectator_session(session_def, host_peer, transport).value();
//                        SessionRunner runner(*session, simulation);  // from the same start as the players
//                        each frame: runner.frame(now);
//
// What is watched is the confirmed timeline: a tick comes when no input can change it any more, and its hash with it, which the
// watching machine compares with its own. Whoever joins late runs from the start, several ticks a frame; or from a recent state,
// which the host sends in chunks (WatchDef::from_state). lockstone/session/join.h: who comes to play, not to watch.
#pragma once

#include "lockstone/session.h"

namespace lockstone {

struct SpectatorHostDef {
    std::uint32_t delay_ticks =
        0; ///< that watchers see later than players, against looking over their shoulders
    std::uint32_t watchers_max = 32;   ///< more are not answered
    std::uint64_t silence_polls = 600; ///< of a watcher: then its place is free again
};

/// Keeps the confirmed timeline from the first tick that it is told of, some bytes a tick, and sends each watcher what it lacks: a
/// packet of ticks a poll, and two of a state. It is told of every tick from then on (asserted).
class SpectatorHost final : public ConfirmedSink {
  public:
    /// `next`: a sink that is told too, a recorder say; not owned, like the transport.
    SpectatorHost(const SessionDef& def, Transport& transport, SpectatorHostDef host = {},
                  ConfirmedSink* next = nullptr);
    ~SpectatorHost() override;
    SpectatorHost(const SpectatorHost&) = delete;
    SpectatorHost& operator=(const SpectatorHost&) = delete;

    void on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash) override;
    /// Whose states watchers may start from: SessionRunner::inspector() of the session that confirms; not owned. Without one they
    /// start from the first tick.
    void set_states(StateInspector* states);
    void poll(); ///< receives, sends; call each frame, after SessionRunner::frame
    std::uint32_t watchers() const;
    std::uint64_t bytes_sent() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl;
};

/// How to watch.
struct WatchDef {
    /// The watcher requests the match from the first host, and hashes from the others, to compare them. It requests the match from the next
    /// host when the current one has no ticks, lies, or sends nothing new for three seconds. It ends (MatchStopped) when no host holds the next
    /// tick any more.
    std::vector<PeerId> hosts;
    std::uint32_t ticks_per_frame = 4; ///< 1..64: so many times as fast as it is played a watcher catches up
    /// Begin at a recent state, not at the first tick. It is taken when its hash is what more hosts tell than tell another one, and
    /// at least one beside who sent it, where another one answers within three seconds. Else it is refused (StateRefused).
    bool from_state = false;
    std::uint32_t state_bytes_max = 16u << 20; ///< of a state, at most 64 MiB; a larger one is refused
};

/// `def` as the players have it; `self` is read by nobody. Runs what has come. Nothing is predicted, saved or rolled back. A hash that
/// differs is told as a Desync with the host.
Result<std::unique_ptr<Session>> make_spectator_session(const SessionDef& def, WatchDef watch,
                                                        Transport& transport);
Result<std::unique_ptr<Session>> make_spectator_session(const SessionDef& def, PeerId host,
                                                        Transport& transport,
                                                        std::uint32_t ticks_per_frame = 4);

} // namespace lockstone
