// Packets: what is written is what is read, and no bytes from outside can break a session.
#include "session/match.h"
#include "session/message.h"

#include "base/bytes.h"
#include "base/hash.h"

#include <doctest/doctest.h>

#include <deque>

using namespace lockstone;
using namespace lockstone::test;
using namespace lockstone::session;

namespace {

constexpr PacketContext context{0x1234, 4, 2};

std::vector<std::byte> sample_input(std::uint64_t tick) {
    const auto held = static_cast<std::byte>(tick / 3);
    return {held, held};
}

Message sample_message() {
    Message message{};
    message.sequence = 77;
    message.tick = 1000;
    message.unwanted = 0b1100;
    message.gone = 0b1000;
    message.has_cut = 0b1000;
    message.cut[3] = 4;
    message.next_input = {990, 991, 1002, 5};
    message.next_hash = 980;
    message.hash_first = 985;
    message.hash_count = 3;
    message.hashes = {1, ~std::uint64_t{0}, 3};
    message.quality = QualityReport{-3, 123456, 123400, 16};
    return message;
}

std::vector<std::byte> sample_packet() {
    PacketWriter writer;
    writer.begin(context, sample_message());
    writer.add_inputs(0, 990, 12, 1, sample_input);
    writer.add_inputs(3, 5, 1, 0, sample_input);
    const auto packet = writer.finish();
    return {packet.begin(), packet.end()};
}

/// Makes the checksum right again, so that damage reaches the checks behind it.
void seal(std::vector<std::byte>& packet) {
    if (packet.size() < 4) return;
    const std::span body(packet.data(), packet.size() - 4);
    base::store_little_endian(static_cast<std::uint32_t>(base::xxh3(body)), packet.data() + body.size());
}

/// Changes, removes, doubles or appends bytes.
void mutate(std::vector<std::byte>& packet, test::Random& random) {
    const std::uint32_t changes = 1 + random.below(4);
    for (std::uint32_t i = 0; i < changes && !packet.empty(); ++i) {
        const std::uint32_t at = random.below(static_cast<std::uint32_t>(packet.size()));
        switch (random.below(6)) {
        case 0:
            packet[at] = static_cast<std::byte>(random.below(256));
            break;
        case 1:
            packet[at] ^= static_cast<std::byte>(1u << random.below(8));
            break;
        case 2:
            packet[at] = random.below(2) != 0 ? std::byte{0xff} : std::byte{0};
            break;
        case 3:
            packet.resize(at);
            break;
        case 4:
            packet.erase(packet.begin() + at);
            break;
        default:
            packet.insert(packet.begin() + at, static_cast<std::byte>(random.below(256)));
            break;
        }
    }
}

/// A transport whose packets the test writes.
class Mailbox final : public Transport {
  public:
    void send(PeerId, std::span<const std::byte> bytes) override { sent.assign(bytes.begin(), bytes.end()); }
    std::optional<Datagram> receive() override {
        if (waiting.empty()) return std::nullopt;
        held = std::move(waiting.front());
        waiting.pop_front();
        return Datagram{from, held};
    }
    PeerId from = 1;
    std::deque<std::vector<std::byte>> waiting;
    std::vector<std::byte> held, sent;
};

} // namespace

TEST_CASE("a packet reads as it was written, field by field") {
    const std::vector<std::byte> packet = sample_packet();
    Message read{};
    REQUIRE_FALSE(decode(packet, context, read));
    const Message wrote = sample_message();
    CHECK(read.sequence == wrote.sequence);
    CHECK(read.tick == wrote.tick);
    CHECK(read.unwanted == wrote.unwanted);
    CHECK(read.gone == wrote.gone);
    CHECK(read.has_cut == wrote.has_cut);
    CHECK(read.cut[3] == wrote.cut[3]);
    CHECK(std::equal(read.next_input.begin(), read.next_input.begin() + 4, wrote.next_input.begin()));
    CHECK(read.next_hash == wrote.next_hash);
    CHECK(read.hash_first == wrote.hash_first);
    REQUIRE(read.hash_count == 3);
    CHECK(std::equal(read.hashes.begin(), read.hashes.begin() + 3, wrote.hashes.begin()));
    REQUIRE(read.quality);
    CHECK(read.quality->ticks_ahead == -3);
    CHECK(read.quality->sent_ms == 123456);
    CHECK(read.quality->echo_ms == 123400);
    CHECK(read.quality->echo_held_ms == 16);
    REQUIRE(read.block_count == 2);
    CHECK(read.blocks[0].count == 12);
    CHECK(read.blocks[1].player == 3);
    std::uint64_t next = 990;
    for_each_input(read.blocks[0], context.input_size,
                   [&](std::uint64_t tick, std::span<const std::byte> input) {
                       CHECK(tick == next++);
                       CHECK(std::ranges::equal(input, sample_input(tick)));
                   });
    CHECK(next == 1002);
    CHECK(read.blocks[0].bytes.size() == 4 * 2); // 12 inputs, 4 different ones
}

