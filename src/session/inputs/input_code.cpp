#include "session/inputs/input_code.h"

#include <algorithm>
#include <bit>

namespace lockstone::session {

namespace {

std::uint32_t difference(std::byte to, std::byte from) {
    return (std::to_integer<std::uint32_t>(to) - std::to_integer<std::uint32_t>(from)) & 0xffu;
}

/// Maps -8..-1 and 1..8 to 0..15. Returns 16 for a change that takes 8 bits.
std::uint32_t short_form(std::uint32_t changed) {
    const std::uint32_t shifted = (changed + 8) & 0xffu; // maps -8..8 to 0..16; 8 is no change
    if (shifted > 16 || shifted == 8) return 16;
    return shifted < 8 ? shifted : shifted - 1;
}

/// Length of a change [bits], with the bit for its form.
constexpr std::uint32_t short_bits = 5, long_bits = 9;

} // namespace

// ---- writing -----------------------------------------------------------------------------------------------------

InputEncoder::InputEncoder(std::vector<std::byte>& to, std::span<const std::byte> before)
    : out(to), start(to.size()) {
    std::ranges::copy(before, previous.begin());
}

void InputEncoder::put(std::uint32_t value, std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i, ++bits) {
        if (bits % 8 == 0) out.push_back(std::byte{0});
        out[start + bits / 8] |= static_cast<std::byte>((value >> i & 1u) << (bits % 8));
    }
}

bool InputEncoder::add(std::span<const std::byte> input, std::size_t bytes_max) {
    const std::uint32_t size = static_cast<std::uint32_t>(input.size());
    std::uint64_t changed = 0;
    std::uint32_t changes_bits = 0;
    for (std::uint32_t i = 0; i < size; ++i) {
        if (input[i] == previous[i]) continue;
        changed |= std::uint64_t{1} << i;
        changes_bits += short_form(difference(input[i], previous[i])) < 16 ? short_bits : long_bits;
    }
    const bool same_bytes = changed == mask;
    const std::uint32_t with_mask = (same_bytes ? 2 : 3 + size) + changes_bits;
    const bool all_bytes = !same_bytes && input_bits_max(size) < with_mask;
    const std::size_t needed = changed == 0 ? 1 : all_bytes ? input_bits_max(size) : with_mask;
    if (bits + needed > 8 * bytes_max) return false;
    if (changed == 0) return put(0, 1), true;
    put(all_bytes ? 7 : same_bytes ? 1 : 3, same_bytes ? 2 : 3);
    if (!all_bytes && !same_bytes)
        for (std::uint32_t i = 0; i < size; ++i) put(static_cast<std::uint32_t>(changed >> i & 1u), 1);
    for (std::uint32_t i = 0; i < size; ++i) {
        const std::uint32_t change = difference(input[i], previous[i]), form = short_form(change);
        if (all_bytes)
            put(change, 8);
        else if ((changed >> i & 1u) != 0)
            put(form < 16 ? form << 1 : change << 1 | 1u, form < 16 ? short_bits : long_bits);
    }
    if (!all_bytes) mask = changed;
    std::ranges::copy(input, previous.begin());
    return true;
}

// ---- reading -----------------------------------------------------------------------------------------------------

InputDecoder::InputDecoder(std::span<const std::byte> code, std::span<const std::byte> before)
    : in(code), size(before.size()) {
    std::ranges::copy(before, input.begin());
}

std::uint32_t InputDecoder::take(std::uint32_t count) {
    if (bits + count > 8 * in.size()) failed = true;
    if (failed) return 0;
    std::uint32_t value = 0;
    for (std::uint32_t i = 0; i < count; ++i, ++bits)
        value |= (std::to_integer<std::uint32_t>(in[bits / 8]) >> (bits % 8) & 1u) << i;
    return value;
}

void InputDecoder::change(std::size_t byte, std::uint32_t by) {
    input[byte] = static_cast<std::byte>((std::to_integer<std::uint32_t>(input[byte]) + by) & 0xffu);
}

std::span<const std::byte> InputDecoder::next() {
    if (take(1) != 0) {
        const bool other_bytes = take(1) != 0;
        if (other_bytes && take(1) != 0) {
            read_all_bytes();
        } else {
            if (other_bytes) mask = 0;
            for (std::size_t i = 0; other_bytes && i < size; ++i) mask |= std::uint64_t{take(1)} << i;
            read_changes();
        }
    }
    return std::span(input).first(size);
}

void InputDecoder::read_changes() {
    if (mask == 0) failed = true;
    for (std::size_t i = 0; i < size && !failed; ++i) {
        if ((mask >> i & 1u) == 0) continue;
        if (take(1) == 0) {
            const std::uint32_t form = take(4);
            change(i, form < 8 ? form - 8 : form - 7);
        } else {
            const std::uint32_t by = take(8);
            if (by == 0 || short_form(by) < 16) failed = true; // the short form was possible
            change(i, by);
        }
    }
}

void InputDecoder::read_all_bytes() {
    std::uint32_t any = 0;
    for (std::size_t i = 0; i < size; ++i) {
        const std::uint32_t by = take(8);
        any |= by;
        change(i, by);
    }
    if (any == 0) failed = true;
}

std::size_t InputDecoder::end() {
    if (bits % 8 != 0 && take(8 - static_cast<std::uint32_t>(bits % 8)) != 0) failed = true;
    return bits / 8;
}

} // namespace lockstone::session
