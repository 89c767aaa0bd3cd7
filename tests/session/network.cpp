// The simulated network and typed inputs.
#include "session/arena.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

std::vector<std::pair<std::uint64_t, std::uint32_t>> arrivals(const LinkDef& link, std::uint64_t seed,
                                                              std::uint32_t count) {
    SimulatedNetwork network(2, link, seed);
    std::vector<std::pair<std::uint64_t, std::uint32_t>> out; // time [ms], value
    for (std::uint64_t now = 0; now < count + 1000; ++now) {
        network.advance_to(now);
        const std::array bytes{static_cast<std::byte>(now), static_cast<std::byte>(now >> 8)};
        if (now < count) network.endpoint(0).send(1, bytes);
        while (const auto datagram = network.endpoint(1).receive())
            out.emplace_back(now, std::to_integer<std::uint32_t>(datagram->bytes[0]) |
                                      std::to_integer<std::uint32_t>(datagram->bytes[1]) << 8);
    }
    return out;
}

struct Mixed {
    Real exact;
    std::int32_t small;
    std::int16_t negative;
    std::array<std::uint8_t, 2> bytes;
};
template <class V> constexpr void describe(Mixed& w, V&& v) {
    v("exact", w.exact), v("small", w.small), v("negative", w.negative), v("bytes", w.bytes);
}

} // namespace

TEST_CASE("a plain link delivers everything in order after its latency") {
    const auto got = arrivals({.latency_ms = 40}, 1, 500);
    REQUIRE(got.size() == 500);
    for (std::uint32_t i = 0; i < got.size(); ++i)
        CHECK(got[i] == std::pair<std::uint64_t, std::uint32_t>{i + 40, i});
}

TEST_CASE(
    "a link loses, repeats, delays and reorders packets at the given rates and equally for equal seeds") {
    const LinkDef link{.latency_ms = 30, .jitter_ms = 20, .loss_permille = 200, .duplicate_permille = 100};
    const auto got = arrivals(link, 5, 10'000);
    CHECK(got.size() > 8500);
    CHECK(got.size() < 9100);
    bool overtaken = false;
    for (std::size_t i = 0; i < got.size(); ++i) {
        const std::uint64_t took = got[i].first - got[i].second;
        CHECK(took >= 30);
        CHECK(took <= 50);
        overtaken = overtaken || (i > 0 && got[i].second < got[i - 1].second);
    }
    CHECK(overtaken);
    CHECK(got == arrivals(link, 5, 10'000));
    CHECK(got != arrivals(link, 6, 10'000));
}

TEST_CASE("an unplugged endpoint neither sends nor receives and other links still deliver") {
    SimulatedNetwork network(3, {}, 1);
    const std::array bytes{std::byte{1}};
    network.unplug(1);
    network.endpoint(0).send(1, bytes);
    network.endpoint(1).send(2, bytes);
    network.endpoint(0).send(2, bytes);
    CHECK_FALSE(network.endpoint(1).receive());
    const auto datagram = network.endpoint(2).receive();
    REQUIRE(datagram);
    CHECK(datagram->from == 0);
    CHECK_FALSE(network.endpoint(2).receive());
    CHECK(network.counters().lost == 2);
}

TEST_CASE("inputs are encoded as little-endian bytes of their leaves and decode to the same values") {
    const Mixed wide{Real::from_raw(-2), 0x01020304, -300, {9, 10}};
    constexpr std::uint32_t size = input_size_of<Mixed>;
    CHECK(size == 16);
    const auto bytes = encode_input(wide);
    CHECK(bytes[0] == std::byte{0xfe});
    CHECK(bytes[7] == std::byte{0xff});
    CHECK(bytes[8] == std::byte{4});
    CHECK(bytes[12] == std::byte{0xd4});
    const Mixed read = decode_input<Mixed>(PlayerInput{bytes, InputStatus::confirmed});
    CHECK(read.exact == wide.exact);
    CHECK(read.small == wide.small);
    CHECK(read.negative == wide.negative);
    CHECK(read.bytes == wide.bytes);
    CHECK(decode_input<Mixed>(std::span(bytes).first(3)).small == 0);
}
