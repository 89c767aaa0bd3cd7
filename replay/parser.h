// Reads the chunks of a file into a Recording. For use inside replay/ only.
#pragma once

#include "base/bytes.h"
#include "replay/recording.h"

#include <set>

namespace lockstone::replay {

/// Checks if these bytes begin like a recording of a known version. Returns an empty text if they do, else the error.
std::string preamble_fault(std::span<const std::byte> bytes);

class Parser {
  public:
    explicit Parser(Recording& into) : out(into), file(into.bytes) {}
    /// Fills the recording. On recovery, errors after the first keyframe become the recording's damage sentence.
    Status run(OnDamage on_damage);

  private:
    /// A chunk with a valid frame and checksum.
    struct Chunk {
        std::uint32_t type = 0;
        bool skippable = false;
        std::uint64_t offset = 0, payload_offset = 0, payload_size = 0;
        std::uint64_t checksum = 0;
    };
    // Errors are sentences without the file's name.
    Status read_chunks();
    Result<Chunk> read_frame();
    Status read_chunk(const Chunk& chunk);
    Status check_order(const Chunk& chunk) const;
    void read_payload(const Chunk& chunk, base::ByteReader& in);
    void read_head(base::ByteReader& in);
    void read_world_definition(base::ByteReader& in);
    void read_asset(base::ByteReader& in);
    void read_keyframe(base::ByteReader& in);
    void read_ticks(base::ByteReader& in, const Chunk& chunk);
    void read_index(base::ByteReader& in);
    void read_end(base::ByteReader& in);
    bool ends_like_a_whole_file() const;
    Error cut(const std::string& how);
    /// The part of the memory limit that is not used yet.
    std::uint64_t memory_left() const;

    Recording& out;
    std::span<const std::byte> file;
    std::size_t at = 0;             ///< offset of the next chunk
    std::uint32_t chunks_seen = 0;  ///< chunks of the opening sequence read so far, up to the first keyframe
    std::uint64_t index_offset = 0; ///< 0 until INDX
    bool ended = false;
    bool is_cut = false; ///< the error was an early end of the file
    std::set<AssetId> assets;
    std::vector<IndexEntry> index; ///< the entries that INDX must have
};

} // namespace lockstone::replay
