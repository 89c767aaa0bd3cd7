#include "live_page.h"

#include "replay_page.h"
#include "view/hud.h"

#include <array>
#include <chrono>

namespace lockstone::demo {
namespace {

constexpr std::uint64_t keyframe_ticks = 120; ///< two seconds, so that seeking in the replay is immediate

constexpr const char* ending_keys = "Enter ends the game and plays it back";

std::string scene_name(const Game& game) {
    const std::string name = game.name();
    return name.substr(0, name.find(' '));
}

Result<cli::InputSource> open_inputs(const Options& options, const Game& game) {
    if (options.input_file.empty()) return cli::InputSource::scripted(game, options.scene.seed);
    return cli::InputSource::open(game, options.input_file);
}

} // namespace

LivePage::LivePage(const Options& options, Stage& stage, std::unique_ptr<Game> game, World world,
                   cli::InputSource source)
    : stage_(stage), game_(std::move(game)), world_(std::move(world)), source_(std::move(source)),
      people_play_(stage.interactive && is_playable(*game_) && options.input_file.empty()),
      ticks_(options.ticks.value_or(people_play_ ? ticks_default_window : ticks_default)),
      record_file_(options.record_file) {
    view_.reset(world_);
    rig_.frame_scene(view_.bounds());
    if (people_play_) rig_.follow(0);
}

Result<std::unique_ptr<Page>> LivePage::open(const Options& options, Stage& stage) {
    Result<std::unique_ptr<Game>> game = make_game(options);
    if (!game) return game.error();
    Result<World> world = (*game)->start();
    if (!world) return world.error();
    Result<cli::InputSource> source = open_inputs(options, **game);
    if (!source) return source.error();
    std::unique_ptr<LivePage> page(
        new LivePage(options, stage, std::move(*game), std::move(*world), std::move(*source)));
    if (const Status status = page->start_recording(options); !status) return status.error();
    return std::unique_ptr<Page>(std::move(page));
}

Status LivePage::start_recording(const Options& options) {
    if (record_file_.empty()) {
        sink_ = std::make_unique<replay::MemorySink>();
    } else {
        Result<replay::FileSink> file = replay::FileSink::create(record_file_);
        if (!file) return file.error();
        sink_ = std::make_unique<replay::FileSink>(std::move(*file));
    }
    replay::RecorderOptions recorder;
    recorder.options = {{"seed", std::to_string(options.scene.seed)}};
    recorder.keyframe_ticks = keyframe_ticks;
    Result<replay::InputRecorder> begun = replay::InputRecorder::begin(*sink_, *game_, world_, recorder);
    if (!begun) return begun.error();
    recorder_ = std::move(*begun);
    return {};
}

Status LivePage::tick() {
    if (finished()) return {};
    const std::span<const PlayerInput> planned = source_.at(world_.tick_count());
    std::vector<PlayerInput> inputs(planned.begin(), planned.end());
    std::array<std::array<std::byte, sizeof(ArenaInput)>, InputMap::seat_count> seats;
    for (std::size_t p = 0; people_play_ && p < inputs.size() && p < seats.size(); ++p) {
        seats[p] = encode_input(input_map_.take(p));
        // The script plays for seats that no person has used.
        if (p == 0 || input_map_.used(p)) inputs[p].bytes = seats[p];
    }
    const auto begin = std::chrono::steady_clock::now();
    if (Status s = game_->advance(world_, inputs); !s) return s;
    const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
    tick_us_ += (tick_us_ == 0 ? 1 : 0.05) * (took.count() - tick_us_);
    view_.capture(world_);
    return recorder_->after_tick(world_, inputs);
}

void LivePage::control(const Input& input, const Moment& moment) {
    if (input.pressed(Key::enter)) ended_ = world_.tick_count() != 0;
    rig_.control(input, view_, moment.size.y * moment.pixel_scale, moment.seconds,
                 people_play_ ? &input_map_ : nullptr);
}

std::vector<Frame> LivePage::draw(const Moment& moment) {
    rig_.update(view_, moment.alpha, moment.seconds);
    Frame frame;
    frame.camera = rig_.camera();
    frame.wireframe = stage_.view.wireframe;
    view_.draw(frame, moment.alpha, stage_, rig_.followed());
    if (stage_.view.overlay) draw_overlay(frame, moment);
    draw_help(frame, moment, stage_.view, (people_play_ ? keys_of_players(*game_) : "") + ending_keys);
    return {std::move(frame)};
}

void LivePage::draw_overlay(Frame& frame, const Moment& moment) const {
    TextPanel panel(moment, {12, 12});
    panel.title(scene_name(*game_));
    panel.line("tick       " + std::to_string(world_.tick_count()) + " of " + std::to_string(ticks_) + "   " +
                   format_speed(stage_.clock),
               ink::white);
    panel.line("hash       " + format_hash(world_.hash()));
    panel.line("bodies     " + std::to_string(view_.body_count()) + "   contacts " +
               std::to_string(view_.contact_count()));
    panel.line("tick time  " + format_number(tick_us_, 0) + " \u00b5s");
    panel.line("recording  " + format_bytes(recorder_->bytes_written()), ink::red);
    panel.draw(frame);
    draw_match(frame, moment, view_, game_->player_count());
    if (!stage_.interactive) return;
    TextPanel hint(moment, {12, moment.size.y - 12});
    hint.line((people_play_ ? keys_in_short(*game_) + "   " : "") + "Enter plays back   F1 keys");
    hint.align_bottom();
    hint.draw(frame);
}

Result<std::unique_ptr<Page>> LivePage::next() {
    if (const Status status = recorder_->close(); !status) return status.error();
    Result<replay::Recording> recording =
        record_file_.empty() ? replay::Recording::from_bytes(
                                   std::move(static_cast<replay::MemorySink&>(*sink_).bytes), "the recording")
                             : replay::Recording::open(record_file_);
    if (!recording) return recording.error();
    return ReplayPage::open(std::move(*recording), std::move(game_), stage_, &rig_);
}

} // namespace lockstone::demo
