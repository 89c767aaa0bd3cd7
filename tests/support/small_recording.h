// Recordings of the small game, and functions that split a recording into chunks and join chunks with valid checksums.
#pragma once

#include "replay/format/codec.h"
#include "replay/format/pack.h"
#include "replay/replay.h"
#include "support/small_game.h"
#include "support/state_sample.h"

#include <algorithm>

namespace lockstone::test {

using Bytes = std::vector<std::byte>;

/// The script of SmallGame for ticks 0 .. ticks - 1, in inputs mode.
inline Bytes record_inputs(std::uint64_t ticks, const replay::RecorderOptions& options = {},
                           const SmallGame& game = SmallGame()) {
    replay::MemorySink sink;
    World world = must(game.start());
    auto recorder = must(replay::InputRecorder::begin(sink, game, world, options));
    for (std::uint64_t t = 0; t < ticks; ++t) {
        const SmallInputs inputs(SmallGame::script(t));
        must(game.advance(world, inputs.list));
        must(recorder.after_tick(world, inputs.list));
    }
    must(recorder.close());
    return sink.bytes;
}

/// The run of record_inputs() in commands mode.
inline Bytes record_commands(std::uint64_t ticks, const replay::RecorderOptions& options = {}) {
    const SmallGame game;
    replay::MemorySink sink;
    World world = must(game.start());
    const auto recorder = must(replay::CommandRecorder::begin(sink, world, "small", options));
    for (std::uint64_t t = 0; t < ticks; ++t)
        must(game.advance(world, SmallInputs(SmallGame::script(t)).list));
    must(recorder->close());
    return sink.bytes;
}

/// Hashes of the script's states at times 0 .. ticks, from a run without a recorder.
inline std::vector<std::uint64_t> played_hashes(std::uint64_t ticks) {
    const SmallGame game;
    World world = must(game.start());
    std::vector<std::uint64_t> hashes = {world.hash()};
    for (std::uint64_t t = 0; t < ticks; ++t) {
        must(game.advance(world, SmallInputs(SmallGame::script(t)).list));
        hashes.push_back(world.hash());
    }
    return hashes;
}

inline Result<replay::Recording> read(Bytes bytes, replay::OnDamage on_damage = replay::OnDamage::refuse) {
    return replay::Recording::from_bytes(std::move(bytes), "test.lsr", on_damage);
}

struct Chunk {
    std::uint32_t type;
    std::uint32_t flags;
    Bytes payload;
};

/// The chunks of a valid recording.
inline std::vector<Chunk> chunks_of(std::span<const std::byte> file) {
    std::vector<Chunk> chunks;
    for (std::size_t at = replay::preamble_bytes; at < file.size();) {
        const auto size =
            static_cast<std::size_t>(base::load_little_endian<std::uint64_t>(file.data() + at + 8));
        const auto payload = file.subspan(at + replay::chunk_head_bytes, size);
        chunks.push_back({base::load_little_endian<std::uint32_t>(file.data() + at),
                          base::load_little_endian<std::uint32_t>(file.data() + at + 4),
                          Bytes(payload.begin(), payload.end())});
        at += replay::chunk_head_bytes + size + replay::checksum_bytes;
    }
    return chunks;
}

/// A file of these chunks with valid checksums. `renew_index`: INDX and END. get the chunks' true offsets.
inline Bytes file_of(std::vector<Chunk> chunks, bool renew_index,
                     std::uint16_t minor = replay::version_minor) {
    auto first_bytes = replay::preamble();
    base::store_little_endian(minor, first_bytes.data() + 10);
    Bytes file(first_bytes.begin(), first_bytes.end());
    std::uint64_t chain = replay::chain_start(first_bytes), index_offset = 0;
    Bytes index;
    std::uint32_t entries = 0;
    for (Chunk& chunk : chunks) {
        if (renew_index && chunk.type == replay::chunk_index) {
            chunk.payload.clear();
            base::ByteWriter(chunk.payload).u32(entries);
            chunk.payload.insert(chunk.payload.end(), index.begin(), index.end());
            index_offset = file.size();
        }
        if (renew_index && chunk.type == replay::chunk_end && chunk.payload.size() == 24)
            base::store_little_endian(index_offset, chunk.payload.data() + 16);
        const bool has_tick = chunk.type == replay::chunk_ticks || chunk.type == replay::chunk_keyframe;
        base::ByteWriter entry(index);
        entry.u32(chunk.type);
        entry.u64(file.size());
        entry.u64(has_tick && chunk.payload.size() >= 8
                      ? base::load_little_endian<std::uint64_t>(chunk.payload.data())
                      : 0);
        ++entries;

        const std::size_t begin = file.size();
        base::ByteWriter to(file);
        to.u32(chunk.type);
        to.u32(chunk.flags);
        to.u64(chunk.payload.size());
        to.bytes(chunk.payload);
        chain = hash_bytes(std::span(file).subspan(begin), chain);
        to.u64(chain);
    }
    return file;
}

/// Index of the n-th chunk of a type.
inline std::size_t find_chunk(const std::vector<Chunk>& chunks, std::uint32_t type, std::size_t n = 0) {
    for (std::size_t i = 0; i < chunks.size(); ++i)
        if (chunks[i].type == type && n-- == 0) return i;
    throw std::runtime_error("no such chunk");
}

} // namespace lockstone::test
