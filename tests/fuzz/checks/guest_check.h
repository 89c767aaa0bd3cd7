// The rules for packets of machines outside the match and for packets about desyncs, with arbitrary bytes. The fuzzer
// and the tests that replay its inputs use them. Byte 0: the kind of packet (modulo 7); from 128 on the checksum is
// made valid. The rest: the packet.
#pragma once

#include "fuzz/edits.h"
#include "session/desync/inspection.h"
#include "session/seal.h"
#include "session/timeline.h"

#include <algorithm>

namespace fuzz {

using namespace lockstone;

inline constexpr std::uint32_t guest_match = 0x01020304;
inline constexpr std::array<std::uint8_t, 7> guest_kinds{0x57, 0x54, 0x4f, 0x43, 0x48, 0x52, 0x51};

/// A decoded packet must encode to equal bytes, and an accepted chunk must match the offer. Returns an error sentence
/// or an empty string.
inline std::string check_guest_packet(std::span<const std::byte> data) {
    Input in(data);
    const std::uint8_t how = in.take_u8();
    const std::span<const std::byte> rest = in.take_rest();
    Buffer packet(rest.begin(), rest.end()), again;
    if (how >= 128 && packet.size() >= 9) {
        packet[0] = std::byte{guest_kinds[how % 7]};
        base::store_little_endian(guest_match, packet.data() + (how % 7 == 6 ? 2 : 1));
        const std::span<std::byte> body = std::span(packet).first(packet.size() - 4);
        base::store_little_endian(static_cast<std::uint32_t>(hash_bytes(body)), packet.data() + body.size());
    }
    const auto same = [&](std::span<const std::byte> written) { return std::ranges::equal(written, packet); };
    constexpr std::uint32_t match = guest_match, players = 3;
    if (const auto wish = session::read_wish(packet, match);
        wish && !same(session::write_wish(again, match, *wish)))
        return "a wish is written otherwise than it is read";
    if (const auto stretch = session::read_stretch(packet, match, 14);
        stretch && !same(session::write_stretch(again, match, *stretch)))
        return "a stretch is written otherwise than it is read";
    if (const auto offer = session::read_offer(packet, match)) {
        if (!same(session::write_offer(again, match, *offer)))
            return "an offer is written otherwise than it is read";
        if (offer->bytes > session::state_bytes_limit) return "an offer is larger than any may be";
    }
    if (const auto chunk = session::read_chunk(packet, match)) {
        if (!same(session::write_chunk(again, match, *chunk)))
            return "a chunk is written otherwise than it is read";
        const session::Snapshot snapshot(7, 8, Buffer(5000));
        session::Assembly assembly(snapshot.offer());
        if (assembly.take(*chunk) &&
            std::ranges::any_of(chunk->bytes, [](std::byte b) { return b != std::byte{}; }))
            return "a chunk was taken that is not of the state";
    }
    if (const auto word = session::read_word(packet, match);
        word && !same(session::write_word(again, match, *word)))
        return "a word is written otherwise than it is read";
    if (const auto admission = session::read_admission(packet, match, players);
        admission && !same(session::write_admission(again, match, players, *admission)))
        return "an admission is written otherwise than it is read";
    std::optional<session::Question> question;
    std::optional<session::Answer> answer;
    if (session::read_inspection(packet, {match, players, 4}, question, answer)) {
        return question || answer ? "a refused inspection was read all the same" : "";
    }
    if (session::is_inspection(packet) && question &&
        !same(session::write_question(again, {match, players, 4}, *question)))
        return "a question is written otherwise than it is read";
    return {};
}

/// One valid packet of each kind, and one of each kind with a wrong byte.
inline std::vector<Seed> guest_seeds() {
    Buffer b;
    session::Chunk chunk;
    const session::Snapshot snapshot(7, 8, Buffer(5000));
    snapshot.chunk(2, chunk);
    std::vector<Buffer> packets;
    const auto add = [&](std::span<const std::byte> bytes) {
        packets.emplace_back(bytes.begin(), bytes.end());
    };
    add(session::write_wish(b, guest_match, {.wants_state = true, .ticket = 256, .wanted = 7, .asked = 6}));
    add(session::write_stretch(b, guest_match, {5, 1, 9, Buffer(14)}));
    add(session::write_offer(b, guest_match, snapshot.offer()));
    add(session::write_chunk(b, guest_match, chunk));
    add(session::write_word(b, guest_match, {5, 6}));
    add(session::write_admission(b, guest_match, 3, {256, 90, {}}));
    add(session::write_question(b, {guest_match, 3, 4}, {5, session::Topic::pages, 1, 2, 3}));
    std::vector<Seed> all;
    for (std::uint8_t kind = 0; kind < packets.size(); ++kind) {
        const std::string name = "kind_" + std::to_string(kind);
        all.push_back({name + "_good", Script().u8(0).bytes(packets[kind]).done()});
        packets[kind][packets[kind].size() / 2] ^= std::byte{0x80};
        const auto how = static_cast<std::uint8_t>(133 + (kind + 7 - 133 % 7) % 7);
        all.push_back({name + "_changed", Script().u8(how).bytes(packets[kind]).done()});
    }
    return all;
}

} // namespace fuzz