TEST_CASE("the bytes of a packet are those of the specification") {
    PacketWriter writer;
    Message message{};
    message.sequence = 5;
    message.tick = 0x01020304;
    writer.begin({0xaabbccdd, 1, 1}, message);
    writer.add_inputs(0, 2, 3, 0, [](std::uint64_t) { return std::array{std::byte{0x77}}; });
    const auto packet = writer.finish();
    const std::array<unsigned, 31> expected{0x4c, 0x53, 2, 0, 0xdd, 0xcc, 0xbb, 0xaa, 5, 0, 0, 0, 4, 3, 2, 1,
                                            0,    0,    0, 0, 0,    0,    0,    0,    1, 0, 2, 0, 0, 0, 3};
    REQUIRE(packet.size() == expected.size() + 2 + 4);
    for (std::size_t i = 0; i < expected.size(); ++i) {
        CAPTURE(i);
        CHECK(std::to_integer<unsigned>(packet[i]) == expected[i]);
    }
    CHECK(packet[31] == std::byte{0b110}); // inputs 1 and 2 repeat input 0
    CHECK(packet[32] == std::byte{0x77});
}

TEST_CASE("a packet never grows beyond its limit; what does not fit waits") {
    PacketContext wide{1, 16, 64};
    PacketWriter writer;
    Message message{};
    message.hash_count = hashes_per_packet;
    message.quality = QualityReport{};
    writer.begin(wide, message);
    for (std::uint32_t p = 0; p < 16; ++p) {
        writer.add_inputs(p, 0, 200, 15 - p, [&](std::uint64_t tick) {
            return std::vector<std::byte>(64, static_cast<std::byte>(tick + p));
        });
    }
    const auto packet = writer.finish();
    CHECK(packet.size() <= packet_bytes_max);
    Message read{};
    CHECK_FALSE(decode(packet, wide, read));
    CHECK(read.block_count > 0);
}

