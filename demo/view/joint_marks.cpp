#include "joint_marks.h"

#include "to_glm.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <cmath>

namespace lockstone::demo {
namespace {

constexpr float width = 1.6f, line_width = 2.5f; ///< [design px]
constexpr float full_turn = glm::two_pi<float>();

void add_line(Frame& frame, const glm::vec3& from, const glm::vec3& to, const glm::vec3& colour,
              float thickness = width) {
    frame.lines.push_back({.from = from, .to = to, .colour = colour, .width = thickness});
}

/// Draws the curve `at`(t) for t from 0 to 1.
template <class At>
void add_curve(Frame& frame, int pieces, const glm::vec3& colour, float thickness, const At& at) {
    for (int i = 0; i < pieces; ++i)
        add_line(frame, at(static_cast<float>(i) / static_cast<float>(pieces)),
                 at(static_cast<float>(i + 1) / static_cast<float>(pieces)), colour, thickness);
}

/// Draws an arc around `middle` between two angles in the plane of u and v.
void add_arc(Frame& frame, const glm::vec3& middle, const glm::vec3& u, const glm::vec3& v, float from,
             float to, const glm::vec3& colour) {
    add_curve(frame, 20, colour, width, [&](float t) {
        const float angle = from + (to - from) * t;
        return middle + std::cos(angle) * u + std::sin(angle) * v;
    });
}

/// Draws a coil with a fixed number of turns at any length.
void add_coil(Frame& frame, const glm::vec3& from, const glm::vec3& to) {
    constexpr int turns = 8, pieces = 12 * turns;
    constexpr float radius = 0.07f, straight = 0.1f; ///< [m]; share of the length at each end
    const glm::vec3 way = to - from;
    if (glm::length(way) < 1e-4f) return;
    const bool upright = std::abs(way.y) > 0.9f * glm::length(way);
    const glm::vec3 u = glm::normalize(glm::cross(way, upright ? glm::vec3(1, 0, 0) : glm::vec3(0, 1, 0))),
                    v = glm::normalize(glm::cross(way, u));
    add_curve(frame, pieces, joint_colour::spring, width, [&](float t) {
        const bool is_end = t < straight || t > 1 - straight;
        const float angle = full_turn * static_cast<float>(turns) * t;
        return from + t * way + (is_end ? 0 : radius) * (std::cos(angle) * u + std::sin(angle) * v);
    });
}

/// Draws a rope. If it is longer than the distance, it sags like a parabola of its length, in the approximation for
/// small sag.
void add_rope(Frame& frame, const glm::vec3& from, const glm::vec3& to, float length) {
    const float way = glm::distance(from, to);
    const float sag = 0.433f * std::sqrt(std::max(length * length - way * way, 0.0f));
    if (sag < 1e-3f) return add_line(frame, from, to, joint_colour::rope, line_width);
    add_curve(frame, 16, joint_colour::rope, line_width,
              [&](float t) { return from + t * (to - from) - glm::vec3(0, 4 * t * (1 - t) * sag, 0); });
}

/// Both frames in the world. The axes of A are unit vectors.
struct Places {
    glm::mat4 a, b;
    glm::vec3 origin{a[3]}, other{b[3]};

