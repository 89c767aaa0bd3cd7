// Recordings that are changed and get valid checksums, then read and used in all ways of a program.
#include "attack/attack.h"
#include "attack/files/scenes.h"
#include "fuzz/checks/recording_check.h"
#include "lockstone/math/random.h"

#include <unistd.h>

namespace {

using namespace attack;
using lockstone::Random;
using namespace lockstone::replay;
using lockstone::test::must;

constexpr std::uint64_t memory_limit = std::uint64_t{256} << 20; ///< [bytes]
constexpr Limits limits{.memory = memory_limit, .commands_per_tick = 4096};

/// Planted faults. tests/attack/README.md lists the expected finding of each.
struct Plants {
    bool crash, hang, memory, accept;
};

/// A number, often at an edge, or a value from another place of the state.
std::uint64_t number(Random& random) {
    static constexpr std::uint64_t edges[] = {0,
                                              1,
                                              2,
                                              0x7f,
                                              0xff,
                                              0x7fff,
                                              0xffff,
                                              0x7fffffff,
                                              0x80000000,
                                              0xffffffff,
                                              std::uint64_t{1} << 62,
                                              std::uint64_t{1} << 63,
                                              ~std::uint64_t{0},
                                              ~std::uint64_t{0} >> 1};
    return random.below(2) == 0 ? edges[random.below(std::size(edges))]
                                : random.next_u64() >> random.below(64);
}

/// Changes some fields of some rows, in game columns half of the time.
void change_rows(State& state, const SceneRecording& of, Random& random) {
    const std::span<const ColumnInfo> columns = state.layout().columns();
    for (std::uint32_t left = 1 + random.below(4); left > 0; --left) {
        const bool in_game = !of.game_columns.empty() && random.below(2) == 0;
        const std::uint32_t column =
            in_game ? of.game_columns[random.below(static_cast<std::uint32_t>(of.game_columns.size()))]
                    : random.below(static_cast<std::uint32_t>(columns.size()));
        const ColumnInfo& info = columns[column];
        const std::span<std::byte> bytes = state.edit_bytes(column);
        const auto rows = static_cast<std::uint32_t>(bytes.size() / info.row_size);
        if (rows == 0) continue;
        const LeafInfo& leaf = info.leaves[random.below(static_cast<std::uint32_t>(info.leaves.size()))];
        const std::span<std::byte> field =
            bytes.subspan(std::size_t{random.below(rows)} * info.row_size + leaf.offset, leaf.size);
        std::uint64_t value = 0;
        std::memcpy(&value, field.data(), field.size());
        switch (random.below(4)) {
        case 0:
            value += random.below(7) - std::uint64_t{3};
            break;
        case 1:
            std::memcpy(&value, bytes.data() + std::size_t{random.below(rows)} * info.row_size + leaf.offset,
                        leaf.size);
            break;
        case 2:
            value ^= std::uint64_t{1} << random.below(8u * leaf.size);
            break;
        default:
            value = number(random);
        }
        std::memcpy(field.data(), &value, field.size());
    }
}

/// Changes bytes of a payload, or of its packed content: a bit, a byte, an integer at an edge, a piece removed,
/// duplicated or new.
void change_bytes(Bytes& bytes, Random& random) {
    if (bytes.empty()) return;
    const auto size = static_cast<std::uint32_t>(bytes.size());
    const std::uint32_t at = random.below(size), length = 1 + random.below(std::min(size - at, 9u));
    const auto place = bytes.begin() + at;
    switch (random.below(5)) {
    case 0:
        *place ^= static_cast<std::byte>(1u << random.below(8));
        break;
    case 1: {
        std::array<std::byte, 8> value{};
        base::store_little_endian(number(random), value.data());
        std::copy_n(value.begin(), std::min(size - at, 1u << random.below(4)), place);
        break;
    }
    case 2:
        bytes.erase(place, place + length);
        break;
    case 3: {
        const Bytes piece(place, place + length);
        bytes.insert(place, piece.begin(), piece.end());
        break;
    }
    default:
        bytes.insert(place, length, static_cast<std::byte>(random.below(256)));
    }
}

void change_chunk(test::Chunk& chunk, Random& random) {
    const std::optional<fuzz::PackedAt> at = fuzz::packed_at(chunk);
    if (!at || random.below(2) == 0) return change_bytes(chunk.payload, random);
    const auto size = base::load_little_endian<std::uint64_t>(chunk.payload.data() + at->size);
    Result<Bytes> contents = unpack(std::span(chunk.payload).subspan(at->packed), size);
    if (!contents) return change_bytes(chunk.payload, random);
    change_bytes(*contents, random);
    base::store_little_endian<std::uint64_t>(contents->size(), chunk.payload.data() + at->size);
    chunk.payload.resize(at->packed);
    pack(*contents, chunk.payload);
}

/// A changed recording of a scene.
Bytes changed_file(const SceneRecording& of, Random& random, Figures& figures) {
    const Recording good = must(test::read(of.file));
    std::vector<test::Chunk> chunks = test::chunks_of(of.file);
    const std::uint32_t how = random.below(8);
    if (how < 5) { // the state at its start; later keyframes are differences to it
        ++figures["states"];
        State state(must(of.game->start()).state().layout_shared());
        must(state.restore_portable(good.keyframe_image(0)));
        change_rows(state, of, random);
        const Bytes image = state.save_portable();
        chunks[test::find_chunk(chunks, chunk_keyframe)].payload =
            fuzz::keyframe_of(good.start_tick(), image, state);
        std::erase_if(chunks, [seen = 0](const test::Chunk& chunk) mutable {
            return chunk.type == chunk_keyframe && seen++ > 0;
        });
        return test::file_of(std::move(chunks), true);
    }
    ++figures["chunks"];
    for (std::uint32_t left = 1 + random.below(3); left > 0; --left)
        change_chunk(chunks[random.below(static_cast<std::uint32_t>(chunks.size()))], random);
    Bytes file = test::file_of(std::move(chunks), random.below(4) != 0);
    if (how == 7) { // as after a crash of the recorder
        ++figures["cut"];
        file.resize(random.below(static_cast<std::uint32_t>(file.size()) + 1));
    }
    return file;
}

/// A recording with the verdict `good` must be complete and have the original definition. use() checks its ticks.
std::string check_good(const Recording& taken, const Recording& original) {
    if (!taken.complete()) return "called good, but it is not whole";
    if (const std::string other = first_difference(taken.world_def(), original.world_def()); !other.empty())
        return "called good with another definition: " + other;
    return {};
}

/// Plays, verifies, branches and repairs. Every error must have a sentence.
std::string use(const Recording& recording, const SceneRecording& of, const Plants& plants,
                Figures& figures) {
    VerifyReport report = verify(recording, of.game.get());
    if (plants.accept) report.verdict = Verdict::good;
    ++figures[name_of(report.verdict)];
    if (report.sentence.size() < 20) return "a verdict without a sentence";
    if (report.good())
        if (std::string wrong = check_good(recording, must(test::read(of.file))); !wrong.empty())
            return wrong;
    Result<Player> player = Player::open(recording, *of.game);
    if (player) {
        ++figures["played"];
        player->keep_states(0);
        for (int t = 0; t < 6 && !player->at_end(); ++t)
            if (const Status status = player->step(); !status) {
                if (status.error().message.size() < 20) return "a step that fails does not say why";
                if (report.good()) return "called good, but a step fails: " + status.error().message;
                break;
            } else if (report.good() && !player->agrees()) {
                return "called good, but it plays otherwise";
            }
    }
    MemorySink sink;
    const std::uint64_t middle = recording.start_tick() + recording.tick_count() / 2;
    const auto branch = branch_inputs(recording, *of.game, middle, sink);
    if (branch && branch->world.tick_count() != middle) return "branched off elsewhere";
    MemorySink whole;
    if (recording.complete() || recording.tick_count() == 0) return {};
    if (const Status status = repair(recording, whole); !status)
        return "cannot be repaired: " + status.error().message;
    const Result<Recording> again = Recording::from_bytes(whole.bytes, "repaired.lsr");
    if (!again || again->end_tick() != recording.end_tick()) return "repaired to something else";
    return {};
}

std::string attack_scene(Random& random, const Plants& plants, Figures& figures) {
    const std::vector<SceneRecording>& all = scene_recordings();
    const SceneRecording& of = all[random.below(static_cast<std::uint32_t>(all.size()))];
    Bytes file = changed_file(of, random, figures);
    const std::uint64_t before = memory_now();
    forget_peak();
    const Result<Recording> recording =
        Recording::from_bytes(std::move(file), "attack.lsr", OnDamage::recover, limits);
    std::string wrong;
    if (recording)
        wrong = use(*recording, of, plants, figures);
    else if (++figures["refused"]; recording.error().message.size() < 20)
        wrong = "a refusal without a sentence";
    Bytes leak;
    if (plants.memory) leak.reserve(memory_limit + 1);
    if (wrong.empty() && memory_peak() > before + memory_limit)
        wrong = "took " + std::to_string(memory_peak() - before) + " bytes";
    return wrong.empty() ? "" : of.name + ": " + wrong;
}

/// Attacks the fuzzers' small states and recordings of inputs and of commands, with random scripts of the fuzzers'
/// format.
std::string attack_small(Random& random, Figures& figures) {
    Bytes script(3 + random.below(60));
    for (std::byte& byte : script) byte = static_cast<std::byte>(random.below(256));
    if (random.below(3) == 0) {
        bool taken = false;
        std::string wrong = fuzz::check_state_load(script, taken);
        ++figures["state images"];
        if (taken) ++figures["images taken"];
        return wrong;
    }
    fuzz::RecordingOutcome outcome;
    const std::string wrong = fuzz::check_recording(script, outcome);
    ++figures["small"];
    if (outcome.was_read) ++figures["small read"];
    if (outcome.was_opened) ++figures["small opened"];
    figures["small ticks"] += outcome.ticks;
    return wrong;
}

} // namespace

int main(int argc, char** argv) {
    const Options options = read_options("files", argc, argv);
    const Plants plants{options.planted == "crash", options.planted == "hang", options.planted == "memory",
                        options.planted == "accept"};
    (void)scene_recordings();
    return run(options, [&](std::uint64_t i, Figures& figures) {
        Random random = Random::seeded(options.seed, 1 + i);
        // throws an exception that no handler catches
        if (plants.crash && i == 3) must(Recording::open("/nowhere"));
        if (plants.hang && i == 3) sleep(seconds_max);
        return i % 4 == 0 || !options.planted.empty() ? attack_scene(random, plants, figures)
                                                      : attack_small(random, figures);
    });
}
