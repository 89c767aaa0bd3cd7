#pragma once
/// What the program shows one after the other: a live game, a replay, netplay.

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

/// What the viewer has switched on.
struct ViewOptions {
    bool wireframe = false;
    bool contacts = false; ///< points, normals
    bool bounds = false;   ///< boxes around shapes
    bool joints = false;   ///< axes, limits, cones
    bool crates = true;    ///< boxes of props as the textured model
    bool help = false;
    bool overlay = true;
};

/// What pages share, and keep when one follows the other.
struct Stage {
    ViewOptions view;
    StepClock clock;
    std::shared_ptr<const Model> crate; ///< null without a renderer
    bool interactive = false;           ///< someone sits in front of a window
    bool in_window = false;             ///< ticks are asked for in real time; else as fast as they come
};

/// One picture: when and how large.
struct Moment {
    float alpha = 1;           ///< between the last two states, 0 .. 1
    float seconds = 0;         ///< since the picture before
    glm::vec2 size{1280, 720}; ///< [design px]
    float pixel_scale = 1;     ///< physical per design pixel
    glm::vec2 cell{9, 17};     ///< of a letter of TextLine's default height [design px]
};

/// The last line of the program.
struct Verdict {
    std::string sentence;
    bool good = true;
};

class Page {
  public:
    virtual ~Page() = default;
    virtual std::string_view name() const = 0;    ///< starts the names of pictures: "play"
    virtual std::uint32_t tick_rate() const = 0;  ///< [1/s]
    virtual std::uint64_t tick_count() const = 0; ///< where it stands
    /// Of the file of a picture, without its ending: "play-000060".
    virtual std::string picture_name() const;
    virtual Status tick() = 0; ///< one step; nothing once it is finished
    virtual bool finished() const = 0;
    virtual void control(const Input& input, const Moment& moment) = 0;
    virtual std::vector<Frame> draw(const Moment& moment) = 0;
    /// The page that comes after this one, which is used up by the call; null: there is none.
    virtual Result<std::unique_ptr<Page>> next() { return std::unique_ptr<Page>(); }
    virtual Verdict verdict() const = 0;
};

inline std::string Page::picture_name() const {
    const std::string count = std::to_string(tick_count());
    return std::string(name()) + "-" + std::string(6 - std::min<std::size_t>(count.size(), 6), '0') + count;
}

} // namespace lockstone::demo
