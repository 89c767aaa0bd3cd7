// A block of ticks: the writer collects and packs it, the reader unpacks it.
#pragma once

#include "lockstone/game.h"
#include "replay/format/format.h"

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

namespace lockstone::base {
class ByteReader; // installed headers use no header of src
}

namespace lockstone::replay {

/// The format of a block's rows, from the header.
struct BlockShape {
    Mode mode = Mode::inputs;
    std::uint32_t player_count = 0;
    std::uint32_t input_size = 0;
    /// Bytes of a row of the input table: for each player a status byte and the input.
    std::size_t input_row_bytes() const { return std::size_t{player_count} * (1 + input_size); }
};

/// Collects ticks, which are then written as one TICK chunk.
class BlockBuilder {
  public:
    explicit BlockBuilder(BlockShape block_shape) : shape(block_shape) {}

    /// Adds the players' inputs of the next tick, and the hash after it. Fails for predicted inputs and wrong sizes.
    Status add_inputs(std::span<const PlayerInput> inputs, std::uint64_t hash);
    /// Adds the commands before the next tick, and the hash after it.
    Status add_commands(std::span<const Command> commands, std::uint64_t hash);

    std::uint32_t ticks() const { return static_cast<std::uint32_t>(hashes.size()); }
    std::size_t unpacked_bytes() const;
    /// Appends the payload of TICK, and starts a new block.
    void finish(std::uint64_t first_tick, std::vector<std::byte>& out);

  private:
    BlockShape shape;
    std::vector<std::uint64_t> hashes;
    std::vector<std::byte> input_rows;
    std::vector<std::byte> count_rows, kind_rows;
    std::map<std::size_t, std::vector<std::byte>> field_rows; ///< by kind
};

/// An unpacked block. read() has checked everything, so access cannot fail.
class TickBlock {
  public:
    TickBlock() = default;
    /// Reads the payload of TICK up to the end of `in`; errors stay in `in`. Allocates at most memory_per_byte for
    /// each byte of the declared unpacked size, and no more than `limits` allow.
    static TickBlock read(base::ByteReader& in, BlockShape shape, const Limits& limits);
    static constexpr std::uint64_t memory_per_byte = 4;
    /// The offset of the hashes in the payload: after first tick, count and unpacked size.
    static constexpr std::uint64_t hashes_offset = 8 + 4 + 8;

    std::uint64_t first_tick() const { return first; }
    std::uint64_t end_tick() const { return first + hashes.size(); }
    bool holds(std::uint64_t tick) const { return tick >= first && tick < end_tick(); }
    /// The hash of the state after a tick. The tick must belong to this block (asserted, here and below).
    std::uint64_t hash_after(std::uint64_t tick) const;
    /// The players' inputs of a tick; the spans point into this block. Empty in commands mode.
    std::vector<PlayerInput> inputs(std::uint64_t tick) const;
    /// The most memory that the commands before any one tick need [bytes]; 0 in inputs mode.
    std::uint64_t commands_memory() const { return most_memory; }
    /// The commands before a tick, in order; empty in inputs mode.
    std::vector<Command> commands(std::uint64_t tick) const;

  private:
    struct CommandRef {
        std::uint32_t kind;
        std::uint32_t row; ///< among the commands of its kind
    };
    void read_inputs(base::ByteReader& in, std::span<const std::byte> unpacked);
    void read_commands(base::ByteReader& in, std::span<const std::byte> unpacked, const Limits& limits);
    void check_work(base::ByteReader& in, const Limits& limits) const;

    BlockShape shape;
    std::uint64_t most_memory = 0; ///< that the commands before any one tick need
    std::uint64_t first = 0;
    std::vector<std::uint64_t> hashes;
    std::vector<std::byte> input_rows;
    std::vector<std::uint32_t> first_command;       ///< by tick; the last entry is the number of commands
    std::vector<CommandRef> refs;                   ///< in order of application
    std::vector<std::vector<std::byte>> field_rows; ///< by kind
};

} // namespace lockstone::replay
