#include "scene_view.h"

#include "to_glm.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <map>

namespace lockstone::demo {
namespace {

constexpr float plane_half_side = 1400; ///< half side of the drawn part of a plane, which is infinite [m]
constexpr std::size_t crate_bodies_max = 200; ///< in larger scenes plain colours are easier to distinguish

glm::vec3 to_colour(std::uint32_t rgb) {
    return glm::vec3((rgb >> 16) & 0xffu, (rgb >> 8) & 0xffu, rgb & 0xffu) / 255.0f;
}

/// The edges of a box of these half extents.
void add_box_lines(Frame& frame, const glm::mat4& pose, const glm::vec3& half, const glm::vec3& colour) {
    const auto corner = [&](unsigned bits) {
        const glm::vec3 sign((bits & 1u) != 0 ? 1 : -1, (bits & 2u) != 0 ? 1 : -1, (bits & 4u) != 0 ? 1 : -1);
        return glm::vec3(pose * glm::vec4(sign * half, 1));
    };
    for (unsigned from = 0; from < 8; ++from)
        for (const unsigned axis : {1u, 2u, 4u})
            if ((from & axis) == 0)
                frame.lines.push_back(
                    {.from = corner(from), .to = corner(from | axis), .colour = colour, .width = 1.4f});
}

/// True if a box intersects the segment from `eye` to `target`.
bool hides(const glm::mat4& pose, const glm::vec3& half, const glm::vec3& eye, const glm::vec3& target) {
    const glm::mat4 inverse = glm::inverse(pose);
    const glm::vec3 from(inverse * glm::vec4(eye, 1)), way = glm::vec3(inverse * glm::vec4(target, 1)) - from;
    float enter = 0, leave = 1;
    for (int axis = 0; axis < 3; ++axis) {
        if (std::abs(way[axis]) < 1e-6f) {
            if (std::abs(from[axis]) > half[axis]) return false;
            continue;
        }
        const float a = (-half[axis] - from[axis]) / way[axis], b = (half[axis] - from[axis]) / way[axis];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return enter < leave;
}

/// The axis-aligned box in the world around a box in a shape's frame.
Bounds moved(const Bounds& bounds, const glm::mat4& pose) {
    const glm::vec3 half = 0.5f * (bounds.max - bounds.min);
    const glm::vec3 reach = glm::abs(glm::vec3(pose[0])) * half.x + glm::abs(glm::vec3(pose[1])) * half.y +
                            glm::abs(glm::vec3(pose[2])) * half.z;
    const glm::vec3 centre(pose * glm::vec4(bounds.centre(), 1));
    return {centre - reach, centre + reach};
}

} // namespace

// ---- reading ----------------------------------------------------------------------------------------------

SceneView::Part SceneView::read_part(const ShapeDef& def) {
    const Geometry& g = def.geometry;
    const float radius = to_float(g.radius) * to_float(g.scale.x);
    const glm::vec3 half = to_glm(to_float(g.half_extent)) * to_glm(to_float(g.scale));
    Part part{.geometry = g, .local = to_glm(def.local)};
    const auto be = [&](ShapeKind kind, const glm::vec3& size, const glm::vec3& reach) {
        part.primitive = kind;
        part.size = size;
        part.bounds = {-reach, reach};
    };
    const bool is_rounded = g.radius > Length{};
    if (g.kind == lockstone::ShapeKind::sphere)
        be(ShapeKind::sphere, glm::vec3(radius), glm::vec3(radius));
    else if (g.kind == lockstone::ShapeKind::capsule)
        be(ShapeKind::capsule, {radius, half.y, radius}, {radius, half.y + radius, radius});
    else if (g.kind == lockstone::ShapeKind::plane)
        be(ShapeKind::plane, {plane_half_side, 0, plane_half_side}, {plane_half_side, 0, plane_half_side});
    else if (g.kind == lockstone::ShapeKind::cylinder && !is_rounded)
        be(ShapeKind::cylinder, half, half);
    else if (g.kind == lockstone::ShapeKind::cone && !is_rounded)
        be(ShapeKind::cone, half, half);
    else if (g.kind == lockstone::ShapeKind::box && !is_rounded)
        be(ShapeKind::box, half, half);
    else
        part.bounds = meshes_->bounds(g, *assets_);
    part.crate = part.primitive == ShapeKind::box &&
                 std::max({half.x, half.y, half.z}) < 1.3f * std::min({half.x, half.y, half.z});
    return part;
}

SceneView::Body SceneView::read_body(const World& world, BodyId id, std::uint32_t row) {
    const Look look = look_of(world.user_key(id));
    const Transform pose = world.pose(id);
    const std::array<float, 4> q = to_float(pose.rotation);
    Body body{.id = id,
              .role = look.role,
              .number = look.number,
              .kind = world.kind(id),
              .colour = to_colour(look.colour),
              .previous = {},
              .current = {to_glm(to_float(pose.position)), glm::quat(q[3], q[0], q[1], q[2])},
              .parts = {}};
    if (const auto owner = prop_owner(world, row))
        body.colour =
            glm::mix(body.colour, to_colour(look_of(user_key_of(Role::player, *owner)).colour), 0.85f);
    if (body.kind == BodyKind::dynamic && !world.is_awake(id))
        body.colour = glm::mix(body.colour, glm::vec3(0.45f), 0.6f); // asleep
    body.previous = body.current;
    for (const ShapeId shape : world.shapes(id)) body.parts.push_back(read_part(world.shape(shape)));
    return body;
}

/// Makes a tyre, and a bar across it that makes rotation visible.
void SceneView::read_wheels(const World& world) {
    std::vector<Body> now;
    for (std::uint32_t row = 0; row < world.vehicle_count(); ++row) {
        const VehicleId id = world.vehicle_at(row);
        const VehicleDef& def = world.vehicle(id);
        const VehicleState state = world.vehicle_state(id);
        for (std::uint32_t i = 0; i < state.wheel_count; ++i) {
            const WheelState& wheel = state.wheel[i];
            const std::array<float, 4> q = to_float(wheel.pose.rotation);
            const glm::quat hub = glm::quat(q[3], q[0], q[1], q[2]) *
                                  glm::angleAxis(to_float(wheel.rotation), glm::vec3(1, 0, 0));
            const float radius = to_float(def.wheel[i].radius),
                        half_width = 0.5f * to_float(def.wheel[i].width);
            Part tyre{}, bar{};
            tyre.primitive = ShapeKind::cylinder;
            tyre.size = {radius, half_width, radius};
            tyre.local = glm::rotate(glm::mat4(1), glm::half_pi<float>(), glm::vec3(0, 0, 1));
            tyre.bounds = {-tyre.size, tyre.size};
            bar.primitive = ShapeKind::box;
            bar.size = {half_width * 1.1f, radius * 0.7f, radius * 0.15f};
            bar.local = glm::mat4(1);
            bar.bounds = {-bar.size, bar.size};
            Body body{.id = def.chassis,
                      .role = Role::machine,
                      .number = i,
                      .kind = BodyKind::dynamic,
                      .colour = glm::vec3(0.22f),
                      .previous = {},
                      .current = {to_glm(to_float(wheel.pose.position)), hub},
                      .parts = {tyre, bar}};
            const bool was_there = now.size() < wheels_.size() && wheels_[now.size()].id == def.chassis;
            body.previous = was_there ? wheels_[now.size()].current : body.current;
            now.push_back(std::move(body));
        }
    }
    wheels_ = std::move(now);
}

const SceneView::Body* SceneView::find(BodyId id, std::size_t hint) const {
    if (hint < bodies_.size() && bodies_[hint].id == id) return &bodies_[hint];
    const auto found =
        std::find_if(bodies_.begin(), bodies_.end(), [&](const Body& b) { return b.id == id; });
    return found == bodies_.end() ? nullptr : &*found;
}

void SceneView::reset(const World& world) {
    bodies_.clear();
    wheels_.clear();
    capture(world);
}

void SceneView::capture(const World& world) {
    assets_ = world.assets_shared();
    std::vector<Body> now;
    now.reserve(world.body_count());
    for (std::uint32_t row = 0; row < world.body_count(); ++row) {
        now.push_back(read_body(world, world.body_at(row), row));
        if (const Body* before = find(now.back().id, row)) now.back().previous = before->current;
    }
    bodies_ = std::move(now);
    read_wheels(world);
    contacts_.clear();
    for (const World::ContactPoint& contact : world.contacts())
        contacts_.push_back(
            {to_glm(to_float(contact.point)), to_glm(to_float(contact.normal)), to_float(contact.impulse)});
    joints_.clear();
    for (std::uint32_t row = 0; row < world.joint_count(); ++row)
        joints_.push_back(read_joint(world, world.joint_at(row)));
    fields_.clear();
    for (std::uint32_t row = 0; row < world.field_count(); ++row)
        fields_.push_back(read_field(world, world.field_at(row)));
    match_ = match_values(world);
    tick_ = world.tick_count();
}

// ---- drawing ----------------------------------------------------------------------------------------------

glm::mat4 SceneView::pose(const Body& body, float alpha) {
    glm::mat4 out = glm::mat4_cast(glm::slerp(body.previous.rotation, body.current.rotation, alpha));
    out[3] = glm::vec4(glm::mix(body.previous.position, body.current.position, alpha), 1);
    return out;
}

void SceneView::draw(Frame& frame, float alpha, const Stage& stage,
                     std::optional<std::uint32_t> followed) const {
    const std::vector<glm::vec3> seen = sights(followed, alpha);
    for (const Body& body : bodies_) draw_body(frame, body, alpha, stage, seen);
    for (const Body& wheel : wheels_) draw_body(frame, wheel, alpha, stage, {});
    if (stage.view.contacts) draw_contacts(frame);
    draw_joints(frame, alpha, stage.view.joints);
    for (const FieldMark& field : fields_) draw_field(frame, field);
    if (match_) draw_it(frame, alpha);
    // A large scene is seen from afar: the haze begins behind it, and the shadows cover it.
    frame.light.haze_distance = std::max(frame.light.haze_distance, 4 * frame.camera.distance());
    frame.light.shadow_distance = std::max(frame.light.shadow_distance, 1.2f * frame.camera.distance());
}

/// The points that must stay visible [m].
std::vector<glm::vec3> SceneView::sights(std::optional<std::uint32_t> followed, float alpha) const {
    if (followed)
        if (const auto player = player_position(*followed, alpha)) return {*player};
    const Bounds all = bounds();
    const glm::vec3 centre = all.centre(), half = 0.4f * (all.max - all.min);
    return {centre, centre + glm::vec3(half.x, 0, half.z), centre + glm::vec3(half.x, 0, -half.z),
            centre + glm::vec3(-half.x, 0, half.z), centre - glm::vec3(half.x, 0, half.z)};
}

void SceneView::draw_body(Frame& frame, const Body& body, float alpha, const Stage& stage,
                          std::span<const glm::vec3> sights) const {
    const bool as_crate = stage.view.crates && stage.crate != nullptr && body.role == Role::prop &&
                          bodies_.size() <= crate_bodies_max;
    const glm::mat4 at = pose(body, alpha);
    for (const Part& part : body.parts) {
        const glm::mat4 place = at * part.local;
        const bool in_the_way = body.kind == BodyKind::static_ && part.primitive == ShapeKind::box &&
                                std::any_of(sights.begin(), sights.end(), [&](const glm::vec3& sight) {
                                    return hides(place, part.size, frame.camera.eye(), sight);
                                });
        if (in_the_way)
            add_box_lines(frame, place, part.size, glm::vec3(0.85f));
        else
            draw_part(frame, body, part, place, part.crate && as_crate, stage);
        if (!stage.view.bounds || part.primitive == ShapeKind::plane) continue;
        const Bounds box = moved(part.bounds, place);
        add_box_lines(frame, glm::translate(glm::mat4(1), box.centre()), 0.5f * (box.max - box.min),
                      {0.35f, 0.75f, 1.0f});
    }
}

void SceneView::draw_part(Frame& frame, const Body& body, const Part& part, const glm::mat4& place,
                          bool as_crate, const Stage& stage) const {
    if (as_crate) {
        frame.objects.emplace_back(stage.crate, glm::scale(place, 2.0f * part.size)); // the model is 1 m wide
        frame.objects.back().set_tint(glm::mix(body.colour, glm::vec3(1), 0.35f));
    } else if (part.primitive) {
        frame.instances.push_back(
            {.kind = *part.primitive, .size = part.size, .pose = place, .colour = body.colour});
    } else if (const auto model = meshes_->model(part.geometry, *assets_)) {
        frame.objects.emplace_back(model, place);
        frame.objects.back().set_tint(body.colour);
    }
}

void SceneView::draw_contacts(Frame& frame) const {
    for (const Touch& touch : contacts_) {
        // The colour goes from yellow to red with the impulse; a contact without impulse is blue.
        const float strength = 1 - std::exp(-2 * touch.impulse);
        const glm::vec3 colour =
            touch.impulse <= 0 ? glm::vec3(0.4f, 0.6f, 1.0f)
                               : glm::mix(glm::vec3(1, 0.9f, 0.2f), glm::vec3(1, 0.15f, 0.1f), strength);
        frame.points.push_back({.position = touch.point, .colour = colour, .diameter = 6});
        frame.lines.push_back({.from = touch.point,
                               .to = touch.point + 0.35f * touch.normal,
                               .colour = {0.2f, 1.0f, 0.45f},
                               .width = 1.6f});
    }
}

void SceneView::draw_joints(Frame& frame, float alpha, bool all) const {
    std::map<BodyId, const Body*> by_id;
    if (!joints_.empty())
        for (const Body& body : bodies_) by_id[body.id] = &body;
    const auto place = [&](BodyId id) {
        const auto found = by_id.find(id);
        return found == by_id.end() ? glm::mat4(1) : pose(*found->second, alpha);
    };
    for (const JointMark& joint : joints_) {
        const glm::mat4 a = place(joint.body_a), b = place(joint.body_b);
        draw_line_joint(frame, joint, a, b);
        if (all) draw_joint(frame, joint, a, b);
    }
}

/// Draws a cone above the player who must tag another.
void SceneView::draw_it(Frame& frame, float alpha) const {
    const auto position = player_position(static_cast<std::uint32_t>(match_->it), alpha);
    if (!position) return;
    const float bob = 0.08f * std::sin(0.12f * (static_cast<float>(tick_ % 100'000) + alpha));
    const glm::mat4 place = glm::translate(glm::mat4(1), *position + glm::vec3(0, 1.25f + bob, 0));
    frame.instances.push_back({.kind = ShapeKind::cone,
                               .size = {0.22f, 0.28f, 0.22f},
                               .pose = glm::rotate(place, glm::pi<float>(), {1, 0, 0}),
                               .colour = {1.0f, 0.75f, 0.1f},
                               .highlight = 0.5f});
}

std::optional<glm::vec3> SceneView::player_position(std::uint32_t player, float alpha) const {
    for (const Body& body : bodies_)
        if (body.role == Role::player && body.number == player) return glm::vec3(pose(body, alpha)[3]);
    return std::nullopt;
}

std::uint32_t SceneView::player_count() const {
    return static_cast<std::uint32_t>(
        std::count_if(bodies_.begin(), bodies_.end(), [](const Body& b) { return b.role == Role::player; }));
}

Bounds SceneView::bounds() const {
    const bool any_moves = std::any_of(bodies_.begin(), bodies_.end(),
                                       [](const Body& b) { return b.kind != BodyKind::static_; });
    Bounds bounds;
    for (const Body& body : bodies_) {
        if (any_moves && body.kind == BodyKind::static_) continue;
        for (const Part& part : body.parts) {
            if (part.primitive == ShapeKind::plane) continue;
            const Bounds box = moved(part.bounds, pose(body, 1) * part.local);
            bounds.add(box.min);
            bounds.add(box.max);
        }
    }
    if (bounds.empty()) bounds.add(glm::vec3(0));
    if (!company_.empty()) bounds.add(company_.min), bounds.add(company_.max);
    return bounds;
}

} // namespace lockstone::demo
