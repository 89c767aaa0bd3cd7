// One run, played in many ways: straight, with seeks forwards and backwards, from inputs or commands, by segments or
// threads, from a file or memory, branched and recorded again. The states are equal.
#include "support/small_recording.h"

#include <doctest/doctest.h>

#include <cstdio>
#include <filesystem>
#include <sstream>

using namespace lockstone;
using namespace lockstone::replay;
using namespace lockstone::test;

namespace {

const SmallGame game;

Player player_of(const Recording& recording) {
    return must(Player::open(recording, recording.header().mode == Mode::inputs ? &game : nullptr));
}

/// Visits every tick forwards, backwards and at random.
void seek_everywhere(Player& player, const std::vector<std::uint64_t>& hashes) {
    const auto visit = [&](std::uint64_t t) {
        must(player.seek(t));
        REQUIRE(player.time() == t);
        REQUIRE(player.world().hash() == hashes[t]);
        REQUIRE(player.agrees());
    };
    for (std::uint64_t t = 0; t < hashes.size(); ++t) visit(t);
    for (std::uint64_t t = hashes.size(); t-- > 0;) visit(t);
    SplitMix random(1);
    for (int i = 0; i < 100; ++i) visit(random.below(static_cast<std::uint32_t>(hashes.size())));
}

} // namespace

TEST_CASE("a seek to any tick in any order gives the state of straight play in both modes") {
    const auto hashes = played_hashes(200);
    for (const std::uint64_t every : {30u, 150u, 0u}) {
        const RecorderOptions options{.keyframe_ticks = every};
        for (const Bytes& bytes : {record_inputs(200, options), record_commands(200, options)}) {
            const Recording recording = must(read(bytes));
            Player player = player_of(recording);
            if (every == 30) player.keep_states(0);
            seek_everywhere(player, hashes);
            CHECK(!player.seek(201));
            must(player.seek(200));
            CHECK(player.at_end());
            CHECK(player.step().error().message == "test.lsr: it ends at tick 200");
        }
    }
}

TEST_CASE("a player does not keep a world for later that was changed by hand while it was shown") {
    const auto hashes = played_hashes(200);
    const Recording recording = must(read(record_inputs(200, {.keyframe_ticks = 0})));
    Player player = must(Player::open(recording, game));
    must(player.world().set_gravity({}));
    must(player.seek(150));
    CHECK(!player.agrees());
    seek_everywhere(player, hashes);
}

TEST_CASE("verifying straight or from keyframes or by threads or by shards covers the same ticks") {
    for (const Bytes& bytes :
         {record_inputs(250, {.keyframe_ticks = 40}), record_commands(250, {.keyframe_ticks = 40})}) {
        const Recording recording = must(read(bytes));
        const Game* rules = recording.header().mode == Mode::inputs ? &game : nullptr;
        std::atomic<std::uint64_t> done = 0;
        for (const VerifyOptions& options :
             {VerifyOptions{.ticks_done = &done}, VerifyOptions{.from_keyframes = true, .ticks_done = &done},
              VerifyOptions{.jobs = 2, .ticks_done = &done},
              VerifyOptions{.jobs = 50, .ticks_done = &done}}) {
            done = 0;
            const VerifyReport report = verify(recording, rules, options);
            REQUIRE_MESSAGE(report.good(), report.sentence);
            CHECK(report.ticks == 250);
            CHECK(report.hashes_compared >= 250);
            CHECK(report.keyframes_compared == 6);
            CHECK(done == 250);
        }
        std::uint64_t ticks = 0, keyframes = 0;
        for (std::uint32_t shard = 0; shard < 3; ++shard) {
            const VerifyReport report = verify(recording, rules, {.shard = shard, .shards = 3});
            REQUIRE(report.good());
            ticks += report.ticks;
            keyframes += report.keyframes_compared;
        }
        CHECK(ticks == 250);
        CHECK(keyframes == 6);
    }
}

TEST_CASE("recording the play of a recording gives the same file byte for byte") {
    const RecorderOptions options{.options = {{"seed", "7"}}, .keyframe_ticks = 25, .block_ticks = 16};
    for (const bool is_inputs : {true, false}) {
        const Bytes first = is_inputs ? record_inputs(130, options) : record_commands(130, options);
        const Recording recording = must(read(first));
        Player player = player_of(recording);
        MemorySink sink;
        if (is_inputs) {
            auto recorder = must(InputRecorder::begin(sink, game, player.world(), options));
            while (!player.at_end()) {
                const TickBlock block = recording.block_with(player.time());
                const auto inputs = block.inputs(player.time());
                must(player.step());
                must(recorder.after_tick(player.world(), inputs));
            }
            must(recorder.close());
        } else {
            const auto recorder = must(CommandRecorder::begin(sink, player.world(), "small", options));
            while (!player.at_end()) must(player.step());
            must(recorder->close());
        }
        CHECK(sink.bytes == first);
    }
}

