// Breaking and reactions of each kind: a joint reports its load, and breaks once, with an event, when the load exceeds
// its strength.
#include "support/about.h"
#include "support/effort.h"
#include "support/rigs/joint_variants.h"

#include <doctest/doctest.h>

#include <string>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr double load = 5000; ///< [N], or half of it in [N m]

/// A joint to a crate B, which an axis force pulls or a torque turns; the joint keeps it in place.
struct Loaded {
    const char* name;
    JointDef def;
    D3 force{}, torque{}; ///< on B
};

std::vector<Loaded> loaded_joints() {
    const D3 x{load, 0, 0}, y{0, load, 0}, turn_x{load / 2, 0, 0}, turn_y{0, load / 2, 0},
        turn_z{0, 0, load / 2};
    JointDef six = six_dof_joint();
    six.axis[along_y].mode = six.axis[about_z].mode = AxisMode::locked;
    JointDef limited = six_dof_joint();
    limited.axis[along_x] = {.mode = AxisMode::limited}; // is at both of its limits
    JointDef twist = ball_joint();
    twist.axis[about_x] = {.mode = AxisMode::limited};
    JointDef driven = slider_joint();
    driven.axis[along_x] = {.mode = AxisMode::free, .motor_force = real(2 * load)};
    JointDef braked = hinge_joint();
    braked.axis[about_x].friction = real(2 * load);
    JointDef sprung = hinge_joint();
    sprung.axis[about_x] = {.mode = AxisMode::free, .spring = 1, .frequency = Real(5)};
    const Real strong = real(10 * load), hz = Real(5);
    return {{"ball", ball_joint(), y},
            {"ball, twist limit", twist, {}, turn_x},
            {"hinge", hinge_joint(), y},
            {"hinge", hinge_joint(), {}, turn_y},
            {"hinge, friction", braked, {}, turn_x},
            {"hinge, spring", sprung, {}, turn_x},
            {"slider", slider_joint(), y},
            {"slider", slider_joint(), {}, turn_z},
            {"slider, motor", driven, x},
            {"weld", weld_joint(), x},
            {"weld", weld_joint(), {}, turn_x},
            {"weld, soft", weld_joint(hz), y},
            {"weld, soft", weld_joint(hz), {}, turn_z},
            {"six_dof", six, y},
            {"six_dof", six, {}, turn_z},
            {"six_dof, limit", limited, x},
            {"wheel, suspension", wheel_joint(hz, Real(1)), y},
            {"wheel", wheel_joint(hz, Real(1)), x},
            {"wheel, steering locked", wheel_joint(hz, Real(1)), {}, turn_y},
            {"motor", motor_joint(hz, strong, strong), y},
            {"motor", motor_joint(hz, strong, strong), {}, turn_y},
            {"mouse", mouse_joint(hz, strong), y},
            {"distance", distance_joint(Real(1)), x},
            {"rope", rope_joint(Real(1)), x},
            {"spring", spring_joint(Real(1), hz, Real(1)), x},
            {"pulley", pulley_joint(vec(-2, 3, 0), vec(0, 3, 0), Real(6)), {0, -load, 0}},
            {"gear", gear_joint(Real(2)), {}, turn_x},
            {"rack_and_pinion", rack_and_pinion_joint(Real(2)), x}};
}

/// B is the crate in the middle. A is at rest, and so is the shaft that a gear or a pinion has there.
struct Stand {
    World world = bare_world();
    BodyId a, b;
    JointId joint;
    Vec3 force, torque;

    Stand(const Loaded& what, double break_force, double break_torque)
        : force(vec(what.force[0], what.force[1], what.force[2])),
          torque(vec(what.torque[0], what.torque[1], what.torque[2])) {
        JointDef def = what.def;
        def.break_force = real(break_force), def.break_torque = real(break_torque);
        const bool turns = def.kind == JointKind::gear || def.kind == JointKind::rack_and_pinion;
        a = turns ? add_crate(world, at(-2, 0, 0)) : add_wall(world, at(-2, 0, 0), vec(0.5, 0.5, 0.5));
        b = add_crate(world, at(0, 0, 0));
        if (turns) made(world.create_joint(weld_joint(), {}, a, at(-2, 0, 0)));
        if (def.kind == JointKind::gear) made(world.create_joint(hinge_joint(), {}, b, at(0, 0, 0)));
        if (def.kind == JointKind::rack_and_pinion)
            made(world.create_joint(slider_joint(), {}, b, at(0, 0, 0)));
        if (def.kind != JointKind::distance && def.kind != JointKind::pulley) {
            joint = made(world.create_joint(def, a, b, at(0, 0, 0)));
            return;
        }
        def.body_a = a, def.body_b = b;
        if (def.kind == JointKind::distance) def.frame_a = at(1, 0, 0);
        joint = made(world.create_joint(def));
    }
    void tick() {
        done(world.add_force(b, force, torque));
        world.tick();
    }
};

/// Returns an error sentence unless the reported reaction on B balances the load.
std::string reaction_fault(const Loaded& what, double share = 1) {
    Stand stand(what, 0, 0);
    for (int t = 0; t < 120; ++t) stand.tick();
    const JointState s = stand.world.joint_state(stand.joint);
    const D3 force = to_double(s.force) + share * what.force,
             torque = to_double(s.torque) + share * what.torque;
    if (length(force) > 0.005 * load) return "the force is off by " + std::to_string(length(force)) + " N";
    if (length(torque) > 0.005 * load)
        return "the torque is off by " + std::to_string(length(torque)) + " N m";
    return {};
}

