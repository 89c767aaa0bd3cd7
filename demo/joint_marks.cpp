#include "joint_marks.h"

#include "to_glm.h"

#include <cmath>

namespace lockstone::demo {
namespace {

constexpr float reach = 0.25f; ///< of axes and arcs [m]
const glm::vec3 axis_colour(1.0f, 0.55f, 0.1f), limit_colour(0.3f, 0.85f, 1.0f),
    hand_colour(1.0f, 0.95f, 0.4f), rope_colour(0.16f, 0.13f, 0.1f), gap_colour(1.0f, 0.1f, 0.2f);

void add_line(Frame& frame, const glm::vec3& from, const glm::vec3& to, const glm::vec3& colour,
              float width) {
    frame.lines.push_back({.from = from, .to = to, .colour = colour, .width = width});
}

/// Around `middle` from angle to angle in the plane of u and v.
void add_arc(Frame& frame, const glm::vec3& middle, const glm::vec3& u, const glm::vec3& v, float from,
             float to) {
    constexpr int pieces = 20;
    const auto at = [&](int i) {
        const float angle = from + (to - from) * static_cast<float>(i) / pieces;
        return middle + std::cos(angle) * u + std::sin(angle) * v;
    };
    for (int i = 0; i < pieces; ++i) add_line(frame, at(i), at(i + 1), limit_colour, 1.6f);
}

std::size_t main_axis(JointKind kind) {
    if (kind == JointKind::slider || kind == JointKind::distance) return along_x;
    return kind == JointKind::wheel ? along_y : about_x;
}

} // namespace

JointMark read_joint(const World& world, JointId joint) {
    const JointDef def = world.joint(joint);
    const JointAxis& axis = def.axis[main_axis(def.kind)];
    return {.body_a = def.body_a,
            .body_b = def.body_b,
            .kind = def.kind,
            .frame_a = to_glm(def.frame_a),
            .frame_b = to_glm(def.frame_b),
            .ground_a = to_glm(def.ground_a),
            .ground_b = to_glm(def.ground_b),
            .mode = axis.mode,
            .lower = to_float(axis.lower),
            .upper = to_float(axis.upper),
            .swing = to_float(def.swing)};
}

void draw_line_joint(Frame& frame, const JointMark& joint, const glm::mat4& a, const glm::mat4& b) {
    const glm::vec3 from(a * joint.frame_a[3]), to(b * joint.frame_b[3]);
    if (joint.kind == JointKind::pulley) {
        add_line(frame, from, joint.ground_a, rope_colour, 2.5f);
        add_line(frame, joint.ground_a, joint.ground_b, rope_colour, 2.5f);
        add_line(frame, joint.ground_b, to, rope_colour, 2.5f);
    } else if (joint.kind == JointKind::distance || joint.kind == JointKind::mouse) {
        add_line(frame, from, to, rope_colour, 2.5f);
    }
}

void draw_joint(Frame& frame, const JointMark& joint, const glm::mat4& a, const glm::mat4& b) {
    const glm::mat4 place_a = a * joint.frame_a, place_b = b * joint.frame_b;
    const glm::vec3 origin(place_a[3]), other(place_b[3]);
    const glm::vec3 x = reach * glm::vec3(place_a[0]), y = reach * glm::vec3(place_a[1]),
                    z = reach * glm::vec3(place_a[2]);
    const bool turns = joint.kind == JointKind::hinge || joint.kind == JointKind::ball;
    frame.points.push_back({.position = other, .colour = hand_colour, .diameter = 5});
    if (joint.kind <= JointKind::weld) add_line(frame, origin, other, gap_colour, 2.0f);
    if (joint.kind == JointKind::slider && joint.mode == AxisMode::limited)
        add_line(frame, origin + joint.lower * x / reach, origin + joint.upper * x / reach, limit_colour,
                 1.6f);
    else if (joint.kind == JointKind::wheel)
        add_line(frame, origin - y, origin + y, axis_colour, 1.6f);
    else if (joint.kind != JointKind::distance && joint.kind != JointKind::pulley &&
             joint.kind != JointKind::mouse)
        add_line(frame, origin - x, origin + x, axis_colour, 1.6f);
    if (turns && joint.mode == AxisMode::limited) {
        add_arc(frame, origin, y, z, joint.lower, joint.upper);
        add_line(frame, other, other + reach * glm::vec3(place_b[1]), hand_colour, 1.6f);
    }
    if (joint.kind == JointKind::ball && joint.swing > 0)
        add_arc(frame, origin + std::cos(joint.swing) * x, std::sin(joint.swing) * y,
                std::sin(joint.swing) * z, 0, 6.2831853f);
}

} // namespace lockstone::demo
