// Planted faults: the verifier finds each fault, names its tick, and never returns `good` for an empty comparison.
#include "support/small_recording.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::replay;
using namespace lockstone::test;

namespace {

const SmallGame game;

bool holds(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

/// The first tick at or after `from` at which a player jumps.
std::uint64_t first_jump(std::uint64_t from) {
    for (std::uint64_t t = from;; ++t)
        for (const SmallInput& pad : SmallGame::script(t))
            if ((pad.buttons & 1u) != 0) return t;
}

/// A sink that fails once it holds more than `room` bytes, like a disk.
class SmallDisk final : public Sink {
  public:
    explicit SmallDisk(std::size_t capacity) : room(capacity) {}
    Status append(std::span<const std::byte> more) override {
        const std::size_t fits = std::min(more.size(), room - bytes.size());
        bytes.insert(bytes.end(), more.begin(), more.begin() + static_cast<std::ptrdiff_t>(fits));
        if (fits == more.size()) return {};
        ++refusals;
        return Error{"disk.lsr: cannot write: No space left on device"};
    }
    Bytes bytes;
    std::size_t room;
    int refusals = 0;
};

} // namespace

TEST_CASE("every way of verifying finds a changed rule of the game at the first tick that the rule affects") {
    const Recording recording = must(read(record_inputs(400, {.keyframe_ticks = 60})));
    REQUIRE(verify(recording, &game).good());
    for (const std::uint64_t from :
         {std::uint64_t{0}, std::uint64_t{50}, std::uint64_t{199}, std::uint64_t{320}}) {
        const SmallGame changed(from);
        for (const VerifyOptions& options :
             {VerifyOptions{}, VerifyOptions{.jobs = 3}, VerifyOptions{.from_keyframes = true}}) {
            const VerifyReport report = verify(recording, &changed, options);
            CHECK(report.verdict == Verdict::diverged);
            CHECK(report.first_bad_tick == first_jump(from));
            CHECK(holds(report.sentence,
                        "test.lsr: tick " + std::to_string(first_jump(from)) + ": the state's hash is 0x"));
        }
    }
    CHECK(
        verify(recording, std::make_unique<SmallGame>(399).get()).good()); // no player jumps: `good` is right
}

TEST_CASE("the verifier finds a wrong hash of one tick at that tick in both modes") {
    for (const bool is_inputs : {true, false}) {
        const Bytes good =
            is_inputs ? record_inputs(40, {.block_ticks = 8}) : record_commands(40, {.block_ticks = 8});
        for (const std::uint64_t tick :
             {std::uint64_t{0}, std::uint64_t{7}, std::uint64_t{8}, std::uint64_t{38}}) {
            auto chunks = chunks_of(good);
            Chunk& block = chunks[find_chunk(chunks, chunk_ticks, tick / 8)];
            block.payload[20 + 8 * (tick % 8)] ^= std::byte{1};
            const VerifyReport report =
                verify(must(read(file_of(chunks, true))), is_inputs ? &game : nullptr);
            CHECK(report.verdict == Verdict::diverged);
            CHECK(report.first_bad_tick == tick);
        }
    }
}

TEST_CASE("the verifier finds a keyframe with one wrong bit by its bytes or by its hash") {
    const Bytes good = record_inputs(60, {.keyframe_ticks = 20});
    const Recording recording = must(read(good));
    Bytes image = recording.keyframe_image(1);
    State state(must(game.start()).state().layout_shared());
    must(state.restore_portable(image));
    for (std::uint32_t c = 0; c < state.layout().columns().size(); ++c)
        if (state.layout().columns()[c].name == "body.velocity") state.edit_bytes(c)[5] ^= std::byte{1};
    image = state.save_portable();

    auto chunks = chunks_of(good);
    Bytes& payload = chunks[find_chunk(chunks, chunk_keyframe, 1)].payload;
    payload.resize(16); // time and hash stay
    base::ByteWriter(payload).u64(image.size());
    const Bytes first = recording.keyframe_image(0);
    Bytes delta = image;
    for (std::size_t i = 0; i < std::min(delta.size(), first.size()); ++i) delta[i] ^= first[i];
    pack(delta, payload);
    const Recording forged = must(read(file_of(chunks, true)));
    REQUIRE(forged.keyframe_image(1) == image);

    const VerifyReport straight = verify(forged, &game);
    CHECK(straight.verdict == Verdict::diverged);
    CHECK(straight.first_bad_tick == 19);
    CHECK(
        holds(straight.sentence,
              "keyframe at 20: the recorded bytes are not those of the state: column body.velocity, row 0"));
    const VerifyReport apart = verify(forged, &game, {.from_keyframes = true});
    CHECK(apart.verdict == Verdict::diverged);
    CHECK(apart.first_bad_tick == 19);
    // The shard that starts from it detects the wrong hash; the player refuses to seek there.
    const VerifyReport shard = verify(forged, &game, {.shard = 1, .shards = 3});
    CHECK(shard.verdict == Verdict::diverged);
    CHECK(holds(shard.sentence, "keyframe at 20: its state has hash 0x"));
    Player player = must(Player::open(forged, game));
    CHECK(!player.seek(25));
}

TEST_CASE("a recording without ticks and a shard without segments do not verify as good") {
    const Recording empty = must(read(record_inputs(0)));
    const VerifyReport nothing = verify(empty, &game);
    CHECK(nothing.verdict == Verdict::vacuous);
    CHECK(nothing.sentence == "test.lsr: no tick was compared, so nothing was verified");

    const Recording recording = must(read(record_inputs(50, {.keyframe_ticks = 20})));
    REQUIRE(segment_count(recording) == 3);
    const VerifyReport none = verify(recording, &game, {.shard = 3, .shards = 4});
    CHECK(none.verdict == Verdict::vacuous);
    CHECK(holds(none.sentence, "there are 3 segments for 4 shards"));
    CHECK(verify(recording, &game, {.shard = 4, .shards = 4}).verdict == Verdict::unusable);
    CHECK(verify(recording, &game, {.shards = 0}).verdict == Verdict::unusable);
}

TEST_CASE("the verifier finds a start that is not the game's even if all later ticks agree") {
    MemorySink sink;
    World world = must(game.start());
    must(world.set_gravity({Real{}, Real(-8), Real{}})); // lighter: an advantage
    auto recorder = must(InputRecorder::begin(sink, game, world));
    for (std::uint64_t t = 0; t < 5; ++t) {
        const SmallInputs inputs(SmallGame::script(t));
        must(game.advance(world, inputs.list));
        must(recorder.after_tick(world, inputs.list));
    }
    must(recorder.close());
    const VerifyReport report = verify(must(read(sink.bytes)), &game);
    CHECK(report.verdict == Verdict::diverged);
    CHECK(report.first_bad_tick == 0);
    CHECK(holds(report.sentence, "the recorded start is not the game's: column world.header, row 0, "));
}

TEST_CASE("the verifier rejects a game that is not the recording's before it runs a tick") {
    struct Other : SmallGame {
        std::string label = "small-game";
        std::uint64_t id = 0x5a11;
        std::uint32_t players = 2;
        std::string name() const override { return label; }
        std::uint64_t content_id() const override { return id; }
        std::uint32_t player_count() const override { return players; }
    };
    const Recording recording = must(read(record_inputs(5)));
    const auto sentence = [&](const Other& other) {
        const VerifyReport report = verify(recording, &other);
        CHECK(report.verdict == Verdict::unusable);
        return report.sentence;
    };
    Other other;
    other.label = "chess";
    CHECK(sentence(other) == "test.lsr: cannot be played: it is of the game small-game, this is chess");
    other = {};
    other.id = 1;
    CHECK(sentence(other) ==
          "test.lsr: cannot be played: it was recorded with content id 0x5a11 of small-game, this is 0x1");
    other = {};
    other.players = 3;
    CHECK(sentence(other) == "test.lsr: cannot be played: it has 2 players, the game 3");
    CHECK(verify(recording, nullptr).sentence ==
          "test.lsr: cannot be played: it holds inputs, so it needs the game small-game");
}

TEST_CASE("a disk that fills up at any byte gives an error and leaves a recording that can be recovered") {
    const Bytes whole = record_inputs(40, {.keyframe_ticks = 15, .block_ticks = 4});
    for (std::size_t room = 0; room < whole.size(); room += 53) {
        SmallDisk disk(room);
        World world = must(game.start());
        auto recorder = InputRecorder::begin(disk, game, world, {.keyframe_ticks = 15, .block_ticks = 4});
        std::string failure = recorder ? "" : recorder.error().message;
        for (std::uint64_t t = 0; t < 40 && recorder; ++t) {
            const SmallInputs inputs(SmallGame::script(t));
            must(game.advance(world, inputs.list));
            const Status status = recorder->after_tick(world, inputs.list);
            if (!failure.empty()) REQUIRE(!status); // the error remains
            if (!status) failure = status.error().message;
        }
        if (recorder) REQUIRE(!recorder->close());
        if (recorder && failure.empty()) failure = recorder->close().error().message;
        REQUIRE(failure == "disk.lsr: cannot write: No space left on device");
        REQUIRE(disk.refusals == 1); // no write follows the error
        REQUIRE(std::equal(disk.bytes.begin(), disk.bytes.end(), whole.begin()));
        REQUIRE(!read(disk.bytes));
    }
}

TEST_CASE("the file sink reports a full device with the file's name and the system's reason") {
    auto created = FileSink::create("/dev/full");
    if (!created) return; // not every system has this device
    World world = must(game.start());
    const auto recorder = InputRecorder::begin(*created, game, world);
    REQUIRE(!recorder);
    CHECK(recorder.error().message == "/dev/full: cannot write 16 bytes: No space left on device");
    CHECK(FileSink::create("/no/such/folder/x.lsr").error().message ==
          "/no/such/folder/x.lsr: cannot create the file: No such file or directory");
}

TEST_CASE("a recorder rejects predicted inputs and inputs of a wrong size and a wrong number of inputs") {
    const auto attempt = [&](std::span<const PlayerInput> inputs) {
        MemorySink sink;
        const World world = must(game.start());
        auto recorder = must(InputRecorder::begin(sink, game, world));
        return recorder.on_tick(0, inputs, 1).error().message;
    };
    const std::array<std::byte, 4> bytes{};
    const PlayerInput good{bytes, InputStatus::confirmed}, guess{bytes, InputStatus::predicted},
        shorter{std::span(bytes).first(3)};
    CHECK(holds(attempt(std::array{good, guess}), "the input of player 1 is a prediction"));
    CHECK(holds(attempt(std::array{shorter, good}), "the input of player 0 has 3 bytes, must have 4"));
    CHECK(holds(attempt(std::array{good}), "1 inputs for 2 players"));
}

TEST_CASE("a player reports a command that the world rejects on replay at the command's tick") {
    auto chunks = chunks_of(record_commands(3));
    BlockBuilder builder({Mode::commands, 0, 0});
    must(builder.add_commands({}, 1));
    const Command dead[] = {SetGravity{{}}, DestroyBody{{30, 1}}};
    must(builder.add_commands(dead, 2));
    Bytes& payload = chunks[find_chunk(chunks, chunk_ticks)].payload;
    payload.clear();
    builder.finish(0, payload);
    Bytes& end = chunks[find_chunk(chunks, chunk_end)].payload;
    base::store_little_endian(std::uint64_t{2}, end.data());
    base::store_little_endian(std::uint64_t{2}, end.data() + 8);
    const Recording recording = must(read(file_of(chunks, true)));
    CHECK(verify(recording, nullptr).first_bad_tick == 0); // hashes 1 and 2 are invented
    Player player = must(Player::open(recording));
    must(player.step());
    const Status refused = player.step();
    REQUIRE(!refused);
    CHECK(
        holds(refused.error().message,
              "test.lsr: tick 1: command 1 (destroy_body) is refused: destroy_body: body 30:1 is not alive"));
}
