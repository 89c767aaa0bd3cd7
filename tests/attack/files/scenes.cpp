#include "attack/files/scenes.h"

namespace attack {

using namespace lockstone::replay;
using test::must;

Started::Started(std::unique_ptr<Game> rules) : game(std::move(rules)), first(must(game->start())) {}

namespace {

constexpr std::uint64_t ticks = 10;

struct Choice {
    const char* scene;
    SceneOptions options;
    std::uint64_t from; ///< ticks that ran before the recording
};

SceneRecording record(const Choice& choice) {
    SceneRecording out{choice.scene, nullptr, {}, {}};
    out.game = std::make_unique<Started>(must(make_scene(choice.scene, choice.options)));
    World world = must(out.game->start());
    std::vector<Bytes> bytes(out.game->player_count(), Bytes(out.game->input_size()));
    std::vector<PlayerInput> inputs(bytes.size());
    const auto step = [&] {
        for (std::uint32_t p = 0; p < inputs.size(); ++p) {
            std::ranges::fill(bytes[p], std::byte{0});
            scripted_input(out.game->rules(), 3, world.tick_count(), p, bytes[p]);
            if (world.tick_count() % 5 == p && !bytes[p].empty())
                bytes[p].back() = std::byte{3}; // presses every button
            inputs[p] = {bytes[p]};
        }
        must(out.game->advance(world, inputs));
    };
    while (world.tick_count() < choice.from) step();
    MemorySink sink;
    auto recorder =
        must(InputRecorder::begin(sink, *out.game, world, {.keyframe_ticks = 5, .block_ticks = 4}));
    while (world.tick_count() < choice.from + ticks) {
        step();
        must(recorder.after_tick(world, inputs));
    }
    must(recorder.close());
    out.file = sink.bytes;
    const std::span<const ColumnInfo> columns = world.state().layout().columns();
    for (std::uint32_t c = 0; c < columns.size(); ++c)
        if (columns[c].group == Group::game) out.game_columns.push_back(c);
    return out;
}

std::vector<SceneRecording> record_all() {
    std::vector<SceneRecording> all;
    for (const Choice& choice : {Choice{"two-blocks", {}, 0},
                                 {"stack", {.size = 3}, 0},
                                 {"pyramid", {.size = 3}, 20},
                                 {"pile", {.size = 10}, 5},
                                 {"convex-pile", {.size = 8}, 5},
                                 {"terrain", {.size = 8}, 5},
                                 {"washer", {.size = 10}, 5},
                                 {"domino", {.size = 8}, 5},
                                 {"ragdolls", {.size = 1, .players = 2}, 0},
                                 {"joint-grid", {.players = 2}, 0},
                                 {"joint-grid", {.players = 1}, 146},
                                 {"joint-grid", {}, 596},
                                 {"bridge", {.size = 10, .players = 2}, 0},
                                 {"wrecking-ball", {.size = 6, .players = 2}, 0},
                                 {"wrecking-ball", {.size = 6, .players = 4}, 30},
                                 {"water", {.size = 6}, 5},
                                 {"blast", {.size = 2}, 55},
                                 {"rollback-arena", {.players = 4}, 0},
                                 {"rollback-arena", {}, 115},
                                 {"cars", {.players = 2}, 0},
                                 {"cars", {.players = 4}, 40},
                                 {"character", {.players = 2}, 0},
                                 {"character", {.players = 4}, 236}})
        all.push_back(record(choice));
    return all;
}

} // namespace

const std::vector<SceneRecording>& scene_recordings() {
    static const std::vector<SceneRecording> all = record_all();
    return all;
}

} // namespace attack