    glm::vec3 axis(std::size_t i) const { return glm::vec3(a[static_cast<int>(i % 3)]); }
    glm::vec3 axis_b(std::size_t i) const { return glm::vec3(b[static_cast<int>(i % 3)]); }
};

/// Draws an axis of translation: its line, or a bar between its limits.
void draw_slide(Frame& frame, const JointMark::Axis& axis, std::size_t i, const Places& at) {
    const glm::vec3 x = at.axis(i), y = 0.2f * joint_reach * at.axis(i + 1);
    if (axis.mode == AxisMode::free)
        add_line(frame, at.origin - joint_reach * x, at.origin + joint_reach * x, joint_colour::axis);
    if (axis.mode != AxisMode::limited) return;
    const glm::vec3 low = at.origin + axis.lower * x, high = at.origin + axis.upper * x;
    add_line(frame, low, high, joint_colour::limit);
    for (const glm::vec3& end : {low, high}) add_line(frame, end - y, end + y, joint_colour::limit);
}

/// Draws springs. A single spring hangs at the far end of its axis; several together pull to one target point.
void draw_springs(Frame& frame, const JointMark& joint, const Places& at) {
    int count = 0;
    glm::vec3 target = at.origin, far_end = at.origin;
    for (std::size_t i = along_x; i <= along_z; ++i) {
        const JointMark::Axis& axis = joint.axis[i];
        if (!axis.has_spring) continue;
        ++count;
        target += axis.target * at.axis(i);
        far_end += (axis.mode == AxisMode::limited ? axis.upper : axis.target + 2 * joint_reach) * at.axis(i);
    }
    if (count != 0) add_coil(frame, count == 1 ? far_end : target, at.other);
}

/// Draws an axis of rotation: its line, an arc between its limits, an arc from the current angle to the target of its
/// spring, and a hand at the current angle.
void draw_turn(Frame& frame, const JointMark::Axis& axis, std::size_t i, const Places& at) {
    if (axis.mode == AxisMode::locked) return;
    const glm::vec3 x = joint_reach * at.axis(i), u = joint_reach * at.axis(i + 1),
                    v = joint_reach * at.axis(i + 2);
    add_line(frame, at.origin - x, at.origin + x, joint_colour::axis);
    if (axis.mode == AxisMode::limited)
        add_arc(frame, at.origin, u, v, axis.lower, axis.upper, joint_colour::limit);
    const glm::vec3 hand = joint_reach * at.axis_b(i + 1);
    if (axis.mode == AxisMode::limited || axis.has_spring)
        add_line(frame, at.other, at.other + hand, joint_colour::hand);
    if (axis.has_spring)
        add_arc(frame, at.origin, 0.6f * u, 0.6f * v, axis.target,
                std::atan2(glm::dot(hand, v), glm::dot(hand, u)), joint_colour::spring);
}

/// The distance of the frames along hard locked axes.
glm::vec3 gap_of(const JointMark& joint, const Places& at) {
    glm::vec3 gap(0);
    for (std::size_t i = along_x; i <= along_z; ++i)
        if (joint.axis[i].mode == AxisMode::locked && !joint.axis[i].has_spring)
            gap += glm::dot(at.other - at.origin, at.axis(i)) * at.axis(i);
    return gap;
}

void draw_axes(Frame& frame, const JointMark& joint, const Places& at) {
    frame.points.push_back({.position = at.other, .colour = joint_colour::hand, .diameter = 5});
    add_line(frame, at.other - gap_of(joint, at), at.other, joint_colour::gap, 2.0f);
    for (std::size_t i = along_x; i <= along_z; ++i) draw_slide(frame, joint.axis[i], i, at);
    for (std::size_t i = about_x; i <= about_z; ++i) draw_turn(frame, joint.axis[i], i, at);
    draw_springs(frame, joint, at);
    if (joint.kind == JointKind::weld)
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::vec3 x = 0.4f * joint_reach * at.axis(i);
            add_line(frame, at.origin - x, at.origin + x, joint_colour::axis);
        }
    if (joint.swing > 0) {
        const float wide = joint_reach * std::sin(joint.swing);
        add_arc(frame, at.origin + joint_reach * std::cos(joint.swing) * at.axis(0), wide * at.axis(1),
                wide * at.axis(2), 0, full_turn, joint_colour::limit);
        add_line(frame, at.other, at.other + joint_reach * at.axis_b(0), joint_colour::hand);
    }
}

/// Draws a circle about the frame's x axis through the body's origin, with a spoke.
void add_wheel(Frame& frame, const glm::vec3& middle, const glm::mat4& place, float radius) {
    const glm::vec3 u = radius * glm::vec3(place[1]), v = radius * glm::vec3(place[2]);
    add_arc(frame, middle, u, v, 0, full_turn, joint_colour::gear);
    add_line(frame, middle, middle + u, joint_colour::hand);
}

/// Draws two wheels that touch and have the ratio of the gear: A's radius is to B's as 1 to the ratio.
void draw_gear(Frame& frame, const JointMark& joint, const glm::mat4& a, const glm::mat4& b,
               const Places& at) {
    const glm::vec3 from(a[3]), to(b[3]);
    const float ratio = std::abs(joint.ratio), apart = std::max(glm::distance(from, to), 2 * joint_reach);
    if (joint.body_a) add_wheel(frame, from, at.a, apart / (1 + ratio));
    add_wheel(frame, to, at.b, apart * ratio / (1 + ratio));
}

/// Draws a wheel that rolls along B's x axis.
void draw_rack(Frame& frame, const JointMark& joint, const glm::mat4& a, const glm::mat4& b,
               const Places& at) {
    const glm::vec3 middle(b[3]), x = 2 * joint_reach * at.axis_b(0);
    add_wheel(frame, glm::vec3(a[3]), at.a, 1 / std::abs(joint.ratio));
    add_line(frame, middle - x, middle + x, joint_colour::gear);
}

} // namespace

JointMark read_joint(const World& world, JointId joint) {
    const JointDef def = world.joint(joint);
    JointMark mark{.body_a = def.body_a,
                   .body_b = def.body_b,
                   .kind = def.kind,
                   .frame_a = to_glm(def.frame_a),
                   .frame_b = to_glm(def.frame_b),
                   .ground_a = to_glm(def.ground_a),
                   .ground_b = to_glm(def.ground_b),
                   .axis = {},
                   .swing = to_float(def.swing),
                   .ratio = to_float(def.ratio)};
    for (std::size_t i = 0; i < joint_axis_count; ++i) {
        const JointAxis& axis = def.axis[i];
        const bool gives = axis.mode == AxisMode::locked && axis.frequency > Real{};
        mark.axis[i] = {axis.mode, to_float(axis.lower), to_float(axis.upper), axis.spring != 0 || gives,
                        to_float(axis.target)};
    }
    return mark;
}

void draw_line_joint(Frame& frame, const JointMark& joint, const glm::mat4& a, const glm::mat4& b) {
    const glm::vec3 from(a * joint.frame_a[3]), to(b * joint.frame_b[3]);
    const JointMark::Axis& line = joint.axis[along_x];
    if (joint.kind == JointKind::pulley) {
        add_line(frame, from, joint.ground_a, joint_colour::rope, line_width);
        add_line(frame, joint.ground_a, joint.ground_b, joint_colour::rope, line_width);
        add_line(frame, joint.ground_b, to, joint_colour::rope, line_width);
    } else if (joint.kind == JointKind::distance && line.has_spring) {
        add_coil(frame, from, to);
    } else if (joint.kind == JointKind::distance && line.mode == AxisMode::limited) {
        add_rope(frame, from, to, line.upper);
    } else if (joint.kind == JointKind::distance || joint.kind == JointKind::mouse) {
        add_line(frame, from, to, joint_colour::rope, line_width);
    }
}

void draw_joint(Frame& frame, const JointMark& joint, const glm::mat4& a, const glm::mat4& b) {
    const Places at{a * joint.frame_a, b * joint.frame_b};
    if (joint.kind == JointKind::gear)
        draw_gear(frame, joint, a, b, at);
    else if (joint.kind == JointKind::rack_and_pinion)
        draw_rack(frame, joint, a, b, at);
    else if (joint.kind <= JointKind::motor)
        draw_axes(frame, joint, at);
}

} // namespace lockstone::demo
