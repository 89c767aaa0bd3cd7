#include "replay/branch.h"

#include "replay/format/codec.h"

#include <algorithm>

namespace lockstone::replay {
namespace {

using base::join;

void set_option(std::vector<Option>& options, std::string key, std::string value) {
    std::erase_if(options, [&](const Option& option) { return option.key == key; });
    options.push_back({std::move(key), std::move(value)});
}

/// The source's header, with the new options in place of its own options of the same keys.
Header header_of(const Recording& source, std::uint64_t at, const RecorderOptions& options) {
    Header header = source.header();
    header.engine = engine_version;
    for (const Option& option : options.options) set_option(header.options, option.key, option.value);
    set_option(header.options, "branch.of", base::hex(source.checksum()));
    set_option(header.options, "branch.at", join(at));
    std::ranges::sort(header.options, {}, &Option::key);
    return header;
}

Result<Writer> begin_like(const Recording& source, const Header& header, Sink& sink,
                          const RecorderOptions& options) {
    return Writer::begin(sink, header, source.schema(), source.world_def(), source.keyframes().front().hash,
                         source.keyframe_image(0), {options.block_ticks, assets_in_order(*source.assets())});
}

Status copy_tick(const Recording& source, const TickBlock& block, std::uint64_t tick, Writer& writer) {
    const std::uint64_t hash = block.hash_after(tick);
    return source.header().mode == Mode::inputs ? writer.add_inputs(block.inputs(tick), hash)
                                                : writer.add_commands(block.commands(tick), hash);
}

/// Copies the ticks of the source up to time `at`, which must lie within it, through a new writer. Simulates nothing.
Result<Writer> copy(const Recording& source, const Header& header, std::uint64_t at, Sink& sink,
                    const RecorderOptions& options) {
    Result<Writer> writer = begin_like(source, header, sink, options);
    if (!writer) return writer.error();
    BlockCursor blocks(source);
    std::size_t keyframe = 1;
    for (std::uint64_t tick = source.start_tick(); tick < at; ++tick) {
        Status status = copy_tick(source, blocks.at(tick), tick, *writer);
        if (status && keyframe < source.keyframes().size() && source.keyframes()[keyframe].time == tick + 1)
            status = writer->add_keyframe(source.keyframe_image(keyframe++));
        if (!status) return status.error();
    }
    return writer;
}

Result<World> world_at(const Recording& source, const Game* game, std::uint64_t at) {
    Result<Player> player = Player::open(source, game);
    if (!player) return player.error();
    if (const Status status = player->seek(at); !status) return status.error();
    if (!player->agrees())
        return Error{join(source.name(), ": cannot branch at ", at,
                          ": re-simulation does not reach the recorded state there")};
    return std::move(*player).release();
}

Error wrong_mode(const Recording& source) {
    return {join(source.name(), ": cannot branch: it holds ", name_of(source.header().mode))};
}

} // namespace

Result<InputBranch> branch_inputs(const Recording& source, const Game& game, std::uint64_t at, Sink& sink,
                                  const RecorderOptions& options) {
    if (source.header().mode != Mode::inputs) return wrong_mode(source);
    Result<World> world = world_at(source, &game, at);
    if (!world) return world.error();
    Result<Writer> writer = copy(source, header_of(source, at, options), at, sink, options);
    if (!writer) return writer.error();
    return InputBranch{InputRecorder::resume(std::move(*writer), options.keyframe_ticks), std::move(*world)};
}

Result<CommandBranch> branch_commands(const Recording& source, std::uint64_t at, Sink& sink,
                                      const RecorderOptions& options) {
    if (source.header().mode != Mode::commands) return wrong_mode(source);
    Result<World> world = world_at(source, nullptr, at);
    if (!world) return world.error();
    Result<Writer> writer = copy(source, header_of(source, at, options), at, sink, options);
    if (!writer) return writer.error();
    return CommandBranch{std::move(*writer), std::move(*world)};
}

Status repair(const Recording& source, Sink& sink) {
    Header header = source.header();
    set_option(header.options, "repaired.of", base::hex(source.checksum()));
    set_option(header.options, "repaired.end", join(source.end_tick()));
    std::ranges::sort(header.options, {}, &Option::key);
    Result<Writer> writer = copy(source, header, source.end_tick(), sink, {});
    return writer ? writer->close() : Status(writer.error());
}

Status add_keyframes(const Recording& source, const Game* game, Sink& sink, const RecorderOptions& options) {
    Result<Player> player = Player::open(source, game);
    if (!player) return player.error();
    Result<Writer> writer = begin_like(source, source.header(), sink, options);
    if (!writer) return writer.error();
    while (!player->at_end()) {
        const std::uint64_t tick = player->time();
        Status status = player->step();
        if (status && !player->agrees())
            status =
                Error{join(source.name(), ": re-simulating tick ", tick, " does not give the recorded hash")};
        if (status) status = copy_tick(source, player->blocks().at(tick), tick, *writer);
        if (status && options.keyframe_ticks != 0 &&
            (tick + 1 - source.start_tick()) % options.keyframe_ticks == 0)
            status = writer->add_keyframe(player->world().save_portable());
        if (!status) return status;
    }
    return writer->close();
}

} // namespace lockstone::replay
