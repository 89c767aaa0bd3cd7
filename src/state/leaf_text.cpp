#include "state/leaf_text.h"

#include "base/text.h"

#include <cstring>

namespace lockstone {

namespace {

/// The bits of a leaf, in the low end.
std::uint64_t raw_bits(std::span<const std::byte> row, const LeafInfo& leaf) {
    const auto read = [&]<class N>(N value) {
        std::memcpy(&value, row.data() + leaf.offset, sizeof value);
        return std::uint64_t{value};
    };
    switch (leaf.size) {
    case 1:
        return read(std::uint8_t{});
    case 2:
        return read(std::uint16_t{});
    case 4:
        return read(std::uint32_t{});
    default:
        return read(std::uint64_t{});
    }
}

std::int64_t sign_extended(std::uint64_t bits, int size_bytes) {
    const int unused = 64 - 8 * size_bytes;
    return static_cast<std::int64_t>(bits << unused) >> unused;
}

/// Returns the next decimal digit of a fraction in units of 2^-64, and keeps the rest of the fraction.
unsigned next_digit(std::uint64_t& fraction) {
    const std::uint64_t low = (fraction & 0xffffffffu) * 10;
    const std::uint64_t high = (fraction >> 32) * 10 + (low >> 32);
    fraction = (high << 32) | (low & 0xffffffffu);
    return static_cast<unsigned>(high >> 32);
}

} // namespace

std::string decimal_text(std::int64_t raw, int fraction_bits) {
    constexpr int decimals = 12;
    const std::uint64_t size = magnitude(raw);
    std::uint64_t whole = fraction_bits == 0 ? size : size >> fraction_bits;
    std::uint64_t fraction = fraction_bits == 0 ? 0 : size << (64 - fraction_bits);

    std::uint64_t digits = 0, scale = 1;
    int count = 0;
    for (; count < decimals && fraction != 0; ++count, scale *= 10)
        digits = digits * 10 + next_digit(fraction);
    if (fraction >> 63 != 0) ++digits; // half or more of the last digit remains
    if (digits == scale && count > 0) ++whole, digits = 0;
    while (count > 0 && digits % 10 == 0) digits /= 10, --count;

    std::string text = raw < 0 && (whole != 0 || digits != 0) ? "-" : "";
    text += std::to_string(whole);
    if (count == 0) return text;
    const std::string tail = std::to_string(digits);
    return text + "." + std::string(static_cast<std::size_t>(count) - tail.size(), '0') + tail;
}

std::string leaf_text(std::span<const std::byte> row, const LeafInfo& leaf) {
    const std::uint64_t bits = raw_bits(row, leaf);
    if (leaf.kind == LeafKind::unsigned_integer) return std::to_string(bits);
    return decimal_text(sign_extended(bits, leaf.size),
                        leaf.kind == LeafKind::fixed_point ? leaf.fraction_bits : 0);
}

std::string leaf_text_with_raw(std::span<const std::byte> row, const LeafInfo& leaf) {
    return leaf_text(row, leaf) + " (raw " + base::hex(raw_bits(row, leaf)) + ")";
}

} // namespace lockstone
