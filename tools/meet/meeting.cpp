#include "meet/meeting.h"

#include <algorithm>

namespace lockstone {
namespace {

constexpr std::uint64_t relay_patience_ms = 5000, silence_ms = 10'000, room_ms = 300'000;

} // namespace

Meeting::Meeting(const Invitation& invitation, LobbyClient client, UdpSocket socket, std::uint64_t now_ms)
    : invitation_(invitation), client_(std::move(client)), socket_(std::move(socket)), begun_ms_(now_ms) {}

Result<Meeting> Meeting::begin(const Invitation& invitation, std::uint32_t machines, std::uint64_t now_ms) {
    Result<UdpSocket> socket = UdpSocket::open({});
    if (!socket) return socket.error();
    LobbyClient client(invitation.relay, invitation.key, invitation.code, machines);
    return Meeting(invitation, std::move(client), std::move(*socket), now_ms);
}

/// The time without an answer of the relay. While the program is paused it reads no packets, so one pause counts as at
/// most a second.
std::uint64_t Meeting::silence(std::uint64_t now_ms) {
    const std::uint64_t since = now_ms - std::min(now_ms, polled_ms_);
    silent_ms_ =
        client_.answered_ms() != answered_ms_ ? 0 : silent_ms_ + std::min<std::uint64_t>(since, 1000);
    answered_ms_ = client_.answered_ms(), polled_ms_ = now_ms;
    return silent_ms_;
}

Status Meeting::poll(std::uint64_t now_ms) {
    while (const auto arrived = socket_.receive()) client_.receive(arrived->from, arrived->bytes, now_ms);
    client_.poll(now_ms);
    while (const auto out = client_.next_outgoing()) socket_.send(out->to, out->bytes);
    const std::string where = "the relay at " + to_string(invitation_.relay);
    if (!client_.refusal().empty())
        return Error{where + " refuses" + (invitation_.code.empty() ? "" : " the code " + invitation_.code) +
                     ": " + client_.refusal()};
    if (!client_.code().empty()) invitation_.code = client_.code();
    if (client_.code().empty() && now_ms - begun_ms_ > relay_patience_ms)
        return Error{where + " does not answer: it is not running, cannot be reached, or has another key"};
    if (!client_.token() && !client_.code().empty() && silence(now_ms) > silence_ms)
        return Error{where + " has not answered for " + std::to_string(silence_ms / 1000) +
                     " seconds: it has ended, or cannot be reached any more"};
    if (!client_.token() && now_ms - begun_ms_ > room_ms)
        return Error{where + " has closed the room of the code " + invitation_.code +
                     ": not all players came within five minutes"};
    return {};
}

} // namespace lockstone
