#include "replay/format/block.h"

#include "base/assert.h"
#include "replay/format/codec.h"
#include "replay/format/pack.h"

#include <algorithm>

namespace lockstone::replay {
namespace {

using base::ByteReader;
using base::join;

constexpr std::byte status_confirmed{0}, status_disconnected{1};
constexpr std::uint64_t explosion_work = 64; ///< in the count for Limits::commands_per_tick
const std::size_t explode_kind = Command(Explode{}).index();
/// A kind and an id; limits the number of commands before any is read.
constexpr std::size_t command_bytes_least = 9;

} // namespace

// ---- BlockBuilder --------------------------------------------------------------------------------------------

Status BlockBuilder::add_inputs(std::span<const PlayerInput> inputs, std::uint64_t hash) {
    if (inputs.size() != shape.player_count)
        return Error{join(inputs.size(), " inputs for ", shape.player_count, " players")};
    for (std::size_t p = 0; p < inputs.size(); ++p) {
        const bool gone = inputs[p].status == InputStatus::disconnected;
        if (inputs[p].status == InputStatus::predicted)
            return Error{
                join("the input of player ", p, " is a prediction; only confirmed ticks are recorded")};
        if (inputs[p].bytes.size() != shape.input_size && !(gone && inputs[p].bytes.empty()))
            return Error{join("the input of player ", p, " has ", inputs[p].bytes.size(),
                              " bytes, must have ", shape.input_size)};
    }
    for (const PlayerInput& input : inputs) {
        const bool gone = input.status == InputStatus::disconnected;
        input_rows.push_back(gone ? status_disconnected : status_confirmed);
        if (gone)
            input_rows.insert(input_rows.end(), shape.input_size, std::byte{0});
        else
            input_rows.insert(input_rows.end(), input.bytes.begin(), input.bytes.end());
    }
    hashes.push_back(hash);
    return {};
}

Status BlockBuilder::add_commands(std::span<const Command> commands, std::uint64_t hash) {
    std::size_t bytes = unpacked_bytes() + 4;
    for (const Command& command : commands) bytes += 1 + command_bytes(command.index());
    if (bytes > block_bytes_max)
        return Error{join(commands.size(), " commands before one tick exceed the ", block_bytes_max,
                          " bytes that a block may hold")};
    base::ByteWriter(count_rows).u32(static_cast<std::uint32_t>(commands.size()));
    for (const Command& command : commands) {
        kind_rows.push_back(static_cast<std::byte>(command.index()));
        append_command(command, field_rows[command.index()]);
    }
    hashes.push_back(hash);
    return {};
}

std::size_t BlockBuilder::unpacked_bytes() const {
    std::size_t bytes = input_rows.size() + count_rows.size() + kind_rows.size();
    for (const auto& [kind, rows] : field_rows) bytes += rows.size();
    return bytes;
}

void BlockBuilder::finish(std::uint64_t first_tick, std::vector<std::byte>& out) {
    std::vector<std::byte> planes;
    planes.reserve(unpacked_bytes());
    append_planes(input_rows, shape.input_row_bytes(), planes);
    append_planes(count_rows, 4, planes);
    append_planes(kind_rows, 1, planes);
    for (const auto& [kind, rows] : field_rows) append_planes(rows, command_bytes(kind), planes);

    base::ByteWriter to(out);
    to.u64(first_tick);
    to.u32(ticks());
    to.u64(planes.size());
    for (const std::uint64_t hash : hashes) to.u64(hash);
    pack(planes, out);
    *this = BlockBuilder(shape);
}

// ---- TickBlock -----------------------------------------------------------------------------------------------

TickBlock TickBlock::read(ByteReader& in, BlockShape shape, const Limits& limits) {
    TickBlock block;
    block.shape = shape;
    block.first = in.u64("first tick");
    const std::uint32_t count = in.u32("count");
    if (count == 0 || count > block_ticks_max)
        in.fail(join("the block has ", count, " ticks, must have 1..", block_ticks_max));
    const std::uint64_t size = in.u64("unpacked size");
    if (size > block_bytes_max) in.fail(join("the unpacked size is ", size, ", at most ", block_bytes_max));
    if (in.ok() && size * memory_per_byte > limits.memory)
        in.fail(join("the block unpacks to ", size, " bytes; the ", limits.memory,
                     " bytes of memory that are left are too few (--memory)"));
    const auto hash_bytes_read = in.bytes(std::uint64_t{count} * 8, "hashes");
    if (!in.ok()) return block;
    for (std::size_t i = 0; i < count; ++i)
        block.hashes.push_back(base::load_little_endian<std::uint64_t>(hash_bytes_read.data() + 8 * i));
    const std::size_t packed_at = in.offset();
    const auto unpacked = unpack(in.bytes(in.remaining(), "packed bytes"), size);
    if (!unpacked)
        in.fail_at(packed_at, unpacked.error().message);
    else if (shape.mode == Mode::inputs)
        block.read_inputs(in, *unpacked);
    else
        block.read_commands(in, *unpacked, limits);
    return block;
}

void TickBlock::read_inputs(ByteReader& in, std::span<const std::byte> unpacked) {
    const std::size_t row_bytes = shape.input_row_bytes(), expected = hashes.size() * row_bytes;
    if (unpacked.size() != expected)
        return in.fail(join("the inputs have ", unpacked.size(), " bytes, must have ", expected));
    input_rows = read_planes(unpacked, row_bytes);
    const std::size_t stride = 1 + std::size_t{shape.input_size};
    for (std::size_t at = 0; at < input_rows.size(); at += stride) {
        const std::byte status = input_rows[at];
        const auto input = std::span(input_rows).subspan(at + 1, shape.input_size);
        const std::uint64_t tick = first + at / row_bytes, player = at % row_bytes / stride;
        if (status != status_confirmed && status != status_disconnected)
            return in.fail(join("tick ", tick, ", player ", player, ": status is ",
                                std::to_integer<int>(status), ", must be 0 or 1"));
        if (status == status_disconnected &&
            std::ranges::any_of(input, [](std::byte b) { return b != std::byte{0}; }))
            return in.fail(
                join("tick ", tick, ", player ", player, " is disconnected, but the input is not zero"));
    }
}

void TickBlock::read_commands(ByteReader& in, std::span<const std::byte> unpacked, const Limits& limits) {
    ByteReader tables(unpacked, "unpacked ticks");
    const auto fail = [&](const std::string& why) { in.fail(why); };
    const auto counts = read_planes(tables.bytes(hashes.size() * 4, "counts"), 4);
    if (!tables.ok()) return fail(tables.error().message);
    std::uint64_t total = 0;
    for (std::size_t at = 0; at < counts.size(); at += 4) {
        first_command.push_back(static_cast<std::uint32_t>(total));
        const auto count = base::load_little_endian<std::uint32_t>(counts.data() + at);
        total += count;
        if (total > unpacked.size() / command_bytes_least)
            return fail(join("more commands are announced than ", unpacked.size(), " bytes can hold"));
    }
    first_command.push_back(static_cast<std::uint32_t>(total));

    const auto kinds = read_planes(tables.bytes(total, "kinds"), 1);
    if (!tables.ok()) return fail(tables.error().message);
    std::array<std::uint32_t, command_kinds> rows{};
    refs.reserve(kinds.size());
    for (const std::byte kind : kinds) {
        const auto k = std::to_integer<std::uint32_t>(kind);
        if (k >= command_kinds)
            return fail(join("a command is of kind ", k, ", this engine knows 0..", command_kinds - 1));
        refs.push_back({k, rows[k]++});
    }
    for (std::size_t t = 0; t < hashes.size(); ++t) {
        std::uint64_t memory = 0;
        for (std::uint32_t i = first_command[t]; i < first_command[t + 1]; ++i)
            memory += command_memory(refs[i].kind);
        most_memory = std::max(most_memory, memory);
    }
    check_work(in, limits);
    if (!in.ok()) return;
    field_rows.resize(command_kinds);
    for (std::size_t k = 0; k < command_kinds; ++k)
        field_rows[k] = read_planes(tables.bytes(rows[k] * command_bytes(k), "fields"), command_bytes(k));
    tables.expect_end();
    if (!tables.ok()) fail(tables.error().message);
}

/// Limits the commands of each tick: they cost memory and time before the world can refuse them.
void TickBlock::check_work(ByteReader& in, const Limits& limits) const {
    for (std::size_t t = 0; t < hashes.size(); ++t) {
        std::uint64_t work = 0;
        for (std::uint32_t i = first_command[t]; i < first_command[t + 1]; ++i)
            work += refs[i].kind == explode_kind ? explosion_work : 1;
        if (work > limits.commands_per_tick)
            return in.fail(join("tick ", first + t, " has ", first_command[t + 1] - first_command[t],
                                " commands, with explosions as ", explosion_work, " each the work of ", work,
                                "; the limit is ", limits.commands_per_tick, " (--commands)"));
    }
}

std::uint64_t TickBlock::hash_after(std::uint64_t tick) const {
    LOCKSTONE_ASSERT(holds(tick), "tick ", tick, " of a block ", first, "..", end_tick());
    return hashes[static_cast<std::size_t>(tick - first)];
}

std::vector<PlayerInput> TickBlock::inputs(std::uint64_t tick) const {
    LOCKSTONE_ASSERT(holds(tick), "tick ", tick, " of a block ", first, "..", end_tick());
    std::vector<PlayerInput> out;
    if (shape.mode != Mode::inputs) return out;
    std::span<const std::byte> row(input_rows);
    row = row.subspan(static_cast<std::size_t>(tick - first) * shape.input_row_bytes(),
                      shape.input_row_bytes());
    for (std::uint32_t p = 0; p < shape.player_count; ++p) {
        const bool gone = row[0] == status_disconnected;
        out.push_back(
            {row.subspan(1, shape.input_size), gone ? InputStatus::disconnected : InputStatus::confirmed});
        row = row.subspan(1 + std::size_t{shape.input_size});
    }
    return out;
}

std::vector<Command> TickBlock::commands(std::uint64_t tick) const {
    LOCKSTONE_ASSERT(holds(tick), "tick ", tick, " of a block ", first, "..", end_tick());
    std::vector<Command> out;
    if (shape.mode != Mode::commands) return out;
    const auto at = static_cast<std::size_t>(tick - first);
    out.reserve(first_command[at + 1] - first_command[at]);
    for (std::uint32_t i = first_command[at]; i < first_command[at + 1]; ++i) {
        const std::size_t bytes = command_bytes(refs[i].kind);
        out.push_back(read_command(refs[i].kind,
                                   std::span(field_rows[refs[i].kind]).subspan(refs[i].row * bytes, bytes)));
    }
    return out;
}

} // namespace lockstone::replay
