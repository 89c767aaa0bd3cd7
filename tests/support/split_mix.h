// Random bits for test data. source: SplitMix64 (Steele, Lea, Flood 2014).
#pragma once

#include <cstdint>

namespace lockstone::test {

class SplitMix {
  public:
    explicit SplitMix(std::uint64_t seed) : state(seed) {}
    std::uint64_t next() {
        std::uint64_t z = state += 0x9e3779b97f4a7c15u;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return z ^ (z >> 31);
    }
    std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(next() % n); }
    bool one_in(std::uint32_t n) { return below(n) == 0; }

  private:
    std::uint64_t state;
};

/// A number in [low, high), in steps of 2^-20 of the range.
inline double drawn(SplitMix& random, double low, double high) {
    return low + (high - low) * static_cast<double>(random.below(1u << 20)) / (1u << 20);
}

} // namespace lockstone::test
