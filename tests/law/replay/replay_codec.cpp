// Written data reads back unchanged: packing, planes, blocks, headers, commands, whole files; over generated data.
#include "support/small_recording.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::replay;
using namespace lockstone::test;

namespace {

/// Bytes with runs of every length, stretches of noise, and mixtures.
Bytes random_bytes(SplitMix& random, std::uint32_t size) {
    Bytes out;
    while (out.size() < size) {
        const std::uint32_t length = 1 + random.below(random.below(3) == 0 ? 300 : 6);
        const auto value = static_cast<std::byte>(random.below(4));
        const bool noise = random.below(2) == 0;
        for (std::uint32_t i = 0; i < length && out.size() < size; ++i)
            out.push_back(noise ? static_cast<std::byte>(random.below(256)) : value);
    }
    return out;
}

Command random_command(SplitMix& random) {
    const std::size_t kind = random.below(command_kinds);
    Bytes fields(command_bytes(kind));
    for (std::byte& b : fields) b = static_cast<std::byte>(random.below(256));
    return read_command(kind, fields);
}

Bytes canonical(const Command& command) {
    Bytes out;
    append_command(command, out);
    return out;
}

} // namespace

TEST_CASE("unpack() returns the packed bytes and pack() never makes them much longer") {
    SplitMix random(1);
    for (std::uint32_t i = 0; i < 3000; ++i) {
        const Bytes bytes = random_bytes(random, i < 700 ? i : random.below(5000));
        Bytes packed;
        pack(bytes, packed);
        REQUIRE(packed.size() <= bytes.size() + bytes.size() / 128 + 1);
        REQUIRE(packed.size() * unpack_ratio_max >= bytes.size());
        REQUIRE(must(unpack(packed, bytes.size())) == bytes);
        REQUIRE(!unpack(packed, bytes.size() + 1));
        if (!bytes.empty()) REQUIRE(!unpack(packed, bytes.size() - 1));
    }
}

TEST_CASE("unpack() of any bytes returns the announced size or an error") {
    SplitMix random(2);
    int unpacked = 0;
    for (int i = 0; i < 20000; ++i) {
        const Bytes packed = random_bytes(random, random.below(12));
        const std::uint64_t size = random.below(40);
        const auto result = unpack(packed, size);
        if (!result) continue;
        ++unpacked;
        REQUIRE(result->size() == size);
    }
    CHECK(unpacked > 100);
}

TEST_CASE("pack() shortens a long run of equal bytes to a sixty-fifth") {
    Bytes packed;
    pack(Bytes(130 * 100), packed);
    CHECK(packed.size() == 200);
}

TEST_CASE("read_planes() restores the table from its planes for every shape of table") {
    SplitMix random(3);
    for (std::uint32_t row = 0; row < 20; ++row)
        for (std::uint32_t rows = 0; rows < 20; ++rows) {
            const Bytes table = random_bytes(random, row * rows);
            Bytes planes;
            append_planes(table, row, planes);
            REQUIRE(planes.size() == table.size());
            REQUIRE(read_planes(planes, row) == table);
        }
}

TEST_CASE("a block of inputs reads back unchanged for every number of players and size of input") {
    SplitMix random(4);
    for (std::uint32_t players = 0; players <= players_max; ++players) {
        const BlockShape shape{Mode::inputs, players, random.below(input_bytes_max + 1)};
        BlockBuilder builder(shape);
        const std::uint32_t ticks = 1 + random.below(100);
        std::vector<Bytes> bytes;
        std::vector<InputStatus> statuses;
        for (std::uint32_t t = 0; t < ticks; ++t) {
            std::vector<PlayerInput> inputs;
            const std::size_t from = bytes.size();
            for (std::uint32_t p = 0; p < players; ++p) {
                const bool gone = random.below(5) == 0;
                bytes.push_back(gone ? Bytes(shape.input_size) : random_bytes(random, shape.input_size));
                statuses.push_back(gone ? InputStatus::disconnected : InputStatus::confirmed);
            }
            for (std::uint32_t p = 0; p < players; ++p)
                inputs.push_back({bytes[from + p], statuses[from + p]});
            must(builder.add_inputs(inputs, t * 31));
        }
        Bytes payload;
        builder.finish(1000, payload);
        REQUIRE(builder.ticks() == 0);
        base::ByteReader in(payload, "block");
        const TickBlock block = TickBlock::read(in, shape, {});
        REQUIRE(in.ok());
        REQUIRE(block.end_tick() == 1000 + ticks);
        for (std::uint32_t t = 0; t < ticks; ++t) {
            REQUIRE(block.hash_after(1000 + t) == t * 31);
            const auto inputs = block.inputs(1000 + t);
            REQUIRE(inputs.size() == players);
            for (std::uint32_t p = 0; p < players; ++p) {
                REQUIRE(inputs[p].status == statuses[t * players + p]);
                REQUIRE(std::ranges::equal(inputs[p].bytes, bytes[t * players + p]));
            }
        }
    }
}

