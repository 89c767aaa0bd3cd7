#pragma once
/// The input of the renderer: plain data, created for each picture. It does not depend on the engine.

#include "render/assets/object.h"
#include "render/camera/camera.h"

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace lockstone::demo {

enum class ShapeKind : std::uint8_t { sphere, capsule, box, cylinder, cone, plane };
constexpr std::size_t shape_kind_count = 6;

/// One primitive shape. World: right-handed, y up, metres. Colours everywhere: sRGB, 0 .. 1.
struct Instance {
    ShapeKind kind = ShapeKind::box;
    /// [m]  box: half extents. sphere: x radius. plane: half extents x and z, faces the pose's y.
    /// capsule, cylinder, cone: x radius, y half height along the pose's y (a capsule's without its caps).
    glm::vec3 size{0.5f};
    glm::mat4 pose{1};
    glm::vec3 colour{0.8f};
    float highlight = 0; ///< 0 .. 1: a glowing rim for selected shapes
};

/// A line over the scene; parts behind a surface are faint.
struct Line {
    glm::vec3 from{0};
    glm::vec3 to{0};
    glm::vec3 colour{1};
    float width = 2; ///< [design px]
};

/// A disc that faces the eye; hidden parts are faint, as with Line.
struct Point {
    glm::vec3 position{0};
    glm::vec3 colour{1};
    float diameter = 7; ///< [design px]
};

/// A filled rectangle over the picture, below all text.
struct Rect {
    glm::vec2 position{0}; ///< upper left corner in the viewport, from its upper left [design px]
    glm::vec2 size{0};     ///< [design px]
    glm::vec4 colour{0, 0, 0, 0.5f};
};

/// Monospace text over the picture, UTF-8; '\n' starts a new line. The font has Latin-1, arrows and a few
/// symbols (see Font); anything else shows as '?'.
struct TextLine {
    std::string text{};
    glm::vec2 position{0}; ///< upper left corner in the viewport, from its upper left [design px]
    glm::vec4 colour{1};
    float height = 17; ///< of a line [design px]
    /// If true, the text is not drawn where it would touch a rect of its frame; only for one line, such as a name in
    /// the world.
    bool yields = false;
};

/// Sun and sky.
struct Light {
    glm::vec3 to_sun{-0.55f, 0.8f, 0.5f}; ///< direction, any length but 0
    float sun = 1;                        ///< strength; 1 is a clear noon
    float sky = 1;                        ///< strength of the light from all other directions
    float haze_distance = 170;            ///< distance at which objects fade into the horizon [m]
    /// Shadows cover objects within this distance of the camera's focus [m].
    float shadow_distance = 60;
    bool shadows = true;
};

/// One viewport of the picture.
struct Frame {
    Camera camera;
    /// Part of the surface, as fractions from its upper left: x, y, width, height.
    glm::vec4 viewport{0, 0, 1, 1};
    /// False: draws only rects and text, over the other frames; for a timeline across a split screen.
    bool scene = true;
    bool wireframe = false; ///< triangle edges over the shaded picture
    Light light;
    std::vector<Instance> instances;
    std::vector<Object> objects;
    std::vector<Line> lines;
    std::vector<Point> points;
    std::vector<Rect> rects;
    std::vector<TextLine> text;
};

/// True if a line of letters of this size [design px] touches one of the rects.
bool touches(const TextLine& line, const glm::vec2& cell, std::span<const Rect> rects);

/// A pleasant colour for the index; the hues of neighbouring indices differ clearly.
glm::vec3 palette_colour(std::uint32_t index);

} // namespace lockstone::demo
