// Checks of fast bodies, bodies far out, heavy loads, waking, the order of contacts, torn joints, and the ground under
// characters and vehicles.
#include "checks.h"
#include "law/zoo/case.h"
#include "law/zoo/passage.h"
#include "law/zoo/pole_points.h"
#include "support/rigs/asked.h"
#include "support/rigs/corrected.h"
#include "support/rigs/elastic.h"
#include "support/rigs/fallen_ragdoll.h"
#include "support/rigs/heavy_load.h"
#include "support/rigs/motor_at_limit.h"
#include "support/rigs/plank.h"
#include "support/rigs/slapped_plate.h"
#include "support/rigs/stopped_fall.h"
#include "support/rigs/sunk_hull.h"
#include "support/rigs/torn_hinge.h"

#include <algorithm>
#include <cmath>

namespace planted {

namespace {

/// Returns whether a ball passes the barrier at y = 0. The balls begin above it and would end far below in one tick.
bool is_passed_by_shots(World& world) {
    for (int i = 0; i < 8; ++i) {
        const BodyId ball = scene::add_ball(world, scene::at(2 * i, 1 + 0.5 * i, 0), 0.125);
        scene::done(world.set_velocity(ball, scene::vec(0, -400, 0), Vec3{}));
    }
    world.tick();
    return std::ranges::any_of(world.bodies(), [&](BodyId body) {
        return world.kind(body) == BodyKind::dynamic && world.center_of_mass(body).y < Real{};
    });
}

std::string planes_stop() {
    World world = scene::made(World::create(scene::small_def()));
    scene::add_floor(world);
    return is_passed_by_shots(world) ? "a ball has gone through a plane" : "";
}

/// A box on a floor, both with bounds beyond the range of 32 bits.
std::string border_holds() {
    World world = scene::made(World::create(scene::small_def()));
    scene::add(world, {.kind = BodyKind::static_, .pose = scene::at(32767.8, -1, 0)},
               {.geometry = box(50_r, 1_r, 50_r)});
    const BodyId body =
        scene::add(world, {.pose = scene::at(32767.8, 0.5, 0)}, {.geometry = box(0.5_r, 0.5_r, 0.5_r)});
    for (int i = 0; i < 30; ++i) world.tick();
    return world.pose(body).position.y > 0.4_r ? ""
                                               : "a box falls through a floor at the border of the range";
}

/// The first fault of this many seeds.
std::string first_fault(std::string (*fault_of)(std::uint64_t), std::uint64_t seeds) {
    for (std::uint64_t seed = 1; seed <= seeds; ++seed)
        if (const std::string fault = fault_of(seed); !fault.empty()) return fault;
    return {};
}

std::string sleep_waits_for_corrections() {
    const std::string pulled = first_fault(test::pulled_body_fault, 10);
    return pulled.empty() ? first_fault(test::buried_body_fault, 10) : pulled;
}

/// The wall moves towards the balls.
std::string driven_walls_stop() {
    World world = scene::made(World::create(scene::weightless()));
    scene::add(world, {.kind = BodyKind::kinematic, .linear_velocity = scene::vec(0, 1, 0)},
               {.geometry = box(20_r, 0.25_r, 2_r)});
    return is_passed_by_shots(world) ? "a ball has gone through a wall" : "";
}

/// Balls at rest, and a thin wall that rises by two metres a tick.
std::string driven_walls_carry() {
    World world = scene::made(World::create(scene::weightless()));
    scene::add(world, {.kind = BodyKind::kinematic, .linear_velocity = scene::vec(0, 120, 0)},
               {.geometry = box(20_r, 0.05_r, 2_r)});
    for (int i = 0; i < 8; ++i) scene::add_ball(world, scene::at(2 * i, 1 + 0.5 * i, 0), 0.125);
    for (int i = 0; i < 10; ++i) world.tick();
    return std::ranges::any_of(world.bodies(),
                               [&](BodyId body) {
                                   return world.kind(body) == BodyKind::dynamic &&
                                          world.center_of_mass(body).y < 19.5_r;
                               })
               ? "a wall has gone through a ball"
               : "";
}

/// A rod that turns about its middle by half a radian a tick, and a thin post beside its end that it would pass in the
/// first tick. The reach of the rod is less than four times its inner radius: contacts of a thinner rod would find the
/// post ahead.
std::string posts_stop_rods() {
    World world = scene::made(World::create(scene::weightless()));
    scene::add(world, {.kind = BodyKind::static_, .pose = scene::at(0.33, 0.16, 0)},
               {.geometry = box(0.01_r, 0.01_r, 1_r)});
    const BodyId rod = scene::add(world, {.angular_velocity = scene::vec(0, 0, 30)},
                                  {.geometry = box(0.37_r, 0.1_r, 0.1_r)});
    world.tick();
    return rotate(world.pose(rod).rotation, Vec3{1_r, 0_r, 0_r}).y < 0.35_r
               ? ""
               : "the end of a rod has gone through a post";
}

/// Two crates 0.1 m apart pass each other at 20 m/s. One of them turns, so two of its corners would reach the other.
std::string corners_close() {
    World world = scene::made(World::create(scene::weightless()));
    scene::add_crate(world, scene::at(0, 0, 0));
    const BodyId crate = scene::add_crate(world, scene::at(1.1, 0, 0));
    scene::done(world.set_velocity(crate, scene::vec(0, 0, 20), scene::vec(0, 0, 15)));
    world.tick();
    const auto closes = [](const World::ContactPoint& point) { return point.point.y > Real{}; };
    return world.contacts().size() == 2 && std::ranges::all_of(world.contacts(), closes)
               ? ""
               : "the contact points are not those that close";
}

/// A beam lies on a crate and on a smooth crate that is on a slab. The smooth crate slides towards a wall two
/// millimetres away. When it touches the wall, its level in the order of contacts is as low as that of the other crate,
/// and the beam's contacts are solved in the reverse order. A restored world computes that order again.
std::string order_is_followed() {
    World world = scene::made(World::create(scene::small_def()));
    scene::add_floor(world);
    scene::add(world, {.kind = BodyKind::static_, .pose = scene::at(4.002, 0.5, 0)},
               {.geometry = box(1_r, 0.5_r, 1_r)});
    scene::add(world, {.pose = scene::at(-2, 0.5, 0)}, {.geometry = box(0.5_r, 0.5_r, 0.5_r)});
    scene::add(world, {.pose = scene::at(2, 0.125, 0)}, {.geometry = box(0.6_r, 0.125_r, 0.5_r)});
    const BodyId slides = scene::add(world, {.pose = scene::at(2.5, 0.625, 0)},
                                     {.geometry = box(0.5_r, 0.375_r, 0.5_r), .friction = 0_r});
    scene::add(world, {.pose = scene::at(0, 1.125, 0)}, {.geometry = box(2.9_r, 0.125_r, 0.5_r)});
    for (int i = 0; i < 60; ++i) {
        if (i == 20) scene::done(world.set_velocity(slides, scene::vec(0.01, 0, 0), Vec3{}));
        World restored = scene::made(World::create(world.def()));
        Image image;
        world.save(image);
        restored.restore(image);
        world.tick(), restored.tick();
        if (world.hash() != restored.hash())
            return "a restored world goes another way in tick " + std::to_string(i);
    }
    return world.pose(slides).position.x > 2.501_r ? "" : "a crate does not slide to a wall";
}

/// A sleeping crate near a dozen rolling balls, and a ball that is shot at the crate.
std::string sleepers_among_many_wake() {
    WorldDef def = scene::small_def();
    def.sleeping = 1;
    World world = scene::made(World::create(def));
    scene::add_floor(world);
    const BodyId crate = scene::add_crate(world, scene::at(0, 0.5, 0));
    for (int i = 0; i < 90; ++i) world.tick();
    if (world.is_awake(crate)) return "a crate at rest does not fall asleep";
    for (int i = 0; i < 12; ++i)
        scene::done(world.set_velocity(scene::add_ball(world, scene::at(4 + 1.5 * i, 0.5, 6)),
                                       scene::vec(1, 0, 0), Vec3{}));
    scene::done(
        world.set_velocity(scene::add_ball(world, scene::at(-3, 0.5, 0)), scene::vec(10, 0, 0), Vec3{}));
    for (int i = 0; i < 40; ++i) world.tick();
    return world.pose(crate).position.x > 0.01_r ? "" : "a crate that is hit sleeps on";
}

ShapeDef elastic(const Geometry& geometry, double friction) {
    return {.geometry = geometry, .friction = scene::real(friction), .restitution = 1_r};
}
/// Elastic bodies part with their closing speed, at any time of the touch within a tick; cubes that fall on corners
/// gain no energy; and a sliding ball loses friction times both parts of the normal impulse.
std::string elastic_bodies_bounce() {
    WorldDef def = scene::weightless(WorldDef{});
    def.bodies_max = def.shapes_max = 4, def.contacts_max = 16;
    for (int i = 0; i < 40; ++i) {
        World world = scene::made(World::create(def));
        const double gap = 0.1 + i * 0.00137;
        scene::add(world, {.pose = scene::at(-1 - gap, 0, 0), .linear_velocity = scene::vec(1.5, 0, 0)},
                   elastic(sphere(0.5_r), 0));
        const BodyId hit = scene::add(world, {}, elastic(sphere(0.5_r), 0));
        for (int t = 0; t < 12; ++t) world.tick();
        if (scene::velocity(world, hit)[0] < 1.499) return "a ball that is hit is slow";
    }
    for (int i = 0; i < 100; ++i) {
        World world = scene::made(World::create(def));
        scene::add_floor(world, elastic(plane(), 0));
        const Quat turn = scene::turned(scene::axis_z, 37 * i) * scene::turned(scene::axis_x, 23 * i + 7);
        scene::add(world, {.pose = scene::at(0, 1, 0, turn), .linear_velocity = scene::vec(0, -5, 0)},
                   elastic(box(0.4_r, 0.4_r, 0.4_r), 0));
        const double before = to_double(world.kinetic_energy());
        for (int t = 0; t < 16; ++t) world.tick();
        if (to_double(world.kinetic_energy()) > 1.001 * before) return "a cube gains energy";
    }
    for (const bool reversed : {false, true}) {
        World world = scene::made(World::create(scene::weightless()));
        const test::ElasticRow row = test::strike_row(world, {.reversed = reversed});
        if (row.last < 1.99) return "the last ball of a row is slow";
    }
    if (const double off = test::farthest_off_bounce(0.2, 5); off > 0.001)
        return "a ball that was hit is " + std::to_string(off) + " m from where it should be";
    if (const double lost = test::height_lost(8); lost > 0.001) return "a ball loses height";
    if (test::reported_impulse(sphere(0.1_r), 1, 3, 0.3) < 5.99)
        return "the impulse of an impact is not reported";
    World world = scene::made(World::create(def));
    scene::add_floor(world, elastic(plane(), 0.2));
    const BodyId ball =
        scene::add(world, {.pose = scene::at(0, 1, 0), .linear_velocity = scene::vec(10, -5, 0)},
                   elastic(sphere(0.5_r), 0.2));
    for (int t = 0; t < 12; ++t) world.tick();
    const double lost = 10 - scene::velocity(world, ball)[0];
    return std::abs(lost - 2) < 0.001 ? "" : "a ball loses too much or too little of its slide";
}

/// Spinning bodies in a closed room.
std::string elastic_bodies_gain_nothing() {
    for (const Geometry& geometry : {box(0.3_r, 0.2_r, 0.25_r), capsule(0.2_r, 0.25_r)})
        for (std::uint64_t seed = 1; seed <= 3; ++seed)
            if (const double most = test::energy_in_room(geometry, 1, seed, 3000); most > 1.1)
                return "a body in a closed room grew to " + std::to_string(most) + " of its energy";
    return "";
}

/// A needle that rolls at 1 cm/s must sleep.
std::string thin_rollers_sleep() {
    WorldDef def = scene::small_def();
    def.sleeping = 1;
    World world = scene::made(World::create(def));
    scene::add_floor(world);
    const BodyId needle = scene::add(world,
                                     {.pose = scene::at(0, 0.02, 0, scene::turned(scene::axis_x, 90)),
                                      .linear_velocity = scene::vec(0.01, 0, 0),
                                      .angular_velocity = scene::vec(0, 0, -0.5)},
                                     {.geometry = capsule(0.02_r, 0.5_r)});
    for (int i = 0; i < 90; ++i) world.tick();
    return world.is_awake(needle) ? "a needle that rolls slowly stays awake" : "";
}

/// A hinge that tears within a tick pulls like a joint with its axes, to a hundredth.
std::string torn_hinges_pull() {
    for (const JointAxis& about : {scene::turns_freely, scene::hardly_turns}) {
        scene::TornHinge hinge(scene::hinge_with(about), 60_r), axes(scene::wheel_like_hinge(about), 60_r);
        hinge.world.tick(), axes.world.tick();
        if (abs(hinge.torque() - axes.torque()) > axes.torque() / Real(100))
            return "a torn hinge pulls otherwise than its axes";
    }
    return {};
}

/// A ball rests on a plane far below, and a crate moves with a platform far to the side.
std::string far_out_holds() {
    World world = scene::made(World::create(scene::small_def()));
    const Vec3 speed = scene::vec(0, 0, 20);
    scene::add(world, {.kind = BodyKind::static_, .pose = scene::at(0, -40000, 0)}, {.geometry = plane()});
    const BodyId ball = scene::add_ball(world, scene::at(0, -39999.5, 0));
    scene::add(world, {.kind = BodyKind::kinematic, .pose = scene::at(40000, 0, 0), .linear_velocity = speed},
               {.geometry = box(10_r, 1_r, 10_r)});
    const BodyId crate = scene::add(world, {.pose = scene::at(40000, 1.5, 0), .linear_velocity = speed},
                                    {.geometry = box(0.5_r, 0.5_r, 0.5_r)});
    for (int i = 0; i < 30; ++i) world.tick();
    if (world.pose(ball).position.y < -39999.6_r) return "a ball falls through a plane far below";
    return world.pose(crate).position.y > 1.4_r ? "" : "a crate falls through a platform far aside";
}

/// The force of a joint that carries a hundred thousand tons.
std::string heavy_joints_tell() {
    World world = scene::made(World::create(scene::small_def()));
    const BodyId ball =
        scene::add(world, {.pose = scene::at(0, -1, 0), .mass = 100000000_r}, {.geometry = sphere(0.3_r)});
    const JointId joint = scene::made(world.create_joint(ball_joint(), {}, ball, scene::at(0, 0, 0)));
    world.tick();
    return abs(world.joint_state(joint).force.y - 981000000_r) < 9810000_r
               ? ""
               : "a joint tells another force than the weight";
}

/// A hinge that turns by more than a half turn in a tick.
std::string fast_hinges_count() {
    World world = scene::made(World::create(scene::weightless()));
    const BodyId ball =
        scene::add(world, {.angular_velocity = scene::vec(200, 0, 0)}, {.geometry = sphere(0.05_r)});
    const JointId joint = scene::made(world.create_joint(hinge_joint(), {}, ball, scene::at(0, 0, 0)));
    for (int i = 0; i < 30; ++i) world.tick();
    return abs(world.joint_state(joint).position[about_x] - 100_r) < 1_r ? "" : "a hinge has lost turns";
}

std::string conveyors_carry() {
    World world = scene::made(World::create(scene::small_def()));
    scene::add(world, {.kind = BodyKind::static_, .pose = scene::at(0, -0.5, 0)},
               {.geometry = box(20_r, 0.5_r, 5_r), .surface_velocity = scene::vec(2, 0, 0)});
    CharacterDef def;
    def.position = scene::vec(0, 0.01, 0);
    const CharacterId character = scene::made(world.create_character(def));
    for (int i = 0; i < 60; ++i) world.tick();
    return world.pose(world.body_of(character)).position.x > 1.5_r
               ? ""
               : "a conveyor leaves a character where it is";
}

std::string cars_park() {
    WorldDef def = scene::small_def();
    def.sleeping = 1;
    World world = scene::made(World::create(def));
    scene::add_floor(world);
    const BodyId body = scene::add(world, {.pose = scene::at(0, 0.8, 0), .mass = 1200_r},
                                   {.geometry = box(0.8_r, 0.3_r, 2_r)});
    VehicleDef car = four_wheels(body, scene::vec(0.75, -0.3, 1.4));
    car.cast = WheelCast::cylinder;
    scene::made(world.create_vehicle(car));
    for (int i = 0; i < 600; ++i) world.tick();
    return world.is_awake(body) ? "a parked car does not come to rest" : "";
}

/// A ball rolls over the joint of two flush boxes as over one box.
std::string passing_is_free() {
    World world = scene::made(World::create(scene::small_def()));
    for (const double side : {-20.0, 20.0})
        scene::add(world, {.kind = BodyKind::static_, .pose = scene::at(side, -1, 0)},
                   {.geometry = box(20_r, 1_r, 20_r)});
    const BodyId ball = scene::add(world,
                                   {.pose = scene::at(-1.6, 0.1, 0.13),
                                    .linear_velocity = scene::vec(5, 0, 0),
                                    .angular_velocity = scene::vec(0, 0, -50)},
                                   {.geometry = sphere(0.1_r)});
    for (int i = 0; i < 60; ++i) {
        world.tick();
        if (world.pose(ball).position.y > 0.11_r) return "a ball hops over the joint of two flush boxes";
    }
    return {};
}

std::string flat_prisms_rest() {
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        const zoo::Drop drop = zoo::draw_flat_prism(seed);
        if (std::string found = zoo::rest_fault(drop, zoo::play(drop)); !found.empty())
            return drop.about() + ": " + found;
    }
    return {};
}

std::string lumpy_objects_rest() {
    for (const std::uint64_t seed : {33, 376, 386, 439, 559, 579, 700, 1467, 2101, 2105, 2280}) {
        const zoo::Drop drop = zoo::draw_drop(seed);
        if (std::string found = zoo::rest_fault(drop, zoo::play(drop)); !found.empty())
            return drop.about() + ": " + found;
    }
    return {};
}

/// Returns the first fault of a law in the cases of the seeds from 1 to `count`.
std::string zoo_fault(zoo::Case (*draw)(std::uint64_t),
                      std::string (*law)(const zoo::Case&, const zoo::Track&), std::uint64_t count) {
    for (std::uint64_t seed = 1; seed <= count; ++seed) {
        const zoo::Case c = draw(seed);
        if (std::string found = law(c, zoo::track(c)); !found.empty()) return c.about() + ": " + found;
    }
    return {};
}

std::string rest_and_sleep_agree() {
    std::string found = zoo_fault(zoo::draw_single, zoo::asleep_law, 40);
    if (found.empty()) found = zoo_fault(zoo::draw_single, zoo::woken_law, 80);
    return found.empty() ? zoo_fault(zoo::draw_pair, zoo::woken_law, 60) : found;
}

std::string beams_rest() {
    for (const double length : {0.5, 2.0, 4.4, 8.0})
        for (const bool precise : {false, true})
            if (std::string found = zoo::beam_fault({length, 0, 0.6, precise}); !found.empty()) return found;
    return {};
}

std::string ragdolls_land() {
    for (std::uint64_t seed = 1; seed <= 40; ++seed)
        if (std::string found = test::fall_fault(test::fall_over(seed)); !found.empty()) return found;
    return {};
}

std::string plates_slap() {
    const test::Slaps slaps = test::slap_many(100);
    return slaps.deep <= 21 ? "" : std::to_string(slaps.deep) + " of 100 plates sink into the floor";
}

/// A plate 10 cm above a parallel slope falls by 7 cm in a tick: it has no contact.
std::string plates_meet_late() {
    World world = scene::made(World::create(WorldDef{}));
    const Quat turn = scene::turned(scene::axis_z, 30);
    scene::add_wall(world, scene::at(0, 0, 0, turn), scene::vec(4, 0.5, 4));
    const double up_x = -0.5, up_y = std::sqrt(0.75), height = 0.5 + 0.01 + 0.1;
    const BodyDef plate{.pose = scene::at(height * up_x, height * up_y, 0, turn),
                        .linear_velocity = scene::vec(-4 * up_x, -4 * up_y, 0)};
    scene::add(world, plate, {.geometry = box(1_r, 0.01_r, 0.5_r)});
    world.tick();
    return world.contacts().empty() ? "" : "a plate has a contact beyond its margin";
}

std::string casts_leave_overlaps_out() {
    int left_out = 0;
    for (std::uint64_t seed = 1; seed <= 4; ++seed)
        if (std::string found = test::overlaps_seen_fault(seed, left_out); !found.empty()) return found;
    return left_out > 50 ? "" : "casts seldom begin in a shape";
}

} // namespace

