#pragma once
/// What the host of a match tells the machines that enter: which game is played, from what start and how long.

#include "lockstone/net.h"
#include "scenes/scenes.h"

namespace lockstone {

struct MatchCard {
    std::string game;              ///< Game::name(), of a scene
    std::uint64_t content_id = 0;  ///< of its rules, as the host has them
    std::uint64_t script_seed = 0; ///< of bots
    std::uint64_t ticks = 0;       ///< how long
    std::uint32_t machines = 2;    ///< player p plays at machine p modulo this
};
std::vector<std::byte> to_bytes(const MatchCard& card);
/// Nothing where the packet is no card: sessions' packets begin otherwise.
std::optional<MatchCard> card_of(std::span<const std::byte> packet);

/// The game of a card. The error says what differs: another scene than `wanted` asks for, one that this program does not
/// have, or other rules. `wanted` empty: any.
Result<std::unique_ptr<Game>> game_of(const MatchCard& card, const std::string& wanted);

/// Takes cards out of what arrives and hands the rest on.
class CardTransport final : public Transport {
  public:
    explicit CardTransport(Transport& whole) : whole_(whole) {}
    void send(PeerId to, std::span<const std::byte> bytes) override { whole_.send(to, bytes); }
    std::optional<Datagram> receive() override;
    bool authenticated() const override { return whole_.authenticated(); }
    /// The newest card of `from` that has come so far.
    const std::optional<MatchCard>& card(PeerId from) const { return from == from_ ? card_ : none_; }

  private:
    Transport& whole_;
    PeerId from_ = 0;
    std::optional<MatchCard> card_;
    static inline const std::optional<MatchCard> none_;
};

} // namespace lockstone
