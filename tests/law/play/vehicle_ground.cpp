// The ground of vehicles: terrain, moving bodies, slippery surfaces; and the commands that make and destroy vehicles.
#include "support/rigs/vehicle_rig.h"

#include <doctest/doctest.h>

#include <vector>

using namespace lockstone;
using namespace lockstone::test::vehicle;

namespace {

constexpr int samples = 61;

double hill(double x, double z) { return 0.5 * std::sin(x * 0.35) * std::cos(z * 0.3); }

Result<AssetBytes> bake_field() {
    std::vector<Length> heights;
    for (int row = 0; row < samples; ++row)
        for (int column = 0; column < samples; ++column)
            heights.push_back(quantize<Length>(hill(column - 30, row - 30)));
    return bake_height_field(
        {.columns = samples, .rows = samples, .spacing = to<Length>(1_r), .heights = heights});
}

Result<AssetBytes> bake_surface() {
    std::vector<Vec3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (int row = 0; row < samples; ++row)
        for (int column = 0; column < samples; ++column)
            vertices.push_back(vec(column, hill(column - 30, row - 30), row));
    for (std::uint32_t row = 0; row + 1 < samples; ++row)
        for (std::uint32_t column = 0; column + 1 < samples; ++column) {
            const std::uint32_t at = row * samples + column;
            triangles.push_back({at, at + samples, at + 1});
            triangles.push_back({at + 1, at + samples, at + samples + 1});
        }
    return bake_mesh({.vertices = vertices, .triangles = triangles});
}

/// A car on terrain of 60 x 60 m.
Rig car_on(const Result<AssetBytes>& baked, WheelCast cast) {
    AssetLibrary library;
    const AssetId asset = made(library.add(made(baked)));
    const Geometry ground = made(library.geometry(asset));
    World w = made(World::create(small_def(), {}, std::make_shared<const AssetLibrary>(std::move(library))));
    add(w, {.kind = BodyKind::static_, .pose = at(-30, 0, -30)}, {.geometry = ground});
    const BodyId body =
        add(w, {.pose = at(0, 1.5, -15), .mass = 1200_r}, {.geometry = box(0.8_r, 0.3_r, 2_r)});
    VehicleDef def = four_wheels(body, {0.75_r, -0.3_r, 1.4_r});
    def.cast = cast;
    const VehicleId id = made(w.create_vehicle(def));
    return {std::move(w), body, id};
}

/// Drives 25 m over the hills. Returns the greatest error of a hub's height while its wheel has a load [m].
double drive_over(Rig rig) {
    rig.run(60);
    rig.drive({.throttle = 0.3_r, .gear = 1});
    double worst = 0;
    int ticks = 0, standing = 0;
    while (rig.at()[2] < 10 && ticks++ < 900) {
        rig.drive({.throttle = rig.speed() < 6 ? 0.4_r : 0_r, .brake = rig.speed() > 8 ? 0.3_r : 0_r});
        rig.run(1);
        const VehicleState s = rig.state();
        for (std::uint32_t i = 0; i < 4; ++i) {
            if (s.wheel[i].load <= 0_r) continue;
            ++standing;
            const D3 hub = to_double(s.wheel[i].pose.position);
            worst = std::max(worst, std::abs(hub[1] - hill(hub[0], hub[2]) - 0.35));
        }
    }
    CHECK(rig.at()[2] >= 10);
    CHECK(std::abs(rig.at()[0]) < 3);
    CHECK(standing > 3 * ticks);
    CHECK(rig.w.faults() == Faults{});
    return worst;
}

Rig car_on_box(const ShapeDef& surface, const BodyDef& body) {
    World w = made(World::create(small_def()));
    add_floor(w, {.friction = {}});
    add(w, body, surface);
    const BodyId chassis =
        add(w, {.pose = at(0, 2, 0), .mass = 1200_r}, {.geometry = box(0.8_r, 0.3_r, 2_r)});
    const VehicleId id = made(w.create_vehicle(four_wheels(chassis, {0.75_r, -0.3_r, 1.4_r})));
    return {std::move(w), chassis, id};
}

} // namespace

TEST_CASE("a car drives over height fields and meshes with every kind of wheel cast") {
    for (WheelCast cast : {WheelCast::ray, WheelCast::sphere, WheelCast::cylinder}) {
        INFO("cast ", static_cast<int>(cast));
        CHECK(drive_over(car_on(bake_field(), cast)) < 0.25);
        CHECK(drive_over(car_on(bake_surface(), cast)) < 0.25);
    }
}

TEST_CASE("wheels push the ground with the opposite of the force on the car") {
    // On a freely sliding raft the total momentum of car and raft stays zero.
    Rig rig = car_on_box({.geometry = box(3_r, 0.4_r, 12_r)}, {.pose = at(0, 0.4, 0), .mass = 3000_r});
    rig.run(180);
    rig.drive({.throttle = 0.5_r});
    rig.run(90);
    double car = 0, other = 0;
    for (BodyId body : rig.w.bodies()) {
        if (rig.w.kind(body) != BodyKind::dynamic) continue;
        (body == rig.chassis ? car : other) += to_double(rig.w.mass(body)) * velocity(rig.w, body)[2];
    }
    INFO("car ", car, " kg m/s, raft ", other, " kg m/s");
    CHECK(car > 2000);
    CHECK(off(-other, car) < 0.01);
}

