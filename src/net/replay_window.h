// Which packets of one direction have been seen. Source: RFC 6479, a bitmap used as a ring; numbers restored as in RFC 9000, A.3.
#pragma once

#include "lockstone/net.h"

namespace lockstone::net {

class ReplayWindow {
  public:
    /// The number nearest to the next expected one whose low 16 bits these are.
    std::uint64_t restored(std::uint16_t low) const;
    /// Neither seen nor older than the window.
    bool is_fresh(std::uint64_t number) const;
    /// Only for a number whose packet is authentic.
    void mark(std::uint64_t number);
    std::uint64_t next() const { return end; } ///< one more than the highest seen

  private:
    std::uint64_t end = 0;
    std::array<std::uint64_t, replay_window_packets / 64>
        seen{}; ///< of number n: bit n % 64 of word n / 64 % size
};

} // namespace lockstone::net
