// Rollback and lockstep: one machine of a match between peers. Lockstep is rollback with a prediction window of 0.
//
//   rollback.cpp       what to run: the algorithm, one screen
//   peer_session.cpp   what is confirmed, what the caller asks and tells
//   exchange.cpp       what is received and sent
//   inspect.cpp        what is asked and told where a peer holds another state
//   departure.cpp      who has left, and from which tick on
//   admission.cpp      who comes late or back, and from which tick on
#pragma once

#include "session/link/peer_link.h"

namespace lockstone::session {

/// Ticks travel as 32 bits.
inline constexpr std::uint64_t tick_limit = (std::uint64_t{1} << 32) - 4096;
/// What is run in a frame at most while a machine that has come in is behind.
inline constexpr std::uint32_t catch_up_ticks = 4;
/// How far ahead a join tick may be told.
inline constexpr std::uint64_t join_ahead_max = 512;

/// How a machine comes into a match that goes on.
struct Entry {
    std::uint64_t tick = 0;                         ///< its inputs count from here on; 0: the match begins
    std::array<std::uint64_t, players_max> since{}; ///< by player, its own ones included: where they came in
    std::uint32_t left = 0;                         ///< bit p: player p is not there
};

class PeerSession final : public Session {
  public:
    PeerSession(const SessionDef& def, Transport& transport, const Entry& entry = {});
    /// For a machine that comes in: the inputs of the tick before its entry, by player. Packets tell inputs as differences, so until this is
    /// called no input of the others can be read.
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
    std::uint64_t agreed_through() const;  ///< and to every other machine, by its own word
    std::uint64_t fixed_through() const;   ///< no departure can change the inputs of ticks below
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
    bool plausible(const PeerLink& link) const; ///< of `incoming`
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
    std::vector<InputQueue> queues; ///< by player
    std::vector<PeerLink> links;    ///< by peer id, without this machine
    std::uint64_t change_max;       ///< how many ticks that may still change may have run
    std::uint32_t gone = 0;         ///< bit p: player p has left; no input of it is accepted any more
    /// By player, as told to all: where it left; `never`: not known yet
    std::array<std::uint64_t, players_max> cuts{};
    bool stopped = false;
    bool has_run;                                   ///< it was asked for ticks; before it only listens
    std::array<std::uint64_t, players_max> since{}; ///< by player: where it came in last; 0: the start
    std::uint64_t entry_tick;                       ///< where this machine did
    std::uint64_t catch_up_end;                     ///< for ticks below, several a frame are run
    TimelineHost timeline;                          ///< for those who come

    bool polled = false;
    std::uint64_t polls = 0;
    std::uint64_t now = 0;
    std::uint64_t current = 0;     ///< next new tick
    std::uint64_t settled_end = 0; ///< ticks below have run on true inputs and will not run again
    std::uint64_t confirmed = 0; ///< ticks below were handed out by next_confirmed; their hashes may be sent
    std::uint64_t next_wait_at = 0;    ///< tick
    std::vector<std::uint64_t> hashes; ///< by tick modulo history_ticks

    std::vector<Request> requests;
    std::vector<std::byte> foreseen_bytes; ///< of one tick that is shown ahead
    std::vector<PlayerInput> foreseen;
    std::vector<PlayerInput> inputs; ///< of all requests' ticks, then of the confirmed one
    std::vector<Notice> notices;
    std::size_t notices_taken = 0;
    Message incoming{}, outgoing{};
    PacketWriter writer;
    SessionStats counts;
};

} // namespace lockstone::session
