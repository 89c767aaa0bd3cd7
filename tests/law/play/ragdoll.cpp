// The ragdoll: masses that add up, joints that hold within their limits, poses that it takes, and no leftovers after
// errors.
#include "lockstone/play/ragdoll.h"
#include "support/about.h"
#include "support/effort.h"
#include "support/rigs/fallen_ragdoll.h"
#include "support/rigs/joint_scenes.h"

#include <doctest/doctest.h>

#include <cstdlib>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

WorldDef ragdoll_def(std::uint32_t bodies = 20) {
    WorldDef def = drowsy_def();
    def.bodies_max = def.shapes_max = bodies;
    def.joints_max = bodies;
    return def;
}

/// The widest gap of a ragdoll's joints [m], and the greatest angle beyond a limit [rad].
struct Strain {
    double gap = 0, beyond = -10;
};
using Joints = std::array<JointDef, ragdoll_part_count>;
Joints joints_of(const World& w, const Ragdoll& r) {
    Joints out;
    for (std::uint32_t part = 1; part < ragdoll_part_count; ++part) out[part] = w.joint(r.joints[part]);
    return out;
}
/// Measures the strain against the joints' original definitions.
Strain strain_of(const World& w, const Ragdoll& r, const Joints& made_as) {
    Strain strain;
    for (std::uint32_t part = 1; part < ragdoll_part_count; ++part) {
        const JointDef& def = made_as[part];
        const Offset o =
            offset_of(place_of(w, def.body_a, def.frame_a), place_of(w, def.body_b, def.frame_b));
        strain.gap = std::max(strain.gap, length(o.along));
        const double twist = to_double(w.joint_state(r.joints[part]).position[about_x]);
        strain.beyond = std::max({strain.beyond, twist - to_double(def.axis[about_x].upper),
                                  to_double(def.axis[about_x].lower) - twist});
        if (def.kind == JointKind::ball)
            strain.beyond = std::max(strain.beyond, o.tilt - to_double(def.swing));
        if (def.kind == JointKind::hinge) strain.beyond = std::max(strain.beyond, o.tilt);
    }
    return strain;
}
Strain strain_of(const World& w, const Ragdoll& r) { return strain_of(w, r, joints_of(w, r)); }

/// A fall from 3 m ends at 7.7 m/s. The impulse reaches a joint in the next substep, and each of the five joints from a
/// hand to a foot one substep later.
constexpr double impact_gap_max = 5 * 7.7 / 480;
/// The bound at the end of a lever of 0.16 m, half a lower leg.
constexpr double lever = 0.16, impact_beyond_max = impact_gap_max / lever;
/// At rest a joint deflects as a spring of a quarter of the substep rate: 75 kg on a head and neck or a foot of 1 kg, g
/// 75 / (2 pi 120)^2.
constexpr double rest_gap_max = 9.81 * 75 / (6.2832 * 120) / (6.2832 * 120);

/// The largest angle between a part's rotations in two poses [rad].
double apart(const RagdollPose& a, const RagdollPose& b) {
    double most = 0;
    for (std::size_t i = 1; i < ragdoll_part_count; ++i)
        most = std::max(most, to_double(to_axis_angle(normalized(conjugate(a[i]) * b[i])).angle));
    return most;
}

} // namespace

