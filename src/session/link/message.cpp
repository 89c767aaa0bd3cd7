#include "session/link/message.h"

#include "base/assert.h"
#include "base/bytes.h"
#include "base/hash.h"

#include <algorithm>
#include <bit>

namespace lockstone::session {

namespace {

/// Flags in the first byte of a short packet and in the fourth byte of a greeting. The lowest two bits are
/// the number of hashes; 3: the number follows in a byte of its own.
constexpr std::uint32_t flag_hashes = 3, flag_quality = 4, flag_departures = 8, flag_joins = 32,
                        flag_short = 128;
constexpr std::uint32_t flag_heard = 16;                     ///< only in greetings
constexpr std::uint64_t number_end = std::uint64_t{1} << 32; ///< limit of ticks and sequence numbers

std::uint32_t checksum(std::span<const std::byte> bytes, std::uint64_t seed) {
    return static_cast<std::uint32_t>(base::xxh3(bytes, seed));
}

/// Seed of the checksum of a short packet. It covers the fields that the packet omits.
std::uint64_t seed_of(std::uint32_t match, std::uint64_t sequence, std::uint64_t tick) {
    base::HashStream hash;
    hash.add(match);
    hash.add(static_cast<std::uint32_t>(sequence));
    hash.add(static_cast<std::uint32_t>(tick));
    return hash.digest();
}

/// The number nearest to `near` that has these low 16 bits.
std::uint64_t expanded(std::uint16_t low, std::uint64_t near) {
    const auto away =
        static_cast<std::int16_t>(static_cast<std::uint16_t>(low - static_cast<std::uint16_t>(near)));
    return near + static_cast<std::uint64_t>(std::int64_t{away});
}

/// Maps the differences 0, -1, 1, -2, ... to 0, 1, 2, 3, ...
std::uint64_t zigzag(std::uint64_t to, std::uint64_t from) {
    const std::int64_t n = static_cast<std::int64_t>(to - from);
    return static_cast<std::uint64_t>(n) << 1 ^ static_cast<std::uint64_t>(n >> 63);
}

} // namespace

std::uint32_t players_at(const SessionDef& def, PeerId machine) {
    std::uint32_t players = 0;
    for (std::uint32_t p = 0; p < def.players.size(); ++p)
        players |= def.players[p] == machine ? 1u << p : 0u;
    return players;
}

std::span<const std::byte> add_checksum(std::vector<std::byte>& buffer) {
    base::ByteWriter(buffer).u32(checksum(buffer, 0));
    return buffer;
}
std::span<const std::byte> checked_body(std::span<const std::byte> packet) {
    if (packet.size() <= checksum_bytes || packet.size() > packet_bytes_max) return {};
    const std::span<const std::byte> body = packet.first(packet.size() - checksum_bytes);
    const auto sum = base::load_little_endian<std::uint32_t>(packet.data() + body.size());
    return sum == checksum(body, 0) ? body : std::span<const std::byte>();
}

PacketContext packet_context(const SessionDef& def) {
    base::HashStream hash;
    hash.add(def.match_id);
    hash.add(def.content_id);
    hash.add(def.input_size);
    for (const PeerId peer : def.players) hash.add(peer);
    if (def.absent != 0) hash.add(def.absent);
    return {static_cast<std::uint32_t>(hash.digest()), static_cast<std::uint32_t>(def.players.size()),
            def.input_size};
}

// ---- writing -----------------------------------------------------------------------------------------------------

void PacketWriter::begin(const PacketContext& context, const Sender& sender, const Message& message) {
    buffer.clear();
    buffer.reserve(packet_bytes_max);
    input_size = context.input_size;
    tick = message.tick;
    with_checksum = message.greeting || !sender.sealed;
    seed = message.greeting ? 0 : seed_of(context.match, message.sequence, message.tick);
    told = {};
    base::ByteWriter out(buffer);
    const bool departures = (message.unwanted | message.gone) != 0;
    const std::uint32_t flags = std::min(message.hash_count, 3u) | (message.quality ? flag_quality : 0u) |
                                (departures ? flag_departures : 0u) |
                                (message.join_count != 0 ? flag_joins : 0u);
    if (message.greeting) {
        out.u16(packet_magic);
        out.u8(packet_version);
        out.u8(static_cast<std::uint8_t>(flags | (message.heard ? flag_heard : 0u)));
        out.u32(context.match);
        out.u32(static_cast<std::uint32_t>(message.sequence));
        out.u32(static_cast<std::uint32_t>(message.tick));
    } else {
        out.u8(static_cast<std::uint8_t>(flags | flag_short));
        out.u16(static_cast<std::uint16_t>(message.sequence));
        out.u16(static_cast<std::uint16_t>(message.tick));
    }
    told.head = buffer.size();
    write_body(context, sender, message);
}

void PacketWriter::write_body(const PacketContext& context, const Sender& sender, const Message& message) {
    base::ByteWriter out(buffer);
    auto part_since = [&, last = buffer.size()](std::size_t& part) mutable {
        part = buffer.size() - last;
        last = buffer.size();
    };
    for (std::uint32_t p = 0; p < context.player_count; ++p)
        if ((sender.players >> p & 1u) == 0) out.varint(zigzag(message.next_input[p], tick));
    part_since(told.acknowledgements);
    if (message.hash_count != 0) {
        if (message.hash_count > 2) out.u8(static_cast<std::uint8_t>(message.hash_count));
        out.varint(zigzag(message.hash_first, tick));
        for (std::uint32_t i = 0; i < message.hash_count; ++i) out.u32(message.hashes[i]);
    }
    part_since(told.hashes);
    if (message.quality) {
        out.varint(zigzag(message.next_hash, tick));
        out.varint(zigzag(static_cast<std::uint64_t>(std::int64_t{message.quality->ticks_ahead}), 0));
        out.u16(message.quality->sent_ms);
        out.varint(message.quality->has_echo ? message.quality->echo_held_ms + 1u : 0u);
        if (message.quality->has_echo) out.u16(message.quality->echo_ms);
    }
    part_since(told.quality);
    if ((message.unwanted | message.gone) != 0) {
        out.u16(static_cast<std::uint16_t>(message.unwanted));
        out.u16(static_cast<std::uint16_t>(message.gone));
        out.u16(static_cast<std::uint16_t>(message.has_cut));
        for (std::uint32_t p = 0; p < context.player_count; ++p)
            if ((message.has_cut >> p & 1u) != 0) out.u32(static_cast<std::uint32_t>(message.cut[p]));
        for (std::uint32_t p = 0; p < context.player_count; ++p)
            if (((message.unwanted | message.gone) >> p & 1u) != 0) out.varint(message.since[p]);
    }
    if (message.join_count != 0) {
        out.u8(static_cast<std::uint8_t>(message.join_count));
        for (const JoinWord& word : message.join_words()) {
            out.u8(static_cast<std::uint8_t>(word.player));
            out.u32(word.ticket);
            out.u8(static_cast<std::uint8_t>(word.stand));
            out.u32(static_cast<std::uint32_t>(word.tick));
        }
    }
    part_since(told.departures);
}

/// Returns the space for the code of a block that begins at byte `block_begin` of the packet [bytes].
std::size_t PacketWriter::code_room(std::size_t block_begin, std::uint32_t blocks_after) const {
    constexpr std::size_t block_head_max = 6;
    const std::size_t room = packet_bytes_max - checksum_bytes - block_begin;
    const std::size_t share = room / (blocks_after + 1);
    return share < block_head_max ? 0 : share - block_head_max;
}

std::uint32_t PacketWriter::inputs_that_fit(std::uint32_t blocks_after) const {
    return static_cast<std::uint32_t>(8 * code_room(buffer.size(), blocks_after) /
                                      input_bits_max(input_size));
}

std::size_t PacketWriter::open_block(std::uint64_t first, std::uint64_t count, std::uint32_t blocks_after) {
    block_at = buffer.size();
    buffer.push_back(std::byte{0});
    if (count == 0) return 0;
    base::ByteWriter(buffer).varint(zigzag(first, tick));
    return code_room(block_at, blocks_after);
}

void PacketWriter::close_block(std::uint32_t taken) {
    if (taken == 0) buffer.resize(block_at + 1);
    buffer[block_at] = static_cast<std::byte>(taken);
    told.inputs += buffer.size() - block_at;
}

std::span<const std::byte> PacketWriter::finish() {
    if (with_checksum) base::ByteWriter(buffer).u32(checksum(buffer, seed));
    told.checksum = with_checksum ? checksum_bytes : 0;
    LOCKSTONE_ASSERT(buffer.size() <= packet_bytes_max, buffer.size(), " bytes");
    return buffer;
}

// ---- reading -----------------------------------------------------------------------------------------------------

namespace {

/// Reads a number that is coded as its difference to the packet's tick.
std::uint64_t read_number(base::ByteReader& in, std::uint64_t tick, std::string_view what) {
    const std::uint64_t code = in.varint(what);
    if (code >= 2 * number_end) in.fail("a number is out of range");
    const std::uint64_t number = tick + (code >> 1 ^ (0 - (code & 1u)));
    if (number >= number_end) in.fail("a number is out of range");
    return in.ok() ? number : 0;
}

void read_hashes(base::ByteReader& in, std::uint32_t count, Message& out) {
    out.hash_count = count < 3 ? count : in.u8("hash count");
    if (count == 3 && (out.hash_count < 3 || out.hash_count > hashes_per_packet))
        return in.fail("hash count out of range");
    out.hash_first = read_number(in, out.tick, "first hash");
    for (std::uint32_t i = 0; i < out.hash_count; ++i) out.hashes[i] = in.u32("hash");
}

void read_quality(base::ByteReader& in, Message& out) {
    QualityReport report{};
    out.next_hash = read_number(in, out.tick, "next hash");
    const std::uint64_t ahead = in.varint("ticks ahead");
    if (ahead >= number_end) return in.fail("ticks ahead out of range");
    report.ticks_ahead = static_cast<std::int32_t>(ahead >> 1 ^ (0 - (ahead & 1u)));
    report.sent_ms = in.u16("time sent");
    const std::uint64_t held = in.varint("time held");
    if (held > 0x10000) return in.fail("time held out of range");
    report.has_echo = held != 0;
    report.echo_held_ms = static_cast<std::uint16_t>(held == 0 ? 0 : held - 1);
    report.echo_ms = held == 0 ? std::uint16_t{0} : in.u16("time echoed");
    out.quality = report;
}

/// A section without a departure is malformed.
void read_departures(base::ByteReader& in, const PacketContext& context, Message& out) {
    out.unwanted = in.u16("unwanted players");
    out.gone = in.u16("gone players");
    out.has_cut = in.u16("players with a cut");
    if ((out.unwanted | out.gone) == 0) return in.fail("no departure");
    if ((out.unwanted | out.gone) >> context.player_count != 0) return in.fail("no such player");
    if ((out.has_cut & ~out.gone) != 0) return in.fail("a last tick of a player that has not left");
    for (std::uint32_t p = 0; p < context.player_count; ++p)
        if ((out.has_cut >> p & 1u) != 0) out.cut[p] = in.u32("cut");
    for (std::uint32_t p = 0; p < context.player_count; ++p) {
        if (((out.unwanted | out.gone) >> p & 1u) == 0) continue;
        out.since[p] = in.varint("since");
        if (out.since[p] >= number_end) in.fail("since is out of range");
    }
}

/// The entries are ordered by player.
void read_joins(base::ByteReader& in, const PacketContext& context, Message& out) {
    out.join_count = in.u8("joins");
    if (out.join_count == 0 || out.join_count > context.player_count) return in.fail("joins out of range");
    for (std::uint32_t i = 0; i < out.join_count; ++i) {
        JoinWord& word = out.joins[i];
        word.player = in.u8("player");
        word.ticket = in.u32("ticket");
        const std::uint32_t stand = in.u8("stand");
        word.stand = static_cast<JoinStand>(stand);
        word.tick = in.u32("join tick");
        if (stand > 2 || word.ticket == 0 || word.player >= context.player_count)
            return in.fail("join out of range");
        if (i > 0 && word.player <= out.joins[i - 1].player) return in.fail("joins out of order");
    }
}

/// Reads the block of one player of the sender. A packet cannot carry inputs of another machine's players.
void read_block(base::ByteReader& in, const PacketContext& context, std::uint32_t player,
                std::span<const std::byte> body, Message& out) {
    constexpr std::array<std::byte, input_bytes_max> anything{};
    const std::uint32_t count = in.u8("input count");
    if (count == 0 || !in.ok()) return;
    InputBlock& block = out.blocks[out.block_count++];
    block = {player, read_number(in, out.tick, "first tick"), count, {}};
    if (!in.ok()) return;
    const std::span<const std::byte> rest = body.subspan(in.offset());
    InputDecoder inputs(rest, std::span(anything).first(context.input_size));
    for (std::uint32_t i = 0; i < count; ++i) inputs.next();
    const std::size_t bytes = inputs.end();
    if (!inputs.ok()) return in.fail("inputs are not coded as they must be");
    block.code = in.bytes(bytes, "inputs");
}

/// Reads the head of a greeting or of a short packet.
std::optional<PacketFault> read_head(base::ByteReader& in, const PacketContext& context, const Sender& sender,
                                     std::uint32_t& flags, Message& out) {
    if (out.greeting) {
        in.u16("magic");
        in.u8("version");
        flags = in.u8("flags");
        if (in.u32("match") != context.match) return PacketFault::match;
        out.heard = (flags & flag_heard) != 0;
        flags &= ~flag_heard;
        out.sequence = in.u32("sequence");
        out.tick = in.u32("tick");
    } else {
        flags = in.u8("flags") & ~flag_short;
        out.heard = true;
        out.sequence = expanded(in.u16("sequence"), sender.sequence);
        out.tick = expanded(in.u16("tick"), sender.tick);
    }
    const std::uint32_t known = flag_hashes | flag_quality | flag_departures | flag_joins;
    if ((flags & ~known) != 0 || out.sequence >= number_end || out.tick >= number_end)
        return PacketFault::malformed;
    return in.ok() ? std::nullopt : std::optional(PacketFault::malformed);
}

/// Checks the checksum, except in short packets of an authenticated transport, and removes it from `body`.
bool is_whole(const PacketContext& context, const Sender& sender, bool greeting,
              std::span<const std::byte>& body) {
    if (!greeting && sender.sealed) return true;
    if (body.size() < checksum_bytes + 5) return false;
    const std::byte* at = body.data();
    body = body.first(body.size() - checksum_bytes);
    const std::uint64_t seed =
        greeting ? 0
                 : seed_of(context.match,
                           expanded(base::load_little_endian<std::uint16_t>(at + 1), sender.sequence),
                           expanded(base::load_little_endian<std::uint16_t>(at + 3), sender.tick));
    return base::load_little_endian<std::uint32_t>(at + body.size()) == checksum(body, seed);
}

} // namespace

std::optional<PacketFault> decode(std::span<const std::byte> bytes, const PacketContext& context,
                                  const Sender& sender, Message& out) {
    if (bytes.empty() || bytes.size() > packet_bytes_max) return PacketFault::damaged;
    out.greeting = (std::to_integer<std::uint32_t>(bytes[0]) & flag_short) == 0;
    std::span<const std::byte> body = bytes;
    if (!is_whole(context, sender, out.greeting, body)) return PacketFault::damaged;
    if (out.greeting) {
        if (base::load_little_endian<std::uint16_t>(body.data()) != packet_magic) return PacketFault::damaged;
        if (body[2] != std::byte{packet_version}) return PacketFault::version;
    }
    base::ByteReader in(body, "packet");
    std::uint32_t flags = 0;
    if (const auto fault = read_head(in, context, sender, flags, out)) return fault;
    for (std::uint32_t p = 0; p < context.player_count; ++p)
        out.next_input[p] = (sender.players >> p & 1u) != 0 ? 0 : read_number(in, out.tick, "next input");
    out.hash_count = out.block_count = 0;
    out.hash_first = out.next_hash = 0;
    out.quality.reset();
    out.unwanted = out.gone = out.has_cut = 0;
    out.join_count = 0;
    if ((flags & flag_hashes) != 0) read_hashes(in, flags & flag_hashes, out);
    if ((flags & flag_quality) != 0) read_quality(in, out);
    if ((flags & flag_departures) != 0) read_departures(in, context, out);
    if ((flags & flag_joins) != 0 && in.ok()) read_joins(in, context, out);
    for (std::uint32_t p = 0; p < context.player_count; ++p)
        if ((sender.players >> p & 1u) != 0) read_block(in, context, p, body, out);
    in.expect_end();
    if (!in.ok()) return PacketFault::malformed;
    return std::nullopt;
}

} // namespace lockstone::session