TEST_CASE("a block of commands of every kind reads back in order and bit for bit") {
    SplitMix random(5);
    std::array<int, command_kinds> seen{};
    for (int i = 0; i < 200; ++i) {
        BlockBuilder builder({Mode::commands, 0, 0});
        std::vector<std::vector<Command>> ticks(1 + random.below(20));
        for (auto& commands : ticks) {
            for (std::uint32_t n = random.below(3) == 0 ? 0 : random.below(12); n > 0; --n) {
                commands.push_back(random_command(random));
                ++seen[commands.back().index()];
            }
            must(builder.add_commands(commands, commands.size()));
        }
        Bytes payload;
        builder.finish(7, payload);
        base::ByteReader in(payload, "block");
        const TickBlock block = TickBlock::read(in, {Mode::commands, 0, 0}, {});
        REQUIRE(in.ok());
        for (std::size_t t = 0; t < ticks.size(); ++t) {
            const auto commands = block.commands(7 + t);
            REQUIRE(commands.size() == ticks[t].size());
            for (std::size_t c = 0; c < commands.size(); ++c) {
                REQUIRE(commands[c].index() == ticks[t][c].index());
                REQUIRE(canonical(commands[c]) == canonical(ticks[t][c]));
            }
        }
    }
    for (const int count : seen) CHECK(count > 50);
}

TEST_CASE("headers and schemas and world definitions read back equal") {
    Header header;
    header.mode = Mode::inputs;
    header.engine = "1.2.3";
    header.game = "a game \xc3\xa4";
    header.content_id = ~std::uint64_t{0};
    header.schema_hash = 5;
    header.tick_rate = 1000;
    header.player_count = 16;
    header.input_size = 64;
    header.start_tick = start_tick_max;
    header.options = {{"", ""}, {"a", "x"}, {"b", std::string(text_bytes_max, 'v')}};
    Bytes bytes;
    append_header(header, bytes);
    base::ByteReader in(bytes, "header");
    CHECK(read_header(in) == header);
    in.expect_end();
    CHECK(in.ok());
    CHECK(find_option(header, "a") != nullptr);
    CHECK(find_option(header, "c") == nullptr);

    const World world = must(SmallGame().start());
    Bytes schema, again, def;
    append_schema(world.schema(), schema);
    base::ByteReader schema_in(schema, "schema");
    append_schema(read_schema(schema_in), again);
    CHECK(schema_in.ok());
    CHECK(again == schema);
    append_world_def(world.def(), def);
    base::ByteReader def_in(def, "definition");
    CHECK(first_difference(read_world_def(def_in), world.def()) == "");
    WorldDef other = world.def();
    other.substeps += 1;
    CHECK(first_difference(world.def(), other) != "");
}

TEST_CASE("the writer rejects headers beyond the limits and writes no byte") {
    const SmallGame game;
    const World world = must(game.start());
    const auto refuse = [&](auto&& change) {
        Header header;
        header.game = "x";
        change(header);
        MemorySink sink;
        const auto writer = Writer::begin(sink, header, {}, WorldDef{}, 0, {});
        REQUIRE(!writer);
        CHECK(sink.bytes.empty());
        return writer.error().message;
    };
    CHECK(refuse([](Header& h) { h.player_count = 17; }) == "cannot record: players is 17, must be 0..16");
    CHECK(refuse([](Header& h) { h.input_size = 65; }) == "cannot record: input size is 65, must be 0..64");
    CHECK(refuse([](Header& h) { h.game = "a\x1b[2J"; }) ==
          "cannot record: game holds the control character 27 at 1");
    CHECK(refuse([](Header& h) { h.game = "a\xc2\x9b[2J"; }) ==
          "cannot record: game holds the control character 155 at 1");
    CHECK(refuse([](Header& h) { h.mode = Mode::commands, h.content_id = 1; }) ==
          "cannot record: content id is 1, must be 0 in a recording of commands");
    CHECK(refuse([](Header& h) { h.tick_rate = 0; }) == "cannot record: tick rate is 0, must be 1..1000");
    CHECK(refuse([](Header& h) { h.tick_rate = 50; }) ==
          "cannot record: the header's tick rate is 50, the world's is 60");
    CHECK(refuse([](Header& h) {
              h.options = {{"a", ""}, {"a", ""}};
          }) == "cannot record: option keys are not ascending: a before a");
}

TEST_CASE("a recording reads back with every tick's inputs and hashes and keyframes at any size of blocks") {
    const auto hashes = played_hashes(150);
    for (const std::uint32_t block_ticks : {1u, 2u, 7u, 64u, 1024u}) {
        for (const std::uint64_t keyframe_ticks : {0u, 1u, 10u, 64u, 150u}) {
            const Recording recording = must(
                read(record_inputs(150, {.keyframe_ticks = keyframe_ticks, .block_ticks = block_ticks})));
            REQUIRE(recording.tick_count() == 150);
            REQUIRE(recording.keyframes().size() == (keyframe_ticks == 0 ? 1 : 1 + 150 / keyframe_ticks));
            for (std::uint64_t t = 0; t <= 150; ++t) REQUIRE(recording.hash_at(t) == hashes[t]);
            for (std::uint64_t t = 0; t < 150; ++t) {
                const TickBlock block = recording.block_with(t);
                const auto inputs = block.inputs(t);
                const SmallInputs pressed(SmallGame::script(t));
                REQUIRE(inputs.size() == 2);
                for (std::size_t p = 0; p < 2; ++p)
                    REQUIRE(std::ranges::equal(inputs[p].bytes, pressed.bytes[p]));
            }
        }
    }
}

TEST_CASE("the writer enforces the smallest and the largest size of blocks") {
    CHECK_THROWS(record_inputs(1, {.block_ticks = 0}));
    CHECK_THROWS(record_inputs(1, {.block_ticks = 1025}));
    CHECK(must(read(record_inputs(3, {.block_ticks = 1024}))).tick_count() == 3);
}
