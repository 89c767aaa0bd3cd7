#include "replay/player.h"

#include "replay/format/codec.h"

#include <algorithm>

namespace lockstone::replay {
namespace {

using base::hex;
using base::join;

constexpr std::uint64_t kept_ticks = 60;

/// Checks that the game is the one of the recording. Returns an empty text if it is, else the error.
std::string game_fault(const Header& header, const Game& game) {
    if (game.name() != header.game) return join("it is of the game ", header.game, ", this is ", game.name());
    if (game.content_id() != header.content_id)
        return join("it was recorded with content id ", hex(header.content_id), " of ", header.game,
                    ", this is ", hex(game.content_id()));
    if (game.player_count() != header.player_count)
        return join("it has ", header.player_count, " players, the game ", game.player_count());
    if (game.input_size() != header.input_size)
        return join("its inputs have ", header.input_size, " bytes, the game's ", game.input_size());
    return {};
}

std::string world_fault(const Recording& recording, const World& world) {
    if (const std::string difference = first_difference(recording.world_def(), world.def());
        !difference.empty())
        return join("the recorded world is defined otherwise than the game's: ", difference);
    std::vector<std::byte> recorded, ours;
    append_schema(recording.schema(), recorded);
    append_schema(world.schema(), ours);
    if (recorded != ours) return "the recorded game columns are not those of the game";
    const std::uint64_t schema = world.state().layout().schema_hash();
    if (schema != recording.header().schema_hash)
        return join("its state has schema ", hex(recording.header().schema_hash), ", this engine's has ",
                    hex(schema), ": it was recorded by engine ", recording.header().engine, ", this is ",
                    engine_version);
    return {};
}

/// Checks rules that World::create asserts: its caller is a program, but this schema comes from a file.
std::string schema_fault(const GameSchema& schema) {
    WorldDef least;
    least.bodies_max = least.shapes_max = least.contacts_max = least.fields_max = least.pair_filters_max = 1;
    least.joints_max = least.characters_max = least.vehicles_max = 1;
    const Result<World> plain = World::create(least);
    if (!plain) return plain.error().message;
    for (const GameSchema::Entry& entry : schema.entries())
        if (plain->state().layout().find_column(entry.name) != nullptr)
            return join("the game's column ", entry.name, " has the name of one of the engine's");
    return {};
}

/// Checks that a world of this definition can play the recording within its limits. Returns an empty text if it can.
std::string memory_fault(const Recording& recording, const WorldDef& def, const GameSchema& schema) {
    if (const auto bytes = World::memory_of(def, schema); !bytes) return bytes.error().message;
    const std::uint64_t need = recording.memory() + Player::memory_of(recording, def, schema);
    if (need <= recording.limits().memory) return {};
    return join("playing it may take ", need, " bytes of memory, the limit is ", recording.limits().memory,
                " (--memory)");
}

} // namespace

Error Player::error(const std::string& sentence) const { return {join(source->name(), ": ", sentence)}; }

Result<Player> Player::open(const Recording& recording, const Game& game) { return open(recording, &game); }
Result<Player> Player::open(const Recording& recording) { return open(recording, nullptr); }

Result<Player> Player::open(const Recording& recording, const Game* game) {
    const Header& header = recording.header();
    const auto refuse = [&](const std::string& why) {
        return Error{join(recording.name(), ": cannot be played: ", why)};
    };
    if (header.mode == Mode::commands) {
        if (const std::string fault = schema_fault(recording.schema()); !fault.empty()) return refuse(fault);
        if (const std::string fault = memory_fault(recording, recording.world_def(), recording.schema());
            !fault.empty())
            return refuse(fault);
        Result<World> world = World::create(recording.world_def(), recording.schema(), recording.assets());
        return world ? at_start(recording, nullptr, std::move(*world)) : refuse(world.error().message);
    }
    if (game == nullptr) return refuse(join("it holds inputs, so it needs the game ", header.game));
    if (const std::string fault = game_fault(header, *game); !fault.empty()) return refuse(fault);
    Result<World> world = game->start();
    return world ? at_start(recording, game, std::move(*world)) : refuse(world.error().message);
}

std::uint64_t Player::memory_of(const Recording& recording, const WorldDef& def, const GameSchema& schema) {
    const Result<World::Memory> world = World::memory_of(def, schema);
    std::uint64_t image = 0;
    for (const Recording::Keyframe& keyframe : recording.keyframes())
        image = std::max(image, keyframe.image_size);
    // The world; states into which keyframes are read and with which they are compared; keyframes as recorded and as
    // computed.
    return (world ? world->all() + 3 * world->state : 0) + 4 * image + recording.commands_memory();
}

Result<Player> Player::at_start(const Recording& recording, const Game* game, World world) {
    if (const std::string fault = world_fault(recording, world); !fault.empty())
        return Error{join(recording.name(), ": cannot be played: ", fault)};
    if (const std::string fault = memory_fault(recording, world.def(), world.schema()); !fault.empty())
        return Error{join(recording.name(), ": cannot be played: ", fault)};
    const std::uint64_t taken = recording.memory() + memory_of(recording, world.def(), world.schema());
    world.set_journal(nullptr);
    Player player(recording, game, std::move(world));
    player.kept_bytes_max = static_cast<std::size_t>(
        std::min<std::uint64_t>(player.kept_bytes_max, recording.limits().memory - taken));
    if (const Status status = player.seek_keyframe(0); !status) return status.error();
    return player;
}

Status Player::step() {
    if (at_end()) return error(join("it ends at tick ", time_now));
    if (game == nullptr) {
        if (const Status status = run_commands(); !status) return status;
    } else {
        if (const Status status = game->advance(now, cursor.at(time_now).inputs(time_now)); !status)
            return error(join("tick ", time_now, ": the game's rules fail: ", status.error().message));
    }
    if (now.tick_count() != time_now + 1)
        return error(join("tick ", time_now, ": the game left the world at tick ", now.tick_count(), ", not ",
                          time_now + 1));
    ++time_now;
    if (time_now % kept_ticks == 0) keep_state();
    return {};
}

void Player::keep_state() {
    const std::size_t bytes = now.state().image_bytes();
    if (kept.contains(time_now) || kept_bytes + bytes > kept_bytes_max || !agrees()) return;
    now.save(kept[time_now]);
    kept_bytes += bytes;
}

Status Player::run_commands() {
    const std::vector<Command> commands = cursor.at(time_now).commands(time_now);
    for (std::size_t i = 0; i < commands.size(); ++i) {
        const auto applied = now.apply(commands[i]);
        if (!applied)
            return error(join("tick ", time_now, ": command ", i, " (", name_of(commands[i]),
                              ") is refused: ", applied.error().message));
    }
    now.tick();
    return {};
}

Status Player::seek(std::uint64_t to) {
    if (to < source->start_tick() || to > source->end_tick())
        return error(join("time ", to, " lies outside of ", source->start_tick(), "..", source->end_tick()));
    const std::size_t keyframe = source->keyframe_before(to);
    const std::uint64_t keyframe_time = source->keyframes()[keyframe].time;
    const auto after = kept.upper_bound(to);
    const bool has_kept = after != kept.begin() && std::prev(after)->first >= keyframe_time;
    const std::uint64_t nearest = has_kept ? std::prev(after)->first : keyframe_time;
    if (to < time_now || nearest > time_now) {
        if (has_kept) {
            now.restore(std::prev(after)->second);
            time_now = nearest;
        } else if (const Status status = seek_keyframe(keyframe); !status) {
            return status;
        }
    }
    while (time_now < to)
        if (const Status status = step(); !status) return status;
    return {};
}

Status Player::seek_keyframe(std::size_t keyframe) {
    if (keyframe >= source->keyframes().size())
        return error(join("there is no keyframe ", keyframe, ": it has ", source->keyframes().size()));
    const Recording::Keyframe& which = source->keyframes()[keyframe];
    const std::string where = join("keyframe at ", which.time, ": ");
    Image before;
    if (game != nullptr) now.save(before);
    if (const Status status = now.restore_portable(source->keyframe_image(keyframe)); !status)
        return error(where + status.error().message);
    if (const Status status = game == nullptr ? Status() : game->check(now); !status) {
        now.restore(before); // the game cannot go on from the refused state
        return error(join(where, "the game refuses the state: ", status.error().message));
    }
    time_now = which.time;
    if (now.tick_count() != which.time) return error(join(where, "its state is of tick ", now.tick_count()));
    if (now.hash() != which.hash)
        return error(join(where, "its state has hash ", hex(now.hash()), ", recorded is ", hex(which.hash)));
    return {};
}

} // namespace lockstone::replay
