// The session of a machine that watches: it runs what hosts tell, from the first tick or from a state.
#pragma once

#include "lockstone/session/spectator.h"
#include "session/join/told_ticks.h"

namespace lockstone::session {

Status check_watch(const SessionDef& def, const WatchDef& watch);

class SpectatorSession final : public Session {
  public:
    SpectatorSession(const SessionDef& def, WatchDef watch, Transport& transport);

    void poll(std::uint64_t now_ms) override;
    void add_local_input(std::uint32_t, std::span<const std::byte>) override {} ///< a watcher has no inputs
    Step advance() override;
    Step settle() override;
    HashCheck report_hash(std::uint64_t tick, std::uint64_t hash) override;
    void report_adopted(const Status& taken, std::uint64_t hash) override;
    std::optional<ConfirmedTick> next_confirmed() override;
    std::optional<Notice> next_notice() override;
    Status drop_peer(PeerId peer) override;
    std::uint64_t current_tick() const override { return current; }
    std::uint32_t images_max() const override {
        return watch.ticks_per_frame + 1;
    } ///< none is saved; events of a frame
    void set_input_delay(std::uint32_t) override {}
    PeerQuality quality(PeerId peer) const override;
    const SessionStats& stats() const override { return counts; }

    // ---- for a machine that comes to play (join_session.h) ----
    void begin_poll(std::uint64_t now_ms);
    /// Why the packet was not taken; nothing: it was.
    std::optional<PacketFault> take(const Datagram& datagram);
    void count(const Datagram& datagram, std::optional<PacketFault> fault);
    void speak(std::uint32_t ticket, bool wants_seat);   ///< sends the wishes of this poll
    void end_at(std::uint64_t tick) { last_end = tick; } ///< runs no tick from there on
    /// After so many polls of a host that tells nothing new, at most host_silence_polls; and at once where it has not been heard for so long.
    void ask_next_after(std::uint32_t polls, std::uint64_t unheard_ms) {
        silence_polls = std::min(polls, host_silence_polls);
        gone_after_ms = unheard_ms;
    }
    /// Whether the machine has said anything within that time. Before that time has passed since `since_ms` it counts as heard.
    bool is_heard(PeerId peer, std::uint64_t since_ms) const;
    std::uint64_t confirmed_through() const { return confirmed; }
    std::uint64_t here_through() const { return ticks.next(); } ///< ticks below are here
    /// The bytes of a tick that is here, as Stretch tells: the newest history_ticks.
    std::span<const std::byte> told(std::uint64_t tick) const { return ticks.at(tick); }
    /// No host has what is missing.
    bool is_stopped() const { return phase == Phase::stopped; }
    /// It has the match, up to a few ticks, and most of those who answer hold the same.
    bool is_level() const;

  private:
    enum class Phase { fetching, adopting, following, stopped };
    struct Host {
        PeerId peer;
        std::optional<std::uint64_t> state_hash; ///< what it tells of the state before assembly.offer().tick
        std::optional<bool> agrees;              ///< whether the newest hash that it told is ours, too
        bool differs_told = false;
        std::uint64_t heard_ms = 0;
        std::uint64_t log_begin = 0;    ///< from its answer to a request for ticks that it no longer holds
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
    std::size_t serving = 0; ///< index of the host that is asked for the match
    std::optional<Assembly> assembly;
    std::uint32_t polls_without_progress = 0, polls_with_state = 0, polls_fetching = 0;
    ToldTicks ticks;
    std::uint64_t ticks_seen = 0; ///< when polls_without_ticks began to count
    std::uint32_t polls_without_ticks = 0, silence_polls = host_silence_polls;
    std::uint32_t polls_starved = 0; ///< that all which is here was run, and the host said that it had more
    std::uint64_t polls_without_log = 0; ///< since a host said that it lacks what is missing
    std::uint64_t gone_after_ms = never, serving_since_ms = 0;
    std::vector<std::uint64_t> hashes; ///< own ones, by tick modulo history_ticks
    std::uint64_t first = 0;           ///< tick that was begun with
    std::uint64_t live_end = 0;        ///< from the packets of the serving host, if any
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
