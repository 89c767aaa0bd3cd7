#include "app.h"

#include "cli/interrupt.h"
#include "cli/text.h"
#include "online/online_page.h"
#include "pages/compare_page.h"
#include "pages/figures_page.h"
#include "pages/live_page.h"
#include "pages/netplay_page.h"
#include "pages/replay_page.h"
#include "render/renderer.h"
#include "view/hud.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

namespace lockstone::demo {
namespace {

/// All objects that need OpenGL, in the order of their creation.
struct Screen {
    explicit Screen(std::unique_ptr<Surface> made) : surface(std::move(made)), renderer(resources) {}
    std::unique_ptr<Surface> surface;
    ResourceManager resources;
    Renderer renderer;
};

void complain(const std::string& sentence) {
    constexpr std::size_t longest = 4000;
    std::fprintf(stderr, "lockstone-demo: %s\n", cli::shown(sentence, longest).c_str());
}

Result<std::unique_ptr<Page>> open_page(const Options& options, Stage& stage) {
    if (options.online()) return open_online_page(options, stage);
    if (options.compare) return open_comparison(options, stage);
    if (options.figures) return FiguresPage::open(options, stage);
    if (options.source_is_file()) return ReplayPage::open(options, stage);
    return options.netplay ? NetplayPage::open(options, stage) : LivePage::open(options, stage);
}

/// Checks the scene before a window opens for it.
Status check_scene(const Options& options) {
    if (!options.join.empty() || !options.watch.empty()) return {}; // the host chooses the game
    if (options.compare) return check_comparison(options);
    if (options.source_is_file()) return {};
    const Result<std::unique_ptr<Game>> game = make_game(options);
    return game ? Status{} : game.error();
}

class App {
  public:
    explicit App(const Options& options);
    int run();

  private:
    void open_screen();
    bool try_screen(bool window);
    Status run_window();
    Status run_offscreen();
    Status run_page_offscreen();
    Result<bool> follow_with_next(); ///< false: this was the last page
    Moment moment(float seconds);
    void take_picture();
    void write_picture();

