// How inputs travel: each as its difference to the one before, bit by bit. Who holds a button sends one bit a tick.
//
//   0                                             the input before, again
//   1 0         changes                           of the same bytes as the last change of this block
//   1 1 0  mask changes                           mask: a bit per byte of an input, at least one set
//   1 1 1       changes of all bytes, 8 bits each: where that is shorter; at least one is not 0
//
// A change is a byte less the byte before, modulo 256: 0 and 4 bits where it is -8..-1 (0..7) or 1..8 (8..15), else 1 and 8
// bits. Bits fill bytes from the lowest; those after the last are 0. Each input has one form, but for the choice of the last.
#pragma once

#include "lockstone/session.h"

namespace lockstone::session {

/// The most bits that one input takes: three and all its bytes.
constexpr std::size_t input_bits_max(std::size_t input_size) { return 3 + 8 * input_size; }

/// Appends inputs to bytes that the caller owns.
class InputEncoder {
  public:
    /// `before`: what the first input is compared with. The code starts at the end of `to`.
    InputEncoder(std::vector<std::byte>& to, std::span<const std::byte> before);
    /// False, and nothing is written, where the code would take more than `bytes_max` bytes.
    bool add(std::span<const std::byte> input, std::size_t bytes_max);

  private:
    void put(std::uint32_t value, std::uint32_t bits);

    std::vector<std::byte>& out;
    std::size_t start;
    std::size_t bits = 0; ///< since `start`
    std::array<std::byte, input_bytes_max> previous{};
    std::uint64_t mask = 0; ///< of the last change; 0: none yet
};

/// Takes inputs out of bytes that nobody vouches for. What is well formed does not depend on `before`.
class InputDecoder {
  public:
    InputDecoder(std::span<const std::byte> code, std::span<const std::byte> before);
    /// The next input, valid until the next call. Of a code that is not well formed: anything, and ok() is false.
    std::span<const std::byte> next();
    bool ok() const { return !failed; }
    /// How many bytes the inputs so far take; the bits after the last are 0, or the code is not well formed.
    std::size_t end();

  private:
    std::uint32_t take(std::uint32_t bits);
    void change(std::size_t byte, std::uint32_t difference);
    void read_changes();
    void read_all_bytes();

    std::span<const std::byte> in;
    std::size_t size; ///< bytes of an input
    std::size_t bits = 0;
    std::array<std::byte, input_bytes_max> input{};
    std::uint64_t mask = 0;
    bool failed = false;
};

} // namespace lockstone::session
