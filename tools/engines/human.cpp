// Adds a human of make_ragdoll to a scene. The bodies and joints are read from a Lockstone world, so that the other
// engines get the same.
#include "engines/pieces.h"

#include "lockstone/math/convert.h"
#include "lockstone/math/math.h"
#include "lockstone/play/ragdoll.h"

#include <algorithm>

namespace engines {
namespace {

namespace ls = lockstone;

V3 back(ls::Vec3 v) { return {ls::to_double(v.x), ls::to_double(v.y), ls::to_double(v.z)}; }
Turn back(ls::Quat q) {
    const auto four = ls::to_double(q);
    return {four[0], four[1], four[2], four[3]};
}

Shape shape_of(const ls::Geometry& geometry) {
    const double round = ls::to_double(geometry.radius);
    const V3 half{ls::to_double(geometry.half_extent.x), ls::to_double(geometry.half_extent.y),
                  ls::to_double(geometry.half_extent.z)};
    if (geometry.kind == ls::ShapeKind::capsule) return capsule(round, half.y);
    Shape made = box(half + V3{round, round, round});
    made.round = round;
    return made;
}

/// The world with one human at the origin, made by make_ragdoll with its defaults.
const ls::World& figure() {
    static const ls::World made = [] {
        ls::World world = ls::World::create({}).value();
        static_cast<void>(ls::make_ragdoll(world, {}).value());
        return world;
    }();
    return made;
}

int number_of(const ls::World& world, ls::BodyId body) {
    const std::vector<ls::BodyId> all = world.bodies();
    return static_cast<int>(std::ranges::find(all, body) - all.begin());
}

} // namespace

void add_human(Scene& scene, V3 at, double heading, V3 velocity) {
    const ls::World& world = figure();
    const Human human{.body = static_cast<int>(scene.bodies.size()),
                      .joint = static_cast<int>(scene.joints.size()),
                      .at = at,
                      .heading = heading,
                      .velocity = velocity};
    const Turn turn = about({0, 1, 0}, heading);
    for (const ls::BodyId id : world.bodies()) {
        const ls::Transform pose = world.pose(id);
        scene.add({.shape = shape_of(world.shape(world.shapes(id)[0]).geometry),
                   .position = at + rotate(turn, back(pose.position)),
                   .rotation = turn * back(pose.rotation),
                   .velocity = velocity,
                   .mass = ls::to_double(world.mass(id))});
    }
    for (std::uint32_t i = 0; i < world.joint_count(); ++i) {
        const ls::JointDef def = world.joint(world.joint_at(i));
        const ls::Transform a = world.pose(def.body_a) * def.frame_a,
                            b = world.pose(def.body_b) * def.frame_b;
        const ls::JointAxis& twist = def.axis[ls::about_x];
        const Turn frame = turn * back(b.rotation);
        scene.joints.push_back({.kind = def.kind == ls::JointKind::hinge ? Link::hinge : Link::ball,
                                .a = human.body + number_of(world, def.body_a),
                                .b = human.body + number_of(world, def.body_b),
                                .anchor = at + rotate(turn, back(b.position)),
                                .axis = rotate(frame, {1, 0, 0}),
                                .friction = ls::to_double(twist.friction),
                                .frames = Joint::Frames{.a = turn * back(a.rotation),
                                                        .b = frame,
                                                        .lower = ls::to_double(twist.lower),
                                                        .upper = ls::to_double(twist.upper),
                                                        .swing = ls::to_double(def.swing)}});
    }
    scene.humans.push_back(human);
}

} // namespace engines
