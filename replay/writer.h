// Writes a recording chunk by chunk, and never changes earlier chunks: a later failure cannot damage them. Most
// callers use recorder.h, which calls the writer for a game or a world.
#pragma once

#include "replay/format/block.h"
#include "replay/sink.h"

namespace lockstone::replay {

struct WriterOptions {
    std::uint32_t block_ticks = block_ticks_default; ///< 1..1024: ticks that a crash may lose
    /// The assets that a recording of commands needs, each after the assets to which it refers.
    std::vector<std::span<const std::byte>> assets = {};
};

class Writer {
  public:
    /// Writes the preamble, HEAD, SCHM, WDEF, the assets and the first keyframe. `sink` must outlive the writer.
    static Result<Writer> begin(Sink& sink, const Header& header, const GameSchema& schema,
                                const WorldDef& def, std::uint64_t start_hash,
                                std::span<const std::byte> start_image, const WriterOptions& options = {});

    // After the first error of the sink nothing more is written, and every call returns that error.
    /// Adds tick next_tick(): its inputs or its commands, by the header's mode (asserted).
    Status add_inputs(std::span<const PlayerInput> inputs, std::uint64_t hash);
    Status add_commands(std::span<const Command> commands, std::uint64_t hash);
    /// Writes the portable image of the state at next_tick(), after the pending ticks. Omits it at the time of the
    /// last keyframe.
    Status add_keyframe(std::span<const std::byte> image);
    /// Writes the pending ticks as a short block.
    Status flush();
    /// Writes the pending ticks, the index and the end, and closes the sink. Without this call the recording is
    /// incomplete.
    Status close();
    /// The first error, if there was one.
    Status status() const { return failure.empty() ? Status{} : Status(Error{failure}); }

    const Header& header() const { return head; }
    std::uint64_t next_tick() const { return time; }
    std::uint64_t last_hash() const { return hash_now; }
    std::uint64_t last_keyframe() const { return keyframe_time; }
    std::uint64_t bytes_written() const { return offset; }

  private:
    Writer(Sink& to, const Header& header, std::uint32_t ticks_per_block);
    Status add_tick(const Status& gathered, std::uint64_t hash);
    Status write_chunk(std::uint32_t type, std::uint64_t tick, std::span<const std::byte> payload);
    Status write_keyframe(std::span<const std::byte> image);
    Status fail(const Error& error);

    Sink* sink;
    Header head;
    std::uint32_t block_ticks;
    BlockBuilder block;
    std::uint64_t time; ///< the next tick
    std::uint64_t keyframe_time;
    std::uint64_t hash_now = 0; ///< of the state at `time`
    std::uint64_t offset = 0;   ///< bytes in the sink
    std::uint64_t chain = 0;    ///< checksum of the last chunk
    std::vector<std::byte> first_image;
    std::vector<IndexEntry> index;
    bool closed = false;
    std::string failure; ///< the first error
};

} // namespace lockstone::replay
