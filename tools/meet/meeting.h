#pragma once
/// The way from an invitation to a connect token. This machine polls the lobby of a relay until all machines of the
/// match have joined.

#include "meet/invitation.h"

namespace lockstone {

class Meeting {
  public:
    /// Opens a room for `machines`, or joins the room of the invitation's code.
    static Result<Meeting> begin(const Invitation& invitation, std::uint32_t machines, std::uint64_t now_ms);
    /// Call it each frame. Errors name the problem and the place: no relay at the address, no such code, a full match,
    /// or no other machine joined in time.
    Status poll(std::uint64_t now_ms);

    const Invitation& invitation() const { return invitation_; } ///< has the code once a room is open
    /// Set once all machines have joined.
    const std::optional<ConnectToken>& token() const { return client_.token(); }

  private:
    Meeting(const Invitation& invitation, LobbyClient client, UdpSocket socket, std::uint64_t now_ms);
    Invitation invitation_;
    LobbyClient client_;
    UdpSocket socket_;
    std::uint64_t silence(std::uint64_t now_ms);
    std::uint64_t begun_ms_;
    /// Time of the last poll(), time of the last answer at that poll, and how long the relay has been silent since
    /// [ms].
    std::uint64_t polled_ms_ = 0, answered_ms_ = 0, silent_ms_ = 0;
};

} // namespace lockstone
