// Conversion of a game's input struct to the bytes of sessions, replays and packets, and back.
//
//   struct Pad { std::int16_t x, y; std::uint32_t buttons; };
//   template <class V> constexpr void describe(Pad& p, V&& v) {
//       v("x", p.x), v("y", p.y), v("buttons", p.buttons);
//   }
//
//   std::uint32_t MyGame::input_size() const { return input_size_of<Pad>; }
//   session.add_local_input(0, encode_input(pad));
//   const Pad pad = decode_input<Pad>(inputs[0]);
#pragma once

#include "lockstone/game.h"

#include <array>

namespace lockstone {

namespace detail {
/// Calls visit(bits of a field, its size) and stores the returned bits.
template <StateRow T, class Visit> constexpr void for_each_leaf_bits(T& value, Visit&& visit) {
    for_each_leaf(value, [&](auto& leaf) {
        using L = std::remove_reference_t<decltype(leaf)>;
        if constexpr (FixedPoint<L>) {
            leaf.raw = static_cast<typename L::rep>(visit(static_cast<std::uint64_t>(leaf.raw), sizeof(L)));
        } else {
            leaf = static_cast<L>(visit(static_cast<std::uint64_t>(leaf), sizeof(L)));
        }
    });
}
} // namespace detail

/// Bytes of an input struct, for Game::input_size().
template <StateRow T> inline constexpr std::uint32_t input_size_of = static_cast<std::uint32_t>(sizeof(T));

/// The canonical bytes of an input: every field in order, little-endian, equal on every machine. At most 64
/// bytes; a larger struct does not compile.
template <StateRow T> constexpr std::array<std::byte, sizeof(T)> encode_input(T input) {
    static_assert(sizeof(T) <= 64, "an input has at most 64 bytes, see Game::input_size");
    std::array<std::byte, sizeof(T)> out{};
    std::size_t at = 0;
    detail::for_each_leaf_bits(input, [&](std::uint64_t bits, std::size_t size) {
        for (std::size_t i = 0; i < size; ++i) out[at++] = static_cast<std::byte>((bits >> (8 * i)) & 0xffu);
        return bits;
    });
    return out;
}

/// The input struct of canonical bytes. The bytes come from other players, so every field, enums included,
/// can have any value: the game must clamp it. All zero if the size differs; a session never returns such an
/// input.
template <StateRow T> constexpr T decode_input(std::span<const std::byte> bytes) {
    T out{};
    if (bytes.size() != sizeof(T)) return out;
    std::size_t at = 0;
    detail::for_each_leaf_bits(out, [&](std::uint64_t, std::size_t size) {
        std::uint64_t bits = 0;
        for (std::size_t i = 0; i < size; ++i) bits |= std::to_integer<std::uint64_t>(bytes[at++]) << (8 * i);
        return bits;
    });
    return out;
}
/// decode_input() of input.bytes.
template <StateRow T> constexpr T decode_input(const PlayerInput& input) {
    return decode_input<T>(input.bytes);
}

} // namespace lockstone
