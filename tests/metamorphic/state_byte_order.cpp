#include "state/canonical.h"
#include "support/state_sample.h"

#include <doctest/doctest.h>

namespace lockstone::test {
namespace {

constexpr std::endian other_order =
    std::endian::native == std::endian::little ? std::endian::big : std::endian::little;

/// The bytes of these rows in the memory of a host of the other byte order.
std::vector<std::byte> other_host(std::span<const std::byte> rows, std::span<const LeafInfo> leaves,
                                  std::size_t row_size) {
    std::vector<std::byte> out(rows.begin(), rows.end());
    for (std::size_t row = 0; row < out.size(); row += row_size)
        for (const LeafInfo& leaf : leaves)
            std::reverse(out.begin() + static_cast<std::ptrdiff_t>(row + leaf.offset),
                         out.begin() + static_cast<std::ptrdiff_t>(row + leaf.offset + leaf.size));
    return out;
}

template <StateRow T> void check_orders(std::uint32_t rows, std::uint64_t seed) {
    SplitMix random(seed);
    std::vector<std::byte> here(rows * sizeof(T));
    for (std::byte& b : here) b = static_cast<std::byte>(random.next() & 255u);
    const auto leaves = leaves_of<T>();
    const auto there = other_host(here, leaves, sizeof(T));

    std::vector<std::byte> canonical_here, canonical_there(there.size()), back(there.size());
    append_canonical(here, leaves, canonical_here);
    copy_canonical(other_order, leaves, there, canonical_there);
    CHECK(canonical_here == canonical_there);
    CHECK(hash_canonical(other_order, leaves, there) == hash_canonical(std::endian::native, leaves, here));
    CHECK(hash_canonical(other_order, leaves, there) == hash_bytes(canonical_here));

    copy_canonical(other_order, leaves, canonical_here, back);
    CHECK(back == there);
    std::vector<std::byte> read(here.size());
    read_canonical(canonical_here, leaves, read);
    CHECK(read == here);
}

} // namespace

TEST_CASE("hosts of both byte orders give the same canonical bytes and the same hash") {
    for (std::uint32_t rows : {0u, 1u, 2u, 37u, 300u}) {
        CAPTURE(rows);
        check_orders<std::uint8_t>(rows, 1);
        check_orders<Transform>(rows, 2);
        check_orders<Health>(rows, 3);
        check_orders<Manifold>(rows, 4);
        check_orders<Inventory>(rows / 37, 5); // longer than the buffer of the swapping path
    }
}

TEST_CASE("canonical bytes are little-endian fields in order") {
    const Health health{.shield = Real::from_raw(0x0102030405060708),
                        .points = 0x11121314,
                        .bonus = 0x2122,
                        .mood = Mood::alert,
                        .luck = -1};
    std::vector<std::byte> out;
    append_canonical(std::as_bytes(std::span(&health, 1)), leaves_of<Health>(), out);
    std::string text;
    for (std::byte b : out) {
        text += "0123456789abcdef"[std::to_integer<unsigned>(b) >> 4];
        text += "0123456789abcdef"[std::to_integer<unsigned>(b) & 15u];
    }
    CHECK(text == "0807060504030201"
                  "14131211"
                  "2221"
                  "01"
                  "ff");
}

} // namespace lockstone::test
