// The code of inputs in packets: each input is a bit sequence, its difference to the input before. An unchanged
// input takes one bit.
//
//   0                                             equal to the input before
//   1 0         changes                           of the same bytes as the last change of this block
//   1 1 0  mask changes                           mask: a bit for each byte of an input, at least one set
//   1 1 1       changes of all bytes              8 bits each, at least one not 0; where this form is shorter
//
// A change is a byte minus the byte before, modulo 256. If it is -8..-1 or 1..8 it takes 5 bits: 0, then 4 bits
// (0..7 or 8..15); else 9 bits: 1, then the 8 bits of the change. Bits fill each byte from its lowest bit; the
// bits after the last are 0. The encoder writes exactly one form for each input. The decoder also accepts a longer
// form, but in the second and third form a change must take 5 bits if it fits.
#pragma once

#include "lockstone/session.h"

namespace lockstone::session {

/// Maximum length of an input [bits]: three bits and all its bytes.
constexpr std::size_t input_bits_max(std::size_t input_size) { return 3 + 8 * input_size; }

/// Appends coded inputs to the caller's bytes.
class InputEncoder {
  public:
    /// `to`: not owned; the code starts at its end. `before`: the input before the first one.
    InputEncoder(std::vector<std::byte>& to, std::span<const std::byte> before);
    /// Returns false and writes nothing if the code would take more than `bytes_max` bytes.
    bool add(std::span<const std::byte> input, std::size_t bytes_max);

  private:
    void put(std::uint32_t value, std::uint32_t bits);

    std::vector<std::byte>& out;
    std::size_t start;
    std::size_t bits = 0; ///< written since `start`
    std::array<std::byte, input_bytes_max> previous{};
    std::uint64_t mask = 0; ///< bytes of the last change; 0: none yet
};

/// Reads coded inputs from untrusted bytes. ok() does not depend on the content of `before`.
class InputDecoder {
  public:
    InputDecoder(std::span<const std::byte> code, std::span<const std::byte> before);
    /// The next input, valid until the next call. After an error in the code: any content, and ok() is
    /// false.
    std::span<const std::byte> next();
    bool ok() const { return !failed; }
    /// Length of the inputs so far [bytes]. Nonzero bits after the last one are an error.
    std::size_t end();

  private:
    std::uint32_t take(std::uint32_t bits);
    void change(std::size_t byte, std::uint32_t difference);
    void read_changes();
    void read_all_bytes();

    std::span<const std::byte> in;
    std::size_t size; ///< length of an input [bytes]
    std::size_t bits = 0;
    std::array<std::byte, input_bytes_max> input{};
    std::uint64_t mask = 0;
    bool failed = false;
};

} // namespace lockstone::session
