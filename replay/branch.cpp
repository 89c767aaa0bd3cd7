#include "replay/branch.h"

#include <algorithm>

namespace lockstone::replay {
namespace {

using base::join;

void set_option(std::vector<Option>& options, std::string key, std::string value) {
    std::erase_if(options, [&](const Option& option) { return option.key == key; });
    options.push_back({std::move(key), std::move(value)});
}

/// The source's header with the new options laid over its own.
Header header_of(const Recording& source, std::uint64_t at, const RecorderOptions& options) {
    Header header = source.header();
    header.engine = engine_version;
    for (const Option& option : options.options) set_option(header.options, option.key, option.value);
    set_option(header.options, "branch.of", base::hex(source.checksum()));
    set_option(header.options, "branch.at", join(at));
    std::ranges::sort(header.options, {}, &Option::key);
    return header;
}

/// The source up to `at`, which it holds, through a new writer. Nothing is simulated.
Result<Writer> copy(const Recording& source, std::uint64_t at, Sink& sink, const RecorderOptions& options) {
    Result<Writer> writer =
        Writer::begin(sink, header_of(source, at, options), source.schema(), source.world_def(),
                      source.keyframes().front().hash, source.keyframe_image(0), {options.block_ticks});
    if (!writer) return writer.error();
    TickBlock block;
    std::size_t keyframe = 1;
    for (std::uint64_t tick = source.start_tick(); tick < at; ++tick) {
        if (!block.holds(tick)) block = source.block_with(tick);
        const std::uint64_t hash = block.hash_after(tick);
        Status status = source.header().mode == Mode::inputs ? writer->add_inputs(block.inputs(tick), hash)
                                                             : writer->add_commands(block.commands(tick), hash);
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
        return Error{join(source.name(), ": cannot branch at ", at, ": re-simulation does not reach the recorded state there")};
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
    Result<Writer> writer = copy(source, at, sink, options);
    if (!writer) return writer.error();
    return InputBranch{InputRecorder::resume(std::move(*writer), options.keyframe_ticks), std::move(*world)};
}

Result<CommandBranch> branch_commands(const Recording& source, std::uint64_t at, Sink& sink,
                                      const RecorderOptions& options) {
    if (source.header().mode != Mode::commands) return wrong_mode(source);
    Result<World> world = world_at(source, nullptr, at);
    if (!world) return world.error();
    Result<Writer> writer = copy(source, at, sink, options);
    if (!writer) return writer.error();
    return CommandBranch{std::move(*writer), std::move(*world)};
}

} // namespace lockstone::replay
