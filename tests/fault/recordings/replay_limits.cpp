// The limits of untrusted files: the reader bounds memory and work before it spends them; definitions are covered by a
// hash; a game's rules refuse states from which they cannot continue.
#include "lockstone/prove.h"
#include "lockstone/session.h"
#include "scenes/scenes.h"
#include "support/small_recording.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::replay;
using namespace lockstone::test;

namespace {

bool holds(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

const Bytes& commands_file() {
    static const Bytes file = record_commands(8, {.keyframe_ticks = 4, .block_ticks = 4});
    return file;
}

Bytes with_definition(const WorldDef& def) {
    auto chunks = chunks_of(commands_file());
    Bytes& payload = chunks[find_chunk(chunks, chunk_world_def)].payload;
    payload.clear();
    append_world_def(def, payload);
    return file_of(std::move(chunks), true);
}

Result<Recording> read_with(Bytes file, const Limits& limits) {
    return Recording::from_bytes(std::move(file), "test.lsr", OnDamage::refuse, limits);
}

/// Packed zeros that unpack to about `bytes`, in whole runs.
Bytes packed_zeros(std::uint64_t bytes) {
    Bytes out;
    for (std::uint64_t runs = bytes / 130; runs > 0; --runs)
        out.push_back(std::byte{255}), out.push_back(std::byte{0});
    return out;
}

/// A first tick with `count` explosions.
Bytes with_explosions(std::uint32_t count) {
    auto chunks = chunks_of(commands_file());
    BlockBuilder builder({Mode::commands, 0, 0});
    const std::vector<Command> commands(count, Explode{{.radius = Real(10), .impulse = Real(1)}});
    must(builder.add_commands(commands, 0));
    Bytes& payload = chunks[find_chunk(chunks, chunk_ticks)].payload;
    payload.clear();
    builder.finish(0, payload);
    return file_of(std::move(chunks), true);
}

} // namespace

TEST_CASE(
    "a recording with a change in any field of the world's definition never verifies under new checksums") {
    const WorldDef good = must(read(commands_file())).world_def();
    REQUIRE(verify(must(read(with_definition(good))), nullptr).good());
    Bytes bytes;
    append_world_def(good, bytes);
    int read_but_bad = 0;
    for (std::size_t at = 0; at < bytes.size(); ++at) {
        CAPTURE(at);
        auto chunks = chunks_of(commands_file());
        chunks[find_chunk(chunks, chunk_world_def)].payload[at] ^= std::byte{1};
        const auto recording = read(file_of(std::move(chunks), true));
        if (!recording) continue;
        CHECK(!verify(*recording, nullptr).good());
        ++read_but_bad;
    }
    CHECK(read_but_bad > 0); // the others are refused at once
}

TEST_CASE("the verifier rejects a definition above the memory limit before it allocates anything") {
    WorldDef def = must(read(commands_file())).world_def();
    def.bodies_max = def.shapes_max = def.contacts_max = def.pair_filters_max = def.joints_max = 1u << 20;
    def.characters_max = def.vehicles_max = 65536;
    CHECK(World::memory_of(def).value().all() > std::uint64_t{4} << 30);
    const VerifyReport report = verify(must(read(with_definition(def))), nullptr);
    CHECK(report.verdict == Verdict::unusable);
    CHECK(holds(report.sentence, "bytes of memory, the limit is 1073741824 (--memory)"));
    // The negative control: a definition within the limit plays, and is refused under a smaller limit.
    CHECK(verify(must(read(commands_file())), nullptr).good());
    CHECK(!verify(must(read_with(commands_file(), {.memory = 1 << 20})), nullptr).good());
}

TEST_CASE(
    "the reader does not unpack an image of packed zeros and the verifier does not play it above the limit") {
    auto chunks = chunks_of(commands_file());
    const Bytes zeros = packed_zeros(std::uint64_t{130} << 20);
    Bytes& payload = chunks[find_chunk(chunks, chunk_keyframe)].payload;
    payload.resize(16);
    base::ByteWriter(payload).u64(std::uint64_t{130} << 20);
    payload.insert(payload.end(), zeros.begin(), zeros.end());
    const Recording recording =
        must(read_with(file_of(std::move(chunks), true), {.memory = std::uint64_t{64} << 20}));
    CHECK(recording.memory() < std::uint64_t{8} << 20);
    CHECK(holds(verify(recording, nullptr).sentence, "the limit is 67108864 (--memory)"));
}

TEST_CASE("the reader rejects a tick with more work than the limit") {
    // The second tick does not continue the first one, so recovery reads the file up to there.
    const auto first_tick = [](std::uint32_t explosions, const Limits& limits) {
        return must(
            Recording::from_bytes(with_explosions(explosions), "test.lsr", OnDamage::recover, limits));
    };
    CHECK(first_tick(1024, {}).tick_count() == 1); // 64 each: exactly the default limit
    CHECK(first_tick(1025, {}).tick_count() == 0);
    CHECK(holds(first_tick(1025, {}).damage(), "tick 0 has 1025 commands"));
    CHECK(first_tick(1025, {.commands_per_tick = 1u << 20}).tick_count() == 1);
    CHECK(!read_with(commands_file(), {.commands_per_tick = 1}).ok());
}

TEST_CASE("jobs of a verification share the memory limit and give the verdict of one job") {
    const Bytes file = record_commands(40, {.keyframe_ticks = 5});
    const Recording roomy = must(read(file));
    const std::uint64_t each = Player::memory_of(roomy, roomy.world_def(), roomy.schema());
    for (const std::uint64_t players : {1u, 2u, 9u}) {
        const Recording tight =
            must(read_with(file, {.memory = roomy.memory() + players * each + (1u << 16)}));
        const VerifyReport report = verify(tight, nullptr, {.jobs = 8});
        CHECK_MESSAGE(report.good(), report.sentence);
        CHECK(report.ticks == 40);
    }
    const Recording none = must(read_with(file, {.memory = roomy.memory() + each / 2}));
    CHECK(verify(none, nullptr, {.jobs = 8}).verdict == Verdict::unusable);
}

// ---- games ---------------------------------------------------------------------------------------------------

namespace {

/// A game without check(): the planted fault of every test here.
class Blind final : public Game {
  public:
    explicit Blind(const Game& rules) : game(rules) {}
    std::string name() const override { return game.name(); }
    std::uint64_t content_id() const override { return game.content_id(); }
    std::uint32_t player_count() const override { return game.player_count(); }
    std::uint32_t input_size() const override { return game.input_size(); }
    Result<World> start() const override { return game.start(); }
    Status advance(World& world, std::span<const PlayerInput> inputs) const override {
        return game.advance(world, inputs);
    }

