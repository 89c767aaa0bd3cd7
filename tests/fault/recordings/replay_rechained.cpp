// Attacks with valid checksums: an attacker who can change a file can also compute its checksums, so only the later
// checks remain. Every mutation ends in an error sentence or a verdict, never in a crash, and never in `good` for other
// states.
#include "support/effort.h"
#include "support/small_recording.h"

#include <doctest/doctest.h>

#include <array>

using namespace lockstone;
using namespace lockstone::replay;
using namespace lockstone::test;

namespace {

/// One small change in the bytes: a bit, a byte, an integer at the edge, a piece removed, duplicated or new.
void mutate(Bytes& bytes, SplitMix& random) {
    if (bytes.empty()) return;
    const auto size = static_cast<std::uint32_t>(bytes.size());
    const std::uint32_t at = random.below(size);
    const auto place = bytes.begin() + at;
    const std::uint32_t length = 1 + random.below(std::min<std::uint32_t>(size - at, 9));
    static constexpr std::array<std::uint64_t, 8> edges = {
        0, 1, 0x7f, 0xffff, 0x7fffffff, 0xffffffff, std::uint64_t{1} << 63, ~std::uint64_t{0}};
    switch (random.below(6)) {
    case 0:
        *place ^= static_cast<std::byte>(1u << random.below(8));
        break;
    case 1:
        *place = static_cast<std::byte>(random.below(256));
        break;
    case 2: {
        std::array<std::byte, 8> integer{};
        base::store_little_endian(edges[random.below(edges.size())], integer.data());
        std::copy_n(integer.begin(), std::min<std::uint32_t>(size - at, random.below(2) == 0 ? 4 : 8), place);
        break;
    }
    case 3:
        bytes.erase(place, place + length);
        break;
    case 4: {
        const Bytes piece(place, place + length);
        bytes.insert(place, piece.begin(), piece.end());
        break;
    }
    default:
        bytes.insert(place, length, static_cast<std::byte>(random.below(256)));
    }
}

struct Tally {
    int unread = 0, unplayable = 0, diverged = 0, good = 0;
};

/// Reads and verifies a file. A file with the verdict `good` must hold the states of the original. Only its format may
/// differ, and its start if that is forged: two states may have one successor.
void judge(Bytes file, const Recording& original, Tally& tally, bool forged_start = false) {
    static const SmallGame game;
    const auto result = read(std::move(file));
    if (!result) {
        ++tally.unread;
        REQUIRE(result.error().message.size() > 30);
        return;
    }
    const Game* rules = result->header().mode == Mode::inputs ? &game : nullptr;
    const VerifyReport report = verify(*result, rules);
    REQUIRE(report.sentence.size() > 30);
    switch (report.verdict) {
    case Verdict::good:
        ++tally.good;
        break;
    case Verdict::diverged:
        ++tally.diverged;
        return;
    default:
        ++tally.unplayable;
        return;
    }
    REQUIRE(result->tick_count() == original.tick_count());
    for (std::uint64_t t = original.start_tick() + 1; t <= original.end_tick(); ++t)
        REQUIRE(result->hash_at(t) == original.hash_at(t));
    if (forged_start) return;
    REQUIRE(result->hash_at(original.start_tick()) == original.hash_at(original.start_tick()));
    for (std::size_t k = 0; k < result->keyframes().size(); ++k)
        REQUIRE(result->keyframe_image(k) == original.keyframe_image(k));
}

/// Tries `rounds` mutations of chunks of one type.
Tally attack(const Bytes& good, std::uint32_t type, int rounds, std::uint64_t seed) {
    const auto chunks = chunks_of(good);
    const Recording original = must(read(good));
    SplitMix random(seed);
    Tally tally;
    for (int i = 0; i < rounds; ++i) {
        auto bad = chunks;
        std::size_t victim = random.below(static_cast<std::uint32_t>(chunks.size()));
        while (bad[victim].type != type) victim = (victim + 1) % chunks.size();
        for (std::uint32_t n = 1 + random.below(3); n > 0; --n) mutate(bad[victim].payload, random);
        CAPTURE(i);
        judge(file_of(std::move(bad), type != chunk_index && random.below(4) != 0), original, tally);
    }
    return tally;
}

const Bytes& inputs_file() {
    static const Bytes file = record_inputs(24, {.keyframe_ticks = 10, .block_ticks = 6});
    return file;
}
const Bytes& commands_file() {
    static const Bytes file = record_commands(24, {.keyframe_ticks = 10, .block_ticks = 6});
    return file;
}

} // namespace

TEST_CASE(
    "mutated headers and schemas and definitions under valid checksums are rejected or change no state") {
    for (const std::uint32_t type : {chunk_head, chunk_schema, chunk_world_def}) {
        CAPTURE(chunk_name(type));
        for (const Bytes* file : {&inputs_file(), &commands_file()}) {
            const int rounds = test::tries(1500);
            const Tally tally = attack(*file, type, rounds, 11);
            CHECK(tally.unread + tally.unplayable > rounds * 3 / 5); // texts and options may have any content
        }
    }
}

