// The session of a spectator: runs the confirmed ticks that hosts send, from the first tick or from a
// state.
#pragma once

#include "lockstone/session/spectator.h"
#include "session/join/told_ticks.h"

namespace lockstone::session {

/// Checks the ranges of a definition.
Status check_watch(const SessionDef& def, const WatchDef& watch);

class SpectatorSession final : public Session {
  public:
    SpectatorSession(const SessionDef& def, WatchDef watch, Transport& transport);

    void poll(std::uint64_t now_ms) override;
    void add_local_input(std::uint32_t, std::span<const std::byte>) override {} ///< a spectator has no inputs
    Step advance() override;
    Step settle() override;
    HashCheck report_hash(std::uint64_t tick, std::uint64_t hash) override;
    void report_adopted(const Status& taken, std::uint64_t hash) override;
    std::optional<ConfirmedTick> next_confirmed() override;
    std::optional<Notice> next_notice() override;
    Status drop_peer(PeerId peer) override;
    std::uint64_t current_tick() const override { return current; }
    /// No tick is saved; the number is for the events of a frame.
    std::uint32_t images_max() const override { return watch.ticks_per_frame + 1; }
    void set_input_delay(std::uint32_t) override {}
    PeerQuality quality(PeerId peer) const override;
    const SessionStats& stats() const override { return counts; }

    // ---- for a machine that joins (join_session.h) ----
    /// Begins a poll, without receiving.
    void begin_poll(std::uint64_t now_ms);
    /// Handles a packet. Returns why it was dropped; empty: it was used.
    std::optional<PacketFault> take(const Datagram& datagram);
    /// Counts a received packet. A packet without `fault` also ends the silence of its host.
    void count(const Datagram& datagram, std::optional<PacketFault> fault);
    void speak(std::uint32_t ticket, bool wants_seat);   ///< Sends the requests of this poll.
    void end_at(std::uint64_t tick) { last_end = tick; } ///< Runs no tick from `tick` on.
    /// Changes to the next host after `polls` polls without new ticks, at most host_silence_polls; at once
    /// if the host is silent for `unheard_ms` and another one is not.
    void ask_next_after(std::uint32_t polls, std::uint64_t unheard_ms) {
        silence_polls = std::min(polls, host_silence_polls);
        gone_after_ms = unheard_ms;
    }
    /// True if the machine sent a valid packet within `unheard_ms`, or if `since_ms` is not longer ago than
    /// that.
    bool is_heard(PeerId peer, std::uint64_t since_ms) const;
    std::uint64_t confirmed_through() const { return confirmed; }
    std::uint64_t here_through() const { return ticks.next(); } ///< all ticks below have arrived
    /// The bytes of an arrived tick in the format of Stretch::bytes; the ring holds the newest
    /// history_ticks.
    std::span<const std::byte> told(std::uint64_t tick) const { return ticks.at(tick); }
    /// True if no host has the next ticks any more.
    bool is_stopped() const { return phase == Phase::stopped; }
    /// True if this machine has caught up to within a few ticks, and most of the machines that answer have
    /// the same state.
    bool is_level() const;

  private:
    enum class Phase { fetching, adopting, following, stopped };
    struct Host {
        PeerId peer;
        std::optional<std::uint64_t> state_hash; ///< its hash of the state before assembly.offer().tick
        std::optional<bool> agrees;              ///< the newest hash that it sent equals the local one
        bool differs_told = false;
        std::uint64_t heard_ms = 0;
        std::uint64_t log_begin = 0;    ///< start of its log, known after a request for ticks before it
        std::uint32_t packets_read = 0; ///< in this poll
    };
    bool lacks_log(const Host& host) const { return host.log_begin > ticks.next(); }
    void show(std::uint64_t tick);
    std::optional<PacketFault> take(Host& from, std::span<const std::byte> packet);
    void take_offer(const Offer& offer);
    void take_word(Host& from, const Word& word);
    void take_stretch(const Stretch& stretch);
    void judge_state();
    void refuse(std::string reason);
    void next_host();
    void ask(std::size_t host);
    std::optional<std::size_t> next_heard() const;
    void judge_host();
    bool is_starved();
    bool is_log_gone();
    void begin_anew();
    void send_wish(PeerId to, const Wish& wish);

    SessionDef def;
    WatchDef watch;
    Transport& transport;
    std::uint32_t match;
    std::size_t tick_bytes;
    Phase phase;
    std::vector<Host> hosts;
    std::size_t serving = 0; ///< index of the host that receives the requests for ticks and states
    std::optional<Assembly> assembly;
    std::uint32_t polls_without_progress = 0, polls_with_state = 0, polls_fetching = 0;
    ToldTicks ticks;
    std::uint64_t ticks_seen = 0; ///< ticks.next() at the last poll
    std::uint32_t polls_without_ticks = 0, silence_polls = host_silence_polls;
    /// Polls in which all arrived ticks were executed although the host announced more.
    std::uint32_t polls_starved = 0;
    std::uint64_t polls_without_log = 0; ///< since a host reported that it no longer holds the next tick
    std::uint64_t gone_after_ms = never, serving_since_ms = 0;
    std::vector<std::uint64_t> hashes; ///< [history_ticks] own hashes, by tick modulo history_ticks
    std::uint64_t first = 0;           ///< the first executed tick
    std::uint64_t live_end = 0;        ///< end of the available ticks as the serving host announced it
    bool has_told_end = false;
    std::uint64_t last_end = never;
    std::uint64_t current = 0, confirmed = 0;
    bool connected = false, differs = false;
    std::uint64_t agreed = 0;
    std::vector<Request> requests;
    std::vector<PlayerInput> inputs;
    std::vector<Notice> notices;
    std::vector<std::byte> packet;
    SessionStats counts;
};

} // namespace lockstone::session
