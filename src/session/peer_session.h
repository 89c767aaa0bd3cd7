// Rollback and lockstep: one machine of a match between peers. Lockstep is rollback with a prediction window of 0.
//
//   rollback.cpp       what to run: the algorithm, one screen
//   peer_session.cpp   what is confirmed, what the caller asks and tells
//   exchange.cpp       what is received and sent
//   departure.cpp      who has left, and from which tick on
#pragma once

#include "session/peer_link.h"

namespace lockstone::session {

/// Ticks travel as 32 bits.
inline constexpr std::uint64_t tick_limit = (std::uint64_t{1} << 32) - 4096;

class PeerSession final : public Session {
  public:
    PeerSession(const SessionDef& def, Transport& transport);

    void poll(std::uint64_t now_ms) override;
    void add_local_input(std::uint32_t player, std::span<const std::byte> input) override;
    Step advance() override;
    Step settle() override;
    HashCheck report_hash(std::uint64_t tick, std::uint64_t hash) override;
    std::optional<ConfirmedTick> next_confirmed() override;
    std::optional<Notice> next_notice() override;
    std::uint64_t current_tick() const override { return current; }
    std::uint32_t images_max() const override { return def.prediction_max + 1; }
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
    std::uint64_t settled_through() const; ///< all inputs of ticks below are known
    std::uint64_t take_first_wrong();
    std::uint32_t wait_recommended();
    void forget_old_inputs();
    bool is_local(std::uint32_t player) const { return def.players[player] == def.self; }
    bool is_gone(std::uint32_t player) const { return (gone >> player & 1u) != 0; }
    PeerLink* find_link(PeerId peer);
    std::uint64_t local_hash(std::uint64_t tick) const { return hashes[tick % history_ticks]; }

    // ---- exchange.cpp ----
    std::optional<PacketFault> receive(const Datagram& datagram);
    bool plausible(const PeerLink& link) const; ///< of `incoming`
    void apply(PeerLink& link);
    void apply_quality(PeerLink& link, const QualityReport& report);
    void send(PeerLink& link);
    void fill_status(PeerLink& link);
    void send_inputs(const PeerLink& link);
    void compare_hashes(PeerLink& link);

    // ---- departure.cpp ----
    void drop_silent_peers();
    void drop(PeerLink& link);
    void settle_departures();
    void settle_departure(std::uint32_t player);

    SessionDef def;
    Transport& transport;
    PacketContext context;
    std::vector<InputQueue> queues; ///< by player
    std::vector<PeerLink> links;    ///< by peer id, without this machine
    std::uint32_t gone = 0;         ///< bit p: no input of player p is accepted from its own machine any more

    bool polled = false;
    std::uint64_t now = 0;
    std::uint64_t current = 0;     ///< next new tick
    std::uint64_t settled_end = 0; ///< ticks below have run on true inputs and will not run again
    std::uint64_t confirmed = 0; ///< ticks below were handed out by next_confirmed; their hashes may be sent
    std::uint64_t next_wait_at = 0;    ///< tick
    std::vector<std::uint64_t> hashes; ///< by tick modulo history_ticks

    std::vector<Request> requests;
    std::vector<PlayerInput> inputs; ///< of all requests' ticks, then of the confirmed one
    std::vector<Notice> notices;
    std::size_t notices_taken = 0;
    Message incoming{}, outgoing{};
    PacketWriter writer;
    SessionStats counts;
};

} // namespace lockstone::session
