#pragma once
/// From an invitation to a token: this machine asks a relay's lobby until all machines of the match are there.

#include "meet/invitation.h"

namespace lockstone {

class Meeting {
  public:
    /// Opens a room for `machines`, or enters that of the invitation's code.
    static Result<Meeting> begin(const Invitation& invitation, std::uint32_t machines, std::uint64_t now_ms);
    /// Call each frame. The error says what is wrong and where: no relay there, no such code, a full match, nobody came.
    Status poll(std::uint64_t now_ms);

    const Invitation& invitation() const { return invitation_; } ///< with the code, once there is one
    const std::optional<ConnectToken>& token() const { return client_.token(); } ///< when all are there

  private:
    Meeting(const Invitation& invitation, LobbyClient client, UdpSocket socket, std::uint64_t now_ms);
    Invitation invitation_;
    LobbyClient client_;
    UdpSocket socket_;
    std::uint64_t silence(std::uint64_t now_ms);
    std::uint64_t begun_ms_;
    /// When poll() last ran, the answer that it knew then, and how long the relay has been silent while it ran [ms].
    std::uint64_t polled_ms_ = 0, answered_ms_ = 0, silent_ms_ = 0;
};

} // namespace lockstone
