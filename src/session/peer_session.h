// Rollback and lockstep sessions: one machine of a match between peers. Lockstep is rollback with a prediction
// window of 0.
//
//   rollback.cpp       the rollback algorithm: which ticks run
//   peer_session.cpp   confirmed ticks, local inputs, notices
//   exchange.cpp       received and sent packets
//   inspect.cpp        comparison of two states after a desync
//   departure.cpp      departures: which machines leave, and at which tick
//   admission.cpp      joins: which machines come in late or return, and at which tick
#pragma once

#include "session/link/peer_link.h"

namespace lockstone::session {

/// Packets carry ticks as 32 bits; the session ends before they overflow.
inline constexpr std::uint64_t tick_limit = (std::uint64_t{1} << 32) - 4096;
/// Maximum number of ticks in a frame while a machine that has joined catches up.
inline constexpr std::uint32_t catch_up_ticks = 4;
/// Maximum distance of an announced join tick from the present tick [ticks].
inline constexpr std::uint64_t join_ahead_max = 512;

/// How this machine enters a match: at its start, or while it runs.
struct Entry {
    std::uint64_t tick = 0; ///< first tick with this machine's inputs; 0: start of the match
    /// [player] tick of each player's last join; 0: the start.
    std::array<std::uint64_t, players_max> since{};
    std::uint32_t left = 0; ///< bit p: player p is not in the match
};

class PeerSession final : public Session {
  public:
    PeerSession(const SessionDef& def, Transport& transport, const Entry& entry = {});
    /// Only after a join. `inputs` [players]: inputs of the tick before the entry. Packets carry inputs as
    /// differences to the tick before, so the session cannot decode inputs of the others until this call.
    void set_inputs_before(std::span<const PlayerInput> inputs);

    void poll(std::uint64_t now_ms) override;
    void add_local_input(std::uint32_t player, std::span<const std::byte> input) override;
    Step advance() override;
    Step settle() override;
    HashCheck report_hash(std::uint64_t tick, std::uint64_t hash) override;
    std::optional<ConfirmedTick> next_confirmed() override;
    std::optional<Notice> next_notice() override;
    Status drop_peer(PeerId peer) override;
    bool set_inspector(StateInspector* whom) override;
    void drop_inspector(const StateInspector& whom) override {
        if (inspector == &whom) inspector = nullptr;
    }
    std::uint64_t current_tick() const override { return current; }
    std::span<const PlayerInput> look_ahead(std::uint32_t offset) override;
    std::uint32_t images_max() const override { return static_cast<std::uint32_t>(change_max) + 1; }
    void set_input_delay(std::uint32_t ticks) override;
    PeerQuality quality(PeerId peer) const override;
    const SessionStats& stats() const override { return counts; }

  private:
    enum class Run { first, again };

    // ---- rollback.cpp ----
    void run_again();
    void roll_back_to(std::uint64_t wrong);
    void run(std::uint64_t tick, Run how);
    Stall why_stall() const;

    // ---- peer_session.cpp ----
    std::uint64_t settled_through() const; ///< all inputs of ticks below are known here
    std::uint64_t agreed_through() const;  ///< every other machine has acknowledged the inputs of ticks below
    /// No departure and no join can change the inputs of ticks below.
    std::uint64_t fixed_through() const;
    std::uint64_t take_first_wrong();
    std::uint32_t wait_recommended();
    void forget_old_inputs();
    bool is_local(std::uint32_t player) const { return def.players[player] == def.self; }
    bool is_gone(std::uint32_t player) const { return (gone >> player & 1u) != 0; }
    bool is_connecting() const;
    PeerLink* find_link(PeerId peer);
    std::uint64_t local_hash(std::uint64_t tick) const { return hashes[tick % history_ticks]; }

    // ---- exchange.cpp ----
    void receive_all();
    std::optional<PacketFault> receive(const Datagram& datagram);
    bool plausible(const PeerLink& link) const; ///< checks `incoming` against what the sender can know
    void apply(PeerLink& link);
    void apply_inputs(const InputBlock& block);
    void apply_departures(PeerLink& link);
    void apply_quality(PeerLink& link, const QualityReport& report);
    void send_to_all();
    void send(PeerLink& link);
    void fill_status(PeerLink& link);
    void fill_departures();
    void send_inputs(const PeerLink& link);
    void compare_hashes(PeerLink& link);