TEST_CASE("a ragdoll has its defined mass and each segment has its share") {
    World w = made(World::create(ragdoll_def()));
    const Ragdoll r = made(make_ragdoll(w, {.height = real(1.7), .mass = real(60), .user_key = 1000}));
    double sum = 0, height = 0;
    for (std::uint32_t i = 0; i < ragdoll_part_count; ++i) {
        sum += to_double(w.mass(r.bodies[i]));
        CHECK(w.user_key(r.bodies[i]) == 1000 + i);
        height += to_double(w.mass(r.bodies[i])) * position(w, r.bodies[i])[1];
    }
    CHECK(sum == test::about(60, 1e-6));
    CHECK(to_double(w.mass(r.bodies[static_cast<std::size_t>(RagdollPart::thigh_left)])) ==
          test::about(6, 1e-6));
    CHECK(height / sum / 1.7 ==
          test::about(0.56, 0.03)); // published: 0.55 to 0.57 of the height above the ground
    CHECK(w.joint_count() == 13);
    CHECK(strain_of(w, r).gap < 1e-6);
    CHECK(strain_of(w, r).beyond < 1e-3);
    w.tick();
    for (const World::ContactPoint& p : w.contacts())
        CHECK(to_double(p.separation) > 0); // no part touches another
    done(w.set_pose(r.bodies[static_cast<std::size_t>(RagdollPart::forearm_left)],
                    w.pose(r.bodies[static_cast<std::size_t>(RagdollPart::head)])));
    w.tick();
    CHECK(std::ranges::any_of(w.contacts(), [](const World::ContactPoint& p) { // planted: an arm in the head
        return to_double(p.separation) < 0;
    }));
}

TEST_CASE("both poses of a ragdoll lie within the limits of all joints and ragdoll_pose() returns them") {
    for (const RagdollPose& pose : {ragdoll_standing(), ragdoll_t_pose()}) {
        World w = made(World::create(weightless(ragdoll_def())));
        const Ragdoll r = made(make_ragdoll(w, {.place = at(3, 1, 2, turned(axis_y, 70)), .pose = pose}));
        CHECK(strain_of(w, r).gap < 1e-6);
        CHECK(strain_of(w, r).beyond < 1e-3);
        CHECK(apart(ragdoll_pose(w, r), pose) < 1e-4);
        for (int t = 0; t < 60; ++t) w.tick();
        CHECK(apart(ragdoll_pose(w, r), pose) < 1e-3); // only parts beyond a limit move
    }
}

namespace {

/// A ragdoll falls from 3 m after `change`. Returns an error sentence unless it lies down whole and within its limits,
/// and sleeps.
template <class Change> std::string fall_fault(int seed, Change&& change) {
    World w = made(World::create(ragdoll_def()));
    add_floor(w);
    Random random = Random::seeded(static_cast<std::uint64_t>(seed));
    const Vec3 angles{random.range(-pi, pi), random.range(-pi, pi), random.range(-pi, pi)};
    const Ragdoll r = made(make_ragdoll(w, {.place = {vec(0, 3, 0), from_euler(angles)},
                                            .pose = seed % 2 == 0 ? ragdoll_standing() : ragdoll_t_pose()}));
    const Joints made_as = joints_of(w, r);
    change(w, r);
    Strain worst;
    for (int t = 0; t < 1200 && w.awake_count() > 0; ++t) {
        w.tick();
        const Strain now = strain_of(w, r, made_as);
        worst = {std::max(worst.gap, now.gap), std::max(worst.beyond, now.beyond)};
    }
    const Strain rest = strain_of(w, r, made_as);
    if (worst.gap > impact_gap_max) return "it comes apart by " + std::to_string(worst.gap);
    if (worst.beyond > impact_beyond_max) return "a limit is passed by " + std::to_string(worst.beyond);
    if (rest.gap > rest_gap_max) return "it lies apart by " + std::to_string(rest.gap);
    if (rest.beyond > rest_gap_max / lever) return "it lies beyond a limit by " + std::to_string(rest.beyond);
    if (w.awake_count() != 0) return "it does not sleep";
    for (BodyId b : r.bodies)
        if (position(w, b)[1] < 0) return "a part is below the floor";
    return w.faults() == Faults{} ? "" : "something was clamped";
}

} // namespace

TEST_CASE("a ragdoll that falls in any way stays whole and within its limits and sleeps") {
    const int count = std::getenv("LOCKSTONE_LONG") != nullptr ? 40 : 3;
    for (int seed = 0; seed < count; ++seed) {
        INFO("seed ", seed);
        CHECK(fall_fault(seed, [](World&, const Ragdoll&) {}) == "");
    }
}

