// A recording in memory: complete, or up to the place where the file was cut or damaged.
//
//   Result<Recording> match = Recording::open("match.lsr");
//   if (!match) print(match.error().message);     // "match.lsr: chunk TICK at byte 4711: the checksum is 0x..., ..."
//
// Reading checks everything that can be checked without simulation, including every input and command of every tick;
// after that, access cannot fail. It needs at most four times the file's size, plus 256 MB while it checks a block of
// ticks, and never more than Limits::memory.
//
// One function, TickBlock::read, checks and reads a block of ticks: once when the recording is opened, and again when
// one of its ticks is needed. An unpacked block may be 65 times as large as in the file, so it is not kept in
// between. Both together are a small fraction of the cost of re-simulation.
#pragma once

#include "replay/format/block.h"

namespace lockstone::replay {

/// The handling of a file that was cut or damaged.
enum class OnDamage {
    refuse,      ///< return an error
    recover_cut, ///< keep the whole chunks of a file that ends too early, as after a crash; refuse a damaged one
    recover,     ///< keep the chunks before the first one that is not whole; damage() has the reason
};

class Recording {
  public:
    static Result<Recording> open(const std::string& path, OnDamage on_damage = OnDamage::refuse,
                                  const Limits& limits = {});
    /// Error sentences contain `name`.
    static Result<Recording> from_bytes(std::vector<std::byte> bytes, std::string name,
                                        OnDamage on_damage = OnDamage::refuse, const Limits& limits = {});

    const std::string& name() const { return file_name; }
    std::uint64_t size_bytes() const { return bytes.size(); }
    const Header& header() const { return head; }
    const GameSchema& schema() const { return game_schema; }
    const WorldDef& world_def() const { return def; }
    /// The assets for its commands; empty in inputs mode, where the game has them.
    const std::shared_ptr<AssetLibrary>& assets() const { return library; }

    const Limits& limits() const { return read_limits; }
    /// The memory that it occupies [bytes].
    std::uint64_t memory() const;
    /// The most memory that the commands before any one tick need [bytes]; 0 in inputs mode.
    std::uint64_t commands_memory() const { return most_command_memory; }

    /// Empty for a complete recording; else a sentence with the place and the reason of its early end.
    const std::string& damage() const { return damage_sentence; }
    bool complete() const { return damage_sentence.empty(); }
    /// The checksum of the last good chunk; identifies the whole recording.
    std::uint64_t checksum() const { return chain; }

    std::uint64_t start_tick() const { return head.start_tick; }
    std::uint64_t end_tick() const { return time; }
    std::uint64_t tick_count() const { return time - head.start_tick; }
    /// The hash of the state at a time start_tick() .. end_tick() (asserted).
    std::uint64_t hash_at(std::uint64_t at) const;

    struct Keyframe {
        std::uint64_t time;
        std::uint64_t hash;
        std::uint64_t image_size;
        std::uint64_t packed_offset; ///< in the file
        std::uint64_t packed_size;
    };
    /// In ascending order; the first is at start_tick().
    std::span<const Keyframe> keyframes() const { return keyframe_list; }
    /// Index of the last keyframe at or before a time >= start_tick().
    std::size_t keyframe_before(std::uint64_t at) const;
    /// The portable image; each call unpacks it again.
    std::vector<std::byte> keyframe_image(std::size_t keyframe) const;

    std::size_t block_count() const { return block_list.size(); }
    /// The block with a tick start_tick() .. end_tick() - 1 (asserted); each call unpacks it again.
    TickBlock block_with(std::uint64_t tick) const;

  private:
    /// The library keeps an asset's bytes and the data made from them.
    static constexpr std::uint64_t asset_memory_per_byte = 8;
    friend class Parser;
    struct Block {
        std::uint64_t first_tick;
        std::uint64_t payload_offset, payload_size;
    };
    const Block& find_block(std::uint64_t tick) const;
    BlockShape block_shape() const { return {head.mode, head.player_count, head.input_size}; }

    Limits read_limits;
    std::string file_name;
    std::vector<std::byte> bytes;
    Header head;
    GameSchema game_schema;
    WorldDef def;
    std::uint64_t asset_bytes = 0;         ///< of all assets in the library
    std::uint64_t most_command_memory = 0; ///< for any one tick
    std::shared_ptr<AssetLibrary> library = std::make_shared<AssetLibrary>();
    std::vector<Keyframe> keyframe_list;
    std::vector<Block> block_list;
    std::uint64_t time = 0;
    std::uint64_t hash_now = 0;
    std::uint64_t chain = 0;
    std::string damage_sentence;
};

/// Iterates over the blocks of a recording, which must outlive the cursor. Unpacks a block at the first access to one
/// of its ticks.
class BlockCursor {
  public:
    explicit BlockCursor(const Recording& recording) : source(&recording) {}
    /// The block with a tick, like Recording::block_with(). Valid until the next call.
    const TickBlock& at(std::uint64_t tick) {
        if (!block.holds(tick)) block = source->block_with(tick);
        return block;
    }

  private:
    const Recording* source;
    TickBlock block;
};

} // namespace lockstone::replay
