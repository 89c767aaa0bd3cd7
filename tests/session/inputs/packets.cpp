// Packets: a decoder reads exactly the values that were encoded, and no bytes from outside can break a session.
#include "session/match.h"
#include "session/seal.h"

#include <doctest/doctest.h>

#include <deque>

using namespace lockstone;
using namespace lockstone::test;
using namespace lockstone::session;

namespace {

constexpr PacketContext context{0x1234, 4, 2};
constexpr Sender sender{.players = 0b1001, .sequence = 76, .tick = 999};

std::vector<std::byte> sample_input(std::uint64_t tick) {
    const auto held = static_cast<std::byte>(tick / 3);
    return {held, held};
}
const std::vector<std::byte> zeros(64);

Message sample_message(bool greeting = false) {
    Message message{};
    message.greeting = greeting;
    message.heard = true;
    message.sequence = 77;
    message.tick = 1000;
    message.unwanted = 0b1100;
    message.gone = 0b1000;
    message.has_cut = 0b1000;
    message.cut[3] = 4;
    message.next_input = {0, 991, 1002, 0};
    message.next_hash = 980;
    message.hash_first = 985;
    message.hash_count = 3;
    message.hashes = {1, ~std::uint32_t{0}, 3};
    message.quality = QualityReport{-3, 12345, true, 12300, 16};
    return message;
}

std::vector<std::byte> sample_packet(bool greeting = false, bool sealed = false) {
    PacketWriter writer;
    writer.begin(context, {sender.players, sealed}, sample_message(greeting));
    writer.add_inputs(990, 12, 1, sample_input(989), sample_input);
    writer.add_inputs(5, 1, 0, sample_input(4), sample_input);
    const auto packet = writer.finish();
    return {packet.begin(), packet.end()};
}

/// Changes, removes, duplicates or appends bytes, or replaces all of them.
void mutate(std::vector<std::byte>& packet, test::SplitMix& random) {
    const std::uint32_t changes = 1 + random.below(4);
    for (std::uint32_t i = 0; i < changes && !packet.empty(); ++i) {
        const std::uint32_t at = random.below(static_cast<std::uint32_t>(packet.size()));
        switch (random.below(20) == 0 ? 6 : random.below(6)) {
        case 0:
            packet[at] = static_cast<std::byte>(random.below(256));
            break;
        case 6:
            packet.resize(random.below(1400));
            for (std::byte& b : packet) b = static_cast<std::byte>(random.next());
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

/// A transport whose packets come from the test.
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

TEST_CASE("decode() reads every field of a packet as it was written in each form") {
    for (const bool greeting : {false, true})
        for (const bool sealed : {false, true}) {
            CAPTURE(greeting);
            const std::vector<std::byte> packet = sample_packet(greeting, sealed);
            Sender from = sender;
            from.sealed = sealed;
            Message read{};
            REQUIRE_FALSE(decode(packet, context, from, read));
            const Message wrote = sample_message(greeting);
            CHECK(read.greeting == wrote.greeting);
            CHECK(read.heard);
            CHECK(read.sequence == wrote.sequence);
            CHECK(read.tick == wrote.tick);
            CHECK(read.unwanted == wrote.unwanted);
            CHECK(read.gone == wrote.gone);
            CHECK(read.has_cut == wrote.has_cut);
            CHECK(read.cut[3] == wrote.cut[3]);
            CHECK(read.next_input == wrote.next_input);
            CHECK(read.next_hash == wrote.next_hash);
            CHECK(read.hash_first == wrote.hash_first);
            REQUIRE(read.hash_count == 3);
            CHECK(std::equal(read.hashes.begin(), read.hashes.begin() + 3, wrote.hashes.begin()));
            REQUIRE(read.quality);
            CHECK(read.quality->ticks_ahead == -3);
            CHECK(read.quality->sent_ms == 12345);
            CHECK(read.quality->has_echo);
            CHECK(read.quality->echo_ms == 12300);
            CHECK(read.quality->echo_held_ms == 16);
            REQUIRE(read.block_count == 2);
            CHECK(read.blocks[0].count == 12);
            CHECK(read.blocks[1].player == 3);
            std::uint64_t next = 990;
            for_each_input(read.blocks[0], sample_input(989),
                           [&](std::uint64_t tick, std::span<const std::byte> input) {
                               CHECK(tick == next++);
                               CHECK(std::ranges::equal(input, sample_input(tick)));
                           });
            CHECK(next == 1002);
            CHECK(read.blocks[0].code.size() ==
                  8); // 12 inputs, 4 of them changes of two bytes: 15 + 3 * 12 + 8 bits
        }
}

TEST_CASE("the packet writer writes the bytes of the specification") {
    PacketWriter writer;
    Message message{};
    message.sequence = 0x10005;
    message.tick = 0x01020304;
    message.next_input[1] = 0x01020300;
    message.hash_first = 0x010202fe;
    message.hash_count = 1;
    message.hashes[0] = 0xa1b2c3d4;
    const auto bytes_of = [&](bool greeting, bool sealed) {
        message.greeting = message.heard = greeting;
        writer.begin({0xaabbccdd, 2, 1}, {.players = 1, .sealed = sealed}, message);
        writer.add_inputs(
            0x01020305, 3, 0, std::array{std::byte{0x70}}, // less 3, no change, 9 more
            [](std::uint64_t tick) { return std::array{std::byte(tick < 0x01020307 ? 0x6d : 0x76)}; });
        const auto packet = writer.finish();
        std::vector<unsigned> out;
        for (const std::byte b : packet) out.push_back(std::to_integer<unsigned>(b));
        return out;
    };
    // The acknowledged tick is 4 less than the tick: 7. The hash is 6 less: 11. Three inputs from 1 more: 2.
    // Bits of the inputs, in order: 1 1 0, mask 1, short 0 with 5 (-3) as 1 0 1 0; 0; 1 0, long 1 with 9 as 1 0 0 1 0 0
    // 0 0.
    const std::vector<unsigned> body{7, 11, 0xd4, 0xc3, 0xb2, 0xa1, 3, 2, 0xab, 0x34, 0x01};
    std::vector<unsigned> brief{0x81, 0x05, 0x00, 0x04, 0x03};
    brief.insert(brief.end(), body.begin(), body.end());
    CHECK(bytes_of(false, true) == brief);
    const std::vector<unsigned> summed = bytes_of(false, false);
    REQUIRE(summed.size() == brief.size() + 4);
    CHECK(std::equal(brief.begin(), brief.end(), summed.begin()));
    std::vector<unsigned> greeting{0x4c, 0x53, 4, 0x11, 0xdd, 0xcc, 0xbb, 0xaa, 5, 0, 1, 0, 4, 3, 2, 1};
    greeting.insert(greeting.end(), body.begin(), body.end());
    for (const bool sealed : {false, true}) {
        const std::vector<unsigned> greeted = bytes_of(true, sealed);
        REQUIRE(greeted.size() == greeting.size() + 4);
        CHECK(std::equal(greeting.begin(), greeting.end(), greeted.begin()));
    }
}

TEST_CASE("the packet writer keeps a packet within its limit and leaves out inputs that do not fit") {
    PacketContext wide{1, 16, 64};
    PacketWriter writer;
    Message message{};
    message.hash_count = hashes_per_packet;
    message.quality = QualityReport{};
    writer.begin(wide, {0xffff}, message);
    for (std::uint32_t p = 0; p < 16; ++p) {
        writer.add_inputs(0, 200, 15 - p, zeros, [&](std::uint64_t tick) {
            return std::vector<std::byte>(64, static_cast<std::byte>(100 * tick + p + 1));
        });
    }
    const auto packet = writer.finish();
    CHECK(packet.size() <= packet_bytes_max);
    Message read{};
    CHECK_FALSE(decode(packet, wide, {0xffff}, read));
    CHECK(read.block_count == 16);
}

TEST_CASE("the checksum of an unsealed short packet covers the fields that the packet leaves out") {
    const std::vector<std::byte> packet = sample_packet();
    Message read{};
    CHECK_FALSE(decode(packet, context, sender, read));
    PacketContext other = context;
    other.match ^= 1;
    CHECK(decode(packet, other, sender, read) == PacketFault::damaged);
    Sender late = sender;
    late.sequence += 0x10000;
    CHECK(decode(packet, context, late, read) == PacketFault::damaged);
    late = sender;
    late.tick += 0x10000;
    CHECK(decode(packet, context, late, read) == PacketFault::damaged);
}

TEST_CASE("decode() restores full numbers from 16 bits where their upper half changes") {
    for (const std::uint64_t near :
         {std::uint64_t{1}, std::uint64_t{0x7fff}, std::uint64_t{0x8001}, std::uint64_t{0xfffe},
          std::uint64_t{0x10001}, std::uint64_t{0xffff'0000}})
        for (const std::int64_t away : {-30'000, -1, 0, 1, 30'000}) {
            Message message{}, read{};
            message.sequence = near + static_cast<std::uint64_t>(away);
            message.tick = near - static_cast<std::uint64_t>(away);
            if (message.sequence >= std::uint64_t{1} << 32 || message.tick >= std::uint64_t{1} << 32)
                continue;
            PacketWriter writer;
            writer.begin({1, 1, 0}, {1, true}, message);
            writer.add_no_inputs();
            REQUIRE_FALSE(decode(writer.finish(), {1, 1, 0}, {1, true, near, near}, read));
            CHECK(read.sequence == message.sequence);
            CHECK(read.tick == message.tick);
        }
}

TEST_CASE("decode() detects any flipped bit, any truncation and any extra byte of a packet") {
    for (const bool greeting : {false, true}) {
        const std::vector<std::byte> packet = sample_packet(greeting);
        Message read{};
        for (std::size_t bit = 0; bit < packet.size() * 8; ++bit) {
            std::vector<std::byte> damaged = packet;
            damaged[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
            CHECK(decode(damaged, context, sender, read) == PacketFault::damaged);
        }
        for (std::size_t size = 0; size < packet.size(); ++size)
            CHECK(decode(std::span(packet).first(size), context, sender, read) == PacketFault::damaged);
        std::vector<std::byte> longer = packet;
        longer.push_back(std::byte{0});
        CHECK(decode(longer, context, sender, read) == PacketFault::damaged);
    }
}

TEST_CASE("decode() rejects a sealed packet with a wrong field and returns the matching fault") {
    const auto refused = [](std::size_t at, unsigned value, bool greeting = false) {
        std::vector<std::byte> packet = sample_packet(greeting);
        packet[at] = static_cast<std::byte>(value);
        test::seal(packet, context.match);
        Message read{};
        return decode(packet, context, sender, read);
    };
    CHECK(refused(0, 0, true) == PacketFault::damaged);
    CHECK(refused(2, 9, true) == PacketFault::version);
    CHECK(refused(3, 0x83, true) == PacketFault::malformed);
    CHECK(refused(4, 0xff, true) == PacketFault::match);
    constexpr std::size_t hash_count_at = 5 + 1 + 1;
    constexpr std::size_t quality_at = hash_count_at + 1 + 1 + 12;
    constexpr std::size_t departures_at = quality_at + 1 + 1 + 2 + 1 + 2;
    constexpr std::size_t block_at = departures_at + 6 + 4 + 2; // of two players: since when
    CHECK(refused(0, 0x9f) == PacketFault::malformed);          // a flag without a meaning
    CHECK(refused(5, 0xff) == PacketFault::malformed);          // acknowledges a tick before tick 0
    CHECK(refused(hash_count_at, 0) == PacketFault::malformed);
    CHECK(refused(hash_count_at, 2) == PacketFault::malformed); // has a shorter form
    CHECK(refused(hash_count_at, 17) == PacketFault::malformed);
    CHECK(refused(departures_at, 0x10) == PacketFault::malformed);     // player 4 of 4 is unwanted
    CHECK(refused(departures_at + 2, 0x18) == PacketFault::malformed); // or gone
    CHECK(refused(departures_at + 4, 0x0c) == PacketFault::malformed); // player 2 has a cut, and is present
    CHECK(refused(block_at, 5) == PacketFault::malformed);             // the code holds more inputs than 5
    CHECK(refused(block_at, 0) == PacketFault::malformed);
    CHECK(refused(block_at + 2, 0xff) == PacketFault::malformed); // a change of all bytes, with too few bytes
    CHECK(refused(block_at + 9, 0xf0) == PacketFault::malformed); // bits after the last
}

TEST_CASE("encoded inputs of any size and movement decode unchanged and take at most three bits beside their "
          "bytes") {
    test::SplitMix random(7);
    for (const std::uint32_t size : {0u, 1u, 2u, 3u, 8u, 17u, 64u})
        for (int kind = 0; kind < 4; ++kind) {
            std::vector<std::vector<std::byte>> inputs(100, std::vector<std::byte>(size));
            for (std::size_t i = 1; i < inputs.size(); ++i) {
                inputs[i] = inputs[i - 1];
                for (std::byte& b : inputs[i]) {
                    if (kind == 0 || random.below(kind == 1 ? 10 : 2) != 0) continue;
                    b = static_cast<std::byte>(
                        kind == 3 ? random.next() : std::to_integer<std::uint32_t>(b) + random.below(19) - 9);
                }
            }
            std::vector<std::byte> code(3, std::byte{0xff}); // the encoder must keep earlier bytes
            InputEncoder encoder(code, inputs[0]);
            for (const std::vector<std::byte>& input : inputs) REQUIRE(encoder.add(input, 7000));
            CHECK(code.size() - 3 <= (100 * input_bits_max(size) + 7) / 8);
            if (kind == 0) CHECK(code.size() - 3 == 13);
            const std::span<const std::byte> written = std::span(code).subspan(3);
            InputDecoder decoder(written, inputs[0]);
            for (const std::vector<std::byte>& input : inputs)
                REQUIRE(std::ranges::equal(decoder.next(), input));
            CHECK(decoder.end() == code.size() - 3);
            CHECK(decoder.ok());
        }
}

TEST_CASE("the input decoder rejects a code that has a shorter form or an end that is not zeros") {
    const auto ok = [](std::initializer_list<unsigned> bytes, std::uint32_t count) {
        std::vector<std::byte> code;
        for (const unsigned b : bytes) code.push_back(static_cast<std::byte>(b));
        InputDecoder decoder(code, std::span(zeros).first(2));
        for (std::uint32_t i = 0; i < count; ++i) decoder.next();
        decoder.end();
        return decoder.ok();
    };
    CHECK(ok({0b00000}, 5));
    CHECK_FALSE(ok({0b100000}, 5));             // a bit after the last
    CHECK_FALSE(ok({}, 1));                     // no bits at all
    CHECK_FALSE(ok({0b01}, 1));                 // repeats the last change, without one
    CHECK_FALSE(ok({0b00011}, 1));              // a change of no byte
    CHECK(ok({0b0'01'011, 0}, 1));              // byte 0 by -8
    CHECK_FALSE(ok({0b1'01'011 | 0x40, 0}, 1)); // the same change in 8 bits: by 1
    CHECK_FALSE(ok({0b111, 0, 0}, 1));          // a change of all bytes, by zero
    CHECK(ok({0b1111, 0, 0}, 1));
}

TEST_CASE("a session drops and counts arbitrary packets of a hostile peer and continues") {
    std::array<std::uint64_t, packet_fault_count> dropped{};
    std::uint64_t ticks = 0, received = 0;
    // short: an accepted lie may stall a match permanently
    for (std::uint64_t seed = 1; seed <= 100; ++seed) {
        test::SplitMix random(seed);
        Mailbox mailbox_0, mailbox_1;
        SessionDef def;
        def.input_size = 4;
        def.players = {0, 1, 1};
        const std::uint32_t match = packet_context(def).match;
        const auto session = make_rollback_session(def, mailbox_0).value();
        def.self = 1;
        // the mutations start from its honest packets
        const auto hostile = make_rollback_session(def, mailbox_1).value();
        mailbox_1.from = 0;
        Arena arena(3), other(3);
        SessionRunner runner(*session, arena), honest(*hostile, other);
        std::vector<std::byte> greeting;
        for (std::uint64_t now = 0; now < 100; ++now) {
            session->add_local_input(0, encode_input(scripted_pad(0, session->current_tick())));
            hostile->add_local_input(1, encode_input(scripted_pad(1, hostile->current_tick())));
            hostile->add_local_input(2, encode_input(scripted_pad(2, hostile->current_tick())));
            honest.frame(now);
            mailbox_0.from = random.below(50) == 0 ? 5 : 1;
            if (now == 0) greeting = mailbox_1.sent; // later packets have the short form
            for (int i = 0; i < 4; ++i) {
                std::vector<std::byte>& packet =
                    mailbox_0.waiting.emplace_back(i == 0 ? greeting : mailbox_1.sent);
                mutate(packet, random);
                // A farewell is rare: the session accepts it, and then refuses all further packets of the match.
                const bool is_short = !packet.empty() && (packet[0] & std::byte{128}) != std::byte{0};
                if (packet.size() > 3 && random.below(500) != 0) packet[is_short ? 0 : 3] &= std::byte{0x97};
                if (random.below(8) != 0) test::seal(packet, match);
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

TEST_CASE("a session drops a whole packet that contains an implausible claim of its sender") {
    Mailbox mailbox;
    SessionDef def;
    def.input_size = 1;
    def.players = {0, 1};
    def.input_delay = 0;
    const auto session = make_rollback_session(def, mailbox).value();
    std::uint64_t sequence = 0;
    const auto implausible = [&](auto change, std::uint64_t first) {
        Message message{};
        message.greeting = true;
        message.sequence = ++sequence;
        message.quality = QualityReport{};
        change(message);
        PacketWriter writer;
        writer.begin(packet_context(def), {players_at(def, 1)}, message);
        writer.add_inputs(first, 2, 0, std::span(zeros).first(1),
                          [](std::uint64_t) { return std::array{std::byte{1}}; });
        const auto packet = writer.finish();
        mailbox.waiting.emplace_back(packet.begin(), packet.end());
        const auto& count = session->stats().dropped[static_cast<std::size_t>(PacketFault::implausible)];
        const std::uint64_t before = count;
        session->poll(0);
        return count == before + 1;
    };
    const auto nothing = [](Message&) {};
    CHECK(implausible([](Message& m) { m.next_input[0] = 1; }, 0)); // has an input that we did not send
    CHECK(implausible([](Message& m) { m.next_hash = 1; }, 0));     // has a hash that we did not send
    CHECK(implausible([](Message& m) { m.hash_count = 1; }, 0));    // confirmed a tick without our input
    // a gap in its inputs, wider than the queue
    CHECK(implausible(nothing, 257));
    CHECK(implausible([](Message& m) { m.greeting = false; }, 0)); // a packet before the greeting
    CHECK(session->advance().stall == Stall::connecting);
    CHECK_FALSE(implausible(nothing, 256)); // a gap: the first inputs may be under way
    CHECK(session->advance().stall == Stall::local_input_missing);
    CHECK_FALSE(implausible(nothing, 0));
    CHECK_FALSE(implausible([](Message& m) { m.greeting = false; }, 2));
    session->add_local_input(0, std::array{std::byte{0}});
    const Step step = session->advance();
    const Advance& first = std::get<Advance>(step.requests.back());
    CHECK(first.inputs[1].status == InputStatus::confirmed);
    CHECK(first.inputs[1].bytes[0] == std::byte{1});
}