  private:
    const Game& game;
};

/// Rules that fail at a tick.
class Failing final : public SmallGame {
  public:
    Status advance(World& world, std::span<const PlayerInput> inputs) const override {
        if (world.tick_count() == 3) return Error{"the ball is gone"};
        return SmallGame::advance(world, inputs);
    }
};

/// Sets each leaf of the game's columns to an invalid id. The game must refuse the state, or advance it or fail with a
/// sentence.
void check_game_columns(const Game& game, int& refused) {
    World world = must(game.start());
    REQUIRE(game.check(world).ok());
    const State good = world.state();
    const std::vector<std::byte> zeros(game.input_size());
    const std::vector<PlayerInput> inputs(game.player_count(), PlayerInput{zeros});
    const std::span<const ColumnInfo> columns = good.layout().columns();
    for (std::uint32_t c = 0; c < columns.size(); ++c) {
        if (columns[c].group != Group::game) continue;
        for (const LeafInfo& leaf : columns[c].leaves) {
            State state = good;
            const auto bytes = state.edit_bytes(c);
            if (bytes.empty()) continue;
            const std::uint64_t value = ~std::uint64_t{0};
            std::memcpy(bytes.data() + leaf.offset, &value, leaf.size);
            must(world.restore_portable(state.save_portable()));
            CAPTURE(columns[c].name);
            CAPTURE(leaf.name);
            if (const Status status = game.check(world); !status) {
                CHECK(holds(status.error().message, "column game."));
                ++refused;
            } else if (const Status gone_on = game.advance(world, inputs); !gone_on) {
                CHECK(gone_on.error().message.size() > 20);
            }
        }
    }
}

/// A recording of the game's start and two ticks, with a dead id in the first leaf of its first column.
Bytes with_dead_id(const Game& game) {
    World world = must(game.start());
    MemorySink sink;
    auto recorder = must(InputRecorder::begin(sink, game, world));
    const std::vector<std::byte> zeros(game.input_size());
    const std::vector<PlayerInput> inputs(game.player_count(), PlayerInput{zeros});
    for (int t = 0; t < 2; ++t) {
        must(game.advance(world, inputs));
        must(recorder.after_tick(world, inputs));
    }
    must(recorder.close());
    auto chunks = chunks_of(sink.bytes);
    World start = must(game.start());
    State state = start.state();
    const std::span<const ColumnInfo> columns = state.layout().columns();
    const auto column = std::ranges::find(columns, Group::game, &ColumnInfo::group);
    state.edit_bytes(static_cast<std::uint32_t>(column - columns.begin()))[0] = std::byte{77};
    const Bytes image = state.save_portable();
    Bytes& payload = chunks[find_chunk(chunks, chunk_keyframe)].payload;
    payload.clear();
    base::ByteWriter to(payload);
    to.u64(0), to.u64(state.hash()), to.u64(image.size());
    pack(image, payload);
    return file_of(std::move(chunks), true);
}

} // namespace

TEST_CASE("the built-in games reject a dead id in their columns or continue without it") {
    int refused = 0;
    for (const SceneInfo& info : scenes()) {
        CAPTURE(info.name);
        SceneOptions options;
        if (info.size_default > 20) options.size = std::max(info.size_min, 10u);
        options.players = info.players_max;
        check_game_columns(*must(make_scene(info.name, options)), refused);
    }
    CHECK(refused > 150);
}

TEST_CASE("verifying and playing and branching reject a recording whose start has a dead id of the game") {
    for (const char* name : {"cars", "character", "two-blocks"}) {
        const std::unique_ptr<Game> game = must(make_scene(name));
        const Recording recording = must(read(with_dead_id(*game)));
        CHECK(verify(recording, game.get()).verdict == Verdict::unusable);
        const auto player = Player::open(recording, *game);
        REQUIRE(!player);
        CHECK(holds(player.error().message, "keyframe at 0: the game refuses the state: column game."));
        MemorySink sink;
        CHECK(!branch_inputs(recording, *game, 1, sink).ok());
        CHECK(Player::open(recording, Blind(*game)).ok()); // negative control: only the game can detect it
    }
}

TEST_CASE("a tick whose game rules fail ends the play with a sentence") {
    const Recording recording = must(read(record_inputs(6)));
    const Failing failing;
    auto player = must(Player::open(recording, failing));
    const Status status = player.seek(6);
    REQUIRE(!status);
    CHECK(holds(status.error().message, "test.lsr: tick 3: the game's rules fail: the ball is gone"));
    const VerifyReport report = verify(recording, &failing);
    CHECK(report.verdict == Verdict::diverged);
    CHECK(report.first_bad_tick == 3);
}

TEST_CASE(
    "a session runs past a tick whose rules fail and reports the first failure while a proof ends with it") {
    const Failing failing;
    World world = must(failing.start());
    WorldSimulation simulation(world, failing);
    for (int t = 0; t < 6; ++t) simulation.advance(SmallInputs(SmallGame::script(world.tick_count())).list);
    CHECK(world.tick_count() == 6);
    REQUIRE(!simulation.failure());
    CHECK(simulation.failure().error().message == "tick 3: the game's rules fail: the ball is gone");
    const auto nothing = [](std::uint64_t, std::uint32_t, std::span<std::byte>) {};
    const auto proof = prove(failing, {.ticks = 8}, nothing);
    REQUIRE(!proof);
    CHECK(holds(proof.error().message, "tick 3: the game's rules fail: the ball is gone"));
    const SmallGame good; // negative control
    CHECK(prove(good, {.ticks = 8, .bits_max = 100}, nothing).ok());
}
