#pragma once
/// The match card: a packet from the host to the machines that join. It names the game, its start and its length.

#include "lockstone/net.h"
#include "scenes/scenes.h"

namespace lockstone {

struct MatchCard {
    std::string game;              ///< Game::name() of a scene
    std::uint64_t content_id = 0;  ///< of the game's rules, as the host has them
    std::uint64_t script_seed = 0; ///< seed of the players that a script drives
    std::uint64_t ticks = 0;       ///< length of the match
    std::uint32_t machines = 2;    ///< player p plays on machine p modulo this
};
std::vector<std::byte> to_bytes(const MatchCard& card);
/// Parses a packet; empty if it is no card. The packets of sessions begin with other bytes.
std::optional<MatchCard> card_of(std::span<const std::byte> packet);

/// Makes the game of a card. Errors: the card names another scene than `wanted` (if not empty), a scene that this
/// program does not have, or other rules.
Result<std::unique_ptr<Game>> game_of(const MatchCard& card, const std::string& wanted);

/// A transport that keeps the match cards among the packets it receives and passes on all other packets.
class CardTransport final : public Transport {
  public:
    explicit CardTransport(Transport& whole) : whole_(whole) {}
    void send(PeerId to, std::span<const std::byte> bytes) override { whole_.send(to, bytes); }
    std::optional<Datagram> receive() override;
    bool authenticated() const override { return whole_.authenticated(); }
    /// The newest card of `from`; empty if none has arrived.
    const std::optional<MatchCard>& card(PeerId from) const { return from == from_ ? card_ : none_; }

  private:
    Transport& whole_;
    PeerId from_ = 0;
    std::optional<MatchCard> card_;
    static inline const std::optional<MatchCard> none_;
};

} // namespace lockstone
