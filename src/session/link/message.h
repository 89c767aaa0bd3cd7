// The packet format, as README.md specifies it: encoding, and decoding of bytes that nobody vouches for.
#pragma once

#include "session/inputs/input_code.h"

#include <algorithm>

namespace lockstone::session {

inline constexpr std::uint16_t packet_magic = 0x534c; // "LS"
inline constexpr std::uint8_t packet_version = 4;
inline constexpr std::size_t checksum_bytes = 4;
inline constexpr std::uint32_t hashes_per_packet = 16;
inline constexpr std::uint32_t inputs_per_block = 255;

/// What every packet of a session must agree on.
struct PacketContext {
    std::uint32_t match; ///< digest of the match, the game and the line-up
    std::uint32_t player_count;
    std::uint32_t input_size;
};
PacketContext packet_context(const SessionDef& def);

/// Appends the low half of XXH3-64 of all before it: of packets that are not those of message.cpp.
std::span<const std::byte> add_checksum(std::vector<std::byte>& buffer);
/// What is before the checksum, which is right; empty where it is not, or where the packet is longer than packet_bytes_max.
std::span<const std::byte> checked_body(std::span<const std::byte> packet);

/// The one machine that a packet is from, and what its receiver knows of it.
struct Sender {
    std::uint32_t players;                ///< bit p: player p plays there
    bool sealed = false;                  ///< Transport::authenticated: short packets have no checksum
    std::uint64_t sequence = 0, tick = 0; ///< newest ones heard: short packets hold the lowest 16 bits
};
std::uint32_t players_at(const SessionDef& def, PeerId machine); ///< bit p: player p plays there

/// Consecutive inputs of one player, as input_code.h tells.
struct InputBlock {
    std::uint32_t player;
    std::uint64_t first; ///< tick
    std::uint32_t count; ///< 1..255
    std::span<const std::byte> code;
};

struct QualityReport {
    std::int32_t ticks_ahead;   ///< sender's tick minus the newest receiver's tick it knows of
    std::uint16_t sent_ms;      ///< sender's clock, low 16 bits
    bool has_echo;              ///< the rest says something
    std::uint16_t echo_ms;      ///< the newest sent_ms that came from the receiver
    std::uint16_t echo_held_ms; ///< how long ago that was
};

/// What a machine says to another one's wish to come in.
enum class JoinStand : std::uint8_t {
    no,    ///< not with this ticket, ever
    yes,   ///< from the tick that it tells, or from a later one that others tell
    ready, ///< all have told this tick; it is final
};
struct JoinWord {
    std::uint32_t player = 0; ///< the first of the machine that comes
    std::uint32_t ticket = 0;
    JoinStand stand = JoinStand::no;
    std::uint64_t tick = 0; ///< where its inputs count from

    friend bool operator==(const JoinWord&, const JoinWord&) = default;
};

struct Message {
    bool greeting;          ///< the long form: until the receiver is known to have heard the sender
    bool heard;             ///< the sender has heard the receiver; always true of the short form
    std::uint64_t sequence; ///< of the sender's packets to this receiver, from 1
    std::uint64_t tick;     ///< the sender's next new tick
    std::uint32_t unwanted; ///< bit p: the sender wants player p's machine to leave
    std::uint32_t gone;     ///< bit p: for the sender it has left
    std::uint32_t has_cut;  ///< bit p: the sender tells in cut[p] at which tick player p left
    std::array<std::uint64_t, players_max> cut;
    /// Of those players: where the sender says they came in last; 0: the start
    std::array<std::uint64_t, players_max> since;
    std::array<JoinWord, players_max> joins;
    std::uint32_t join_count;
    /// By player: first tick whose input the sender lacks. Of its own players 0: it has them.
    std::array<std::uint64_t, players_max> next_input;
    std::uint64_t next_hash; ///< first tick whose hash the sender lacks; told with `quality`, else 0
    std::array<InputBlock, players_max> blocks;
    std::uint32_t block_count;
    std::uint64_t hash_first; ///< tick
    std::uint32_t hash_count;
    std::array<std::uint32_t, hashes_per_packet> hashes; ///< of confirmed ticks: low half of the root hash
    std::optional<QualityReport> quality;

    std::span<const JoinWord> join_words() const { return {joins.data(), join_count}; }
    std::span<const InputBlock> input_blocks() const { return {blocks.data(), block_count}; }
};

/// Walks a block's inputs: visit(tick, bytes). `before`: the input of the tick before the first, zeros before tick 0.
template <class Visit>
void for_each_input(const InputBlock& block, std::span<const std::byte> before, Visit&& visit) {
    InputDecoder inputs(block.code, before);
    for (std::uint32_t i = 0; i < block.count; ++i) visit(block.first + i, inputs.next());
}

/// How many bytes of a packet say what, for the ledger of the tests.
struct PacketParts {
    std::size_t head, acknowledgements, hashes, quality, departures, inputs, checksum;
};

/// Builds one packet in a buffer that is reused.
class PacketWriter {
  public:
    /// Starts a packet with everything of `message` but its input blocks. add_inputs follows for each player of the
    /// sender, in order.
    void begin(const PacketContext& context, const Sender& sender, const Message& message);
    /// The number of inputs that fit into the next block whatever their values, when `blocks_after` further blocks take as much room.
    std::uint32_t inputs_that_fit(std::uint32_t blocks_after) const;
    /// Adds inputs `first`, `first + 1`... as input_of(tick) gives them, as many of `count` as fit when `blocks_after`
    /// further blocks want as much room. `before`: as in for_each_input.
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
    void add_no_inputs() { buffer.push_back(std::byte{0}); }
    /// Ends the packet; valid until the next begin.
    std::span<const std::byte> finish();
    const PacketParts& parts() const { return told; } ///< of the packet that was finished last

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

/// Checks every field against the format; the views of `out` point into `bytes`. Never asserts, whatever the bytes.
std::optional<PacketFault> decode(std::span<const std::byte> bytes, const PacketContext& context,
                                  const Sender& sender, Message& out);

} // namespace lockstone::session