TEST_CASE("a recording through a file or a stream equals the recording in memory") {
    const Bytes bytes = record_inputs(70);
    const std::string path = (std::filesystem::temp_directory_path() / "lockstone_replay_play.lsr").string();
    std::ostringstream text;
    FileSink file = must(FileSink::create(path));
    StreamSink stream(text, "text");
    for (Sink* sink : {static_cast<Sink*>(&file), static_cast<Sink*>(&stream)}) {
        must(sink->append(bytes));
        must(sink->close());
    }
    const Recording recording = must(Recording::open(path));
    std::remove(path.c_str());
    CHECK(recording.name() == path);
    CHECK(recording.size_bytes() == bytes.size());
    CHECK(recording.checksum() == must(read(bytes)).checksum());
    CHECK(verify(recording, &game).good());
    CHECK(text.str() == std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

TEST_CASE("a recording that starts in the middle of a run plays like the end of that run") {
    World world = must(game.start());
    for (std::uint64_t t = 0; t < 60; ++t) must(game.advance(world, SmallInputs(SmallGame::script(t)).list));
    MemorySink sink;
    auto recorder = must(InputRecorder::begin(sink, game, world, {.keyframe_ticks = 20}));
    for (std::uint64_t t = 60; t < 130; ++t) {
        const SmallInputs inputs(SmallGame::script(t));
        must(game.advance(world, inputs.list));
        must(recorder.after_tick(world, inputs.list));
    }
    must(recorder.close());
    const Recording recording = must(read(sink.bytes));
    CHECK(recording.start_tick() == 60);
    CHECK(verify(recording, &game).good());
    const DiffReport report = must(diff({must(read(record_inputs(130))), &game}, {recording, &game}));
    CHECK(report.states_agree);
    CHECK(report.from == 60);
    CHECK(report.to == 130);
}

TEST_CASE(
    "ticks from a confirmed timeline without a world make the same recording except for its keyframes") {
    const Bytes expected = record_inputs(90, {.keyframe_ticks = 0});
    const auto hashes = played_hashes(90);
    MemorySink sink;
    auto recorder = must(InputRecorder::begin(sink, game, must(game.start()), {.keyframe_ticks = 0}));
    for (std::uint64_t t = 0; t < 90; ++t)
        must(recorder.on_tick(t, SmallInputs(SmallGame::script(t)).list, hashes[t + 1]));
    CHECK(!recorder.keyframe_due());
    must(recorder.close());
    CHECK(sink.bytes == expected);
}

TEST_CASE("the recorder stores a player that leaves as disconnected") {
    MemorySink sink;
    World world = must(game.start());
    auto recorder = must(InputRecorder::begin(sink, game, world));
    for (std::uint64_t t = 0; t < 60; ++t) {
        SmallInputs inputs(SmallGame::script(t));
        const std::array<std::byte, 4> zeros{};
        if (t >= 20) inputs.list[1] = {zeros, InputStatus::disconnected};
        must(game.advance(world, inputs.list));
        must(recorder.after_tick(world, inputs.list));
    }
    must(recorder.close());
    const Recording recording = must(read(sink.bytes));
    CHECK(verify(recording, &game).good());
    CHECK(recording.block_with(19).inputs(19)[1].status == InputStatus::confirmed);
    CHECK(recording.block_with(20).inputs(20)[1].status == InputStatus::disconnected);
    const DiffReport report = must(diff({recording, &game}, {must(read(record_inputs(60))), &game}));
    CHECK(report.input_tick == 20);
    CHECK(report.input_difference.starts_with("player 1: input disconnected against "));
}

TEST_CASE("a branch with the same inputs equals its source and with others diverges at the tick where they "
          "differ") {
    const Recording source =
        must(read(record_inputs(120, {.options = {{"seed", "7"}}, .keyframe_ticks = 25})));
    for (const std::uint64_t at : {0u, 1u, 25u, 63u, 64u, 119u, 120u}) {
        for (const bool other : {false, true}) {
            MemorySink sink;
            InputBranch branch = must(branch_inputs(source, game, at, sink, {.keyframe_ticks = 25}));
            REQUIRE(branch.recorder.next_tick() == at);
            REQUIRE(branch.world.hash() == source.hash_at(at));
            for (std::uint64_t t = at; t < 120; ++t) {
                auto pads = SmallGame::script(t);
                if (other && t == at) pads[0].x = static_cast<std::int8_t>(pads[0].x + 1);
                const SmallInputs inputs(pads);
                must(game.advance(branch.world, inputs.list));
                must(branch.recorder.after_tick(branch.world, inputs.list));
            }
            must(branch.recorder.close());
            const Recording branched = must(read(sink.bytes));
            REQUIRE(verify(branched, &game).good());
            CHECK(*find_option(branched.header(), "seed") == "7");
            CHECK(*find_option(branched.header(), "branch.at") == std::to_string(at));
            CHECK(*find_option(branched.header(), "branch.of") == base::hex(source.checksum()));
            const DiffReport report = must(diff({source, &game}, {branched, &game}));
            const bool parts = other && at < 120;
            CHECK(report.states_agree == !parts);
            if (!parts) continue;
            CHECK(report.tick == at);
            CHECK(report.input_tick == at);
            CHECK(report.phase == "commands");
            CHECK(!report.differences.empty());
        }
    }
    MemorySink sink;
    CHECK(!branch_inputs(source, game, 121, sink));
    CHECK(!branch_commands(source, 10, sink));
    CHECK(sink.bytes.empty());
}

TEST_CASE("a branch of commands continues from its tick") {
    const Recording source = must(read(record_commands(100, {.keyframe_ticks = 30})));
    MemorySink sink;
    CommandBranch branch = must(branch_commands(source, 70, sink));
    const auto recorder = CommandRecorder::resume(std::move(branch.writer), branch.world, 30);
    for (std::uint64_t t = 70; t < 100; ++t) {
        if (t == 90) must(branch.world.set_gravity({Real{}, Real(5), Real{}}));
        must(game.advance(branch.world, SmallInputs(SmallGame::script(t)).list));
    }
    must(recorder->close());
    const Recording branched = must(read(sink.bytes));
    CHECK(verify(branched, nullptr).good());
    const DiffReport report = must(diff({source}, {branched}));
    CHECK(report.tick == 90);
    CHECK(report.input_tick == 90);
    CHECK(report.input_difference.find("against set_gravity") != std::string::npos);
}

TEST_CASE("diff names the tick and phase and column and row and field and both values") {
    const SmallGame changed(100);
    const Recording ours = must(read(record_inputs(200, {.keyframe_ticks = 50})));
    const Recording theirs = must(read(record_inputs(200, {.keyframe_ticks = 50}, changed)));
    const DiffReport report = must(diff({ours, &game}, {theirs, &changed}));
    REQUIRE(report.tick.has_value());
    CHECK(verify(theirs, &game).first_bad_tick == report.tick);
    CHECK(!report.input_tick);
    CHECK(report.phase == "commands");
    CHECK(report.left_reproduces);
    CHECK(report.right_reproduces);
    CHECK(report.compared_at == *report.tick + 1);
    const auto velocity = std::ranges::find_if(
        report.differences, [](const Difference& d) { return d.column == "body.velocity"; });
    REQUIRE(velocity != report.differences.end());
    CHECK(velocity->field == "linear.y");
    CHECK(velocity->left != velocity->right);
    for (const char* part : {"first differing tick: ", "first differing phase: commands",
                             "the inputs are equal up to there", "column body.velocity, row "})
        CHECK_MESSAGE(report.text.find(part) != std::string::npos, part);
}

TEST_CASE("diff finds the recording that another engine made and compares states at its next keyframe") {
    const SmallGame changed(100);
    const Recording ours = must(read(record_inputs(200, {.keyframe_ticks = 50})));
    const Recording theirs = must(read(record_inputs(200, {.keyframe_ticks = 50}, changed)));
    const DiffReport report = must(diff({ours, &game}, {theirs, &game})); // without their rules
    CHECK(report.left_reproduces);
    CHECK(!report.right_reproduces);
    CHECK(report.phase.empty());
    CHECK(report.compared_at == 150);
    CHECK(!report.differences.empty());
}

TEST_CASE("diff distinguishes inputs without effect from states that differ") {
    MemorySink sink;
    World world = must(game.start());
    auto recorder = must(InputRecorder::begin(sink, game, world));
    for (std::uint64_t t = 0; t < 30; ++t) {
        auto pads = SmallGame::script(t);
        if (t == 12) pads[1].buttons |= 0x8000u; // a button that the game ignores
        const SmallInputs inputs(pads);
        must(game.advance(world, inputs.list));
        must(recorder.after_tick(world, inputs.list));
    }
    must(recorder.close());
    const DiffReport report =
        must(diff({must(read(record_inputs(30))), &game}, {must(read(sink.bytes)), &game}));
    CHECK(report.states_agree);
    CHECK(report.input_tick == 12);
    CHECK(report.text.find("first differing input: tick 12, player 1: input ") != std::string::npos);
}

TEST_CASE("keyframes that are added later equal the keyframes of a recorder that has the world") {
    for (const bool is_inputs : {true, false}) {
        const auto record = [&](std::uint64_t every) {
            return is_inputs ? record_inputs(100, {.keyframe_ticks = every})
                             : record_commands(100, {.keyframe_ticks = every});
        };
        MemorySink sink;
        const Recording source = must(read(record(0)));
        must(add_keyframes(source, is_inputs ? &game : nullptr, sink, {.keyframe_ticks = 30}));
        CHECK(sink.bytes == record(30));
    }
    const SmallGame changed(50);
    MemorySink sink;
    const Status refused = add_keyframes(must(read(record_inputs(100))), &changed, sink);
    REQUIRE(!refused);
    CHECK(refused.error().message == "test.lsr: re-simulating tick 84 does not give the recorded hash");
}
