// Detection of repeated packets of one direction. Source: RFC 6479, a bitmap used as a ring; numbers are
// restored as in RFC 9000, A.3.
#pragma once

#include "lockstone/net.h"

namespace lockstone::net {

class ReplayWindow {
  public:
    /// The number with these low 16 bits that is nearest to the next expected one.
    std::uint64_t restored(std::uint16_t low) const;
    /// True if the number was not seen and is not older than the window.
    bool is_fresh(std::uint64_t number) const;
    /// Marks a number as seen. Call it only after its packet has proven authentic.
    void mark(std::uint64_t number);
    std::uint64_t next() const { return end; } ///< The highest seen number plus 1.

  private:
    std::uint64_t end = 0;
    /// Bit n % 64 of word n / 64 % size: number n was seen.
    std::array<std::uint64_t, replay_window_packets / 64> seen{};
};

} // namespace lockstone::net
