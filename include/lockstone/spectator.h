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
// watching machine compares with its own. Whoever joins late runs from the start, several ticks a frame.
#pragma once

#include "lockstone/session.h"

namespace lockstone {

struct SpectatorHostDef {
    std::uint32_t delay_ticks =
        0; ///< that watchers see later than players, against looking over their shoulders
    std::uint32_t watchers_max = 32;   ///< more are not answered
    std::uint64_t silence_polls = 600; ///< of a watcher: then its place is free again
};

/// Keeps the confirmed timeline from tick 0, some bytes a tick, and sends each watcher what it lacks: a packet a poll at most. It
/// is there from the match's first tick on (asserted).
class SpectatorHost final : public ConfirmedSink {
  public:
    /// `next`: a sink that is told too, a recorder say; not owned, like the transport.
    SpectatorHost(const SessionDef& def, Transport& transport, SpectatorHostDef host = {},
                  ConfirmedSink* next = nullptr);
    ~SpectatorHost() override;
    SpectatorHost(const SpectatorHost&) = delete;
    SpectatorHost& operator=(const SpectatorHost&) = delete;

    void on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash) override;
    void poll(); ///< receives, sends; call each frame
    std::uint32_t watchers() const;
    std::uint64_t bytes_sent() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl;
};

/// `def` as the players have it; `self` is read by nobody. Runs what has come, up to `ticks_per_frame` (1..64) a frame, so
/// a watcher that joins late catches up that many times as fast. Nothing is predicted, saved or rolled back. A hash that differs
/// is told as a Desync with the host.
Result<std::unique_ptr<Session>> make_spectator_session(const SessionDef& def, PeerId host,
                                                        Transport& transport,
                                                        std::uint32_t ticks_per_frame = 4);

} // namespace lockstone
