#include "base/bytes.h"
#include "base/hash.h"
#include "support/state_sample.h"

#include <doctest/doctest.h>

namespace lockstone::test {

namespace {
struct Values {
    std::uint8_t a;
    std::uint16_t b;
    std::uint32_t c;
    std::uint64_t d;
    std::int32_t e;
    std::int64_t f;
    std::string_view text;
};
constexpr Values values{0x12, 0x3456, 0x789abcdeu, 0xfedcba9876543210u, -2, -3, "pose"};

std::vector<std::byte> written() {
    std::vector<std::byte> bytes;
    base::ByteWriter out(bytes);
    out.u8(values.a), out.u16(values.b), out.u32(values.c), out.u64(values.d), out.i32(values.e),
        out.i64(values.f);
    out.text(values.text);
    return bytes;
}

Values read(base::ByteReader& in) {
    Values v{};
    v.a = in.u8("a"), v.b = in.u16("b"), v.c = in.u32("c"), v.d = in.u64("d"), v.e = in.i32("e"),
    v.f = in.i64("f");
    v.text = in.text("text");
    return v;
}
} // namespace

TEST_CASE("ByteReader reads the written values back and the bytes are little-endian") {
    const auto bytes = written();
    CHECK(bytes[1] == std::byte{0x56});
    CHECK(bytes[3] == std::byte{0xde});
    base::ByteReader in(bytes, "values");
    const Values v = read(in);
    in.expect_end();
    REQUIRE(in.ok());
    CHECK(v.a == values.a);
    CHECK(v.b == values.b);
    CHECK(v.c == values.c);
    CHECK(v.d == values.d);
    CHECK(v.e == values.e);
    CHECK(v.f == values.f);
    CHECK(v.text == values.text);
}

TEST_CASE("ByteReader reports each truncation with the field and the place and the missing bytes") {
    const auto bytes = written();
    for (std::size_t size = 0; size < bytes.size(); ++size) {
        base::ByteReader in({bytes.data(), size}, "values");
        read(in);
        REQUIRE(!in.ok());
        CHECK(!in.error().message.empty());
    }
    base::ByteReader in({bytes.data(), 5}, "values");
    read(in);
    CHECK(in.error().message == "values: c needs 4 bytes, only 2 remain (at byte 3)");
    CHECK(in.u32("later") == 0);
    CHECK(in.remaining() == 0);
    CHECK(in.error().message ==
          "values: c needs 4 bytes, only 2 remain (at byte 3)"); // the first error remains
}

TEST_CASE("ByteReader rejects a length larger than memory and reports bytes that are left over") {
    const std::array<std::byte, 4> bytes{};
    base::ByteReader in(bytes, "packet");
    CHECK(in.bytes(0xffffffffffffffffu, "payload").empty());
    CHECK(in.error().message ==
          "packet: payload needs 18446744073709551615 bytes, only 4 remain (at byte 0)");
    base::ByteReader rest(bytes, "packet");
    rest.u8("kind");
    rest.expect_end();
    CHECK(rest.error().message == "packet: ends here, but 3 bytes follow (at byte 1)");
}

TEST_CASE("a hash over pieces equals the hash of the whole") {
    SplitMix random(11);
    std::vector<std::byte> bytes(5000);
    for (std::byte& b : bytes) b = static_cast<std::byte>(random.next() & 255u);
    for (const std::uint64_t seed : {std::uint64_t{0}, random.next()})
        for (int round = 0; round < 200; ++round) {
            const auto whole = std::span<const std::byte>(bytes).first(random.below(5001));
            base::HashStream stream(seed);
            for (std::size_t at = 0; at < whole.size();) {
                const std::size_t piece = std::min<std::size_t>(whole.size() - at, 1 + random.below(700));
                stream.add(whole.subspan(at, piece));
                at += piece;
            }
            REQUIRE(stream.digest() == base::xxh3(whole, seed));
        }
    // The published value for no bytes and no seed.
    CHECK(base::xxh3(std::span<const std::byte>{}) == 0x2d06800538d394c2u);
}

} // namespace lockstone::test
