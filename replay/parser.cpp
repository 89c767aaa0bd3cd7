#include "replay/parser.h"

#include "lockstone/state.h"
#include "replay/format/codec.h"
#include "replay/format/pack.h"

#include <algorithm>

namespace lockstone::replay {

using base::ByteReader;
using base::join;

namespace {

/// The chunks that every file starts with, in order.
constexpr std::array opening = {chunk_head, chunk_schema, chunk_world_def, chunk_keyframe};

bool is_known(std::uint32_t type) {
    constexpr std::array known = {chunk_head,     chunk_schema, chunk_world_def, chunk_asset,
                                  chunk_keyframe, chunk_ticks,  chunk_index,     chunk_end};
    return std::ranges::find(known, type) != known.end();
}

} // namespace

std::string preamble_fault(std::span<const std::byte> bytes) {
    const auto expected = preamble();
    if (bytes.empty()) return "the file is empty, it should be a recording (.lsr)";
    const std::size_t magic = std::min<std::size_t>(bytes.size(), 8);
    if (!std::ranges::equal(bytes.first(magic), std::span(expected).first(magic)))
        return "this is not a recording: it does not begin with the eight bytes of .lsr files";
    if (bytes.size() < preamble_bytes)
        return join("the recording is cut at byte ", bytes.size(), ", inside the preamble");
    const auto major = base::load_little_endian<std::uint16_t>(bytes.data() + 8);
    if (major != version_major)
        return join("the recording is of format version ", major, ", this reader knows version ",
                    version_major);
    if (const auto reserved = base::load_little_endian<std::uint32_t>(bytes.data() + 12); reserved != 0)
        return join("the reserved field at byte 12 is ", reserved, ", must be 0");
    return {};
}

Status Parser::run(OnDamage on_damage) {
    if (const std::string fault = preamble_fault(file); !fault.empty())
        return Error{join(out.file_name, ": ", fault)};
    const Status status = read_chunks();
    if (status) return {};
    out.damage_sentence = join(out.file_name, ": ", status.error().message);
    const bool playable = chunks_seen == opening.size();
    const bool keeps = on_damage == OnDamage::recover || (on_damage == OnDamage::recover_cut && is_cut);
    if (keeps && playable) return {};
    return Error{out.damage_sentence};
}

Status Parser::read_chunks() {
    std::array<std::byte, preamble_bytes> first_bytes;
    std::ranges::copy(file.first(preamble_bytes), first_bytes.begin());
    out.chain = chain_start(first_bytes);
    at = preamble_bytes;
    while (!ended) {
        if (at == file.size()) return cut("ends before its END. chunk");
        const Result<Chunk> chunk = read_frame();
        if (!chunk) return chunk.error();
        if (const Status status = read_chunk(*chunk); !status) return status;
        out.chain = chunk->checksum;
        at = static_cast<std::size_t>(chunk->payload_offset + chunk->payload_size) + checksum_bytes;
    }
    if (at != file.size())
        return Error{join(file.size() - at, " bytes follow the END. chunk (at byte ", at, ")")};
    return {};
}

/// Returns true if the last chunk is END., so the file was closed. If a chunk seems to run past the end of such a
/// file, its size is wrong; the file is not cut.
bool Parser::ends_like_a_whole_file() const {
    constexpr std::size_t end_bytes = chunk_head_bytes + 24 + checksum_bytes;
    return file.size() >= preamble_bytes + end_bytes &&
           base::load_little_endian<std::uint32_t>(file.data() + file.size() - end_bytes) == chunk_end;
}

std::uint64_t Parser::memory_left() const {
    const std::uint64_t taken = out.memory() + index.capacity() * sizeof(IndexEntry);
    return out.read_limits.memory > taken ? out.read_limits.memory - taken : 0;
}

Error Parser::cut(const std::string& how) {
    is_cut = true;
    return {join("the recording is incomplete: it ", how, " (at byte ", at, "); ", out.tick_count(),
                 " ticks before that are whole")};
}

Result<Parser::Chunk> Parser::read_frame() {
    const std::size_t remaining = file.size() - at;
    if (remaining < chunk_head_bytes) return cut("is cut inside the frame of a chunk");
    Chunk chunk;
    chunk.offset = at;
    chunk.type = base::load_little_endian<std::uint32_t>(file.data() + at);
    const auto flags = base::load_little_endian<std::uint32_t>(file.data() + at + 4);
    chunk.payload_size = base::load_little_endian<std::uint64_t>(file.data() + at + 8);
    chunk.payload_offset = at + chunk_head_bytes;
    chunk.skippable = flags == flag_skippable;
    const std::string where = join("chunk ", chunk_name(chunk.type), " at byte ", at, ": ");
    const std::size_t framed = remaining - chunk_head_bytes;
    if (framed < checksum_bytes || chunk.payload_size > framed - checksum_bytes) {
        if (ends_like_a_whole_file())
            return Error{join(where, "its size is ", chunk.payload_size, ", but only ", framed,
                              " bytes follow; the file is damaged")};
        return cut(join("is cut inside chunk ", chunk_name(chunk.type), ", which needs ", chunk.payload_size,
                        " bytes and a checksum where ", framed, " bytes follow"));
    }
    const auto size = static_cast<std::size_t>(chunk.payload_size);
    chunk.checksum = base::load_little_endian<std::uint64_t>(file.data() + chunk.payload_offset + size);
    const std::uint64_t computed = hash_bytes(file.subspan(at, chunk_head_bytes + size), out.chain);
    if (computed != chunk.checksum)
        return Error{join(where, "the checksum is ", base::hex(chunk.checksum), ", but its bytes give ",
                          base::hex(computed), "; the file is damaged here or before")};
    if ((flags & ~flag_skippable) != 0)
        return Error{join(where, "its flags are ", flags, ", must be 0 or 1")};
    return chunk;
}

Status Parser::read_chunk(const Chunk& chunk) {
    if (const Status status = check_order(chunk); !status)
        return Error{
            join("chunk ", chunk_name(chunk.type), " at byte ", chunk.offset, ": ", status.error().message)};
    const std::string subject = join("chunk ", chunk_name(chunk.type), " at byte ", chunk.offset);
    // Starts the reader at byte 0 and skips to the payload, so that its offsets are those of the file.
    const std::uint64_t end = chunk.payload_offset + chunk.payload_size;
    ByteReader in(file.first(static_cast<std::size_t>(end)), subject);
    in.bytes(chunk.payload_offset, "file");
    const std::uint64_t time_before = out.time;
    read_payload(chunk, in);
    if (!in.ok()) return in.error();
    if (chunk.type == chunk_index) index_offset = chunk.offset;
    if (memory_left() < index.size() * sizeof(IndexEntry)) // growth of the list may need as much memory again
        return Error{join(subject, ": the limit of memory, ", out.read_limits.memory,
                          " bytes, is reached (--memory)")};
    const bool has_tick = chunk.type == chunk_ticks || chunk.type == chunk_keyframe;
    index.push_back({chunk.type, chunk.offset, has_tick ? time_before : 0});
    if (chunks_seen < opening.size() && chunk.type == opening[chunks_seen]) ++chunks_seen;
    return {};
}

Status Parser::check_order(const Chunk& chunk) const {
    if (!is_known(chunk.type)) {
        if (!chunk.skippable)
            return Error{"this reader does not know the type, and it is not marked skippable"};
        if (chunks_seen == 0) return Error{"HEAD must come first"};
        if (index_offset != 0) return Error{"after INDX only END. may follow"};
        return {};
    }
    if (chunk.skippable) return Error{"it is marked skippable, which this type never is"};
    if (chunk.type == chunk_asset) {
        if (chunks_seen != 0 && out.head.mode == Mode::inputs)
            return Error{"a recording of inputs has no assets: the game has them"};
        if (chunks_seen + 1 == opening.size()) return {};
        return Error{"assets stand between WDEF and the first KEYF"};
    }
    if (chunks_seen < opening.size()) {
        if (chunk.type == opening[chunks_seen]) return {};
        return Error{join(chunk_name(opening[chunks_seen]), " must come before it")};
    }
    if (index_offset != 0 && chunk.type != chunk_end) return Error{"after INDX only END. may follow"};
    if (index_offset == 0 && chunk.type == chunk_end) return Error{"INDX must come before it"};
    if (chunk.type == chunk_head || chunk.type == chunk_schema || chunk.type == chunk_world_def)
        return Error{"there is one already"};
    return {};
}

void Parser::read_payload(const Chunk& chunk, ByteReader& in) {
    switch (chunk.type) {
    case chunk_head:
        read_head(in);
        break;
    case chunk_schema:
        if (chunk.payload_size > schema_bytes_max)
            return in.fail(join("it has ", chunk.payload_size, " bytes, at most ", schema_bytes_max));
        out.game_schema = read_schema(in);
        break;
    case chunk_world_def:
        read_world_definition(in);
        break;
    case chunk_asset:
        read_asset(in);
        break;
    case chunk_keyframe:
        read_keyframe(in);
        break;
    case chunk_ticks:
        read_ticks(in, chunk);
        break;
    case chunk_index:
        read_index(in);
        break;
    case chunk_end:
        read_end(in);
        break;
    default:
        return; // a skippable chunk
    }
    in.expect_end();
}

void Parser::read_head(ByteReader& in) {
    out.head = read_header(in);
    out.time = out.head.start_tick;
}

void Parser::read_world_definition(ByteReader& in) {
    out.def = read_world_def(in);
    if (out.def.tick_rate != out.head.tick_rate)
        in.fail(join("the tick rate is ", out.def.tick_rate, ", HEAD says ", out.head.tick_rate));
}

void Parser::read_asset(ByteReader& in) {
    const std::span<const std::byte> bytes = in.bytes(in.remaining(), "asset");
    if (memory_left() / Recording::asset_memory_per_byte < bytes.size())
        return in.fail(join("the asset has ", bytes.size(), " bytes; ", memory_left(),
                            " bytes of memory that are left are too few to read it (--memory)"));
    const Result<AssetId> id = out.library->add(bytes);
    if (!id) return in.fail(id.error().message);
    if (out.library->bytes(*id).size() != bytes.size())
        return in.fail("it holds a set of assets, it must hold one asset");
    if (!assets.insert(*id).second) in.fail("the asset stands twice");
    out.asset_bytes += bytes.size();
}

void Parser::read_keyframe(ByteReader& in) {
    Recording::Keyframe keyframe{};
    keyframe.time = in.u64("time");
    keyframe.hash = in.u64("hash");
    keyframe.image_size = in.u64("image size");
    keyframe.packed_offset = in.offset();
    const auto packed = in.bytes(in.remaining(), "packed image");
    keyframe.packed_size = packed.size();
    if (!in.ok()) return;
    const bool is_first = out.keyframe_list.empty();
    if (keyframe.time != out.time)
        return in.fail(join("its time is ", keyframe.time, ", must be ", out.time));
    if (!is_first && keyframe.time == out.keyframe_list.back().time)
        return in.fail(join("there is a keyframe at time ", keyframe.time, " already"));
    if (!is_first && keyframe.hash != out.hash_now)
        return in.fail(join("its hash is ", base::hex(keyframe.hash), ", the tick before it says ",
                            base::hex(out.hash_now)));
    if (keyframe.image_size > image_bytes_max)
        return in.fail(join("the image has ", keyframe.image_size, " bytes, at most ", image_bytes_max));
    if (const Status status = check_packed(packed, keyframe.image_size); !status)
        return in.fail(status.error().message);
    out.hash_now = keyframe.hash;
    out.keyframe_list.push_back(keyframe);
}

void Parser::read_ticks(ByteReader& in, const Chunk& chunk) {
    const TickBlock block =
        TickBlock::read(in, out.block_shape(),
                        {.memory = memory_left(), .commands_per_tick = out.read_limits.commands_per_tick});
    out.most_command_memory = std::max(out.most_command_memory, block.commands_memory());
    if (!in.ok()) return;
    if (block.first_tick() != out.time)
        return in.fail(join("its first tick is ", block.first_tick(), ", must be ", out.time));
    out.block_list.push_back({block.first_tick(), chunk.payload_offset, chunk.payload_size});
    out.time = block.end_tick();
    out.hash_now = block.hash_after(out.time - 1);
}

void Parser::read_index(ByteReader& in) {
    const std::uint32_t count = in.u32("number of entries");
    if (in.ok() && count != index.size())
        in.fail(join("it has ", count, " entries, but ", index.size(), " chunks precede it"));
    for (std::size_t i = 0; in.ok() && i < index.size(); ++i) {
        IndexEntry entry{};
        entry.type = in.u32("entry's type");
        entry.offset = in.u64("entry's offset");
        entry.tick = in.u64("entry's tick");
        if (in.ok() && entry != index[i])
            in.fail(join("entry ", i, " says ", chunk_name(entry.type), " at byte ", entry.offset, ", tick ",
                         entry.tick, "; there is ", chunk_name(index[i].type), " at byte ", index[i].offset,
                         ", tick ", index[i].tick));
    }
}

void Parser::read_end(ByteReader& in) {
    const std::uint64_t ticks = in.u64("number of ticks");
    const std::uint64_t hash = in.u64("last hash");
    const std::uint64_t index_at = in.u64("offset of INDX");
    if (!in.ok()) return;
    if (ticks != out.tick_count())
        return in.fail(join("it counts ", ticks, " ticks, there are ", out.tick_count()));
    if (hash != out.hash_now)
        return in.fail(
            join("its hash is ", base::hex(hash), ", that of the last tick ", base::hex(out.hash_now)));
    if (index_at != index_offset)
        return in.fail(join("it puts INDX at byte ", index_at, ", it is at byte ", index_offset));
    ended = true;
}

} // namespace lockstone::replay
