#pragma once
/// A relay on a thread of its own, for a host that names no other relay.

#include "meet/invitation.h"

#include <atomic>
#include <memory>
#include <thread>

namespace lockstone::demo {

class HostRelay {
  public:
    /// Listens at every address of this machine. Port 0: any free port. Errors contain the message of the system.
    static Result<std::unique_ptr<HostRelay>> start(std::uint16_t port);
    ~HostRelay();
    HostRelay(const HostRelay&) = delete;
    HostRelay& operator=(const HostRelay&) = delete;

    /// An invitation with the address of this machine; the code is empty.
    Invitation invitation() const;

  private:
    explicit HostRelay(UdpSocket opened);
    void serve();
    NetKey secret_ = random_key();
    UdpSocket socket_;
    std::uint16_t port_;
    std::atomic<bool> over_ = false;
    std::thread thread_; ///< must be the last member, since it uses all others
};

} // namespace lockstone::demo
