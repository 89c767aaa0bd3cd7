#include "replay/writer.h"

#include "base/assert.h"
#include "lockstone/state.h"
#include "replay/format/codec.h"
#include "replay/format/pack.h"

#include <algorithm>

namespace lockstone::replay {
namespace {

using base::ByteWriter;
using base::join;

/// The writer ends a block early at this size, so that little is pending.
constexpr std::size_t block_bytes_soft = std::size_t{1} << 20;

/// `image` xor `reference`; `reference` counts as zero beyond its end.
std::vector<std::byte> delta(std::span<const std::byte> image, std::span<const std::byte> reference) {
    std::vector<std::byte> out(image.begin(), image.end());
    for (std::size_t i = 0; i < std::min(image.size(), reference.size()); ++i) out[i] ^= reference[i];
    return out;
}

} // namespace

Writer::Writer(Sink& to, const Header& header, std::uint32_t ticks_per_block)
    : sink(&to), head(header), block_ticks(ticks_per_block),
      block({header.mode, header.player_count, header.input_size}), time(header.start_tick),
      keyframe_time(header.start_tick) {}

Result<Writer> Writer::begin(Sink& sink, const Header& header, const GameSchema& schema, const WorldDef& def,
                             std::uint64_t start_hash, std::span<const std::byte> start_image,
                             const WriterOptions& options) {
    std::string fault = find_fault(header);
    if (fault.empty()) fault = find_fault(schema);
    if (fault.empty() && def.tick_rate != header.tick_rate)
        fault = join("the header's tick rate is ", header.tick_rate, ", the world's is ", def.tick_rate);
    if (fault.empty() && (options.block_ticks == 0 || options.block_ticks > block_ticks_max))
        fault = join("block_ticks is ", options.block_ticks, ", must be 1..", block_ticks_max);
    if (!fault.empty()) return Error{join("cannot record: ", fault)};

    Writer writer(sink, header, options.block_ticks);
    const auto first_bytes = preamble();
    if (const Status status = sink.append(first_bytes); !status) return status.error();
    writer.offset = first_bytes.size();
    writer.chain = chain_start(first_bytes);

    std::vector<std::byte> head_payload, schema_payload, def_payload;
    append_header(header, head_payload);
    append_schema(schema, schema_payload);
    append_world_def(def, def_payload);
    writer.hash_now = start_hash;
    Status status = writer.write_chunk(chunk_head, 0, head_payload);
    if (status) status = writer.write_chunk(chunk_schema, 0, schema_payload);
    if (status) status = writer.write_chunk(chunk_world_def, 0, def_payload);
    for (const std::span<const std::byte> asset : options.assets)
        if (status) status = writer.write_chunk(chunk_asset, 0, asset);
    if (status) status = writer.write_keyframe(start_image);
    if (!status) return status.error();
    writer.first_image.assign(start_image.begin(), start_image.end());
    return writer;
}

Status Writer::fail(const Error& error) {
    if (failure.empty()) failure = error.message;
    return Error{failure};
}

Status Writer::add_inputs(std::span<const PlayerInput> inputs, std::uint64_t hash) {
    LOCKSTONE_ASSERT(head.mode == Mode::inputs, "the recording's mode is ", name_of(head.mode));
    if (!failure.empty()) return Error{failure};
    return add_tick(block.add_inputs(inputs, hash), hash);
}

Status Writer::add_commands(std::span<const Command> commands, std::uint64_t hash) {
    LOCKSTONE_ASSERT(head.mode == Mode::commands, "the recording's mode is ", name_of(head.mode));
    if (!failure.empty()) return Error{failure};
    Status gathered = block.add_commands(commands, hash);
    if (!gathered && block.ticks() != 0) { // it may fit into its own block
        if (const Status status = flush(); !status) return status;
        gathered = block.add_commands(commands, hash);
    }
    return add_tick(gathered, hash);
}

Status Writer::add_tick(const Status& gathered, std::uint64_t hash) {
    if (closed) return Error{"the recording is closed"};
    if (!gathered) return fail({join("cannot record tick ", time, ": ", gathered.error().message)});
    ++time;
    hash_now = hash;
    if (block.ticks() < block_ticks && block.unpacked_bytes() < block_bytes_soft) return {};
    return flush();
}

Status Writer::add_keyframe(std::span<const std::byte> image) {
    if (closed) return Error{"the recording is closed"};
    if (time == keyframe_time) return status();
    if (const Status status = flush(); !status) return status;
    return write_keyframe(image);
}

Status Writer::flush() {
    if (!failure.empty()) return Error{failure};
    if (block.ticks() == 0) return {};
    const std::uint64_t first = time - block.ticks();
    std::vector<std::byte> payload;
    block.finish(first, payload);
    return write_chunk(chunk_ticks, first, payload);
}

Status Writer::close() {
    if (closed) return status();
    closed = true;
    if (const Status status = flush(); !status) return status;
    const std::uint64_t index_at = offset;
    std::vector<std::byte> entries, end;
    ByteWriter to(entries);
    to.u32(static_cast<std::uint32_t>(index.size()));
    for (const IndexEntry& entry : index) {
        to.u32(entry.type);
        to.u64(entry.offset);
        to.u64(entry.tick);
    }
    ByteWriter last(end);
    last.u64(time - head.start_tick);
    last.u64(hash_now);
    last.u64(index_at);
    if (const Status status = write_chunk(chunk_index, 0, entries); !status) return status;
    if (const Status status = write_chunk(chunk_end, 0, end); !status) return status;
    if (const Status status = sink->close(); !status) return fail(status.error());
    return {};
}

Status Writer::write_chunk(std::uint32_t type, std::uint64_t tick, std::span<const std::byte> payload) {
    if (!failure.empty()) return Error{failure};
    std::vector<std::byte> chunk;
    chunk.reserve(chunk_head_bytes + payload.size() + checksum_bytes);
    ByteWriter to(chunk);
    to.u32(type);
    to.u32(0);
    to.u64(payload.size());
    to.bytes(payload);
    const std::uint64_t checksum = hash_bytes(chunk, chain);
    to.u64(checksum);
    if (const Status status = sink->append(chunk); !status) return fail(status.error());
    index.push_back({type, offset, tick});
    offset += chunk.size();
    chain = checksum;
    return {};
}

Status Writer::write_keyframe(std::span<const std::byte> image) {
    if (image.size() > image_bytes_max)
        return fail({join("cannot record the keyframe at ", time, ": it has ", image.size(),
                          " bytes, at most ", image_bytes_max)});
    std::vector<std::byte> payload;
    ByteWriter to(payload);
    to.u64(time);
    to.u64(hash_now);
    to.u64(image.size());
    pack(delta(image, first_image), payload);
    keyframe_time = time;
    return write_chunk(chunk_keyframe, time, payload);
}

} // namespace lockstone::replay