    const Options& options_;
    std::unique_ptr<Screen> screen_; ///< null: no pictures; it must outlive all owners of GL objects
    Stage stage_;
    bool window_ = false;
    bool pictures_ = false; ///< pictures are written at intervals
    std::unique_ptr<Page> page_;
    const cli::Interrupt interrupt_;
};

App::App(const Options& options) : options_(options) {
    const auto shown = [&](const char* what) {
        return std::find(options.show.begin(), options.show.end(), what) != options.show.end();
    };
    stage_.view.wireframe = shown("wireframe");
    stage_.view.contacts = shown("contacts");
    stage_.view.bounds = shown("bounds");
    stage_.view.joints = shown("joints");
    stage_.view.help = shown("help");
}

// ---- the screen -------------------------------------------------------------------------------------------

bool App::try_screen(bool window) {
    try {
        const SurfaceOptions wanted{.size = {options_.width, options_.height}};
        screen_ =
            std::make_unique<Screen>(window ? Surface::open_window(wanted) : Surface::open_offscreen(wanted));
        stage_.crate = screen_->resources.model("crate.obj");
        return true;
    } catch (const std::runtime_error& error) {
        screen_.reset();
        complain(std::string(window ? "no window: " : "no pictures: ") + error.what());
        return false;
    }
}

void App::open_screen() {
    window_ = !options_.offscreen && Surface::display_available() && try_screen(true);
    if (!window_) try_screen(false);
    stage_.interactive = window_ && !options_.script;
    stage_.in_window = window_;
    pictures_ = screen_ != nullptr && (!window_ || !options_.frames_folder.empty());
}

Moment App::moment(float seconds) {
    const float scale = screen_->surface->pixel_scale();
    const glm::vec2 size = glm::vec2(screen_->surface->size()) / scale;
    return {.alpha = window_ ? stage_.clock.alpha() : 1.0f,
            .seconds = seconds,
            .size = size,
            .pixel_scale = scale,
            .cell = screen_->renderer.text_cell(*screen_->surface)};
}

void App::write_picture() {
    const std::filesystem::path folder(options_.frames_folder.empty() ? "lockstone-frames"
                                                                      : options_.frames_folder);
    std::filesystem::create_directories(folder);
    screen_->surface->write_png(folder / (page_->picture_name() + ".png"));
}

// ---- the loops --------------------------------------------------------------------------------------------

Result<bool> App::follow_with_next() {
    Result<std::unique_ptr<Page>> next = page_->next();
    if (!next) return next.error();
    if (*next == nullptr) return false;
    page_ = std::move(*next);
    return true;
}

void App::take_picture() {
    screen_->surface->poll();
    const std::vector<Frame> frames = page_->draw(moment(static_cast<float>(options_.frame_every) / 60));
    screen_->renderer.draw(*screen_->surface, frames);
    screen_->surface->present();
    write_picture();
}

Status App::run_page_offscreen() {
    std::uint64_t next_picture = options_.frame_every;
    while (!page_->finished() && !interrupt_.came()) {
        if (const Status status = page_->tick(); !status) return status;
        if (!pictures_ || (page_->tick_count() < next_picture && !page_->finished())) continue;
        take_picture();
        next_picture = page_->tick_count() + options_.frame_every;
    }
    return {};
}

/// Runs one page after another without waiting, and writes pictures at intervals if OpenGL is available.
Status App::run_offscreen() {
    for (;;) {
        if (const Status status = run_page_offscreen(); !status) return status;
        const Result<bool> more = follow_with_next();
        if (!more) return more.error();
        if (!*more || interrupt_.came()) return {}; // the page has closed its recording
    }
}

Status App::run_window() {
    using Clock = std::chrono::steady_clock;
    Clock::time_point before = Clock::now();
    std::uint64_t next_picture = options_.frame_every;
    while (!screen_->surface->close_requested() && !interrupt_.came()) {
        const Input& input = screen_->surface->poll();
        if (input.pressed(Key::escape)) break;
        const Clock::time_point now = Clock::now();
        const float seconds = std::min(std::chrono::duration<float>(now - before).count(), 0.25f);
        before = now;
        control_stage(stage_, input);
        page_->control(input, moment(seconds));
        for (int steps = stage_.clock.advance(seconds, page_->tick_rate()); steps > 0; --steps)
            if (const Status status = page_->tick(); !status) return status;
        screen_->renderer.draw(*screen_->surface, page_->draw(moment(seconds)));
        screen_->surface->present();
        if (input.pressed(Key::f12)) write_picture();
        if (pictures_ && page_->tick_count() >= next_picture) {
            write_picture();
            next_picture = page_->tick_count() + options_.frame_every;
        }
        if (!page_->finished()) continue;
        const Result<bool> more = follow_with_next();
        if (!more) return more.error();
        if (*more)
            next_picture = options_.frame_every;
        else if (options_.script)
            return {};
    }
    // The recording still has to be verified. If the window is gone, this happens without pictures.
    const Result<bool> more = follow_with_next();
    if (!more) return more.error();
    while (*more && !page_->finished() && !interrupt_.came())
        if (const Status status = page_->tick(); !status) return status;
    return {};
}

int App::run() {
    if (const Status status = check_scene(options_); !status) {
        complain(status.error().message);
        return 2;
    }
    open_screen();
    if (options_.figures && screen_ == nullptr) return 2; // open_screen has printed the reason
    Result<std::unique_ptr<Page>> page = open_page(options_, stage_);
    if (!page) {
        complain(page.error().message);
        return 2;
    }
    page_ = std::move(*page);
    if (const Status status = window_ ? run_window() : run_offscreen(); !status) {
        complain(status.error().message);
        return 2;
    }
    interrupt_.follow();
    const Verdict verdict = page_->verdict();
    std::printf("%s\n", verdict.sentence.c_str());
    return verdict.good ? 0 : 1;
}

} // namespace

int run(const Options& options) { return App(options).run(); }

} // namespace lockstone::demo
