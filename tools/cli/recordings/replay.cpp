// The commands `lockstone replay` and `lockstone info`.
#include "cli/progress.h"
#include "cli/recordings/recording_choice.h"
#include "cli/text.h"
#include "replay/player.h"
#include "json/json.h"

#include <cstdio>
#include <optional>

namespace lockstone::cli {
namespace {

struct ReplayArgs {
    std::string file, hashes;
    std::optional<std::uint64_t> from, to;
    std::uint32_t threads = 1;
    LimitChoice limits;
};

void describe(CLI::App& command, ReplayArgs& args) {
    add_text(command, "FILE", args.file, "a recording (.lsr)").required();
    add_number(command, "--from", args.from, "tick to start at; default: the first of the recording");
    add_number(command, "--to", args.to, "tick to stop at; default: the last of the recording");
    add_threads(command, args.threads);
    add_text(command, "--hashes", args.hashes,
             "write a line for each tick to this file: tick, tab, root hash after the tick");
    describe_limits(command, args.limits);
}

struct Range {
    std::uint64_t from, to;
};
Result<Range> range_of(const ReplayArgs& args, const replay::Recording& recording) {
    const Range all{recording.start_tick(), recording.end_tick()};
    const Range range{args.from.value_or(all.from), args.to.value_or(all.to)};
    if (range.from < all.from || range.to > all.to || range.from > range.to)
        return Error{args.file + ": holds ticks " + std::to_string(all.from) + " to " +
                     std::to_string(all.to) + ", not " + std::to_string(range.from) + " to " +
                     std::to_string(range.to)};
    return range;
}

Exit parted(const std::string& file, std::uint64_t tick, const World& world, std::uint64_t recorded) {
    print_line(file + ": differs from the recording at tick " + std::to_string(tick) + ": hash " +
               hash_text(world.hash()) + " against " + hash_text(recorded));
    return Exit::check_failed;
}

Result<Exit> play(const ReplayArgs& args) {
    if (Status s = check_outputs({args.hashes}, {args.file}); !s) return s.error();
    const Result<Loaded> loaded = load(args.file, args.limits.limits());
    if (!loaded) return loaded.error();
    const Result<Range> range = range_of(args, loaded->recording);
    if (!range) return range.error();
    Result<replay::Player> player = replay::Player::open(loaded->recording, loaded->game.get());
    if (!player) return player.error();
    const std::unique_ptr<Tasks> tasks = tasks_of(args.threads);
    player->world().set_tasks(tasks.get());
    if (Status s = player->seek(range->from); !s) return s.error();
    if (!player->agrees())
        return parted(args.file, range->from, player->world(), loaded->recording.hash_at(range->from));
    std::string hashes;
    Progress progress(args.file, range->to - range->from);
    while (player->time() < range->to) {
        const std::uint64_t tick = player->time();
        if (Status s = player->step(); !s) return s.error();
        hashes += std::to_string(tick) + '\t' + hash_text(player->world().hash()) + '\n';
        if (!player->agrees())
            return parted(args.file, tick, player->world(), loaded->recording.hash_at(player->time()));
        progress.at(player->time() - range->from);
    }
    if (!args.hashes.empty())
        if (Status s = write_file(args.hashes, hashes); !s) return s.error();
    const std::string hash = hash_text(player->world().hash());
    if (range->from == range->to)
        print_line(args.file + ": the range contains no tick; the state at time " +
                   std::to_string(range->to) + " has the recorded hash, " + hash);
    else
        print_line(args.file + ": ticks " + std::to_string(range->from) + " to " + std::to_string(range->to) +
                   " are bit-exact, hash " + hash);
    return Exit::good;
}

struct InfoArgs {
    std::string file;
    bool json = false;
    LimitChoice limits;
};

void describe(CLI::App& command, InfoArgs& args) {
    add_text(command, "FILE", args.file, "a recording (.lsr)").required();
    add_flag(command, "--json", args.json, "print JSON");
    describe_limits(command, args.limits);
}

json::Value facts_of(const replay::Recording& recording) {
    const replay::Header& head = recording.header();
    json::Value options = json::Value::object();
    for (const replay::Option& option : head.options) options[option.key] = option.value;
    json::Value columns = json::Value::array();
    for (const GameSchema::Entry& column : recording.schema().entries()) columns.push_back(column.name);
    return {{"file", recording.name()},
            {"mode", replay::name_of(head.mode)},
            {"engine", head.engine},
            {"game", head.game},
            {"content_id", hash_text(head.content_id)},
            {"schema_hash", hash_text(head.schema_hash)},
            {"tick_rate", head.tick_rate},
            {"players", head.player_count},
            {"input_size", head.input_size},
            {"complete", recording.complete()},
            {"start_tick", recording.start_tick()},
            {"ticks", recording.tick_count()},
            {"seconds", static_cast<double>(recording.tick_count()) / head.tick_rate},
            {"keyframes", recording.keyframes().size()},
            {"bytes", recording.size_bytes()},
            {"hash", hash_text(recording.hash_at(recording.end_tick()))},
            {"checksum", hash_text(recording.checksum())},
            {"columns", columns},
            {"options", options}};
}

Result<Exit> inform(const InfoArgs& args) {
    const Result<replay::Recording> recording = open_recording(args.file, args.limits.limits());
    if (!recording) return recording.error();
    const json::Value facts = facts_of(*recording);
    if (args.json) {
        std::printf("%s\n", facts.dump(2).c_str());
        return Exit::good;
    }
    for (const auto& [key, value] : facts.members())
        print_line(key + std::string(key.size() < 12 ? 12 - key.size() : 0, ' ') + ' ' +
                   (value.is_text() ? value.as_text() : value.dump()));
    return Exit::good;
}

} // namespace

void add_replay(CLI::App& app, Work& work) {
    add_command<ReplayArgs>(app, work, "replay", "Re-simulate a recording and compare every tick's hash.",
                            describe, play);
    add_command<InfoArgs>(app, work, "info", "Print the header, the size and the last hash of a recording.",
                          describe, inform);
}

} // namespace lockstone::cli
