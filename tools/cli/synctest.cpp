// The command `lockstone synctest`.
#include "cli/progress.h"
#include "cli/scene_choice.h"
#include "cli/text.h"
#include "lockstone/session.h"
#include "lockstone/session/forgetful.h"

#include <cstdio>

namespace lockstone::cli {
namespace {

struct Args {
    SceneChoice choice;
    std::uint64_t ticks = 600;
    std::uint32_t depth = 7, threads = 1;
    std::string plant;
};

void describe(CLI::App& command, Args& args) {
    describe_scene(command, args.choice);
    add_number(command, "--ticks", args.ticks, "number of ticks to run");
    add_number(command, "--depth", args.depth, "number of ticks that every tick rolls back, 1 to 64", 1, 64);
    add_threads(command, args.threads);
    add_text(command, "--plant", args.plant, "plant a fault: the snapshots leave out this column");
}

/// A session needs at least one player. This wrapper adds a player without input to a scene that has none.
class WithPlayer final : public Game {
  public:
    explicit WithPlayer(const Game& rules) : game(rules) {}
    std::string name() const override { return game.name(); }
    std::uint64_t content_id() const override { return game.content_id(); }
    std::uint32_t player_count() const override { return std::max(1u, game.player_count()); }
    std::uint32_t input_size() const override { return game.input_size(); }
    Result<World> start() const override { return game.start(); }
    Status advance(World& world, std::span<const PlayerInput> inputs) const override {
        return game.advance(world, inputs.first(game.player_count()));
    }

  private:
    const Game& game;
};

Status check_column(const World& world, const std::string& column) {
    if (column.empty() || world.state().layout().find_column(column) != nullptr) return {};
    std::string names;
    for (const ColumnInfo& info : world.state().layout().columns())
        names += (names.empty() ? "" : ", ") + info.name;
    return Error{"--plant " + column + ": there is no such column; the columns are " + names};
}

Result<Exit> synctest(const Args& args) {
    Result<Started> started = start(args.choice);
    if (!started) return started.error();
    if (Status s = check_column(started->world, args.plant); !s) return s.error();
    if (args.ticks <= args.depth) // no tick has so many ticks before it
        return Error{args.choice.scene + ": " + std::to_string(args.ticks) +
                     " ticks are too few to roll back by " + std::to_string(args.depth) +
                     ", so nothing would be compared: --ticks must be more than --depth"};
    const WithPlayer game(*started->game);
    const std::vector<PeerId> players(game.player_count(), 0);
    const Result<std::unique_ptr<Session>> session =
        make_sync_test_session(session_def(game, 0, players), args.depth);
    if (!session) return session.error();
    const std::unique_ptr<Tasks> tasks = tasks_of(args.threads);
    started->world.set_tasks(tasks.get());
    WorldSimulation simulation(started->world, game);
    testing::ForgetfulSimulation planted(simulation, args.plant);
    SessionRunner runner(**session, planted);
    std::vector<std::byte> input(game.input_size());
    Progress progress(args.choice.scene, args.ticks);
    while ((*session)->current_tick() < args.ticks) {
        const std::uint64_t tick = (*session)->current_tick();
        for (std::uint32_t p = 0; p < game.player_count(); ++p) {
            scripted_input(*started->game, args.choice.options.seed, tick, p, input);
            (*session)->add_local_input(p, input);
        }
        runner.frame(tick);
        if (const SyncTestFailure* failure = runner.sync_failure()) {
            std::printf("%s: %s\n", started->game->name().c_str(), to_string(*failure).c_str());
            return Exit::check_failed;
        }
        progress.at(tick + 1);
    }
    const SessionStats& stats = (*session)->stats();
    std::printf(
        "%s: %llu ticks, %llu times rolled back %u ticks and run again, %llu hashes compared: bit-exact, "
        "hash %s\n",
        started->game->name().c_str(), static_cast<unsigned long long>(args.ticks),
        static_cast<unsigned long long>(stats.rollbacks), args.depth,
        static_cast<unsigned long long>(stats.hashes_compared), hash_text(started->world.hash()).c_str());
    return Exit::good;
}

} // namespace

void add_synctest(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "synctest", "Roll back every tick, run it again, compare complete hashes.",
                      describe, synctest);
}

} // namespace lockstone::cli
