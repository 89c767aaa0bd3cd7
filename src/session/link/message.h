// The packet format of README.md: encoding, and decoding of untrusted bytes.
#pragma once

#include "session/inputs/input_code.h"

#include <algorithm>

namespace lockstone::session {

inline constexpr std::uint16_t packet_magic = 0x534c; // "LS"
inline constexpr std::uint8_t packet_version = 4;
inline constexpr std::size_t checksum_bytes = 4;
/// Maximum number of hashes in a packet.
inline constexpr std::uint32_t hashes_per_packet = 16;
/// Maximum number of inputs of one player in a packet.
inline constexpr std::uint32_t inputs_per_block = 255;

/// Data that must be equal in all packets between two machines.
struct PacketContext {
    std::uint32_t match; ///< digest of the match, the game and the list of players
    std::uint32_t player_count;
    std::uint32_t input_size;
};
PacketContext packet_context(const SessionDef& def);

/// Appends the low half of XXH3-64 of all bytes before it. For the packets outside message.cpp.
std::span<const std::byte> add_checksum(std::vector<std::byte>& buffer);
/// The bytes before the checksum; empty: a wrong checksum, or a packet longer than packet_bytes_max.
std::span<const std::byte> checked_body(std::span<const std::byte> packet);

/// The sender of a packet, and what the receiver knows of it.
struct Sender {
    std::uint32_t players;                ///< bit p: player p plays on this machine
    bool sealed = false;                  ///< Transport::authenticated(): short packets have no checksum
    std::uint64_t sequence = 0, tick = 0; ///< newest received ones: short packets hold the low 16 bits only
};
std::uint32_t players_at(const SessionDef& def, PeerId machine); ///< Bit p: player p plays on this machine.

/// Consecutive inputs of one player in the code of input_code.h.
struct InputBlock {
    std::uint32_t player;
    std::uint64_t first; ///< tick of the first input
    std::uint32_t count; ///< number of inputs, 1..255
    std::span<const std::byte> code;
};

/// Measurements of the connection.
struct QualityReport {
    std::int32_t ticks_ahead;   ///< the sender's tick minus the newest tick of the receiver that it knows
    std::uint16_t sent_ms;      ///< the sender's clock [ms], low 16 bits
    bool has_echo;              ///< the fields below are valid
    std::uint16_t echo_ms;      ///< the newest sent_ms of the receiver
    std::uint16_t echo_held_ms; ///< time since it arrived [ms]
};

/// A machine's answer to a request for a seat.
enum class JoinStand : std::uint8_t {
    no,    ///< refused: final for this ticket
    yes,   ///< accepted, from the tick in the word or from a later one of another machine
    ready, ///< all machines have announced this tick; final
};
/// The answer of one machine, as it announces it to the others.
struct JoinWord {
    std::uint32_t player = 0; ///< the first player of the joining machine
    std::uint32_t ticket = 0;
    JoinStand stand = JoinStand::no;
    std::uint64_t tick = 0; ///< first tick with the inputs of the joining machine

    friend bool operator==(const JoinWord&, const JoinWord&) = default;
};

/// Content of a packet.
struct Message {
    bool greeting;          ///< the long form, used until the receiver is known to have heard the sender
    bool heard;             ///< the sender has heard the receiver; always true in the short form
    std::uint64_t sequence; ///< number of the packet among those of the sender to this receiver, from 1
    std::uint64_t tick;     ///< the sender's next new tick
    std::uint32_t unwanted; ///< bit p: the sender votes for the machine of player p to leave
    std::uint32_t gone;     ///< bit p: the machine of player p has left for the sender
    std::uint32_t has_cut;  ///< bit p: cut[p] holds the tick at which player p left
    std::array<std::uint64_t, players_max> cut;
    /// [player] of `unwanted` and `gone`: the tick of the player's last join as the sender knows it; 0: the
    /// start.
    std::array<std::uint64_t, players_max> since;
    std::array<JoinWord, players_max> joins;
    std::uint32_t join_count;
    /// [player] First tick whose input the sender lacks; 0 for its own players.
    std::array<std::uint64_t, players_max> next_input;
    std::uint64_t next_hash; ///< first tick whose hash the sender lacks; sent with `quality`, else 0
    std::array<InputBlock, players_max> blocks;
    std::uint32_t block_count;
    std::uint64_t hash_first; ///< tick of the first hash
    std::uint32_t hash_count;
    std::array<std::uint32_t, hashes_per_packet> hashes; ///< of confirmed ticks: low half of the root hash
    std::optional<QualityReport> quality;

    std::span<const JoinWord> join_words() const { return {joins.data(), join_count}; }
    std::span<const InputBlock> input_blocks() const { return {blocks.data(), block_count}; }
};

/// Calls visit(tick, bytes) for each input of a block. `before`: the input before the first one, zeros
/// before tick 0.
template <class Visit>
void for_each_input(const InputBlock& block, std::span<const std::byte> before, Visit&& visit) {
    InputDecoder inputs(block.code, before);
    for (std::uint32_t i = 0; i < block.count; ++i) visit(block.first + i, inputs.next());
}

/// Sizes of the parts of a packet [bytes], for a test that prints them.
struct PacketParts {
    std::size_t head, acknowledgements, hashes, quality, departures, inputs, checksum;
};

/// Builds packets in a buffer that it reuses.
class PacketWriter {
  public:
    /// Starts a packet with all of `message` except its input blocks. Call add_inputs() or add_no_inputs()
    /// next, once for each player of the sender, in order.
    void begin(const PacketContext& context, const Sender& sender, const Message& message);
    /// Number of inputs of any value that fit into the next block if `blocks_after` further blocks take as
    /// much space.
    std::uint32_t inputs_that_fit(std::uint32_t blocks_after) const;
    /// Adds a block with as many of the inputs input_of(first), input_of(first + 1), ... as fit, at most
    /// `count`, if `blocks_after` further blocks take as much space. `before`: as in for_each_input().
    template <class InputOf>
    void add_inputs(std::uint64_t first, std::uint64_t count, std::uint32_t blocks_after,
                    std::span<const std::byte> before, InputOf&& input_of) {
        const std::size_t bytes_max = open_block(first, count, blocks_after);
        InputEncoder code(buffer, before);
        std::uint32_t taken = 0;
        while (taken < std::min<std::uint64_t>(count, inputs_per_block) &&
               code.add(input_of(first + taken), bytes_max))
            ++taken;
        close_block(taken);
    }
    /// Adds an empty block.
    void add_no_inputs() { buffer.push_back(std::byte{0}); }
    /// Ends the packet and returns it; valid until the next begin().
    std::span<const std::byte> finish();
    const PacketParts& parts() const { return told; } ///< Sizes of the parts of the last finished packet.

  private:
    void write_body(const PacketContext& context, const Sender& sender, const Message& message);
    std::size_t code_room(std::size_t block_begin, std::uint32_t blocks_after) const;
    std::size_t open_block(std::uint64_t first, std::uint64_t count, std::uint32_t blocks_after);
    void close_block(std::uint32_t taken);

    std::vector<std::byte> buffer;
    std::uint32_t input_size = 0;
    std::uint64_t tick = 0, seed = 0;
    bool with_checksum = true;
    std::size_t block_at = 0;
    PacketParts told{};
};

/// Reads a packet and checks each field against the format. The views in `out` point into `bytes`. Returns
/// why the packet is invalid; empty: it is valid. Never asserts.
std::optional<PacketFault> decode(std::span<const std::byte> bytes, const PacketContext& context,
                                  const Sender& sender, Message& out);

} // namespace lockstone::session
