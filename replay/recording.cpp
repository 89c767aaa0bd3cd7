#include "replay/recording.h"

#include "base/assert.h"
#include "replay/format/pack.h"
#include "replay/parser.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>

namespace lockstone::replay {
namespace {

using base::join;

struct CloseFile {
    void operator()(std::FILE* f) const { std::fclose(f); }
};

/// The size of a file; 0 if the system does not know it, as for pipes. Uses only stdio, which exists on every system.
std::uint64_t told_size(std::FILE* file) {
    const bool told = std::fseek(file, 0, SEEK_END) == 0;
    const long end = told ? std::ftell(file) : 0;
    if (told && std::fseek(file, 0, SEEK_SET) != 0) std::rewind(file);
    return end > 0 ? static_cast<std::uint64_t>(end) : 0;
}

/// Reads the whole file in growing steps: the reported size is not trusted, and reading stops after the preamble if
/// the file is no recording. Never holds more than `memory` bytes at a time; if the system reports the size, the
/// buffer has just that size.
Result<std::vector<std::byte>> read_file(const std::string& path, std::uint64_t memory) {
    errno = 0;
    const std::unique_ptr<std::FILE, CloseFile> file(std::fopen(path.c_str(), "rb"));
    if (!file) return Error{join(path, ": cannot open the file: ", std::generic_category().message(errno))};
    const std::uint64_t told = told_size(file.get());
    const std::uint64_t most = std::min(file_bytes_max, memory);
    std::vector<std::byte> bytes;
    // One more byte, for the read that finds the end.
    if (told != 0 && told < most) bytes.reserve(static_cast<std::size_t>(told) + 1);
    std::size_t step = preamble_bytes;
    while (true) {
        const std::size_t before = bytes.size();
        if (bytes.capacity() > before) step = std::min(step, bytes.capacity() - before);
        if (before + step > bytes.capacity() && 2 * before + step > most) // the old buffer and the new one
            return Error{join(path, ": the file has more than ", before, " bytes; with ", most,
                              " bytes of memory no more can be read (--memory)")};
        bytes.resize(before + step);
        errno = 0;
        const std::size_t got = std::fread(bytes.data() + before, 1, step, file.get());
        bytes.resize(before + got);
        if (std::ferror(file.get()) != 0)
            return Error{join(path, ": cannot read the file at byte ", bytes.size(), ": ",
                              std::generic_category().message(errno))};
        if (got < step) return bytes;
        if (before == 0)
            if (const std::string fault = preamble_fault(bytes); !fault.empty())
                return Error{join(path, ": ", fault)};
        step = std::max<std::size_t>(bytes.size() / 2, std::size_t{1} << 16);
    }
}

} // namespace

Result<Recording> Recording::open(const std::string& path, OnDamage on_damage, const Limits& limits) {
    auto bytes = read_file(path, limits.memory);
    if (!bytes) return bytes.error();
    return from_bytes(std::move(*bytes), path, on_damage, limits);
}

Result<Recording> Recording::from_bytes(std::vector<std::byte> bytes, std::string name, OnDamage on_damage,
                                        const Limits& limits) {
    Recording recording;
    recording.read_limits = limits;
    recording.file_name = std::move(name);
    recording.bytes = std::move(bytes);
    if (const Status status = Parser(recording).run(on_damage); !status) return status.error();
    return recording;
}

std::uint64_t Recording::memory() const {
    return bytes.capacity() + keyframe_list.capacity() * sizeof(Keyframe) +
           block_list.capacity() * sizeof(Block) + asset_memory_per_byte * asset_bytes;
}

std::uint64_t Recording::hash_at(std::uint64_t at) const {
    LOCKSTONE_ASSERT(at >= start_tick() && at <= end_tick(), "time ", at, " of ", start_tick(), "..",
                     end_tick());
    if (at == start_tick()) return keyframe_list.front().hash;
    const Block& block = find_block(at - 1);
    const std::uint64_t offset =
        block.payload_offset + TickBlock::hashes_offset + 8 * (at - 1 - block.first_tick);
    return base::load_little_endian<std::uint64_t>(bytes.data() + offset);
}

std::size_t Recording::keyframe_before(std::uint64_t at) const {
    LOCKSTONE_ASSERT(at >= start_tick(), "time ", at, " before the start ", start_tick());
    const auto after = std::ranges::upper_bound(keyframe_list, at, {}, &Keyframe::time);
    return static_cast<std::size_t>(after - keyframe_list.begin()) - 1;
}

std::vector<std::byte> Recording::keyframe_image(std::size_t keyframe) const {
    LOCKSTONE_ASSERT(keyframe < keyframe_list.size(), "keyframe ", keyframe, " of ", keyframe_list.size());
    const Keyframe& which = keyframe_list[keyframe];
    const auto packed = std::span(bytes).subspan(static_cast<std::size_t>(which.packed_offset),
                                                 static_cast<std::size_t>(which.packed_size));
    std::vector<std::byte> image = unpack(packed, which.image_size).value();
    if (keyframe == 0) return image;
    const std::vector<std::byte> first_image = keyframe_image(0);
    for (std::size_t i = 0; i < std::min(image.size(), first_image.size()); ++i) image[i] ^= first_image[i];
    return image;
}

const Recording::Block& Recording::find_block(std::uint64_t tick) const {
    LOCKSTONE_ASSERT(tick >= start_tick() && tick < end_tick(), "tick ", tick, " of ", start_tick(), "..",
                     end_tick());
    return *(std::ranges::upper_bound(block_list, tick, {}, &Block::first_tick) - 1);
}

TickBlock Recording::block_with(std::uint64_t tick) const {
    const Block& block = find_block(tick);
    const auto payload = std::span(bytes).subspan(static_cast<std::size_t>(block.payload_offset),
                                                  static_cast<std::size_t>(block.payload_size));
    base::ByteReader in(payload, file_name);
    TickBlock out = TickBlock::read(in, block_shape(),
                                    {.memory = ~std::uint64_t{0}, .commands_per_tick = ~std::uint32_t{0}});
    LOCKSTONE_ASSERT(in.ok(), "a block that was checked does not read");
    return out;
}

} // namespace lockstone::replay
