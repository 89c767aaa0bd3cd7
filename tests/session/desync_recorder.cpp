// A recorder notes the commands of a world that a session drives. The inquiry into a desync must not end the recording.
#include "lockstone/session.h"
#include "replay/recorder.h"
#include "replay/recording.h"
#include "replay/verifier.h"
#include "scenes/scenes.h"

#include <doctest/doctest.h>

#include <array>
#include <memory>

using namespace lockstone;

namespace {

/// The second machine's rules add one push at one tick.
class PushingGame final : public Game {
  public:
    PushingGame(std::unique_ptr<Game> of, std::uint64_t tick) : real(std::move(of)), pushed_at(tick) {}
    std::string name() const override { return real->name(); }
    std::uint64_t content_id() const override { return real->content_id(); }
    std::uint32_t player_count() const override { return real->player_count(); }
    std::uint32_t input_size() const override { return real->input_size(); }
    Result<World> start() const override { return real->start(); }
    Status advance(World& world, std::span<const PlayerInput> inputs) const override {
        for (std::uint32_t row = 0; world.tick_count() == pushed_at && row < world.body_count(); ++row)
            if (world.kind(world.body_at(row)) == BodyKind::dynamic) {
                if (Status s = world.add_force(world.body_at(row), {9_r, 0_r, 0_r}); !s) return s;
                break;
            }
        return real->advance(world, inputs);
    }

  private:
    std::unique_ptr<Game> real;
    std::uint64_t pushed_at;
};

/// A simulation without run_aside(), as every simulation has that is not a world's.
class NotAside final : public Simulation {
  public:
    explicit NotAside(Simulation& of) : real(of) {}
    void save(Image& image) const override { real.save(image); }
    void restore(const Image& image) override { real.restore(image); }
    void advance(std::span<const PlayerInput> inputs) override { real.advance(inputs); }
    std::uint64_t hash() const override { return real.hash(); }
    std::span<const Event> events() const override { return real.events(); }
    State& state() override { return real.state(); }
    void record_phase_hashes(bool on) override { real.record_phase_hashes(on); }
    std::span<const PhaseHash> phase_hashes() const override { return real.phase_hashes(); }

  private:
    Simulation& real;
};

struct Outcome {
    Status recorded;
    std::vector<std::byte> bytes; ///< recorded by machine 0
    std::shared_ptr<const DesyncReport> report;
    std::uint64_t ticks = 0;
};

/// Plays a lockstep match of two machines whose states differ from tick 60 on. The first machine records its commands.
/// `aside`: the simulations can run a tick aside, as WorldSimulation can.
Outcome play(bool aside) {
    const auto rules = [](std::uint64_t tick) {
        return PushingGame(make_scene("rollback-arena", {.size = 0, .seed = 1, .players = 2}).value(), tick);
    };
    const std::array<PushingGame, 2> games{rules(~std::uint64_t{0}), rules(60)};
    SimulatedNetwork network(2, {.latency_ms = 20}, 1);
    std::vector<World> worlds;
    for (const PushingGame& game : games) worlds.push_back(game.start().value());
    replay::MemorySink sink;
    const auto recorder = replay::CommandRecorder::begin(sink, worlds[0], "lockstep").value();
    std::array<WorldSimulation, 2> simulations{WorldSimulation(worlds[0], games[0]),
                                               WorldSimulation(worlds[1], games[1])};
    NotAside wrapped(simulations[0]);
    std::vector<std::unique_ptr<Session>> sessions;
    std::vector<std::unique_ptr<SessionRunner>> runners;
    Outcome out;
    for (PeerId id = 0; id < 2; ++id) {
        SessionDef def = session_def(games[id], id, {0, 1});
        def.input_delay = 4;
        sessions.push_back(make_lockstep_session(def, network.endpoint(id)).value());
        Simulation& driven = id == 0 && !aside ? static_cast<Simulation&>(wrapped) : simulations[id];
        runners.push_back(std::make_unique<SessionRunner>(*sessions[id], driven));
    }
    for (std::uint64_t frame = 0; frame < 300; ++frame) {
        network.advance_to(frame * 1000 / 60);
        for (PeerId id = 0; id < 2; ++id) {
            std::vector<std::byte> input(games[id].input_size());
            scripted_input(games[id], 1, sessions[id]->current_tick(), id, input);
            sessions[id]->add_local_input(id, input);
            runners[id]->frame(frame * 1000 / 60);
            while (const auto notice = sessions[id]->next_notice())
                if (const auto* named = std::get_if<DesyncNamed>(&*notice); named && id == 0)
                    out.report = named->report;
        }
    }
    out.ticks = worlds[0].tick_count();
    out.recorded = recorder->close();
    out.bytes = std::move(sink.bytes);
    return out;
}

} // namespace

TEST_CASE(
    "a recording of commands verifies after a desync when the tick is simulated again on a separate world") {
    const Outcome out = play(true);
    REQUIRE(out.report);
    CHECK(out.report->tick == 60);
    CHECK(out.report->complete);
    CHECK(out.report->local_repeats);
    CHECK_FALSE(out.report->phase.empty());
    CHECK(to_string(*out.report).find("tick 60, machine 2: ") == 0); // counted from 1
    CHECK(out.recorded.ok());
    const auto recording = replay::Recording::from_bytes(out.bytes, "recording").value();
    const auto verified = replay::verify(recording, nullptr);
    CHECK(verified.good());
    CHECK(out.ticks > 200);
}

TEST_CASE("a recording fails and reports why when the tick is simulated again on the played world itself") {
    // The planted fault: the inquiry cannot run a tick aside, so the recording must fail.
    const Outcome out = play(false);
    REQUIRE(out.report);
    REQUIRE_FALSE(out.recorded.ok());
    CHECK(out.recorded.error().message.find("the world was restored to tick 60") != std::string::npos);
}
