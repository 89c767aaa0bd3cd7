#pragma once
/// The base class of pages. The program shows one page after another page: a live game, a replay, netplay.

#include "lockstone/result.h"
#include "render/assets/model.h"
#include "render/camera/input.h"
#include "render/frame.h"
#include "step_clock.h"

#include <algorithm>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace lockstone::demo {

/// Flags for drawing; the viewer switches them with keys.
struct ViewOptions {
    bool wireframe = false;
    bool contacts = false; ///< points, normals
    bool bounds = false;   ///< boxes around shapes
    bool joints = false;   ///< axes, limits, cones
    bool crates = true;    ///< draws props that are boxes as the textured model
    bool help = false;
    bool overlay = true;
};

/// State that all pages share. It is kept when a page follows another.
struct Stage {
    ViewOptions view;
    StepClock clock;
    std::shared_ptr<const Model> crate; ///< null without a renderer
    bool interactive = false;           ///< a person uses a window
    bool in_window = false;             ///< ticks are called in real time; else as fast as possible
};

/// The time and the size of a picture.
struct Moment {
    float alpha = 1;           ///< between the last two states, 0 .. 1
    float seconds = 0;         ///< since the last picture
    glm::vec2 size{1280, 720}; ///< [design px]
    float pixel_scale = 1;     ///< physical per design pixel
    glm::vec2 cell{9, 17};     ///< of a letter of TextLine's default height [design px]
};

/// The last line of the program's output.
struct Verdict {
    std::string sentence;
    bool good = true;
};

class Page {
  public:
    virtual ~Page() = default;
    virtual std::string_view name() const = 0;    ///< the beginning of the names of pictures: "play"
    virtual std::uint32_t tick_rate() const = 0;  ///< [1/s]
    virtual std::uint64_t tick_count() const = 0; ///< current time of the page
    /// The name of a picture's file without extension: "play-000060".
    virtual std::string picture_name() const;
    virtual Status tick() = 0; ///< runs one step; does nothing after the end
    virtual bool finished() const = 0;
    virtual void control(const Input& input, const Moment& moment) = 0;
    virtual std::vector<Frame> draw(const Moment& moment) = 0;
    /// Makes the page that follows, and leaves this one unusable; null: there is none.
    virtual Result<std::unique_ptr<Page>> next() { return std::unique_ptr<Page>(); }
    virtual Verdict verdict() const = 0;
};

inline std::string Page::picture_name() const {
    const std::string count = std::to_string(tick_count());
    return std::string(name()) + "-" + std::string(6 - std::min<std::size_t>(count.size(), 6), '0') + count;
}

} // namespace lockstone::demo
