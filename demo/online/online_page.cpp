#include "online/online_page.h"

#include "camera_rig.h"
#include "online/online_match.h"
#include "pages/replay_page.h"
#include "view/hud.h"

#include <chrono>
#include <cstdio>
#include <thread>

namespace lockstone::demo {
namespace {

using Phase = OnlineMatch::Phase;

constexpr std::uint32_t tick_rate_default = 60; ///< until the game is known
constexpr std::size_t sentence_letters = 84;    ///< of a line of an error

/// Breaks a text into lines at spaces.
std::vector<std::string> in_lines(std::string text) {
    std::vector<std::string> lines;
    while (text.size() > sentence_letters) {
        std::size_t end = text.rfind(' ', sentence_letters);
        if (end == std::string::npos || end == 0) end = sentence_letters;
        lines.push_back(text.substr(0, end));
        text.erase(0, text[end] == ' ' ? end + 1 : end);
    }
    lines.push_back(text);
    return lines;
}

std::string first_word(const std::string& text) { return text.substr(0, text.find(' ')); }

class OnlinePage final : public Page {
  public:
    OnlinePage(const Options& options, Stage& stage, std::unique_ptr<OnlineMatch> match)
        : stage_(stage), match_(std::move(match)), people_play_(stage.interactive && !match_->watches()),
          in_real_time_(stage.in_window), record_file_(options.record_file) {}

    std::string_view name() const override {
        return match_->is_host() ? "host" : match_->watches() ? "watch" : "join";
    }
    std::uint32_t tick_rate() const override {
        return match_->world() ? match_->world()->def().tick_rate : tick_rate_default;
    }
    std::uint64_t tick_count() const override {
        return match_->world() ? match_->session().current_tick() : 0;
    }
    Status tick() override;
    bool finished() const override;
    void control(const Input& input, const Moment& moment) override;
    std::vector<Frame> draw(const Moment& moment) override;
    Result<std::unique_ptr<Page>> next() override;
    Verdict verdict() const override;

  private:
    void tell_code();
    void tell_code_to_watch();
    void keep_time();
    Status begin_recording();
    Status write_recording();
    void tell_where_worlds_differ();
    void draw_panel(Frame& frame, const Moment& moment) const;
    void add_machines(TextPanel& panel) const;
    void add_session(TextPanel& panel) const;
    void draw_error(Frame& frame, const Moment& moment) const;
    void draw_invitation(Frame& frame, const Moment& moment) const;