    // ---- admission.cpp ----
    std::optional<PacketFault> receive_wish(PeerLink& link, std::span<const std::byte> packet);
    void apply_joins(PeerLink& link);
    void admit();
    void take_a_stand(PeerLink& seat);
    bool may_come(const PeerLink& seat) const;
    bool is_admitting() const;
    void agree_on_join(PeerLink& seat);
    void settle_join(PeerLink& seat);
    void serve_those_who_come();
    std::uint64_t join_bound() const;
    std::uint64_t earliest_entry() const;
    bool is_entry_open(std::uint64_t cut) const;
    bool is_reached(std::uint64_t tick) const;
    bool owes_join_word(const PeerLink& link) const;
    const JoinWord& word_of(const PeerLink& link, const PeerLink& seat) const;
    PacketContext context_with(PeerId peer) const;

    // ---- inspect.cpp ----
    void begin_inspection(PeerLink& link, const Desync& desync);
    std::optional<PacketFault> receive_inspection(PeerLink& link, std::span<const std::byte> packet);
    void go_on_inspecting(PeerLink& link);
    std::vector<DesyncReport::Tick> last_ticks(const PeerLink& link, std::uint64_t tick) const;

    // ---- departure.cpp ----
    struct Votes {
        std::uint32_t of, against;
    };
    void judge_peers();
    std::uint32_t players_of(PeerId peer) const { return players_at(def, peer); }
    bool has_dropped_us(const PeerLink& link) const;
    bool is_dropped() const;
    bool has_come_in_vain() const;
    void find_silent_peers();
    void find_fault_with(PeerLink& link);
    void find_late_peer();
    void count_waits(std::uint64_t passed_ms);
    void make_up_for_waits();
    bool is_awaited(const PeerLink& link) const;
    bool owes_word(const PeerLink& link) const;
    bool is_heard(PeerId peer) const;
    bool has_not_judged(const PeerLink& link) const;
    Votes count_votes(const PeerLink& accused) const;
    void drop_unwanted_peers();
    bool is_somebody_leaving() const;
    bool has_say_in_cut(const PeerLink& link, std::uint32_t player) const;
    void agree_on_cut(std::uint32_t player);
    void stop_without_cut(std::uint32_t player, const PeerLink& link, std::uint64_t here);
    void stop(std::string reason);

    SessionDef def;
    Transport& transport;
    StateInspector* inspector = nullptr;
    PacketContext context;
    std::vector<InputQueue> queues; ///< [player]
    std::vector<PeerLink> links;    ///< by peer id, without this machine
    std::uint64_t change_max;       ///< maximum number of executed ticks that may still change
    std::uint32_t gone = 0;         ///< bit p: player p has left; further inputs of it are ignored
    /// [player] The cut as this machine announces it: first tick without the player; `never`: not known
    /// yet.
    std::array<std::uint64_t, players_max> cuts{};
    bool stopped = false;
    bool has_run; ///< counts waiting times: from the start, after a join from the first advance() on
    std::array<std::uint64_t, players_max> since{}; ///< [player] tick of the player's last join; 0: the start
    std::uint64_t entry_tick;                       ///< tick at which this machine joined; 0: the start
    std::uint64_t catch_up_end;                     ///< below this tick a frame runs several ticks
    TimelineHost timeline;                          ///< confirmed ticks for machines that join

    bool polled = false;
    std::uint64_t polls = 0;
    std::uint64_t now = 0;
    std::uint64_t current = 0;      ///< the next new tick
    std::uint64_t settled_end = 0;  ///< ticks below ran on true inputs and do not run again
    std::uint64_t confirmed = 0;    ///< next_confirmed() has returned ticks below; their hashes may be sent
    std::uint64_t next_wait_at = 0; ///< first tick with the next wait recommendation
    std::vector<std::uint64_t> hashes; ///< [history_ticks] by tick modulo history_ticks

    std::vector<Request> requests;
    std::vector<std::byte> foreseen_bytes; ///< inputs of one tick of look_ahead()
    std::vector<PlayerInput> foreseen;
    std::vector<PlayerInput> inputs; ///< of the ticks of all requests, then of the confirmed tick
    std::vector<Notice> notices;
    std::size_t notices_taken = 0;
    Message incoming{}, outgoing{};
    PacketWriter writer;
    SessionStats counts;
};

} // namespace lockstone::session
