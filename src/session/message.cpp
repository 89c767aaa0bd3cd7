#include "session/message.h"

#include "base/assert.h"
#include "base/bytes.h"
#include "base/hash.h"

#include <algorithm>

namespace lockstone::session {

namespace {

enum Section : std::uint8_t {
    section_hashes = 1,
    section_quality = 2,
    section_departures = 4,
    sections_known = 7
};

constexpr std::size_t block_header_bytes = 6;
constexpr std::size_t checksum_bytes = 4;
constexpr std::size_t shortest_packet = 16;

std::uint32_t checksum(std::span<const std::byte> bytes) {
    return static_cast<std::uint32_t>(base::xxh3(bytes));
}

std::size_t repeat_bytes(std::size_t inputs) { return (inputs + 7) / 8; }

} // namespace

PacketContext packet_context(const SessionDef& def) {
    base::HashStream hash;
    hash.add(def.match_id);
    hash.add(def.content_id);
    hash.add(def.input_size);
    for (const PeerId peer : def.players) hash.add(peer);
    return {static_cast<std::uint32_t>(hash.digest()), static_cast<std::uint32_t>(def.players.size()),
            def.input_size};
}

// ---- writing -----------------------------------------------------------------------------------------------------

void PacketWriter::begin(const PacketContext& context, const Message& message) {
    buffer.clear();
    buffer.reserve(packet_bytes_max);
    input_size = context.input_size;
    base::ByteWriter out(buffer);
    out.u16(packet_magic);
    out.u8(packet_version);
    const bool departures = (message.unwanted | message.gone) != 0;
    out.u8(static_cast<std::uint8_t>((message.hash_count != 0 ? section_hashes : 0) |
                                     (message.quality ? section_quality : 0) |
                                     (departures ? section_departures : 0)));
    out.u32(context.match);
    out.u32(static_cast<std::uint32_t>(message.sequence));
    out.u32(static_cast<std::uint32_t>(message.tick));
    for (std::uint32_t p = 0; p < context.player_count; ++p)
        out.u32(static_cast<std::uint32_t>(message.next_input[p]));
    out.u32(static_cast<std::uint32_t>(message.next_hash));
    if (message.hash_count != 0) {
        out.u32(static_cast<std::uint32_t>(message.hash_first));
        out.u8(static_cast<std::uint8_t>(message.hash_count));
        for (std::uint32_t i = 0; i < message.hash_count; ++i) out.u64(message.hashes[i]);
    }
    if (message.quality) {
        out.i32(message.quality->ticks_ahead);
        out.u32(message.quality->sent_ms);
        out.u32(message.quality->echo_ms);
        out.u32(message.quality->echo_held_ms);
    }
    if (departures) {
        out.u16(static_cast<std::uint16_t>(message.unwanted));
        out.u16(static_cast<std::uint16_t>(message.gone));
        out.u16(static_cast<std::uint16_t>(message.has_cut));
        for (std::uint32_t p = 0; p < context.player_count; ++p)
            if ((message.has_cut >> p & 1u) != 0) out.u32(static_cast<std::uint32_t>(message.cut[p]));
    }
    block_count_at = buffer.size();
    out.u8(0);
}

std::uint32_t PacketWriter::open_block(std::uint32_t player, std::uint64_t first, std::uint64_t count,
                                       std::uint32_t blocks_after) {
    const auto block_bytes = [&](std::uint32_t inputs) { // as if none repeated: what is promised must fit
        return block_header_bytes + repeat_bytes(inputs) + std::size_t{inputs} * input_size;
    };
    const std::size_t share = (packet_bytes_max - checksum_bytes - buffer.size()) / (blocks_after + 1);
    std::uint32_t taken = static_cast<std::uint32_t>(std::min<std::uint64_t>(count, inputs_per_block));
    while (taken > 0 && block_bytes(taken) > share) --taken;
    if (taken == 0) return 0;
    base::ByteWriter out(buffer);
    out.u8(static_cast<std::uint8_t>(player));
    out.u32(static_cast<std::uint32_t>(first));
    out.u8(static_cast<std::uint8_t>(taken));
    repeats_at = buffer.size();
    buffer.resize(buffer.size() + repeat_bytes(taken));
    buffer[block_count_at] = static_cast<std::byte>(std::to_integer<unsigned>(buffer[block_count_at]) + 1u);
    return taken;
}

void PacketWriter::append_input(std::uint32_t index, std::span<const std::byte> input) {
    const bool repeats = index > 0 && std::ranges::equal(input, std::span(previous).first(input.size()));
    if (repeats) {
        buffer[repeats_at + index / 8] |= static_cast<std::byte>(1u << (index % 8));
    } else {
        buffer.insert(buffer.end(), input.begin(), input.end());
        std::ranges::copy(input, previous.begin());
    }
}

std::span<const std::byte> PacketWriter::finish() {
    base::ByteWriter(buffer).u32(checksum(buffer));
    LOCKSTONE_ASSERT(buffer.size() <= packet_bytes_max, buffer.size(), " bytes");
    return buffer;
}

// ---- reading -----------------------------------------------------------------------------------------------------

namespace {

void read_hashes(base::ByteReader& in, Message& out) {
    out.hash_first = in.u32("first hash");
    out.hash_count = in.u8("hash count");
    if (out.hash_count == 0 || out.hash_count > hashes_per_packet) return in.fail("hash count out of range");
    for (std::uint32_t i = 0; i < out.hash_count; ++i) out.hashes[i] = in.u64("hash");
}

void read_quality(base::ByteReader& in, Message& out) {
    QualityReport report{};
    report.ticks_ahead = in.i32("ticks ahead");
    report.sent_ms = in.u32("time sent");
    report.echo_ms = in.u32("time echoed");
    report.echo_held_ms = in.u32("time held");
    out.quality = report;
}

/// Only what is to be told: a section without a departure is malformed.
void read_departures(base::ByteReader& in, const PacketContext& context, Message& out) {
    out.unwanted = in.u16("unwanted players");
    out.gone = in.u16("gone players");
    out.has_cut = in.u16("players with a cut");
    if ((out.unwanted | out.gone) == 0) return in.fail("no departure");
    if ((out.unwanted | out.gone) >> context.player_count != 0) return in.fail("no such player");
    if ((out.has_cut & ~out.gone) != 0) return in.fail("a cut of a player who has not left");
    for (std::uint32_t p = 0; p < context.player_count; ++p)
        if ((out.has_cut >> p & 1u) != 0) out.cut[p] = in.u32("cut");
}

/// Repeats are canonical: the first input is never a repeat, and the bits after the last are zero.
void read_block(base::ByteReader& in, const PacketContext& context, InputBlock& out) {
    out.player = in.u8("player");
    out.first = in.u32("first tick");
    out.count = in.u8("input count");
    if (!in.ok()) return;
    if (out.player >= context.player_count) return in.fail("no such player");
    if (out.count == 0) return in.fail("empty block");
    out.repeats = in.bytes(repeat_bytes(out.count), "repeat bits");
    if (!in.ok()) return;
    std::uint32_t repeated = 0;
    for (std::uint32_t i = 0; i < out.repeats.size() * 8; ++i) {
        const bool set = (std::to_integer<std::uint32_t>(out.repeats[i / 8]) >> (i % 8) & 1u) != 0;
        if (set && (i == 0 || i >= out.count)) return in.fail("repeat bit out of place");
        repeated += set ? 1 : 0;
    }
    out.bytes = in.bytes(std::uint64_t{out.count - repeated} * context.input_size, "inputs");
}

void read_blocks(base::ByteReader& in, const PacketContext& context, Message& out) {
    out.block_count = in.u8("block count");
    if (out.block_count > context.player_count) return in.fail("more blocks than players");
    for (std::uint32_t i = 0; i < out.block_count && in.ok(); ++i) {
        read_block(in, context, out.blocks[i]);
        if (i > 0 && out.blocks[i].player <= out.blocks[i - 1].player) in.fail("players out of order");
    }
}

} // namespace

std::optional<PacketFault> decode(std::span<const std::byte> bytes, const PacketContext& context,
                                  Message& out) {
    if (bytes.size() < shortest_packet || bytes.size() > packet_bytes_max) return PacketFault::damaged;
    const std::span<const std::byte> body = bytes.first(bytes.size() - checksum_bytes);
    if (base::load_little_endian<std::uint32_t>(body.data() + body.size()) != checksum(body))
        return PacketFault::damaged;

    base::ByteReader in(body, "packet");
    if (in.u16("magic") != packet_magic) return PacketFault::damaged;
    if (in.u8("version") != packet_version) return PacketFault::version;
    const std::uint8_t sections = in.u8("sections");
    if (in.u32("match") != context.match) return PacketFault::match;
    if ((sections & ~sections_known) != 0) return PacketFault::malformed;

    out.sequence = in.u32("sequence");
    out.tick = in.u32("tick");
    for (std::uint32_t p = 0; p < context.player_count; ++p) out.next_input[p] = in.u32("next input");
    out.next_hash = in.u32("next hash");
    out.hash_count = 0;
    out.hash_first = 0;
    out.quality.reset();
    out.unwanted = out.gone = out.has_cut = 0;
    if ((sections & section_hashes) != 0) read_hashes(in, out);
    if ((sections & section_quality) != 0) read_quality(in, out);
    if ((sections & section_departures) != 0) read_departures(in, context, out);
    read_blocks(in, context, out);
    in.expect_end();
    if (!in.ok()) return PacketFault::malformed;
    return std::nullopt;
}

} // namespace lockstone::session