TEST_CASE("a ragdoll's fall adds no energy and opens joints by at most 60 mm (30 mm in 19 of 20 falls; 100 "
          "mm on meshes)") {
    std::vector<double> widest;
    for (int seed = 1; seed <= lockstone::test::tries(100); ++seed) {
        const lockstone::test::RagdollFall fall =
            lockstone::test::fall_over(static_cast<std::uint64_t>(seed));
        CHECK(lockstone::test::fall_fault(fall) == "");
        if (!fall.is_mesh) widest.push_back(fall.widest);
    }
    std::ranges::sort(widest);
    CHECK(widest[widest.size() * 19 / 20] < 0.03);
    CHECK(widest[widest.size() / 2] < 0.01);
}

TEST_CASE("planted fault: the fall check reports a neck that is 10 cm too long and a knee that bends the "
          "wrong way") {
    const auto joint = [](const Ragdoll& r, RagdollPart part) {
        return r.joints[static_cast<std::size_t>(part)];
    };
    const auto stretched = [&](World& w, const Ragdoll& r) {
        const JointDef neck = w.joint(joint(r, RagdollPart::head));
        Transform longer = neck.frame_a;
        longer.position.y += 0.1_r;
        done(w.set_joint_frames(joint(r, RagdollPart::head), longer, neck.frame_b));
    };
    const auto backwards = [&](World& w, const Ragdoll& r) {
        JointAxis knee = w.joint(joint(r, RagdollPart::shin_left)).axis[about_x];
        knee.lower = -2.4_r, knee.upper = -0.7_r;
        done(w.set_joint_axis(joint(r, RagdollPart::shin_left), about_x, knee));
    };
    CHECK(fall_fault(0, stretched).starts_with("it comes apart"));
    CHECK(fall_fault(0, backwards).starts_with("a limit is passed"));
}

TEST_CASE("a driven ragdoll takes and keeps a pose and a ragdoll without drive has no springs") {
    World w = made(World::create(weightless(ragdoll_def())));
    const Ragdoll r = made(make_ragdoll(w, {}));
    RagdollPose pose = ragdoll_t_pose();
    pose[static_cast<std::size_t>(RagdollPart::shin_left)] = turned(axis_x, 60);
    pose[static_cast<std::size_t>(RagdollPart::head)] = turned(axis_y, 30);
    pose[static_cast<std::size_t>(RagdollPart::thigh_right)] = turned(axis_x, -40);
    done(set_ragdoll_drive(w, r, pose, {.frequency = Real(20)}));
    for (int t = 0; t < 240; ++t) w.tick();
    CHECK(apart(ragdoll_pose(w, r), pose) < 0.06); // friction holds the rest; a player does not see 3 degrees
    CHECK(apart(ragdoll_pose(w, r), ragdoll_standing()) > 0.9);
    done(set_ragdoll_drive(w, r, pose, {}));
    for (JointId joint : r.joints)
        if (joint) CHECK(w.joint(joint).axis[about_x].spring == 0);
    CHECK(!set_ragdoll_drive(w, r, pose, {.frequency = Real(2000)}).ok());
}

TEST_CASE("make_ragdoll() leaves no body and no joint in a world without enough capacity") {
    World w = made(World::create(ragdoll_def()));
    const auto full = [&](WorldDef def, const char* words) {
        World small = made(World::create(def));
        add_ball(small, at(0, 0, 0));
        const Result<Ragdoll> r = make_ragdoll(small, {});
        REQUIRE(!r.ok());
        CHECK(r.error().message.find(words) != std::string::npos);
        CHECK((small.body_count() == 1 && small.joint_count() == 0));
    };
    WorldDef few_bodies = ragdoll_def(), few_joints = ragdoll_def();
    few_bodies.bodies_max = 10, few_joints.joints_max = 5;
    full(few_bodies, "bodies_max is 10");
    full(few_joints, "joints_max is 5");
    const Ragdoll r = made(make_ragdoll(w, {}));
    destroy_ragdoll(w, r);
    CHECK((w.body_count() == 0 && w.joint_count() == 0));
    destroy_ragdoll(w, r); // destroyed already: no effect
}
