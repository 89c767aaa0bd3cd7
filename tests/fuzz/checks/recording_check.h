// The rules for arbitrary bytes that are read and played as a recording. The fuzzer and the tests that replay its
// inputs use them.
//
// Byte 0 of an input: bits 0-1 the recording (modulo 3); bits 2-3 the meaning of the rest:
//   0     the file itself
//   1     changes of a valid file, each a `splice`
//   2     changes of its chunks: u8 chunk, u8 1: its packed content, 0: its payload, then a `splice`
//   3     changes of the state at its start: see `edit_rows`; later keyframes are left out
// bit 4: the index has the places of the chunks after the change (2 and 3). Checksums and hashes are made valid
// afterwards.
#pragma once

#include "fuzz/checks/state_check.h"
#include "support/small_recording.h"

namespace fuzz {

using replay::OnDamage;
using replay::Player;
using replay::Recording;

/// Continues where the small game stops with an error, as in states that it never makes.
class ForgivingGame final : public lockstone::test::SmallGame {
  public:
    Status advance(World& world, std::span<const PlayerInput> inputs) const override {
        try {
            return SmallGame::advance(world, inputs);
        } catch (const std::runtime_error&) { world.tick(); }
        return {};
    }
};

namespace detail {

/// Commands of many kinds on the worlds that the state fuzzer damages.
inline Buffer record_commands_of(const World& start) {
    World w = start.clone();
    replay::MemorySink sink;
    const auto recorder =
        made(replay::CommandRecorder::begin(sink, w, "fuzz", {.keyframe_ticks = 5, .block_ticks = 4}));
    for (int tick = 0; tick < 10; ++tick) {
        const BodyId body = w.body_at(static_cast<std::uint32_t>(tick) % w.body_count());
        (void)w.add_impulse(body, vec(1, tick, 0)), (void)w.add_force(body, vec(0, 5, 0));
        (void)w.set_velocity(body, vec(0, 1, 0), vec(0, 0, tick));
        if (tick == 2) (void)w.explode({.center = vec(1, 0, 1), .radius = Real(3), .impulse = Real(20)});
        if (tick == 3) add_crate(w, at(1, 4, 1));
        if (tick == 4) (void)w.write(Column<Purse>{0}, Purse{1, 2, 3});
        if (tick == 5 && w.joint_count() > 0) done(w.destroy(w.joint_at(0)));
        if (tick == 6) (void)w.destroy(body);
        if (tick == 7) done(w.set_gravity(vec(0, -5, 1)));
        w.tick();
    }
    done(recorder->close());
    return sink.bytes;
}

} // namespace detail

inline constexpr std::size_t recording_count = 3;
inline const ForgivingGame& recorded_game() {
    static const ForgivingGame game;
    return game;
}
inline const Buffer& recording_of(std::size_t index) {
    static const std::array<Buffer, recording_count> all{
        lockstone::test::record_inputs(10, {.keyframe_ticks = 5, .block_ticks = 4}, recorded_game()),
        detail::record_commands_of(base_of(1).now), detail::record_commands_of(base_of(2).now)};
    return all[index];
}

/// Makes the chain of checksums valid, as far as the frames can be read.
inline void seal_recording(Buffer& file) {
    using namespace lockstone::replay;
    if (file.size() < preamble_bytes) return;
    std::array<std::byte, preamble_bytes> first_bytes{};
    std::copy_n(file.begin(), preamble_bytes, first_bytes.begin());
    std::uint64_t chain = chain_start(first_bytes);
    for (std::size_t at = preamble_bytes; file.size() - at >= chunk_head_bytes + checksum_bytes;) {
        const std::uint64_t size = base::load_little_endian<std::uint64_t>(file.data() + at + 8);
        if (size > file.size() - at - chunk_head_bytes - checksum_bytes) return;
        const std::size_t framed = chunk_head_bytes + static_cast<std::size_t>(size);
        chain = hash_bytes(std::span(file).subspan(at, framed), chain);
        base::store_little_endian(chain, file.data() + at + framed);
        at += framed + checksum_bytes;
    }
}

/// The offset of a payload's packed bytes, and of the u64 with their unpacked size.
struct PackedAt {
    std::size_t packed, size;
};
inline std::optional<PackedAt> packed_at(const lockstone::test::Chunk& chunk) {
    PackedAt at{24, 16};
    if (chunk.type == replay::chunk_ticks && chunk.payload.size() >= 20)
        at = {20 + std::size_t{8} * base::load_little_endian<std::uint32_t>(chunk.payload.data() + 8), 12};
    else if (chunk.type != replay::chunk_keyframe)
        return std::nullopt;
    if (at.packed > chunk.payload.size()) return std::nullopt;
    return at;
}

/// A keyframe of this image, with a valid checksum. If the image is a valid state, the keyframe has that state's hash.
inline Buffer keyframe_of(std::uint64_t time, Buffer image, State& scratch) {
    seal_state(image);
    const bool is_one = scratch.restore_portable(image).ok();
    Buffer payload;
    base::ByteWriter to(payload);
    to.u64(time), to.u64(is_one ? scratch.hash() : 0), to.u64(image.size());
    replay::pack(image, payload);
    return payload;
}

inline State state_of(const Recording& recording, std::size_t index) {
    const World world = index == 0 ? recorded_game().start().value() : base_of(index).now.clone();
    State state(world.state().layout_shared());
    lockstone::test::scene::done(state.restore_portable(recording.keyframe_image(0)));
    return state;
}

/// Changes a chunk's payload or its packed content.
inline void edit_chunk(Input& in, lockstone::test::Chunk& chunk, State& scratch) {
    const bool inside = in.take_u8() % 2 != 0;
    const std::optional<PackedAt> at = packed_at(chunk);
    if (!inside || !at) return splice(in, chunk.payload);
    const auto size = base::load_little_endian<std::uint64_t>(chunk.payload.data() + at->size);
    Result<Buffer> contents = replay::unpack(std::span(chunk.payload).subspan(at->packed), size);
    if (!contents) return splice(in, chunk.payload);
    splice(in, *contents);
    const auto time = base::load_little_endian<std::uint64_t>(chunk.payload.data());
    if (chunk.type == replay::chunk_keyframe && contents->size() >= 8 &&
        (*contents)[0] == std::byte{'L'}) { // a whole state: no difference to another one
        chunk.payload = keyframe_of(time, std::move(*contents), scratch);
        return;
    }
    base::store_little_endian<std::uint64_t>(contents->size(), chunk.payload.data() + at->size);
    chunk.payload.resize(at->packed);
    replay::pack(*contents, chunk.payload);
}

struct RecordingInput {
    const Game* game; ///< null if the recording holds commands
    Buffer file;
};

inline RecordingInput read_recording_input(std::span<const std::byte> data) {
    Input in(data);
    const std::uint8_t first = in.take_u8(), how = first >> 2 & 3u;
    const std::size_t index = (first & 3u) % recording_count;
    RecordingInput out{index == 0 ? &recorded_game() : nullptr, recording_of(index)};
    if (how == 0) {
        const std::span<const std::byte> rest = in.take_rest();
        out.file.assign(rest.begin(), rest.end());
    } else if (how == 1) {
        while (!in.empty()) splice(in, out.file);
    } else {
        const Recording good = lockstone::test::must(lockstone::test::read(out.file));
        std::vector<lockstone::test::Chunk> chunks = lockstone::test::chunks_of(out.file);
        State state = state_of(good, index);
        if (how == 2) {
            while (!in.empty()) edit_chunk(in, chunks[in.take_u8() % chunks.size()], state);
        } else {
            edit_rows(in, state);
            const Buffer image = state.save_portable();
            chunks[lockstone::test::find_chunk(chunks, replay::chunk_keyframe)].payload =
                keyframe_of(good.start_tick(), image, state);
            std::erase_if(chunks, [seen = 0](const lockstone::test::Chunk& chunk) mutable {
                return chunk.type == replay::chunk_keyframe && seen++ > 0;
            });
        }
        out.file = lockstone::test::file_of(std::move(chunks), (first & 16u) != 0);
    }
    seal_recording(out.file);
    return out;
}

// ---- rules -------------------------------------------------------------------------------------------------------

/// How far the checks came with an input.
struct RecordingOutcome {
    bool was_read = false, was_opened = false;
    std::uint64_t ticks = 0; ///< ticks played
};

/// Reads and plays recordings. A test may use others to plant a fault.
struct RecordingReader {
    Result<Recording> operator()(const Buffer& file, OnDamage on_damage) const {
        return Recording::from_bytes(file, "fuzz.lsr", on_damage);
    }
};
struct RecordingStepper {
    Status operator()(Player& player) const { return player.step(); }
};

inline bool says_why(const std::string& sentence) {
    return sentence.starts_with("fuzz.lsr: ") && sentence.size() > 20;
}

/// Reads all data that can be read without playing.
inline std::string check_contents(const Recording& r) {
    for (std::uint64_t t = r.start_tick(); t <= r.end_tick(); ++t) (void)r.hash_at(t);
    for (std::size_t k = 0; k < r.keyframes().size(); ++k)
        if (r.keyframe_image(k).size() != r.keyframes()[k].image_size) return "a keyframe has another size";
    for (std::uint64_t t = r.start_tick(); t < r.end_tick();) {
        const replay::TickBlock block = r.block_with(t);
        if (!block.holds(t)) return "a block is not where it should be";
        for (; t < block.end_tick(); ++t) {
            const bool has_inputs = r.header().mode == replay::Mode::inputs;
            if (block.inputs(t).size() != (has_inputs ? r.header().player_count : 0))
                return "an input is missing";
            (void)block.commands(t);
        }
    }
    return {};
}

/// Returns whether the recording plays in a few milliseconds.
inline bool is_small(const Recording& r) {
    const WorldDef& d = r.world_def();
    std::uint64_t rows = 0, game_bytes = 0;
    for (const std::uint32_t n : {d.bodies_max, d.shapes_max, d.contacts_max, d.fields_max,
                                  d.pair_filters_max, d.joints_max, d.characters_max, d.vehicles_max})
        rows += n;
    for (const GameSchema::Entry& e : r.schema().entries())
        game_bytes += e.row_size * std::uint64_t{e.per_body ? d.bodies_max : 1};
    return rows <= 2000 && game_bytes <= 1u << 20 && r.tick_count() <= 64;
}

/// Hashes after each of the first ticks, up to the first tick that fails.
template <class Stepper>
std::vector<std::uint64_t> hashes_of(Player& player, Stepper&& step, std::string& complaint) {
    constexpr std::size_t ticks_max = 8;
    std::vector<std::uint64_t> hashes;
    while (!player.at_end() && hashes.size() < ticks_max) {
        if (const Status status = step(player); !status) {
            if (!says_why(status.error().message)) complaint = "a step that fails does not say why";
            break;
        }
        hashes.push_back(player.world().hash());
    }
    return hashes;
}

/// Plays the recording twice from its start, with equal hashes. A recording that verify() calls good must play as
/// recorded.
template <class Stepper>
std::string check_play(const Recording& r, const Game* game, RecordingOutcome& outcome, Stepper&& step) {
    Result<Player> player = Player::open(r, game);
    const replay::VerifyReport report = replay::verify(r, game);
    if (!says_why(report.sentence)) return "a verdict without a sentence";
    outcome.was_opened = player.ok();
    if (!player) return says_why(player.error().message) && !report.good() ? "" : "refused without a reason";
    std::string complaint;
    const std::vector<std::uint64_t> hashes = hashes_of(*player, step, complaint);
    outcome.ticks = hashes.size();
    for (std::size_t i = 0; report.good() && i < hashes.size(); ++i)
        if (hashes[i] != r.hash_at(r.start_tick() + i + 1)) return "verified as good, but it plays otherwise";
    if (report.good() && !r.complete()) return "verified as good, but it is not whole";
    player->keep_states(0);
    if (const Status back = player->seek(r.start_tick()); !back)
        return "the start cannot be reached again: " + back.error().message;
    if (hashes_of(*player, step, complaint) != hashes) return "played from the start again it is another run";
    for (const std::uint64_t to : {r.end_tick(), r.start_tick() + r.tick_count() / 2, r.end_tick() + 1})
        if (const Status status = player->seek(to); !status && !says_why(status.error().message))
            complaint = "a seek that fails does not say why";
    return complaint;
}

/// Returns an error sentence about reading or playing, or an empty string.
template <class Reader = RecordingReader, class Stepper = RecordingStepper>
std::string check_recording(const RecordingInput& input, RecordingOutcome& outcome, Reader&& read = {},
                            Stepper&& step = {}) {
    const Result<Recording> strict = read(input.file, OnDamage::refuse),
                            recovered = read(input.file, OnDamage::recover);
    outcome.was_read = strict.ok();
    for (const Result<Recording>* r : {&strict, &recovered})
        if (!*r && !says_why(r->error().message)) return "a refusal does not say why";
    if (strict && (!recovered || !strict->complete() || recovered->tick_count() != strict->tick_count()))
        return "a whole file is recovered otherwise";
    if (!recovered) return {};
    if (!strict && !says_why(recovered->damage()))
        return "what was recovered does not say that it was damaged";
    if (std::string e = check_contents(*recovered); !e.empty()) return e;
    return is_small(*recovered) ? check_play(*recovered, input.game, outcome, step) : "";
}

inline std::string check_recording(std::span<const std::byte> data, RecordingOutcome& outcome) {
    return check_recording(read_recording_input(data), outcome);
}

} // namespace fuzz