TEST_CASE("mutated ticks under valid checksums are rejected or diverge and never cause a crash") {
    for (const Bytes* file : {&inputs_file(), &commands_file()}) {
        const int rounds = test::tries(2000);
        const Tally tally = attack(*file, chunk_ticks, rounds, 12);
        CHECK(tally.unread > rounds / 4);
        CHECK(tally.diverged > rounds / 40);
    }
}

TEST_CASE("mutated keyframes and indexes and ends under valid checksums are rejected or diverge") {
    for (const std::uint32_t type : {chunk_keyframe, chunk_index, chunk_end})
        for (const Bytes* file : {&inputs_file(), &commands_file()}) {
            CAPTURE(chunk_name(type));
            const int rounds = test::tries(1500);
            const Tally tally = attack(*file, type, rounds, 13);
            CHECK(tally.unread + tally.unplayable + tally.diverged > rounds * 3 / 5);
        }
}

TEST_CASE(
    "changed inputs in a block that is packed again diverge at their tick unless the game ignores them") {
    const auto chunks = chunks_of(inputs_file());
    const Recording original = must(read(inputs_file()));
    SplitMix random(14);
    Tally tally;
    const int rounds = test::tries(300);
    for (int i = 0; i < rounds; ++i) {
        const std::uint64_t tick = random.below(24), player = random.below(2), byte = random.below(4);
        const TickBlock block = original.block_with(tick);
        BlockBuilder builder({Mode::inputs, 2, 4});
        for (std::uint64_t t = block.first_tick(); t < block.end_tick(); ++t) {
            std::vector<PlayerInput> inputs = block.inputs(t);
            Bytes changed(inputs[player].bytes.begin(), inputs[player].bytes.end());
            if (t == tick) changed[byte] ^= static_cast<std::byte>(1 + random.below(255));
            inputs[player].bytes = changed;
            must(builder.add_inputs(inputs, block.hash_after(t)));
        }
        auto bad = chunks;
        Bytes payload;
        builder.finish(block.first_tick(), payload);
        for (Chunk& chunk : bad)
            if (chunk.type == chunk_ticks &&
                base::load_little_endian<std::uint64_t>(chunk.payload.data()) == block.first_tick())
                chunk.payload = payload;
        const Bytes file = file_of(bad, true);
        const SmallGame game;
        const VerifyReport report = verify(must(read(file)), &game);
        if (report.verdict == Verdict::diverged) REQUIRE(report.first_bad_tick == tick);
        judge(file, original, tally);
    }
    CHECK(tally.diverged > rounds / 3);
    CHECK(tally.unread == 0);
}

TEST_CASE("a forged start image with valid checksums and hashes is rejected or does not match the ticks") {
    // The strongest attack: the image's own checksum and the root hashes are valid, so only the world's checks of its
    // state and the new simulation remain.
    const Bytes& good = commands_file();
    const auto chunks = chunks_of(good);
    const Recording original = must(read(good));
    const Bytes image = original.keyframe_image(0);
    State state(must(World::create(original.world_def(), original.schema())).state().layout_shared());
    SplitMix random(15);
    Tally tally;
    int loaded = 0;
    const int rounds = test::tries(1200);
    for (int i = 0; i < rounds; ++i) {
        Bytes forged = image;
        for (std::uint32_t n = 1 + random.below(2); n > 0; --n) {
            const std::uint32_t at = random.below(static_cast<std::uint32_t>(image.size()) - 8);
            forged[at] ^=
                static_cast<std::byte>(random.below(2) == 0 ? 1u << random.below(8) : 1 + random.below(255));
        }
        base::store_little_endian(hash_bytes(std::span(forged).first(forged.size() - 8)),
                                  forged.data() + forged.size() - 8);
        if (!state.restore_portable(forged)) continue;
        ++loaded;
        auto bad = chunks;
        Bytes& payload = bad[find_chunk(bad, chunk_keyframe)].payload;
        payload.resize(8);
        base::ByteWriter to(payload);
        to.u64(state.hash());
        to.u64(forged.size());
        pack(forged, payload);
        // Later keyframes are deltas to the first one: they are dropped, so that only the ticks can reveal the change.
        std::erase_if(
            bad, [&, n = 0](const Chunk& chunk) mutable { return chunk.type == chunk_keyframe && n++ > 0; });
        judge(file_of(bad, true), original, tally, true);
    }
    CHECK(loaded > rounds / 4);
    CHECK(tally.unplayable > rounds / 20); // the world's own checks
    CHECK(tally.diverged > rounds / 20);   // the hashes
    CHECK(tally.good <
          loaded / 20); // a force too small for any motion, a game row that is overwritten before it is read
}

