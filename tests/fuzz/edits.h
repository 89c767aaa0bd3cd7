// Inputs that describe damage to valid data. A few bytes reach any place, so an input need not contain the data.
#pragma once

#include "base/bytes.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace fuzz {

using Buffer = std::vector<std::byte>;

/// An input that the corpus holds from the beginning.
struct Seed {
    std::string name;
    Buffer bytes;
};

/// Reads from the front; zeros after the end of the input.
class Input {
  public:
    explicit Input(std::span<const std::byte> all) : rest(all) {}
    bool empty() const { return rest.empty(); }
    template <std::unsigned_integral N> N take() {
        std::array<std::byte, sizeof(N)> bytes{};
        const std::span<const std::byte> there = take_bytes(sizeof(N));
        std::ranges::copy(there, bytes.begin());
        return lockstone::base::load_little_endian<N>(bytes.data());
    }
    std::uint8_t take_u8() { return take<std::uint8_t>(); }
    /// Returns the remaining bytes, at most `size`.
    std::span<const std::byte> take_bytes(std::size_t size) {
        const std::span<const std::byte> taken = rest.first(std::min(size, rest.size()));
        rest = rest.subspan(taken.size());
        return taken;
    }
    std::span<const std::byte> take_rest() { return take_bytes(rest.size()); }

  private:
    std::span<const std::byte> rest;
};

/// One change: place u16 (modulo the size), number of removed bytes u8, number of inserted bytes u8, the inserted
/// bytes.
inline void splice(Input& in, Buffer& into) {
    const std::size_t place = in.take<std::uint16_t>() % (into.size() + 1);
    const std::size_t gone = std::min<std::size_t>(in.take_u8(), into.size() - place);
    const std::span<const std::byte> come = in.take_bytes(in.take_u8());
    Buffer out(into.size() - gone + come.size());
    const auto first = std::copy_n(into.begin(), place, out.begin());
    std::ranges::copy(std::span(into).subspan(place + gone), std::ranges::copy(come, first).out);
    into = std::move(out);
}

/// Writes inputs in this format, for seeds.
class Script {
  public:
    Script& u8(std::uint8_t v) { return to().u8(v), *this; }
    Script& u16(std::uint16_t v) { return to().u16(v), *this; }
    Script& bytes(std::span<const std::byte> v) { return to().bytes(v), *this; }
    Script& splice(std::uint16_t place, std::uint8_t gone, std::span<const std::byte> come) {
        return u16(place).u8(gone).u8(static_cast<std::uint8_t>(come.size())).bytes(come);
    }
    const Buffer& done() const { return out; }

  private:
    lockstone::base::ByteWriter to() { return lockstone::base::ByteWriter(out); }
    Buffer out;
};

} // namespace fuzz
