#pragma once
/// Admits watchers to a match. Each watcher enters a room for two at the relay, in turn, and is a peer afterwards.

#include "meet/match_card.h"
#include "meet/meeting.h"

#include <memory>

namespace lockstone::demo {

/// The transport of SpectatorHost; watcher i is PeerId i + 1.
class Gallery final : public Transport {
  public:
    static constexpr std::uint32_t watchers_max = 8;

    Gallery(const Invitation& relay, const MatchCard& card) : relay_(relay), card_(card) {}
    /// Opens a new room when the last one is taken, and sends the match card to watchers. Call it each frame.
    void poll(std::uint64_t now_ms);
    /// The invitation for the next watcher; its code is empty while no room is open.
    Invitation invitation() const { return room_ ? room_->invitation() : relay_; }

    std::size_t let_in() const { return watchers_.size(); } ///< number of watchers so far

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
    std::size_t next_ = 0; ///< index of the watcher whose packets are read next
    std::uint64_t polls_ = 0, opened_ms_ = 0;
};

} // namespace lockstone::demo
