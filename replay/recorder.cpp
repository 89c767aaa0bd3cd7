#include "replay/recorder.h"

#include "base/assert.h"
#include "replay/format/codec.h"

#include <algorithm>
#include <utility>

namespace lockstone::replay {
namespace {

using base::join;

Header header_of(const World& world, const RecorderOptions& options) {
    Header header;
    header.engine = engine_version;
    header.schema_hash = world.state().layout().schema_hash();
    header.tick_rate = world.def().tick_rate;
    header.start_tick = world.tick_count();
    header.options = options.options;
    std::ranges::sort(header.options, {}, &Option::key);
    return header;
}

Result<Writer> begin_at(Sink& sink, const Header& header, const World& world,
                        const RecorderOptions& options) {
    WriterOptions writing{options.block_ticks};
    if (header.mode == Mode::commands) writing.assets = assets_in_order(world.assets());
    return Writer::begin(sink, header, world.schema(), world.def(), world.hash(), world.save_portable(),
                         writing);
}

bool is_due(const Writer& writer, std::uint64_t keyframe_ticks) {
    return keyframe_ticks != 0 && writer.next_tick() - writer.last_keyframe() >= keyframe_ticks;
}

Error out_of_order(std::uint64_t tick, std::uint64_t expected) {
    return {join("cannot record tick ", tick, ": tick ", expected,
                 " comes next; ticks are recorded once and in order")};
}

} // namespace

// ---- InputRecorder -------------------------------------------------------------------------------------------

Result<InputRecorder> InputRecorder::begin(Sink& sink, const Game& game, const World& start,
                                           const RecorderOptions& options) {
    Header header = header_of(start, options);
    header.mode = Mode::inputs;
    header.game = game.name();
    header.content_id = game.content_id();
    header.player_count = game.player_count();
    header.input_size = game.input_size();
    Result<Writer> writer = begin_at(sink, header, start, options);
    if (!writer) return writer.error();
    return InputRecorder(std::move(*writer), options.keyframe_ticks);
}

InputRecorder InputRecorder::resume(Writer writer, std::uint64_t keyframe_ticks) {
    return InputRecorder(std::move(writer), keyframe_ticks);
}

Status InputRecorder::on_tick(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash) {
    if (const Status status = writer.status(); !status) return status;
    if (tick != writer.next_tick()) return out_of_order(tick, writer.next_tick());
    return writer.add_inputs(inputs, hash);
}

bool InputRecorder::keyframe_due() const { return is_due(writer, keyframe_ticks); }

Status InputRecorder::keyframe(const World& world) {
    if (const Status status = writer.status(); !status) return status;
    if (world.tick_count() != writer.next_tick())
        return Error{join("cannot record a keyframe: the world stands at ", world.tick_count(),
                          ", the recording at ", writer.next_tick())};
    if (world.hash() != writer.last_hash())
        return Error{join("cannot record a keyframe at ", world.tick_count(), ": the world's hash is ",
                          base::hex(world.hash()), ", the last tick was recorded with ",
                          base::hex(writer.last_hash()))};
    return writer.add_keyframe(world.save_portable());
}

Status InputRecorder::after_tick(const World& world, std::span<const PlayerInput> inputs) {
    if (world.tick_count() == 0) return out_of_order(0, writer.next_tick());
    if (const Status status = on_tick(world.tick_count() - 1, inputs, world.hash()); !status) return status;
    return keyframe_due() ? keyframe(world) : Status{};
}

// ---- CommandRecorder -----------------------------------------------------------------------------------------

Result<std::unique_ptr<CommandRecorder>>
CommandRecorder::begin(Sink& sink, World& world, const std::string& label, const RecorderOptions& options) {
    Header header = header_of(world, options);
    header.mode = Mode::commands;
    header.game = label;
    Result<Writer> writer = begin_at(sink, header, world, options);
    if (!writer) return writer.error();
    return resume(std::move(*writer), world, options.keyframe_ticks);
}

std::unique_ptr<CommandRecorder> CommandRecorder::resume(Writer writer, World& world,
                                                         std::uint64_t keyframe_ticks) {
    std::unique_ptr<CommandRecorder> recorder(new CommandRecorder(std::move(writer), world, keyframe_ticks));
    world.set_journal(recorder.get());
    return recorder;
}

CommandRecorder::~CommandRecorder() { detach(); }

void CommandRecorder::detach() {
    if (world == nullptr) return;
    LOCKSTONE_ASSERT(!lifetime.expired(), "the world was destroyed before its recorder");
    std::exchange(world, nullptr)->set_journal(nullptr);
}

void CommandRecorder::on_command(std::uint64_t tick, const Command& command) {
    if (!state) return;
    if (tick != writer.next_tick())
        state = out_of_order(tick, writer.next_tick());
    else
        pending.push_back(command);
}

void CommandRecorder::on_tick(std::uint64_t tick, std::uint64_t hash) {
    if (!state) return;
    if (tick != writer.next_tick())
        state = out_of_order(tick, writer.next_tick());
    else
        state = writer.add_commands(pending, hash);
    pending.clear();
    if (state && is_due(writer, keyframe_ticks)) state = writer.add_keyframe(world->save_portable());
}

void CommandRecorder::on_restore(std::uint64_t tick) {
    if (state)
        state = Error{join("cannot record on: the world was restored to tick ", tick,
                           ", and commands alone do not lead there")};
}

Status CommandRecorder::close() {
    detach();
    if (!state) return state;
    return state = writer.close();
}

} // namespace lockstone::replay