TEST_CASE("a braked car rides a conveyor") {
    Rig rig = car_on_box({.geometry = box(3_r, 0.4_r, 40_r), .surface_velocity = {0_r, 0_r, 2_r}},
                         {.kind = BodyKind::static_, .pose = at(0, 0.4, 0)});
    rig.drive({.brake = 1_r, .gear = 0});
    rig.run(300);
    CHECK(off(rig.speed(), 2) < 1e-3);
}

TEST_CASE("the grip of tyres is proportional to the friction of the ground") {
    const auto way = [](Real friction) {
        Rig rig = car_on_box({.geometry = box(3_r, 0.4_r, 90_r), .friction = friction},
                             {.kind = BodyKind::static_, .pose = at(0, 0.4, 0)});
        rig.run(120);
        done(rig.w.set_velocity(rig.chassis, vec(0, 0, 5), {}));
        rig.drive({.brake = 1_r, .gear = 0});
        const D3 from = rig.at();
        rig.run(600);
        return length(rig.at() - from);
    };
    CHECK(off(way(0.06_r) / way(0.6_r), 10) < 0.2);
}

TEST_CASE("a vehicle is destroyed with its chassis or by command and commands reject dead ids") {
    Rig rig = make_car();
    CHECK(rig.w.vehicle_count() == 1);
    CHECK(rig.w.create_vehicle(four_wheels(rig.chassis, {})).error().message.find("already has") !=
          std::string::npos);
    const std::uint64_t before = rig.w.hash();
    CHECK_FALSE(rig.w.set_vehicle_input(rig.id, {.throttle = 2_r}).ok());
    CHECK(rig.w.hash() == before);
    done(rig.w.destroy(rig.id));
    CHECK_FALSE(rig.w.is_alive(rig.id));
    CHECK_FALSE(rig.w.set_vehicle_input(rig.id, {}).ok());
    CHECK_FALSE(rig.w.destroy(rig.id).ok());
    const VehicleId again = made(rig.w.create_vehicle(four_wheels(rig.chassis, {0.7_r, -0.3_r, 1_r})));
    rig.run(10);
    done(rig.w.destroy(rig.chassis));
    CHECK_FALSE(rig.w.is_alive(again));
    CHECK(rig.w.vehicle_count() == 0);
    rig.run(10);
}

TEST_CASE("create_vehicle() rejects definitions out of range with a sentence") {
    Rig rig = make_car();
    done(rig.w.destroy(rig.id));
    const auto refused = [&](auto&& change, const char* part) {
        VehicleDef def = four_wheels(rig.chassis, vec(0.7, -0.3, 1));
        change(def);
        const Result<VehicleId> made = rig.w.create_vehicle(def);
        return !made.ok() && made.error().message.find(part) != std::string::npos;
    };
    CHECK(refused([](VehicleDef& d) { d.wheel[1].direction = {unit_one, Unit{}, Unit{}}; }, "point down"));
    CHECK(refused([](VehicleDef& d) { d.wheel[0].drive_share = 1_r; }, "drive shares"));
    CHECK(refused([](VehicleDef& d) { d.tyre[0].along[2].x = {}; }, "left of"));
    CHECK(refused([](VehicleDef& d) { d.differential[0].wheels_a = 16; }, "not there"));
    CHECK(refused([](VehicleDef& d) { d.anti_roll[0].wheel_b = 4; }, "not there"));
    CHECK(refused([](VehicleDef& d) { d.tracks.enabled = 1; }, "both tracks"));
    CHECK(refused([](VehicleDef& d) { d.chassis = {}; }, "not alive"));
    CHECK_FALSE(refused([](VehicleDef&) {}, ""));
}

TEST_CASE("a vehicle with values at the ends of their ranges keeps its speed in range") {
    for (int k = 0; k < 6; ++k) {
        Setting s;
        s.mass = k < 2 ? 0.01 : 1e6;
        Rig rig = make_car(s, [&](VehicleDef& def) {
            for (WheelDef& w : def.wheel) {
                w.frequency = k % 2 == 0 ? 50_r : 0.1_r;
                w.damping_compression = w.damping_rebound = k % 3 == 0 ? 10_r : 0_r;
                w.inertia = k % 2 == 0 ? 0.001_r : 1000000_r;
                w.brake_torque = 100000000_r;
            }
            def.engine.torque_max = 10000000_r;
            def.engine.inertia = k < 3 ? 0.001_r : 100000_r;
            def.gearbox.clutch_torque = 100000000_r;
            def.gearbox.forward[0] = 1000_r;
            def.gearbox.final_drive = k < 4 ? 1000_r : 0.001_r;
        });
        for (int i = 0; i < 200; ++i) {
            rig.drive({.throttle = i % 40 < 20 ? 1_r : 0_r,
                       .brake = i % 40 > 30 ? 1_r : 0_r,
                       .steer = i % 3 == 0 ? 1_r : -1_r});
            rig.run(1);
            CHECK(length(velocity(rig.w, rig.chassis)) <= 501);
        }
    }
}