Checks motion_checks() {
    return {
        {"planes stop what is fast", planes_stop},
        {"a floor at the border of the range holds", border_holds},
        {"driven walls stop what is fast", driven_walls_stop},
        {"driven walls carry what rests", driven_walls_carry},
        {"posts stop what turns fast", posts_stop_rods},
        {"corners that close are contacts", corners_close},
        {"who sleeps among many is woken", sleepers_among_many_wake},
        {"the order of contacts is followed", order_is_followed},
        {"elastic bodies bounce", elastic_bodies_bounce},
        {"elastic bodies gain no energy", elastic_bodies_gain_nothing},
        {"thin bodies that roll fall asleep", thin_rollers_sleep},
        {"torn hinges pull", torn_hinges_pull},
        {"what is far out is held", far_out_holds},
        {"heavy joints tell their load", heavy_joints_tell},
        {"fast hinges count their turns", fast_hinges_count},
        {"conveyors carry characters", conveyors_carry},
        {"cars on cylinders park", cars_park},
        {"objects gain no energy", [] { return zoo_fault(zoo::draw_shot, zoo::energy_law, 210); }},
        {"flat prisms rest", flat_prisms_rest},
        {"lumpy objects rest", lumpy_objects_rest},
        {"beams rest", beams_rest},
        {"rest and sleep agree", rest_and_sleep_agree},
        {"poles and plates gain no energy",
         [] {
             for (const std::uint64_t seed : {448u, 453u, 998u, 2678u, 1656u, 2206u}) {
                 const zoo::Case c = zoo::draw_shot(seed);
                 if (std::string found = zoo::energy_law(c, zoo::track(c)); !found.empty()) return found;
             }
             return std::string();
         }},
        {"poles have their points on them", [] { return first_fault(zoo::pole_point_fault, 20); }},
        {"thin bodies that touch gain no energy",
         [] {
             for (const zoo::Case& c : {zoo::draw_pair(558), zoo::draw_pair(2614), zoo::draw_meeting(1161)})
                 if (std::string found = zoo::energy_law(c, zoo::track(c)); !found.empty()) return found;
             return std::string();
         }},
        {"shots stay above floors", [] { return zoo_fault(zoo::draw_shot, zoo::passage_law, 60); }},
        {"pairs in space keep momentum", [] { return zoo_fault(zoo::draw_meeting, zoo::momentum_law, 40); }},
        {"stopped balls have fallen as far as they went",
         [] { return first_fault(test::stopped_fall_fault, 20); }},
        {"compounds come to rest", [] { return zoo_fault(zoo::draw_single, zoo::settled_law, 160); }},
        {"deepest corners are contacts", [] { return first_fault(test::sunk_hull_fault, 100); }},
        {"sleep waits for corrections", sleep_waits_for_corrections},
        {"rafts sleep level", [] { return first_fault(test::raft_fault, 10); }},
        {"limits hold drives", test::limits_fault},
        {"overlap is pushed out", [] { return first_fault(test::push_fault, 10); }},
        {"ragdolls land", ragdolls_land},
        {"plates slap without sinking in", plates_slap},
        {"plates meet within their margin", plates_meet_late},
        {"casts leave overlaps out", casts_leave_overlaps_out},
        {"bodies have their points", [] { return first_fault(test::body_points_fault, 10); }},
        {"heavy loads rest", [] { return first_fault(test::heavy_load_fault, 100); }},
        {"planks stay up", [] { return first_fault(test::plank_fault, 10); }},
        {"free rows keep momentum", [] { return first_fault(test::free_row_fault, 100); }},
        {"passages are reported", [] { return first_fault(zoo::passage_fault, 300); }},
        {"what passes is not run into", passing_is_free}};
}

} // namespace planted