/// Returns "borne" after two seconds, "broken" after a break at once, or a sentence about another outcome.
std::string outcome(const Loaded& what, double strength) {
    const double force = length(what.force), torque = length(what.torque);
    Stand stand(what, strength * force, strength * torque);
    int events = 0, first = -1;
    for (int t = 0; t < 120; ++t) {
        stand.tick();
        for (const Event& e : stand.world.events()) {
            if (e.kind != EventKind::joint_break) continue;
            if (e.joint != stand.joint || e.body_a != stand.a || e.body_b != stand.b)
                return "another's event";
            if (e.tick != static_cast<std::uint64_t>(t)) return "an event of another tick";
            ++events, first = first < 0 ? t : first;
        }
        if (stand.world.is_alive(stand.joint) != (events == 0))
            return "an event, but no end, or an end without";
    }
    if (events == 0) return "borne";
    if (events > 1) return "it broke more than once";
    const double speed =
        force > 0 ? length(velocity(stand.world, stand.b)) : length(spin(stand.world, stand.b));
    if (speed < 1) return "it broke, but nothing moves";
    return first < 20 ? "broken" : "broken in tick " + std::to_string(first);
}

} // namespace

TEST_CASE("every kind of joint reports the force and the torque with which it bears a load") {
    for (const Loaded& what : loaded_joints()) {
        INFO(std::string(what.name));
        CHECK(reaction_fault(what) == "");
    }
}

TEST_CASE("planted fault: the check reports a reaction that is 3 % too small") {
    for (const Loaded& what : loaded_joints()) {
        INFO(std::string(what.name));
        CHECK(reaction_fault(what, 1.03) != "");
    }
}

TEST_CASE("every kind of joint bears loads below its strength and breaks once with one event above it") {
    for (const Loaded& what : loaded_joints()) {
        INFO(std::string(what.name));
        CHECK(outcome(what, 1.25) == "borne"); // a soft joint is loaded by 1.135 times its load at first
        CHECK(outcome(what, 0.8) == "broken");
        CHECK(outcome(what, 0) == "borne"); // unbreakable
    }
}

TEST_CASE("a gear and a rack load the other side with their ratio") {
    for (const JointDef& def : {gear_joint(Real(4)), rack_and_pinion_joint(Real(4))}) {
        const bool gear = def.kind == JointKind::gear;
        Stand stand({"", def, gear ? D3{} : D3{load, 0, 0}, gear ? D3{load, 0, 0} : D3{}}, 0, 0);
        for (int t = 0; t < 60; ++t) stand.tick();
        const JointId held = stand.world.joint_at(0); // of A to the world
        INFO(std::string(name_of(def.kind)));
        CHECK(to_double(stand.world.joint_state(held).torque.x) ==
              test::about((gear ? 1 : -1) * load / 4, 0.01));
    }
}

namespace {

/// A ball of so many kg hangs 1 m below the joint, or beside it. Returns the joint's force and torque after a second;
/// `holds` is false if it broke.
struct Hung {
    bool holds = false;
    double force = 0, torque = 0;
};
Hung hang_heavy(JointDef def, double mass, bool beside, std::uint32_t tick_rate) {
    WorldDef world = small_def();
    world.tick_rate = tick_rate;
    World w = made(World::create(world));
    const BodyId b = add(w, {.pose = beside ? at(1, 0, 0) : at(0, -1, 0), .mass = real(mass)},
                         {.geometry = sphere(0.3_r)});
    const JointId joint = made(w.create_joint(def, {}, b, at(0, 0, 0)));
    for (std::uint32_t t = 0; t < tick_rate && w.is_alive(joint); ++t) w.tick();
    if (!w.is_alive(joint)) return {};
    const JointState s = w.joint_state(joint);
    return {true, length(to_double(s.force)), length(to_double(s.torque))};
}

} // namespace

TEST_CASE("joints report the loads of the heaviest bodies and break under loads above their strength" *
          doctest::skip(lockstone::test::is_small_sample())) {
    for (const std::uint32_t tick_rate : {60u, 1000u})
        for (const double mass : {2e6, 2e7, 5e7, 1e8, 2e8}) {
            INFO("mass ", mass, ", tick rate ", tick_rate);
            const double weight = mass * 9.81;
            JointDef middle = hinge_joint();
            middle.axis[about_x] = {.mode = AxisMode::limited, .lower = -1_r, .upper = 1_r};
            for (JointDef def : {ball_joint(), middle, weld_joint(), slider_joint()}) {
                INFO("kind ", std::string(name_of(def.kind)));
                CHECK(hang_heavy(def, mass, false, tick_rate).force == test::about(weight, 0.01));
                def.break_force = real(0.9 * weight);
                CHECK_FALSE(hang_heavy(def, mass, false, tick_rate).holds);
                def.break_force = real(std::min(1.1 * weight, 2e9));
                CHECK(hang_heavy(def, mass, false, tick_rate).holds);
            }
            JointDef bracket = weld_joint();
            CHECK(hang_heavy(bracket, mass, true, tick_rate).torque == test::about(weight, 0.01));
            bracket.break_torque = real(0.9 * weight);
            CHECK_FALSE(hang_heavy(bracket, mass, true, tick_rate).holds);
        }
}
