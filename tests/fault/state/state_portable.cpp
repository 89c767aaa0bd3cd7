// Damaged, foreign and hostile portable images: refused with an error sentence, or loaded exactly as written.
#include "base/bytes.h"
#include "base/hash.h"
#include "support/effort.h"
#include "support/state_sample.h"

#include <doctest/doctest.h>

#include <algorithm>

namespace lockstone::test {
namespace {

using Bytes = std::vector<std::byte>;

Bytes from_hex(std::string_view text) {
    Bytes out;
    int high = -1;
    for (char c : text) {
        if (c == ' ' || c == '\n') continue;
        const int digit = c <= '9' ? c - '0' : c - 'a' + 10;
        if (high < 0)
            high = digit;
        else
            out.push_back(static_cast<std::byte>(high * 16 + digit)), high = -1;
    }
    return out;
}

std::string to_hex(std::span<const std::byte> bytes) {
    std::string out;
    for (std::byte b : bytes) {
        out += "0123456789abcdef"[std::to_integer<unsigned>(b) >> 4];
        out += "0123456789abcdef"[std::to_integer<unsigned>(b) & 15u];
    }
    return out;
}

/// Writes a valid size field and checksum, as an attacker would do.
void seal(Bytes& image) {
    base::store_little_endian<std::uint64_t>(image.size(), image.data() + 12);
    const std::size_t end = image.size() - 8;
    base::store_little_endian(base::xxh3(std::span<const std::byte>(image).first(end)), image.data() + end);
}

/// Restores the image into a state with content. Requires an error sentence and an unchanged state. Returns the
/// sentence.
std::string refusal(std::span<const std::byte> image, const Sample& s = make_sample()) {
    static const State before = random_state(make_sample(), 2, 3, 1, 99);
    State state(s.layout);
    if (s.layout->schema_hash() == before.layout().schema_hash() &&
        s.layout->size_bytes() == before.layout().size_bytes())
        state = before;
    const State untouched = state;
    const Status status = state.restore_portable(image);
    REQUIRE(!status.ok());
    REQUIRE(same_bytes(state.block_bytes(), untouched.block_bytes()));
    REQUIRE(status.error().message.starts_with("state image: "));
    return status.error().message;
}

/// The offset of a text in an image.
std::size_t find(const Bytes& image, std::string_view text) {
    const auto bytes = std::as_bytes(std::span(text.data(), text.size()));
    const auto found = std::search(image.begin(), image.end(), bytes.begin(), bytes.end());
    REQUIRE(found != image.end());
    return static_cast<std::size_t>(found - image.begin());
}

Bytes small_image() { return random_state(make_sample(), 3, 4, 5, 17).save_portable(); }

} // namespace

TEST_CASE("the portable bytes of a tiny state equal bytes computed by hand") {
    StateLayout layout;
    const TableId t = layout.add_table("t", 4);
    const auto speed = layout.add_column<Speed>(t, "t.speed", Group::motion);
    const auto key = layout.add_column<std::uint64_t>(t, "t.key", Group::game);
    State state(std::move(layout).finished());
    state.resize(t, 2);
    state.edit_row(speed, 0) = decimal<Speed>("1.5");
    state.edit_row(speed, 1) = decimal<Speed>("-0.25");
    state.edit_row(key, 1) = 0x0102030405060708;
    const std::string golden = // computed by hand from the format's README, without this code
        "4c5353544154450a"     // magic
        "01000000"             // version
        "7900000000000000"     // size
        "3fbc0c18d5b43db9"     // schema hash
        "0100000002000000"     // tables, columns
        "010000007402000000"   // table t: 2 rows
        "07000000742e7370656564000000000200000004000000" // t.speed: table, group, row size
        "00000c000000feff"                               // 1.5, -0.25
        "05000000742e6b6579000000000400000008000000"     // t.key
        "00000000000000000807060504030201"               // 0, 0x0102030405060708
        "9e630dc5f2e1ad53";                              // checksum
    const Bytes image = state.save_portable();
    CHECK(to_hex(image) == to_hex(from_hex(golden)));
    CHECK(state.hash() == 0xba8839d59bfd69d8u);

    State read(state.layout_shared());
    REQUIRE(read.restore_portable(from_hex(golden)).ok());
    CHECK(same_bytes(read.block_bytes(), state.block_bytes()));
}

TEST_CASE("a state rejects every truncated image with an old or a new checksum and every extra byte") {
    const Bytes image = small_image();
    for (std::size_t size = 0; size < image.size(); ++size) {
        Bytes cut(image.begin(), image.begin() + static_cast<std::ptrdiff_t>(size));
        refusal(cut);
        if (size < 28) continue;
        seal(cut);
        refusal(cut);
    }
    Bytes longer = image;
    longer.push_back(std::byte{});
    refusal(longer);
}

TEST_CASE("a state rejects an image with any change of a single byte") {
    Bytes image = small_image();
    for (std::byte& byte : image)
        for (unsigned flip = 1; flip < 256; flip += test::is_too_long_here() ? 17u : 1u) {
            byte ^= static_cast<std::byte>(flip);
            refusal(image);
            byte ^= static_cast<std::byte>(flip);
        }
}

TEST_CASE("a state rejects a changed byte under a valid checksum or holds this byte afterwards") {
    const Bytes original = small_image();
    std::size_t accepted = 0;
    for (std::size_t at = 0; at + 8 < original.size(); ++at)
        for (unsigned flip : {1u, 2u, 0x80u, 0xffu}) {
            Bytes image = original;
            image[at] ^= static_cast<std::byte>(flip);
            const bool size_field = at >= 12 && at < 20;
            if (!size_field) seal(image);
            State state(make_sample().layout);
            const Status status = state.restore_portable(image);
            if (!status.ok()) {
                REQUIRE(!status.error().message.empty());
                REQUIRE(same_bytes(state.block_bytes(), State(make_sample().layout).block_bytes()));
            } else {
                ++accepted;
                REQUIRE(state.save_portable() == image);
            }
        }
    // Rows, and the count of the table without columns.
    CHECK(accepted > 4 * (3 * (40 + 12 + 16 + 1) + 4 * 24));
}

TEST_CASE("the error of a rejected image names the place and both values") {
    const Bytes original = small_image();
    const auto with_u32 = [&](std::size_t at, std::uint32_t value) {
        Bytes image = original;
        base::store_little_endian(value, image.data() + at);
        seal(image);
        return image;
    };
    const std::size_t body = find(original, "body"), velocity = find(original, "body.velocity");
    CHECK(refusal({}) == "state image: magic needs 8 bytes, only 0 remain (at byte 0)");
    CHECK(refusal(from_hex("4c5353544154450d0a000000000000")) ==
          "state image: not a state image: it should begin with 'LSSTATE' and a line feed (at byte 0)");
    CHECK(refusal(with_u32(8, 2)) == "state image: format version 2, this build reads version 1 (at byte 8)");
    CHECK(refusal(std::span(original).first(100)) == base::join("state image: the image should be ",
                                                                original.size(),
                                                                " bytes long, but it has 100 (at byte 12)"));
    CHECK(refusal(with_u32(28, 4)) ==
          "state image: number of tables is 4 in the image, 3 in this build (at byte 28)");
    CHECK(refusal(with_u32(32, 0xffffffffu)) ==
          "state image: number of columns is 4294967295 in the image, 5 in this build (at byte 32)");
    CHECK(refusal(with_u32(36, 0xffffffffu)) ==
          base::join("state image: table name needs 4294967295 bytes, only ", original.size() - 48,
                     " remain (at byte 40)"));
    CHECK(refusal(with_u32(body + 4, 9)) ==
          "state image: table 'body' has 9 rows in the image, but capacity for 8 (at byte 44)");
    CHECK(refusal(with_u32(velocity + 13, 1)) ==
          base::join(
              "state image: table of column 'body.velocity' is 1 in the image, 0 in this build (at byte ",
              velocity - 4, ")"));
    CHECK(
        refusal(with_u32(velocity + 21, 16)) ==
        base::join(
            "state image: row size of column 'body.velocity' is 16 in the image, 12 in this build (at byte ",
            velocity - 4, ")"));
    Bytes damaged = original;
    damaged[velocity] ^= std::byte{1};
    CHECK(refusal(damaged).starts_with("state image: damaged: the checksum is 0x"));
    Bytes trailing = original;
    trailing.insert(trailing.end() - 8, 5, std::byte{});
    seal(trailing);
    CHECK(refusal(trailing) ==
          base::join("state image: ends here, but 5 bytes follow (at byte ", original.size() - 8, ")"));
}

TEST_CASE("a state rejects an image of another manifest and names the first column that differs") {
    const auto layout_with = [](const char* name, std::uint8_t fraction_bits) {
        StateLayout layout;
        layout.add_column(layout.add_table("t", 2), name, Group::game, 4,
                          {{"x", 0, 4, LeafKind::fixed_point, fraction_bits}});
        Sample s{};
        s.layout = std::move(layout).finished();
        return s;
    };
    const Bytes image = State(layout_with("t.mana", 16).layout).save_portable();
    CHECK(refusal(image, layout_with("t.rage", 16)) ==
          "state image: column name is 't.mana' in the image, 't.rage' in this build (at byte 45)");
    const std::string fields = refusal(image, layout_with("t.mana", 19));
    CHECK(fields.starts_with("state image: schema hash is 0x"));
    CHECK(fields.ends_with("in this build: the fields of some column differ (at byte 20)"));
}

TEST_CASE("a table without columns can hold the largest count") {
    StateLayout layout;
    layout.add_table("unused", 0xffffffffu);
    Sample s{};
    s.layout = std::move(layout).finished();
    Bytes image = State(s.layout).save_portable();
    base::store_little_endian(0xffffffffu, image.data() + find(image, "unused") + 6);
    seal(image);
    State state(s.layout);
    CHECK(state.restore_portable(image).ok());
    CHECK(state.count({0}) == 0xffffffffu);
    CHECK(state.save_portable() == image);
}

} // namespace lockstone::test
