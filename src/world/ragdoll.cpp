// Creates ragdolls: segments, joints, and a pose that is computed from the pelvis outwards.
#include "lockstone/play/ragdoll.h"

#include "base/assert.h"
#include "base/text.h"
#include "lockstone/math/decimal.h"
#include "lockstone/math/math.h"

#include <algorithm>

namespace lockstone {

namespace {

using base::join;
using Part = RagdollPart;

constexpr UnitVec3 axis_x{unit_one, Unit{}, Unit{}}, axis_z{Unit{}, Unit{}, unit_one};

// ---- the human ------------------------------------------------------------------------------------------------

/// A segment of a standing human. Lengths in units of the human's height, from the ground between the feet.
struct Segment {
    const char* name;
    Part parent;
    Real mass;   ///< as a fraction of the human's mass
    Vec3 center; ///< of the segment: the origin of its body
    Vec3 joint;  ///< position of the joint to its parent
    Vec3 half;   ///< half extents; of a capsule, x is the radius and y half of its whole length
    bool is_box; ///< a rounded box; else a capsule along y
};

constexpr Segment segment(const char* name, Part parent, Real mass, Vec3 center, Vec3 joint, Vec3 half,
                          bool is_box = false) {
    return {name, parent, mass, center, joint, half, is_box};
}

constexpr std::array<Segment, ragdoll_part_count> segments{{
    segment("pelvis", Part::pelvis, 0.142_r, {0_r, 0.56_r, 0_r}, {}, {0.095_r, 0.055_r, 0.06_r}, true),
    segment("abdomen", Part::pelvis, 0.139_r, {0_r, 0.6575_r, 0_r}, {0_r, 0.615_r, 0_r},
            {0.08_r, 0.05_r, 0.055_r}, true),
    segment("chest", Part::abdomen, 0.216_r, {0_r, 0.77_r, 0_r}, {0_r, 0.71_r, 0_r},
            {0.105_r, 0.07_r, 0.06_r}, true),
    segment("head", Part::chest, 0.081_r, {0_r, 0.925_r, 0_r}, {0_r, 0.85_r, 0_r}, {0.055_r, 0.075_r, 0_r}),
    segment("upper_arm_left", Part::chest, 0.028_r, {0.129_r, 0.725_r, 0_r}, {0.129_r, 0.818_r, 0_r},
            {0.025_r, 0.093_r, 0_r}),
    segment("forearm_left", Part::upper_arm_left, 0.022_r, {0.129_r, 0.5145_r, 0_r}, {0.129_r, 0.632_r, 0_r},
            {0.022_r, 0.1175_r, 0_r}),
    segment("upper_arm_right", Part::chest, 0.028_r, {-0.129_r, 0.725_r, 0_r}, {-0.129_r, 0.818_r, 0_r},
            {0.025_r, 0.093_r, 0_r}),
    segment("forearm_right", Part::upper_arm_right, 0.022_r, {-0.129_r, 0.5145_r, 0_r},
            {-0.129_r, 0.632_r, 0_r}, {0.022_r, 0.1175_r, 0_r}),
    segment("thigh_left", Part::pelvis, 0.1_r, {0.052_r, 0.4075_r, 0_r}, {0.052_r, 0.53_r, 0_r},
            {0.045_r, 0.1225_r, 0_r}),
    segment("shin_left", Part::thigh_left, 0.0465_r, {0.052_r, 0.162_r, 0_r}, {0.052_r, 0.285_r, 0_r},
            {0.03_r, 0.123_r, 0_r}),
    segment("foot_left", Part::shin_left, 0.0145_r, {0.052_r, 0.0195_r, 0.036_r}, {0.052_r, 0.039_r, 0_r},
            {0.0275_r, 0.0195_r, 0.076_r}, true),
    segment("thigh_right", Part::pelvis, 0.1_r, {-0.052_r, 0.4075_r, 0_r}, {-0.052_r, 0.53_r, 0_r},
            {0.045_r, 0.1225_r, 0_r}),
    segment("shin_right", Part::thigh_right, 0.0465_r, {-0.052_r, 0.162_r, 0_r}, {-0.052_r, 0.285_r, 0_r},
            {0.03_r, 0.123_r, 0_r}),
    segment("foot_right", Part::shin_right, 0.0145_r, {-0.052_r, 0.0195_r, 0.036_r}, {-0.052_r, 0.039_r, 0_r},
            {0.0275_r, 0.0195_r, 0.076_r}, true),
}};

const Segment& segment_of(std::uint32_t part) { return segments[part]; }
std::uint32_t parent_of(std::uint32_t part) { return static_cast<std::uint32_t>(segments[part].parent); }

Geometry geometry_of(const Segment& s, Real height) {
    const Vec3 half = s.half * height;
    if (!s.is_box) return capsule(half.x, half.y - half.x);
    const Real round = half.y * 0.4_r;
    return rounded(box(half.x - round, half.y - round, half.z - round), round);
}

// ---- the joints -----------------------------------------------------------------------------------------------

/// Angles in rad; torques in N m, for a human of 75 kg and 1.8 m.
struct Hold {
    bool is_hinge;
    Real lower, upper; ///< of a hinge: its angle about x; of a ball: its twist
    Real swing;        ///< of a ball: half angle of its cone
    Vec3 tilt; ///< of a ball: the axis of the cone, turned about x and then z from the standing segment
    Real friction;
};

Hold hold_of(std::uint32_t part) {
    const Real side = segments[part].joint.x < 0_r ? -1_r : 1_r;
    switch (static_cast<Part>(part)) {
    case Part::abdomen:
    case Part::chest:
        return {false, -0.35_r, 0.35_r, 0.5_r, {0.15_r, 0_r, 0_r}, 20_r};
    case Part::head:
        return {false, -1_r, 1_r, 0.7_r, {}, 5_r};
    case Part::upper_arm_left:
    case Part::upper_arm_right:
        return {false, -1.2_r, 1.2_r, 1.75_r, {-0.6_r, 0_r, 0.9_r * side}, 5_r};
    case Part::forearm_left:
    case Part::forearm_right:
        return {true, -2.5_r, 0.05_r, 0_r, {}, 4_r};
    case Part::thigh_left:
    case Part::thigh_right:
        return {false, -0.7_r, 0.7_r, 1.1_r, {-0.75_r, 0_r, 0.25_r * side}, 12_r};
    case Part::shin_left:
    case Part::shin_right:
        return {true, -0.05_r, 2.4_r, 0_r, {}, 8_r};
    default:
        return {true, -0.35_r, 0.8_r, 0_r, {}, 5_r};
    }
}

/// The axes of a joint's frames in its two bodies, for the standing human. The x axis of a ball joint runs along the
/// segment.
struct Turns {
    Quat a, b;
};
Turns turns_of(std::uint32_t part) {
    const Hold hold = hold_of(part);
    if (hold.is_hinge) return {Quat::identity(), Quat::identity()};
    const bool up = segments[part].center.y > segments[part].joint.y;
    const Quat along = from_axis_angle(axis_z, up ? half_pi : -half_pi);
    const Quat tilt = from_axis_angle(axis_z, hold.tilt.z) * from_axis_angle(axis_x, hold.tilt.x);
    return {normalized(normalized(tilt) * along), along};
}

JointDef joint_of(const RagdollDef& def, std::uint32_t part) {
    const Hold hold = hold_of(part);
    const Segment& s = segment_of(part);
    JointDef joint = hold.is_hinge ? hinge_joint() : ball_joint();
    const Real size = def.mass / 75_r * (def.height / 1.8_r);
    for (std::uint32_t i = about_x; i <= (hold.is_hinge ? about_x : about_z); ++i)
        joint.axis[i].friction = hold.friction * size * def.stiffness;
    joint.axis[about_x].mode = AxisMode::limited;
    joint.axis[about_x].lower = hold.lower, joint.axis[about_x].upper = hold.upper;
    joint.swing = hold.swing;
    const Turns turns = turns_of(part);
    joint.frame_a = {(s.joint - segment_of(parent_of(part)).center) * def.height, turns.a};
    joint.frame_b = {(s.joint - s.center) * def.height, turns.b};
    joint.user_key = def.user_key + part;
    return joint;
}

// ---- creation -------------------------------------------------------------------------------------------------

/// Returns an error if a quaternion is zero, which is no rotation. Ignores the quaternion of the pelvis.
std::string check(const RagdollPose& pose) {
    for (std::uint32_t part = 1; part < ragdoll_part_count; ++part)
        if (pose[part] == Quat{})
            return join("pose of ", segments[part].name, " is no rotation: all four parts are 0");
    return {};
}

std::string check(const RagdollDef& def) {
    const auto outside = [](const char* what, Real value, Real low, Real high) {
        if (value >= low && value <= high) return std::string();
        return join(what, " is ", to_string(value), ", must be ", to_string(low), " to ", to_string(high));
    };
    if (std::string e = outside("height", def.height, 0.5_r, 3_r); !e.empty()) return e;
    if (std::string e = outside("mass", def.mass, 5_r, 500_r); !e.empty()) return e;
    if (std::string e = outside("stiffness", def.stiffness, 0_r, 100_r); !e.empty()) return e;
    if (def.place.rotation == Quat{}) return "place.rotation is no rotation: all four parts are 0";
    return check(def.pose);
}

/// Computes the pose of each part from that of its parent, so that the joints stay together.
std::array<Transform, ragdoll_part_count> places(const RagdollDef& def) {
    std::array<Transform, ragdoll_part_count> place{};
    const Quat facing = normalized(def.place.rotation);
    const Transform ground{def.place.position, facing};
    place[0] = {ground * (segments[0].center * def.height), facing};
    for (std::uint32_t i = 1; i < ragdoll_part_count; ++i) {
        const Segment& s = segment_of(i);
        const Transform& parent = place[parent_of(i)];
        const Quat rotation = normalized(parent.rotation * normalized(def.pose[i]));
        const Vec3 joint = parent * ((s.joint - segment_of(parent_of(i)).center) * def.height);
        place[i] = {joint + rotate(rotation, (s.center - s.joint) * def.height), rotation};
    }
    return place;
}

Status make_part(World& world, const RagdollDef& def, std::uint32_t part, const Transform& place,
                 Ragdoll& made) {
    const Segment& s = segment_of(part);
    const Result<BodyId> body = world.create_body({.pose = place,
                                                   .linear_velocity = def.linear_velocity,
                                                   .angular_damping = 0.5_r, // damping of soft tissue
                                                   .mass = s.mass * def.mass,
                                                   .user_key = def.user_key + part});
    if (!body) return body.error();
    made.bodies[part] = *body;
    const Result<ShapeId> shape = world.create_shape(*body, {.geometry = geometry_of(s, def.height),
                                                             .friction = def.friction,
                                                             .category = def.category,
                                                             .mask = def.mask,
                                                             .user_key = def.user_key + part});
    if (!shape) return shape.error();
    if (part == 0) return {};
    JointDef joint = joint_of(def, part);
    joint.body_a = made.bodies[parent_of(part)], joint.body_b = *body;
    const Result<JointId> id = world.create_joint(joint);
    if (!id) return id.error();
    made.joints[part] = *id;
    return {};
}

Result<Ragdoll> make_parts(World& world, const RagdollDef& def) {
    const std::array<Transform, ragdoll_part_count> place = places(def);
    Ragdoll made{};
    for (std::uint32_t part = 0; part < ragdoll_part_count; ++part)
        if (const Status status = make_part(world, def, part, place[part], made); !status)
            return Error{join("make_ragdoll: ", segments[part].name, ": ", status.error().message)};
    return made;
}

/// A world for a trial run, which refuses what `world` would refuse: an empty one if `world` certainly has room, else
/// a clone.
Result<World> trial_of(const World& world) {
    const WorldRows rows = world.capacity(); // capacities, at least the present row counts
    const WorldDef& def = world.def();
    const auto has_room = [](std::uint32_t now, std::uint32_t most) {
        return most - now >= ragdoll_part_count;
    };
    const bool roomy = has_room(rows.bodies, def.bodies_max) && has_room(rows.shapes, def.shapes_max) &&
                       has_room(rows.joints, def.joints_max);
    return roomy ? World::create(def) : world.clone();
}

/// The axis times the angle, in the shorter direction.
Vec3 rotation_vector(Quat q) {
    const AxisAngle turn = to_axis_angle(q);
    return to<Real>(turn.axis) * turn.angle;
}

} // namespace

const char* name_of(RagdollPart part) {
    const auto i = static_cast<std::uint32_t>(part);
    return i < ragdoll_part_count ? segments[i].name : "unknown";
}

RagdollPart ragdoll_parent(RagdollPart part) {
    const auto i = static_cast<std::uint32_t>(part);
    LOCKSTONE_ASSERT(i < ragdoll_part_count, "part ", i, " of ", ragdoll_part_count);
    return segments[i].parent;
}

RagdollPose ragdoll_standing() {
    RagdollPose pose;
    pose.fill(Quat::identity());
    return pose;
}

RagdollPose ragdoll_t_pose() {
    RagdollPose pose = ragdoll_standing();
    pose[static_cast<std::size_t>(Part::upper_arm_left)] = from_axis_angle(axis_z, half_pi);
    pose[static_cast<std::size_t>(Part::upper_arm_right)] = from_axis_angle(axis_z, -half_pi);
    return pose;
}

Result<Ragdoll> make_ragdoll(World& world, const RagdollDef& def) {
    if (std::string e = check(def); !e.empty()) return Error{"make_ragdoll: " + e};
    Result<World> trial = trial_of(world);
    if (!trial) return trial.error();
    if (const Result<Ragdoll> tried = make_parts(*trial, def); !tried) return tried.error();
    return make_parts(world, def);
}

void destroy_ragdoll(World& world, const Ragdoll& ragdoll) {
    for (std::size_t i = ragdoll_part_count; i-- > 0;)
        if (world.is_alive(ragdoll.bodies[i])) static_cast<void>(world.destroy(ragdoll.bodies[i]).ok());
}

Status set_ragdoll_drive(World& world, const Ragdoll& ragdoll, const RagdollPose& pose,
                         const RagdollDrive& drive) {
    if (std::string e = check(pose); !e.empty()) return Error{"set_ragdoll_drive: " + e};
    for (std::uint32_t part = 1; part < ragdoll_part_count; ++part) {
        if (!world.is_alive(ragdoll.joints[part])) continue;
        const JointDef def = world.joint(ragdoll.joints[part]);
        const Turns turns = turns_of(part);
        const Quat relative = normalized(conjugate(turns.a) * normalized(pose[part]));
        const Vec3 target = rotation_vector(normalized(relative * turns.b));
        for (std::uint32_t i = about_x; i <= (def.kind == JointKind::hinge ? about_x : about_z); ++i) {
            JointAxis axis = def.axis[i];
            axis.spring = drive.frequency > Real{} ? 1 : 0;
            axis.frequency = drive.frequency, axis.damping_ratio = drive.damping_ratio;
            axis.target = target[static_cast<int>(i - about_x)], axis.spring_force = drive.torque_max;
            const Status status =
                world.set_joint_axis(ragdoll.joints[part], static_cast<JointAxisIndex>(i), axis);
            if (!status)
                return Error{join("set_ragdoll_drive: ", segments[part].name, ": ", status.error().message)};
        }
    }
    return {};
}

RagdollPose ragdoll_pose(const World& world, const Ragdoll& ragdoll) {
    RagdollPose pose = ragdoll_standing();
    for (std::uint32_t part = 1; part < ragdoll_part_count; ++part) {
        const BodyId body = ragdoll.bodies[part], parent = ragdoll.bodies[parent_of(part)];
        if (!world.is_alive(body) || !world.is_alive(parent)) continue;
        pose[part] = normalized(conjugate(world.pose(parent).rotation) * world.pose(body).rotation);
    }
    return pose;
}

} // namespace lockstone
