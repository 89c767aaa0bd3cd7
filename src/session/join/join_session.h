// The session of a machine that joins a running match: a spectator until it has caught up, then a player.
//
//   spectator: state, log ... ticks below R | player: ticks from R on
//
// When R is known, the session creates the player's session, which then receives packets too, so that the inputs
// of the others are here when tick R is reached.
#pragma once

#include "lockstone/session/join.h"
#include "session/join/spectator.h"
#include "session/peer_session.h"

#include <deque>

namespace lockstone::session {

/// Transport of the player's session: returns the packets that put() stored, sends through the real
/// transport.
class Inbox final : public Transport {
  public:
    explicit Inbox(Transport& to) : wire(to) {}
    void send(PeerId to, std::span<const std::byte> bytes) override { wire.send(to, bytes); }
    std::optional<Datagram> receive() override;
    bool authenticated() const override { return wire.authenticated(); }
    /// Stores a copy of a packet; a full inbox drops it.
    void put(const Datagram& datagram);

  private:
    struct Packet {
        PeerId from;
        std::vector<std::byte> bytes;
    };
    Transport& wire;
    std::deque<Packet> waiting;
    Packet held{};
};

class JoinSession final : public Session {
  public:
    JoinSession(const SessionDef& def, const JoinDef& join, Transport& transport);

    void poll(std::uint64_t now_ms) override;
    void add_local_input(std::uint32_t player, std::span<const std::byte> input) override;
    Step advance() override;
    Step settle() override;
    HashCheck report_hash(std::uint64_t tick, std::uint64_t hash) override {
        return now_driving().report_hash(tick, hash);
    }
    void report_adopted(const Status& taken, std::uint64_t hash) override {
        watch.report_adopted(taken, hash);
    }
    std::optional<ConfirmedTick> next_confirmed() override { return now_driving().next_confirmed(); }
    std::optional<Notice> next_notice() override;
    Status drop_peer(PeerId peer) override;
    bool set_inspector(StateInspector* whom) override;
    void drop_inspector(const StateInspector& whom) override;
    std::uint64_t current_tick() const override { return driving().current_tick(); }
    std::span<const PlayerInput> look_ahead(std::uint32_t offset) override {
        return is_playing() ? play->look_ahead(offset) : std::span<const PlayerInput>();
    }
    std::uint32_t images_max() const override { return images; }
    void set_input_delay(std::uint32_t ticks) override;
    PeerQuality quality(PeerId peer) const override { return driving().quality(peer); }
    const SessionStats& stats() const override { return play ? play->stats() : watch.stats(); }

  private:
    bool is_playing() const { return play != nullptr && watch.confirmed_through() == admission.tick; }
    const Session& driving() const;
    Session& now_driving();
    void receive_all();
    void hear_admission(const Datagram& datagram);
    std::optional<Admission> agreed_admission(std::uint32_t left) const;
    void come_in();
    void ask_anew();
    void begin_to_play(const Admission& agreed, std::uint32_t left);

    SessionDef def;
    JoinDef join;
    Transport& transport;
    std::uint32_t match;
    SpectatorSession watch;
    Inbox inbox;
    std::unique_ptr<PeerSession> play;
    Admission admission;
    std::vector<std::pair<PeerId, Admission>> told; ///< admissions for tickets of this life, by machine
    std::uint32_t ticket;
    std::uint64_t now = 0;
    /// Time of the newest ticket that was requested before the first admission arrived [ms].
    std::uint64_t asked_ms = 0;
    std::uint64_t ticket_ms = 0; ///< time of the newest ticket [ms]
    bool asks = false, knows_before = false;
    std::uint32_t images;
    StateInspector* inspector = nullptr;
    std::vector<Notice> notices;
};

} // namespace lockstone::session