    Stage& stage_;
    std::unique_ptr<OnlineMatch> match_;
    bool people_play_;
    bool in_real_time_; ///< a window's clock calls tick; else the page waits itself
    std::string record_file_, watch_code_;
    std::optional<replay::FileSink> file_; ///< set from the start of the match
    bool written_ = false, report_told_ = false;
    std::optional<std::chrono::steady_clock::time_point> next_tick_;
    bool code_told_ = false, seen_ = false, ended_ = false;
    InputMap input_map_;
    SceneView view_;
    CameraRig rig_;
};

// ---- time -------------------------------------------------------------------------------------------------

Status OnlinePage::tick() {
    keep_time();
    match_->frame(people_play_ ? &input_map_ : nullptr);
    tell_code();
    tell_code_to_watch();
    if (match_->world() == nullptr) return {};
    if (!seen_)
        if (const Status begun = begin_recording(); !begun) return begun;
    if (seen_) {
        view_.capture(*match_->world());
    } else {
        view_.reset(*match_->world());
        rig_.frame_scene(view_.bounds());
        if (!match_->watches()) rig_.follow(match_->self());
        seen_ = true;
    }
    return {};
}

/// All machines must run at the same pace, so without a window the page waits for the time of the next tick.
void OnlinePage::keep_time() {
    if (in_real_time_) return;
    const auto now = std::chrono::steady_clock::now();
    next_tick_ = next_tick_.value_or(now) + std::chrono::microseconds(1'000'000 / tick_rate());
    // Drops lost time of more than a second.
    if (now - *next_tick_ > std::chrono::seconds(1)) next_tick_ = now;
    std::this_thread::sleep_until(*next_tick_);
}

void OnlinePage::tell_code() {
    if (code_told_ || !match_->is_host() || match_->invitation().code.empty()) return;
    code_told_ = true;
    const std::string word = to_string(match_->invitation());
    std::printf("code %s\nto join: lockstone-demo --join %s\n", match_->invitation().code.c_str(),
                word.c_str());
    if (match_->relay_is_ours())
        std::printf("from another machine: replace 127.0.0.1 with the address of this machine\n");
    std::fflush(stdout);
}

void OnlinePage::tell_code_to_watch() {
    const Invitation invitation = match_->invitation_to_watch();
    if (invitation.code.empty() || invitation.code == watch_code_) return;
    watch_code_ = invitation.code;
    std::printf("to watch: lockstone-demo --watch %s\n", to_string(invitation).c_str());
    std::fflush(stdout);
}

bool OnlinePage::finished() const {
    const bool stays_for_reading = match_->phase() == Phase::failed && stage_.interactive;
    return ended_ || match_->phase() == Phase::over ||
           (match_->phase() == Phase::failed && !stays_for_reading);
}

/// Creates the file when a match has begun. Until then an old file of that name is kept.
Status OnlinePage::begin_recording() {
    if (record_file_.empty() || file_) return {};
    Result<replay::FileSink> created = replay::FileSink::create(record_file_);
    if (!created) return created.error();
    file_.emplace(std::move(*created));
    return {};
}

/// Writes the recording, whatever ended the match: its confirmed ticks show the reason.
Status OnlinePage::write_recording() {
    if (!file_ || written_) return {};
    written_ = true;
    const Result<std::span<const std::byte>> bytes = match_->recording();
    if (!bytes) return bytes.error();
    if (const Status appended = file_->append(*bytes); !appended) return appended;
    return file_->close();
}

void OnlinePage::tell_where_worlds_differ() {
    if (report_told_ || match_->desync_report() == nullptr) return;
    report_told_ = true;
    std::printf("%s", log_text(*match_->desync_report()).c_str());
    std::fflush(stdout);
}

Result<std::unique_ptr<Page>> OnlinePage::next() {
    if (const Status written = write_recording(); !written) return written.error();
    tell_where_worlds_differ();
    const bool differs = match_->desynced();
    if (!match_->error().empty() && !differs) return Error{match_->error()};
    if (match_->world() == nullptr || differs) return std::unique_ptr<Page>();
    std::printf("%s\n", match_->summary().c_str());
    std::fflush(stdout);
    Result<std::optional<OnlineMatch::Recorded>> recorded = match_->finish();
    if (!recorded) return recorded.error();
    if (!*recorded) return std::unique_ptr<Page>();
    Result<replay::Recording> recording =
        replay::Recording::from_bytes(std::move((*recorded)->bytes), "the recording");
    if (!recording) return recording.error();
    return ReplayPage::open(std::move(*recording), std::move((*recorded)->game), stage_, &rig_);
}

Verdict OnlinePage::verdict() const {
    if (!match_->error().empty()) return {match_->error(), false};
    return {match_->desynced() ? "the worlds differ" : "the match had not begun: no tick was compared",
            false};
}

void OnlinePage::control(const Input& input, const Moment& moment) {
    // The other machines do not pause, so this machine must not pause either.
    stage_.clock = stage_.clock.at_full_speed();
    if (input.pressed(Key::enter)) ended_ = match_->world() != nullptr && tick_count() != 0;
    rig_.control(input, view_, moment.size.y * moment.pixel_scale, moment.seconds,
                 people_play_ ? &input_map_ : nullptr);
}

// ---- drawing ----------------------------------------------------------------------------------------------

std::vector<Frame> OnlinePage::draw(const Moment& moment) {
    Frame frame;
    if (seen_) {
        rig_.update(view_, moment.alpha, moment.seconds);
        frame.camera = rig_.camera();
        frame.wireframe = stage_.view.wireframe;
        view_.draw(frame, moment.alpha, stage_, rig_.followed());
    }
    if (stage_.view.overlay) {
        draw_panel(frame, moment);
        if (seen_) draw_match(frame, moment, view_, match_->game()->player_count());
        if (!seen_) draw_invitation(frame, moment);
    }
    draw_error(frame, moment);
    draw_help(frame, moment, stage_.view,
              (people_play_ && match_->game() ? keys_of_players(*match_->game()) : "") +
                  "Enter leaves the match and plays it back");
    return {std::move(frame)};
}

void OnlinePage::draw_panel(Frame& frame, const Moment& moment) const {
    TextPanel panel(moment, {12, 12});
    const Game* game = match_->game();
    panel.title((game ? first_word(game->name()) : std::string("a match")) +
                (match_->is_host()   ? ", hosted here"
                 : match_->watches() ? ", watched"
                                     : ", joined"));
    panel.line("code       " + (match_->invitation().code.empty() ? "none yet" : match_->invitation().code),
               ink::white);
    panel.line("relay      " + to_string(match_->invitation().relay) +
               (match_->relay_is_ours() ? ", ours" : ""));
    panel.line("state      " + match_->state(), match_->error().empty() ? ink::green : ink::red);
    if (match_->world() != nullptr) {
        add_machines(panel);
        add_session(panel);
    }
    panel.draw(frame);
}

void OnlinePage::add_machines(TextPanel& panel) const {
    for (std::uint32_t p = 0; p < match_->game()->player_count(); ++p)
        panel.line("player " + std::to_string(p + 1) + "   " + match_->player_in_words(p));
    for (PeerId peer = 0; peer < match_->machines() && !match_->watches(); ++peer) {
        if (peer == match_->self()) continue;
        const PeerQuality quality = match_->session().quality(peer);
        panel.line("machine " + std::to_string(peer + 1) + "  " +
                       (quality.connected ? "ping " + std::to_string(quality.ping_ms) + " ms, " +
                                                std::to_string(quality.hashes_agreed) + " hashes agree"
                                          : std::string("not connected")),
                   quality.connected ? ink::blue : ink::amber);
    }
}

void OnlinePage::add_session(TextPanel& panel) const {
    const SessionStats& stats = match_->session().stats();
    panel.line("tick       " + std::to_string(match_->session().current_tick()) + " of " +
                   std::to_string(match_->ticks()) + ", confirmed " +
                   std::to_string(match_->log().hashes().size()),
               ink::white);
    panel.line("rollbacks  " + std::to_string(stats.rollbacks) + ", depth " +
               std::to_string(match_->last_depth()) + ", at most " + std::to_string(stats.depth_max));
    if (!match_->watches())
        panel.line("own input  " + std::to_string(match_->input_delay()) +
                   " ticks of delay, so that others predict less");
    panel.line("run again  " + std::to_string(stats.resimulated) + " ticks, " + std::to_string(stats.stalls) +
               " frames waited");
    if (!watch_code_.empty())
        panel.line("watching   " + std::to_string(match_->watchers()) + ", code for the next " + watch_code_);
    if (!match_->notices().empty()) panel.line(match_->notices().back(), ink::amber);
}

/// Until the match starts, shows the command with which others join.
void OnlinePage::draw_invitation(Frame& frame, const Moment& moment) const {
    if (!match_->is_host() || match_->invitation().code.empty() || !match_->error().empty()) return;
    TextPanel panel(moment, {0, 0});
    panel.title("code " + match_->invitation().code);
    panel.line("to join, run this command in one line (the terminal shows it too):");
    panel.line("lockstone-demo --join", ink::white);
    panel.line(match_->invitation().code + "@" + to_string(match_->invitation().relay), ink::white);
    panel.line("#" + to_string(match_->invitation().key), ink::white);
    if (match_->relay_is_ours())
        panel.line("from another machine: replace 127.0.0.1 with the address of this machine");
    panel.move_to(0.5f * (moment.size - panel.size()));
    panel.draw(frame);
}

void OnlinePage::draw_error(Frame& frame, const Moment& moment) const {
    if (match_->error().empty()) return;
    TextPanel panel(moment, {0, 0});
    panel.title(match_->desynced() ? "the worlds differ" : "the match cannot continue", ink::red);
    for (const std::string& line : in_lines(match_->error())) panel.line(line, ink::white);
    if (stage_.interactive) panel.line("Escape ends");
    panel.move_to({0.5f * (moment.size.x - panel.size().x), moment.size.y - panel.size().y - 40});
    panel.draw(frame);
}

} // namespace

Result<std::unique_ptr<Page>> open_online_page(const Options& options, Stage& stage) {
    const std::uint64_t ticks =
        options.ticks.value_or(stage.interactive ? ticks_default_window : ticks_default);
    Result<std::unique_ptr<OnlineMatch>> match = OnlineMatch::begin(options, ticks);
    if (!match) return match.error();
    return std::unique_ptr<Page>(std::make_unique<OnlinePage>(options, stage, std::move(*match)));
}

} // namespace lockstone::demo
