#include "online/gallery.h"

namespace lockstone::demo {
namespace {

constexpr std::uint64_t polls_between_cards = 30, reopen_ms = 5000;

} // namespace

void Gallery::poll(std::uint64_t now_ms) {
    // No watcher came, or the relay is gone: request a new room.
    if (room_ && !room_->poll(now_ms)) room_.reset();
    if (!room_) open_room(now_ms);
    if (room_ && room_->token()) admit(now_ms);
    const bool tell = ++polls_ % polls_between_cards == 0;
    for (const auto& watcher : watchers_) {
        watcher->poll(now_ms);
        if (tell) watcher->send(1, to_bytes(card_));
    }
    next_ = 0;
}

void Gallery::open_room(std::uint64_t now_ms) {
    if (watchers_.size() == watchers_max || (opened_ms_ != 0 && now_ms - opened_ms_ < reopen_ms)) return;
    opened_ms_ = now_ms;
    if (Result<Meeting> begun = Meeting::begin(relay_, 2, now_ms)) room_ = std::move(*begun);
}

void Gallery::admit(std::uint64_t now_ms) {
    if (Result<UdpTransport> opened = UdpTransport::open(*room_->token(), {}, {}, now_ms))
        watchers_.push_back(std::make_unique<UdpTransport>(std::move(*opened)));
    room_.reset();
    opened_ms_ = 0;
}

void Gallery::send(PeerId to, std::span<const std::byte> bytes) {
    if (to >= 1 && to <= watchers_.size()) watchers_[to - 1]->send(1, bytes);
}

std::optional<Datagram> Gallery::receive() {
    for (; next_ < watchers_.size(); ++next_)
        if (const std::optional<Datagram> packet = watchers_[next_]->receive())
            return Datagram{static_cast<PeerId>(next_ + 1), packet->bytes};
    return {};
}

} // namespace lockstone::demo