TEST_CASE("the reader rejects a command of an unknown kind and names the kind's number") {
    auto chunks = chunks_of(commands_file());
    BlockBuilder builder({Mode::commands, 0, 0});
    const Command command = DestroyBody{{1, 1}};
    must(builder.add_commands({&command, 1}, 0));
    Bytes payload;
    builder.finish(0, payload);
    // unpacked: count u32, kind u8, fields; packed as a literal 01, a run of three zeros, literals.
    const auto planes = must(unpack(std::span(payload).subspan(28), 13));
    REQUIRE(planes[4] == std::byte{1});
    for (const unsigned kind :
         {static_cast<unsigned>(command_kinds), static_cast<unsigned>(command_kinds) + 1, 200u, 255u}) {
        Bytes changed = planes;
        changed[4] = static_cast<std::byte>(kind);
        Bytes bad_payload(payload.begin(), payload.begin() + 28);
        pack(changed, bad_payload);
        chunks[find_chunk(chunks, chunk_ticks)].payload = bad_payload;
        const auto result = read(file_of(chunks, true));
        REQUIRE(!result);
        CHECK(result.error().message.find("a command is of kind " + std::to_string(kind) +
                                          ", this engine knows 0.." + std::to_string(command_kinds - 1)) !=
              std::string::npos);
    }
}

TEST_CASE("the verifier rejects a recording whose columns would assert or exhaust memory in World::create") {
    const auto chunks = chunks_of(commands_file());
    const auto with_schema = [&](std::uint32_t row_size, bool per_body, const std::string& name) {
        GameSchema schema;
        GameSchema::Entry entry{name, per_body, row_size, {}};
        for (std::uint32_t at = 0; at < row_size; at += 8)
            entry.leaves.push_back({"f", at, 8, LeafKind::unsigned_integer, 0});
        schema.add(std::move(entry));
        WorldDef def;
        def.bodies_max = 1u << 20;
        auto bad = chunks;
        Bytes& schema_payload = bad[find_chunk(bad, chunk_schema)].payload;
        schema_payload.clear();
        append_schema(schema, schema_payload);
        Bytes& def_payload = bad[find_chunk(bad, chunk_world_def)].payload;
        def_payload.clear();
        append_world_def(def, def_payload);
        return verify(must(read(file_of(bad, true))), nullptr);
    };
    const VerifyReport huge = with_schema(65536, true, "game.huge");
    CHECK(huge.verdict == Verdict::unusable);
    CHECK(huge.sentence.find("bytes of memory, the limit is 1073741824") != std::string::npos);
    const VerifyReport taken = with_schema(8, false, "body.pose");
    CHECK(taken.verdict == Verdict::unusable);
    CHECK(taken.sentence.find("the game's column body.pose has the name of one of the engine's") !=
          std::string::npos);
}

TEST_CASE("the reader rejects assets in a recording of inputs and a content id in a recording of commands") {
    const LengthVec3 corners[] = {{}, {Length(1), {}, {}}, {{}, Length(1), {}}, {{}, {}, Length(1)}};
    const AssetBytes hull = bake_hull(corners).value();
    const auto with_asset = [&](const Bytes& file, const AssetBytes& asset) {
        auto chunks = chunks_of(file);
        const auto place =
            chunks.begin() + static_cast<std::ptrdiff_t>(find_chunk(chunks, chunk_world_def)) + 1;
        chunks.insert(place, {chunk_asset, 0, Bytes(asset.begin(), asset.end())});
        return read(file_of(chunks, true));
    };
    CHECK(with_asset(commands_file(), hull));
    const LengthVec3 larger[] = {{}, {Length(2), {}, {}}, {{}, Length(1), {}}, {{}, {}, Length(1)}};
    const AssetBytes both[] = {hull, bake_hull(larger).value()};
    const Result<Recording> set = with_asset(commands_file(), encode_assets(both));
    REQUIRE_FALSE(set);
    CHECK(set.error().message.find("it holds a set of assets, it must hold one asset") != std::string::npos);
    const Result<Recording> refused = with_asset(inputs_file(), hull);
    REQUIRE_FALSE(refused);
    CHECK(refused.error().message.find(": a recording of inputs has no assets: the game has them") !=
          std::string::npos);

    auto chunks = chunks_of(commands_file());
    Header header = must(read(commands_file())).header();
    header.content_id = 1;
    Bytes& payload = chunks[find_chunk(chunks, chunk_head)].payload;
    payload.clear();
    append_header(header, payload);
    const Result<Recording> strange = read(file_of(chunks, true));
    REQUIRE_FALSE(strange);
    CHECK(strange.error().message.find("content id is 1, must be 0 in a recording of commands") !=
          std::string::npos);
}
