// What a host tells its watchers, and the session of one that watches.
#pragma once

#include "lockstone/spectator.h"
#include "session/input_queue.h"
#include "session/message.h"

namespace lockstone::session {

/// Ticks of the confirmed timeline: of each the status of each player, the low half of the hash, and the inputs.
struct Stretch {
    std::uint64_t first = 0;
    std::uint32_t count = 0;
    std::uint64_t end = 0;            ///< ticks below may be watched by now
    std::span<const std::byte> bytes; ///< per tick: u32 hash, u16 bit p: player p has left, then inputs
};
inline constexpr std::size_t stretch_bytes_max = 1100;

/// Packets of a watcher, which asks for what comes from `wanted` on, and of a host.
std::span<const std::byte> write_wish(std::vector<std::byte>& buffer, std::uint32_t match,
                                      std::uint64_t wanted);
std::span<const std::byte> write_stretch(std::vector<std::byte>& buffer, std::uint32_t match,
                                         const Stretch& stretch);
/// Nothing of a packet that is not one of this match, to the bit.
std::optional<std::uint64_t> read_wish(std::span<const std::byte> packet, std::uint32_t match);
std::optional<Stretch> read_stretch(std::span<const std::byte> packet, std::uint32_t match,
                                    std::size_t tick_bytes);

class SpectatorSession final : public Session {
  public:
    SpectatorSession(const SessionDef& def, PeerId host, Transport& transport, std::uint32_t ticks_per_frame);

    void poll(std::uint64_t now_ms) override;
    void add_local_input(std::uint32_t, std::span<const std::byte>) override {} ///< a watcher has no inputs
    Step advance() override;
    Step settle() override;
    HashCheck report_hash(std::uint64_t tick, std::uint64_t hash) override;
    std::optional<ConfirmedTick> next_confirmed() override;
    std::optional<Notice> next_notice() override;
    Status drop_peer(PeerId peer) override;
    std::uint64_t current_tick() const override { return current; }
    std::uint32_t images_max() const override {
        return ticks_per_frame + 1;
    } ///< none is saved; events of a frame
    void set_input_delay(std::uint32_t) override {}
    PeerQuality quality(PeerId peer) const override;
    const SessionStats& stats() const override { return counts; }

  private:
    std::span<std::byte> slot(std::uint64_t tick) {
        return std::span(ring).subspan(tick % history_ticks * tick_bytes, tick_bytes);
    }
    void show(std::uint64_t tick);

    SessionDef def;
    PeerId host;
    Transport& transport;
    std::uint32_t match, ticks_per_frame;
    std::size_t tick_bytes;
    std::vector<std::byte> ring;       ///< by tick modulo history_ticks, as in Stretch
    std::vector<std::uint64_t> hashes; ///< own ones, likewise
    std::uint64_t next = 0;            ///< first tick that is not here
    std::uint64_t live_end = 0;        ///< as the host tells
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
