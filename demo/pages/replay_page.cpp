#include "replay_page.h"

#include "recorded_game.h"
#include "view/hud.h"

#include <algorithm>
#include <chrono>

namespace lockstone::demo {
namespace {

/// Time per picture, so that a long seek does not freeze the window.
constexpr std::chrono::milliseconds seek_budget(12);

constexpr const char* page_keys = "Space play or pause   Left, Right one tick   with shift a second\n"
                                  "Home, End first and last tick   Page up, Page down keyframes\n"
                                  "drag the bar to go anywhere";

std::string title_of(const std::string& game) { return game.substr(0, game.find(' ')); }

} // namespace

ReplayPage::ReplayPage(replay::Recording recording, std::unique_ptr<Game> game, Stage& stage)
    : stage_(stage), recording_(std::move(recording)), game_(std::move(game)), last_(recording_.end_tick()),
      checks_(recording_.tick_count(), TickCheck::unknown) {}

Result<std::unique_ptr<Page>> ReplayPage::open(const Options& options, Stage& stage) {
    Result<RecordedGame> recorded = open_recording(options.source);
    if (!recorded) return recorded.error();
    Result<std::unique_ptr<Page>> page =
        open(std::move(recorded->recording), std::move(recorded->game), stage, nullptr);
    if (page && options.ticks) {
        auto& self = static_cast<ReplayPage&>(**page);
        self.last_ = std::min(self.last_, self.recording_.start_tick() + *options.ticks);
    }
    return page;
}

Result<std::unique_ptr<Page>> ReplayPage::open(replay::Recording recording, std::unique_ptr<Game> game,
                                               Stage& stage, const CameraRig* rig) {
    std::unique_ptr<ReplayPage> page(new ReplayPage(std::move(recording), std::move(game), stage));
    Result<replay::Player> player = replay::Player::open(page->recording_, page->game_.get());
    if (!player) return player.error();
    page->player_ = std::move(*player);
    page->view_.reset(page->player_->world());
    if (rig != nullptr)
        page->rig_ = *rig;
    else
        page->rig_.frame_scene(page->view_.bounds());
    return std::unique_ptr<Page>(std::move(page));
}

// ---- time -------------------------------------------------------------------------------------------------

bool ReplayPage::finished() const { return !failure_.empty() || player_->time() >= last_; }

Status ReplayPage::tick() {
    if (finished() || target_) return {};
    step();
    view_.capture(player_->world());
    return {};
}

void ReplayPage::step() {
    const std::uint64_t tick = player_->time();
    if (const Status status = player_->step(); !status) {
        failure_ = status.error().message;
        return;
    }
    TickCheck& check = checks_[tick - recording_.start_tick()];
    if (check == TickCheck::bit_exact) --good_;
    if (check == TickCheck::differs) --bad_;
    check = player_->agrees() ? TickCheck::bit_exact : TickCheck::differs;
    ++(check == TickCheck::bit_exact ? good_ : bad_);
    if (check == TickCheck::bit_exact || (first_bad_ && *first_bad_ <= tick)) return;
    first_bad_ = tick;
    first_bad_hash_ = player_->world().hash();
}

void ReplayPage::seek(std::uint64_t to) {
    target_ = std::clamp(to, recording_.start_tick(), recording_.end_tick());
    const std::size_t keyframe = recording_.keyframe_before(*target_);
    if (*target_ >= player_->time() && recording_.keyframes()[keyframe].time <= player_->time()) return;
    if (const Status status = player_->seek_keyframe(keyframe); !status) failure_ = status.error().message;
}

/// Runs ticks towards the target of a seek. Every tick on the way is compared.
void ReplayPage::work_on_seek() {
    if (!target_) return;
    const auto begin = std::chrono::steady_clock::now();
    while (failure_.empty() && player_->time() < *target_ &&
           std::chrono::steady_clock::now() - begin < seek_budget)
        step();
    view_.reset(player_->world());
    if (player_->time() >= *target_ || !failure_.empty()) target_.reset();
}

// ---- controls ---------------------------------------------------------------------------------------------

std::optional<std::uint64_t> ReplayPage::key_target(const Input& input) const {
    const std::uint64_t now = target_.value_or(player_->time());
    const std::uint64_t first = recording_.start_tick(), end = recording_.end_tick();
    const std::uint64_t stride = input.down(Key::left_shift) ? recording_.header().tick_rate : 1;
    if (input.pressed(Key::left)) return now - std::min(stride, now - first);
    if (input.pressed(Key::right)) return std::min(now + stride, end);
    if (input.pressed(Key::home) && !input.down(Key::left_shift)) return first;
    if (input.pressed(Key::end)) return end;
    const auto keyframes = recording_.keyframes();
    const std::size_t here = recording_.keyframe_before(now);
    if (input.pressed(Key::page_up))
        return keyframes[keyframes[here].time == now && here != 0 ? here - 1 : here].time;
    if (input.pressed(Key::page_down)) return here + 1 < keyframes.size() ? keyframes[here + 1].time : end;
    return std::nullopt;
}

void ReplayPage::control(const Input& input, const Moment& moment) {
    if (input.pressed(Key::space)) {
        if (finished() && failure_.empty())
            seek(recording_.start_tick());
        else
            stage_.clock.set_paused(!stage_.clock.paused());
    }
    std::optional<std::uint64_t> to = timeline_.drag(input, moment, timeline_content());
    if (!to) to = key_target(input);
    if (to && *to != target_.value_or(player_->time())) seek(*to);
    work_on_seek();
    rig_.control(input, view_, moment.size.y * moment.pixel_scale, moment.seconds, false);
}

// ---- drawing ----------------------------------------------------------------------------------------------

TimelineContent ReplayPage::timeline_content() const {
    TimelineContent content{.start = recording_.start_tick(),
                            .end = recording_.end_tick(),
                            .now = player_->time(),
                            .tick_rate = recording_.header().tick_rate,
                            .keyframes = {},
                            .checks = checks_};
    for (const replay::Recording::Keyframe& keyframe : recording_.keyframes())
        content.keyframes.push_back(keyframe.time);
    return content;
}

std::vector<Frame> ReplayPage::draw(const Moment& moment) {
    const bool moving = !finished() && !target_;
    const float alpha = moving ? moment.alpha : 1;
    rig_.update(view_, alpha, moment.seconds);
    Frame frame;
    frame.camera = rig_.camera();
    frame.wireframe = stage_.view.wireframe;
    view_.draw(frame, alpha, stage_, rig_.followed());
    if (stage_.view.overlay) draw_overlay(frame, moment);
    timeline_.draw(frame, moment, timeline_content());
    draw_help(frame, moment, stage_.view, page_keys);
    return {std::move(frame)};
}

void ReplayPage::draw_overlay(Frame& frame, const Moment& moment) const {
    const std::uint64_t now = player_->time();
    const std::uint64_t recorded = recording_.hash_at(now), simulated = player_->world().hash();
    const glm::vec4 colour = recorded == simulated ? ink::green : ink::red;
    TextPanel panel(moment, {12, 12});
    panel.title(title_of(recording_.header().game) + "  replay");
    panel.line("tick          " + std::to_string(now) + " of " + std::to_string(recording_.end_tick()) +
                   "   " + format_speed(stage_.clock),
               ink::white);
    panel.line("recorded      " + format_hash(recorded));
    panel.line("re-simulated  " + format_hash(simulated), colour);
    panel.line(recorded == simulated ? "\u2713 bit-exact" : "\u00d7 differs", colour);
    panel.line(std::to_string(good_) + " ticks bit-exact", ink::green);
    if (first_bad_)
        panel.line(std::to_string(bad_) + " ticks differ, the first is tick " + std::to_string(*first_bad_),
                   ink::red);
    if (!failure_.empty()) panel.line(failure_, ink::red);
    panel.draw(frame);
    draw_match(frame, moment, view_, recording_.header().player_count);
}

Verdict ReplayPage::verdict() const {
    const std::uint64_t compared = good_ + bad_, all = last_ - recording_.start_tick();
    if (compared == 0 && failure_.empty())
        return {recording_.header().game + ": no tick was compared, so nothing was shown to be bit-exact",
                false};
    std::string sentence = recording_.header().game + ": " + std::to_string(good_) + " of " +
                           std::to_string(std::max(compared, all)) + " ticks bit-exact";
    const bool good = bad_ == 0 && failure_.empty();
    if (first_bad_)
        sentence += "; tick " + std::to_string(*first_bad_) + " is the first that differs: recorded hash " +
                    format_hash(recording_.hash_at(*first_bad_ + 1)) + ", re-simulated " +
                    format_hash(first_bad_hash_);
    else if (!failure_.empty())
        sentence += "; " + failure_;
    else if (compared < all)
        sentence += " (the others were not played)";
    else
        sentence += ", final hash " + format_hash(recording_.hash_at(last_));
    return {sentence, good};
}

} // namespace lockstone::demo
