#pragma once
/// Lets others watch a match: each watcher enters a room for two at the relay, one after the other, and is a peer from then on.

#include "meet/match_card.h"
#include "meet/meeting.h"

#include <memory>

namespace lockstone::demo {

/// What SpectatorHost sends through: watcher i is PeerId i + 1.
class Gallery final : public Transport {
  public:
    static constexpr std::uint32_t watchers_max = 8;

    Gallery(const Invitation& relay, const MatchCard& card) : relay_(relay), card_(card) {}
    /// Opens the next room when the last one is taken, tells watchers what is played. Call each frame.
    void poll(std::uint64_t now_ms);
    /// Of the next watcher; the code is empty while there is no room.
    Invitation invitation() const { return room_ ? room_->invitation() : relay_; }

    std::size_t let_in() const { return watchers_.size(); } ///< so far

    void send(PeerId to, std::span<const std::byte> bytes) override;
    std::optional<Datagram> receive() override;
    bool authenticated() const override { return true; }

  private:
    void open_room(std::uint64_t now_ms);
    void admit(std::uint64_t now_ms);
    Invitation relay_;
    MatchCard card_;
    std::optional<Meeting> room_;
    std::vector<std::unique_ptr<UdpTransport>> watchers_;
    std::size_t next_ = 0; ///< whose packets are read
    std::uint64_t polls_ = 0, opened_ms_ = 0;
};

} // namespace lockstone::demo
