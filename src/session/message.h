// The packet format, as README.md specifies it: encoding, and decoding of bytes that nobody vouches for.
#pragma once

#include "lockstone/session.h"

namespace lockstone::session {

inline constexpr std::uint16_t packet_magic = 0x534c; // "LS"
inline constexpr std::uint8_t packet_version = 2;
inline constexpr std::uint32_t hashes_per_packet = 16;
inline constexpr std::uint32_t inputs_per_block = 255;

/// What every packet of a session must agree on.
struct PacketContext {
    std::uint32_t match; ///< digest of the match, the game and the line-up
    std::uint32_t player_count;
    std::uint32_t input_size;
};
PacketContext packet_context(const SessionDef& def);

/// Consecutive inputs of one player.
struct InputBlock {
    std::uint32_t player;
    std::uint64_t first;                ///< tick
    std::uint32_t count;                ///< 1..255
    std::span<const std::byte> repeats; ///< bit i: input i equals input i - 1, and is left out of `bytes`
    std::span<const std::byte> bytes;
};

struct QualityReport {
    std::int32_t ticks_ahead;   ///< sender's tick minus the newest receiver's tick it knows of
    std::uint32_t sent_ms;      ///< sender's clock, low 32 bits
    std::uint32_t echo_ms;      ///< the newest sent_ms that came from the receiver
    std::uint32_t echo_held_ms; ///< how long ago that was
};

struct Message {
    std::uint64_t sequence;                            ///< of the sender's packets to this receiver, from 1
    std::uint64_t tick;                                ///< the sender's next new tick
    std::uint32_t unwanted; ///< bit p: the sender wants player p's machine to leave
    std::uint32_t gone;     ///< bit p: for the sender it has left
    std::uint32_t has_cut;  ///< bit p: the sender tells in cut[p] at which tick player p left
    std::array<std::uint64_t, players_max> cut;
    std::array<std::uint64_t, players_max> next_input; ///< by player: first tick whose input the sender lacks
    std::uint64_t next_hash;                           ///< first tick whose hash the sender lacks
    std::array<InputBlock, players_max> blocks;
    std::uint32_t block_count;
    std::uint64_t hash_first; ///< tick
    std::uint32_t hash_count;
    std::array<std::uint64_t, hashes_per_packet> hashes; ///< of confirmed ticks
    std::optional<QualityReport> quality;

    std::span<const InputBlock> input_blocks() const { return {blocks.data(), block_count}; }
};

/// Walks a block's inputs: visit(tick, bytes).
template <class Visit> void for_each_input(const InputBlock& block, std::uint32_t input_size, Visit&& visit) {
    std::size_t next = 0;
    std::span<const std::byte> input;
    for (std::uint32_t i = 0; i < block.count; ++i) {
        const bool repeats = (std::to_integer<std::uint32_t>(block.repeats[i / 8]) >> (i % 8) & 1u) != 0;
        if (!repeats) {
            input = block.bytes.subspan(next, input_size);
            next += input_size;
        }
        visit(block.first + i, input);
    }
}

/// Builds one packet in a buffer that is reused.
class PacketWriter {
  public:
    /// Starts a packet with everything of `message` but its input blocks.
    void begin(const PacketContext& context, const Message& message);
    /// Adds inputs `first`, `first + 1`... as input_of(tick) gives them, as many of `count` as fit when `blocks_after`
    /// further blocks want as much room.
    template <class InputOf>
    void add_inputs(std::uint32_t player, std::uint64_t first, std::uint64_t count,
                    std::uint32_t blocks_after, InputOf&& input_of) {
        std::uint32_t taken = open_block(player, first, count, blocks_after);
        for (std::uint32_t i = 0; i < taken; ++i) append_input(i, input_of(first + i));
    }
    /// Ends the packet; valid until the next begin.
    std::span<const std::byte> finish();

  private:
    std::uint32_t open_block(std::uint32_t player, std::uint64_t first, std::uint64_t count,
                             std::uint32_t blocks_after);
    void append_input(std::uint32_t index, std::span<const std::byte> input);

    std::vector<std::byte> buffer;
    std::uint32_t input_size = 0;
    std::size_t block_count_at = 0;
    std::size_t repeats_at = 0;
    std::array<std::byte, input_bytes_max> previous{};
};

/// Checks every field against the format; the views of `out` point into `bytes`. Never asserts, whatever the bytes.
std::optional<PacketFault> decode(std::span<const std::byte> bytes, const PacketContext& context,
                                  Message& out);

} // namespace lockstone::session
