// Small recordings that require much memory, read under a random memory limit. The attack counts allocations.
#include "attack/attack.h"
#include "lockstone/joint.h"
#include "lockstone/math/random.h"
#include "replay/branch.h"
#include "replay/diff.h"
#include "support/small_recording.h"

namespace {

using namespace attack;
using lockstone::Random;
using namespace lockstone;
using namespace lockstone::replay;
using test::Bytes;
using test::Chunk;
using test::must;

const Bytes& commands_file() {
    static const Bytes file = test::record_commands(6, {.block_ticks = 2});
    return file;
}

std::uint32_t capacity(Random& random) { return 1u << random.below(21); }

/// An empty world with arbitrary capacities.
void many_rows(std::vector<Chunk>& chunks, Random& random) {
    const Recording good = must(test::read(commands_file()));
    WorldDef def = good.world_def();
    for (std::uint32_t* most :
         {&def.bodies_max, &def.shapes_max, &def.contacts_max, &def.pair_filters_max, &def.joints_max})
        if (random.below(2) == 0) *most = capacity(random);
    def.characters_max = std::min(capacity(random), 65536u),
    def.vehicles_max = std::min(capacity(random), 65536u);
    Bytes& payload = chunks[test::find_chunk(chunks, chunk_world_def)].payload;
    payload.clear();
    append_world_def(def, payload);
    Result<World> world =
        random.below(4) == 0 ? World::create(def, good.schema()) : Error{"too large to be made here"};
    if (!world) return;
    // a keyframe that matches the definition
    Bytes& keyframe = chunks[test::find_chunk(chunks, chunk_keyframe)].payload;
    const Bytes image = world->save_portable();
    keyframe.clear();
    base::ByteWriter to(keyframe);
    to.u64(0), to.u64(world->hash()), to.u64(image.size());
    pack(image, keyframe);
}

/// Packed zeros that unpack to `bytes`.
void append_zeros(Bytes& out, std::uint64_t bytes) {
    for (; bytes >= 130; bytes -= 130) out.push_back(std::byte{255}), out.push_back(std::byte{0});
    for (; bytes > 0; --bytes) out.push_back(std::byte{0}), out.push_back(std::byte{0});
}

void large_image(std::vector<Chunk>& chunks, Random& random) {
    const std::uint64_t size = std::uint64_t{1} << (16 + random.below(13)); // up to 256 MB, packed into 4 MB
    Bytes& payload = chunks[test::find_chunk(chunks, chunk_keyframe, 0)].payload;
    payload.resize(16);
    base::ByteWriter to(payload);
    to.u64(size);
    append_zeros(payload, size);
}

/// Ticks of as many commands as a block can hold: `unpacked` bytes of planes, mostly zeros.
void many_commands(std::vector<Chunk>& chunks, Random& random) {
    const std::size_t kind = random.below(static_cast<std::uint32_t>(command_kinds));
    const std::uint32_t count = 1u << (10 + random.below(12)), ticks = 1 + random.below(8);
    const std::uint64_t unpacked = 4 * ticks + count * (1 + std::uint64_t{command_bytes(kind)});
    if (unpacked > block_bytes_max) return;
    Bytes planes(unpacked);
    for (std::size_t byte = 0; byte < 4;
         ++byte) // of the first tick's count; the others have that count, or none
        planes[byte * ticks] = static_cast<std::byte>(count >> (8 * byte) & 0xff);
    if (ticks > 1)
        for (std::size_t byte = 0; byte < 4; ++byte) planes[byte * ticks + 1] = planes[byte * ticks];
    planes[4 * ticks] = static_cast<std::byte>(kind);
    // A valid command; else every file would fail at its first command.
    Bytes fields;
    append_command(kind == Command(Explode{}).index()
                       ? Command(Explode{{.radius = Real(30000), .impulse = Real(100)}})
                       : Command(CreateBody{}),
                   fields);
    for (std::size_t byte = 0; byte < std::min<std::size_t>(fields.size(), command_bytes(kind)); ++byte)
        planes[4 * ticks + count + byte * count] = fields[byte];
    Bytes& payload = chunks[test::find_chunk(chunks, chunk_ticks)].payload;
    payload.clear();
    base::ByteWriter to(payload);
    to.u64(0), to.u32(ticks), to.u64(unpacked);
    for (std::uint32_t t = 0; t < ticks; ++t) to.u64(0);
    pack(planes, payload);
}

void many_columns(std::vector<Chunk>& chunks, Random& random) {
    Bytes& payload = chunks[test::find_chunk(chunks, chunk_schema)].payload;
    GameSchema schema;
    for (std::uint32_t c = 1 + random.below(columns_max); c > 0; --c) {
        GameSchema::Entry entry{
            "game." + std::to_string(c), random.below(2) == 0, 1u << random.below(17), {}};
        const std::uint32_t step = 1u << random.below(4);
        if (entry.row_size < step) entry.row_size = step;
        for (std::uint32_t at = 0; at < entry.row_size; at += step)
            entry.leaves.push_back({"f", at, static_cast<std::uint8_t>(step), LeafKind::unsigned_integer, 0});
        schema.add(std::move(entry));
        if (random.below(16) == 0) break;
    }
    payload.clear();
    append_schema(schema, payload);
}

/// As many chunks as fit into some megabytes.
void many_chunks(std::vector<Chunk>& chunks, Random& random) {
    const auto at = chunks.begin() + static_cast<std::ptrdiff_t>(test::find_chunk(chunks, chunk_ticks));
    chunks.insert(at, 1u << random.below(18), Chunk{chunk_type("NONE"), flag_skippable, {}});
}

constexpr std::array bombs = {many_rows, large_image, many_commands, many_columns, many_chunks};

/// A world with full tables must use at most the memory that World::memory_of reports.
std::string fill_world(Random& random, Figures& figures) {
    const auto some = [&](std::uint32_t most) { return 1 + random.below(most); };
    const bool is_crowd = random.below(3) == 0; // all in one place
    WorldDef def;
    def.bodies_max = def.shapes_max = some(is_crowd ? 1000 : 400), def.contacts_max = some(3000),
    def.joints_max = some(300);
    def.pair_filters_max = some(100), def.characters_max = some(20), def.vehicles_max = some(10);
    const std::uint64_t told = must(World::memory_of(def)).all(), before = memory_now();
    forget_peak();
    World world = must(World::create(def));
    const BodyId floor = must(world.create_body({.kind = BodyKind::static_}));
    (void)world.create_shape(floor, {.geometry = plane()});
    BodyId last{};
    Real side = is_crowd ? 0.1_r : 1_r; // of a heap in which each box has its own volume
    while (!is_crowd && side * side * side < Real(def.bodies_max)) side += 0.1_r;
    while (world.body_count() < def.bodies_max) { // each jointed to the previous one
        const Real x = random.range(0_r, side), y = random.range(0_r, side), z = random.range(0_r, side);
        const BodyId body = must(world.create_body({.pose = {{x, y, z}, Quat::identity()}}));
        if (!world.create_shape(body, {.geometry = box(0.4_r, 0.4_r, 0.4_r)})) break;
        if (last && !is_crowd) (void)world.create_joint(weld_joint(), last, body, world.pose(body));
        last = body;
    }
    for (int i = 0; i < 20; ++i) (void)world.create_character({.position = {Real(2 * i), 0_r, 8_r}});
    for (int t = 0; t < 4; ++t) world.tick();
    ++figures[is_crowd ? "crowds" : "full worlds"];
    figures["told kB"] += told >> 10;
    figures["taken kB"] += (memory_peak() - before) >> 10;
    figures["dropped"] += world.faults().contacts_dropped;
    if (memory_peak() <= before + told) return {};
    return "a world took " + std::to_string(memory_peak() - before) + " bytes of " + std::to_string(told);
}

std::string explode(Random& random, bool leak, Figures& figures) {
    std::vector<Chunk> chunks = test::chunks_of(commands_file());
    bombs[random.below(bombs.size())](chunks, random);
    Bytes file = test::file_of(std::move(chunks), true);
    const Limits limits{.memory = std::uint64_t{16} << (20 + random.below(7))};
    const std::uint64_t before = memory_now() - file.capacity(); // the file counts as well
    forget_peak();
    const Result<Recording> recording =
        Recording::from_bytes(std::move(file), "bomb.lsr", OnDamage::recover, limits);
    if (!recording) ++figures["refused"];
    if (recording) {
        const VerifyReport report = verify(*recording, nullptr, {.jobs = 1 + random.below(3)});
        ++figures[name_of(report.verdict)];
        if (report.good() && recording->checksum() != must(test::read(commands_file())).checksum() &&
            !first_difference(recording->world_def(), must(test::read(commands_file())).world_def())
                 .empty() &&
            recording->hash_at(1) == must(test::read(commands_file())).hash_at(1))
            return "called good with another definition";
        MemorySink sink;
        (void)branch_commands(*recording, recording->end_tick(), sink);
    }
    Bytes planted;
    if (leak) planted.reserve(limits.memory + 1);
    figures["limit MB"] += limits.memory >> 20;
    figures["peak MB"] += (memory_peak() - before) >> 20;
    if (memory_peak() <= before + limits.memory) return {};
    return "took " + std::to_string(memory_peak() - before) + " bytes of " + std::to_string(limits.memory) +
           ": " + (recording ? "read" : recording.error().message);
}

} // namespace

int main(int argc, char** argv) {
    const Options options = read_options("bombs", argc, argv);
    (void)commands_file();
    return run(options, [&](std::uint64_t i, Figures& figures) {
        Random random = Random::seeded(options.seed, 1 + i);
        if (i % 4 == 3) return fill_world(random, figures);
        return explode(random, options.planted == "memory", figures);
    });
}