TEST_CASE("any flipped bit, any truncation and any extra byte of a packet is noticed") {
    const std::vector<std::byte> packet = sample_packet();
    Message read{};
    for (std::size_t bit = 0; bit < packet.size() * 8; ++bit) {
        std::vector<std::byte> damaged = packet;
        damaged[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
        CHECK(decode(damaged, context, read) == PacketFault::damaged);
    }
    for (std::size_t size = 0; size < packet.size(); ++size)
        CHECK(decode(std::span(packet).first(size), context, read) == PacketFault::damaged);
    std::vector<std::byte> longer = packet;
    longer.push_back(std::byte{0});
    CHECK(decode(longer, context, read) == PacketFault::damaged);
}

TEST_CASE("a sealed packet with a wrong field is refused for what is wrong") {
    const auto refused = [](std::size_t at, unsigned value) {
        std::vector<std::byte> packet = sample_packet();
        packet[at] = static_cast<std::byte>(value);
        seal(packet);
        Message read{};
        return decode(packet, context, read);
    };
    constexpr std::size_t hash_count_at = 8 + 4 + 4 + 16 + 4 + 4;
    constexpr std::size_t departures_at = hash_count_at + 1 + 24 + 16;
    constexpr std::size_t block_count_at = departures_at + 6 + 4;
    CHECK(refused(0, 0) == PacketFault::damaged);
    CHECK(refused(2, 9) == PacketFault::version);
    CHECK(refused(3, 0x83) == PacketFault::malformed);
    CHECK(refused(4, 0xff) == PacketFault::match);
    CHECK(refused(departures_at, 0x10) == PacketFault::malformed);     // player 4 of 4 is unwanted
    CHECK(refused(departures_at + 2, 0x18) == PacketFault::malformed); // or gone
    CHECK(refused(departures_at + 4, 0x0c) == PacketFault::malformed); // player 2 has a cut, and is here
    CHECK(refused(hash_count_at, 0) == PacketFault::malformed);
    CHECK(refused(hash_count_at, 17) == PacketFault::malformed);
    CHECK(refused(block_count_at, 5) == PacketFault::malformed);
    CHECK(refused(block_count_at, 1) == PacketFault::malformed);        // bytes follow
    CHECK(refused(block_count_at + 1, 4) == PacketFault::malformed);    // no such player
    CHECK(refused(block_count_at + 1, 3) == PacketFault::malformed);    // not in order
    CHECK(refused(block_count_at + 6, 0) == PacketFault::malformed);    // no inputs
    CHECK(refused(block_count_at + 7, 1) == PacketFault::malformed);    // the first repeats
    CHECK(refused(block_count_at + 8, 0xf0) == PacketFault::malformed); // bits after the last
}

TEST_CASE("random and mutated bytes, sealed or not, never break the decoder") {
    test::Random random(99);
    Message read{};
    std::array<std::uint64_t, packet_fault_count + 1> outcomes{};
    for (int i = 0; i < 60'000; ++i) {
        std::vector<std::byte> packet = sample_packet();
        if (i % 4 == 0) {
            packet.resize(random.below(1400));
            for (std::byte& b : packet) b = static_cast<std::byte>(random.next());
        } else {
            mutate(packet, random);
        }
        if (i % 3 != 0) seal(packet);
        const auto fault = decode(packet, context, read);
        ++outcomes[fault ? static_cast<std::size_t>(*fault) : packet_fault_count];
        if (fault) continue;
        for (const InputBlock& block : read.input_blocks())
            for_each_input(block, context.input_size, [](std::uint64_t, std::span<const std::byte> input) {
                REQUIRE(input.size() == context.input_size);
            });
    }
    CHECK(outcomes[static_cast<std::size_t>(PacketFault::malformed)] > 1000);
    CHECK(outcomes[static_cast<std::size_t>(PacketFault::damaged)] > 1000);
    CHECK(outcomes[packet_fault_count] > 1000);
}

TEST_CASE("a hostile peer can send what it likes: the session drops it, counts it and goes on") {
    std::array<std::uint64_t, packet_fault_count> dropped{};
    std::uint64_t ticks = 0, received = 0;
    for (std::uint64_t seed = 1; seed <= 100; ++seed) { // short: an accepted lie may stall a match for good
        test::Random random(seed);
        Mailbox mailbox_0, mailbox_1;
        SessionDef def;
        def.input_size = 4;
        def.players = {0, 1, 1};
        const auto session = make_rollback_session(def, mailbox_0).value();
        def.self = 1;
        const auto hostile = make_rollback_session(def, mailbox_1).value(); // lends its honest packets
        mailbox_1.from = 0;
        Arena arena(3), other(3);
        SessionRunner runner(*session, arena), honest(*hostile, other);
        for (std::uint64_t now = 0; now < 100; ++now) {
            session->add_local_input(0, encode_input(scripted_pad(0, session->current_tick())));
            hostile->add_local_input(1, encode_input(scripted_pad(1, hostile->current_tick())));
            hostile->add_local_input(2, encode_input(scripted_pad(2, hostile->current_tick())));
            honest.frame(now);
            mailbox_0.from = random.below(50) == 0 ? 5 : 1;
            for (int i = 0; i < 4; ++i) {
                std::vector<std::byte>& packet = mailbox_0.waiting.emplace_back(mailbox_1.sent);
                mutate(packet, random);
                // Rarely a farewell: it is believed, and the rest of the match would be refused.
                if (packet.size() > 3 && random.below(500) != 0) packet[3] &= std::byte{3};
                if (random.below(8) != 0) seal(packet);
            }
            if (now % 3 == 0) mailbox_0.waiting.push_back(mailbox_1.sent);
            runner.frame(now);
            mailbox_1.waiting.push_back(mailbox_0.sent);
        }
        const SessionStats& stats = session->stats();
        ticks += stats.ticks;
        received += stats.packets_received;
        for (std::size_t i = 0; i < dropped.size(); ++i) dropped[i] += stats.dropped[i];
        CHECK(stats.packets_dropped > 100);
    }
    MESSAGE("ticks ", ticks, ", packets ", received, ", strangers ", dropped[0], ", damaged ", dropped[1],
            ", version ", dropped[2], ", match ", dropped[3], ", malformed ", dropped[4], ", implausible ",
            dropped[5]);
    for (std::size_t fault = 0; fault < dropped.size(); ++fault)
        CHECK(((dropped[fault] > 100) || fault == static_cast<std::size_t>(PacketFault::flood)));
    CHECK(ticks > 1000);
    CHECK(received > 40'000);
}

TEST_CASE("claims that the sender cannot make are refused whole") {
    Mailbox mailbox;
    SessionDef def;
    def.input_size = 1;
    def.players = {0, 1};
    def.input_delay = 0;
    const auto session = make_rollback_session(def, mailbox).value();
    std::uint64_t sequence = 0;
    const auto implausible = [&](auto change, std::uint32_t player, std::uint64_t first) {
        Message message{};
        message.sequence = ++sequence;
        change(message);
        PacketWriter writer;
        writer.begin(packet_context(def), message);
        writer.add_inputs(player, first, 2, 0, [](std::uint64_t) { return std::array{std::byte{1}}; });
        const auto packet = writer.finish();
        mailbox.waiting.emplace_back(packet.begin(), packet.end());
        const auto& count = session->stats().dropped[static_cast<std::size_t>(PacketFault::implausible)];
        const std::uint64_t before = count;
        session->poll(0);
        return count == before + 1;
    };
    const auto nothing = [](Message&) {};
    CHECK(implausible([](Message& m) { m.next_input[0] = 1; }, 1, 0)); // has an input we did not send
    CHECK(implausible([](Message& m) { m.next_hash = 1; }, 1, 0));     // has a hash we did not send
    CHECK(implausible([](Message& m) { m.hash_count = 1; }, 1, 0));    // confirmed a tick without our input
    CHECK(implausible(nothing, 1, 1));                                 // a gap in its inputs
    CHECK(implausible(nothing, 0, 0));                                 // inputs of another machine's player
    CHECK(session->advance().stall == Stall::connecting);
    CHECK_FALSE(implausible(nothing, 1, 0));
    CHECK(session->advance().stall == Stall::local_input_missing);
}
