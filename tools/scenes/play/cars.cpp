// Up to four cars and a tank on hills of 128 x 128 m with a flat area in the middle, ramps, and crates. A car drives in
// the direction of the stick, as a camera behind it shows it; a direction far behind the car means reverse. Jump is the
// hand brake; push puts a car back on its wheels. The tank follows a fixed route.
#include "lockstone/math/math.h"
#include "lockstone/math/random.h"
#include "scenes/scene.h"

#include <algorithm>
#include <array>
#include <vector>

namespace lockstone::scenes_detail {
namespace {

constexpr std::uint32_t car_count = 4, crate_rows = 4, samples = 129;
constexpr std::uint32_t crate_count = 4 * (crate_rows * (crate_rows + 1) / 2);
constexpr std::uint32_t help_pause = 120;                                ///< [ticks] between two uses of push
constexpr Real half_side = 64_r, car_mass = 1300_r, tank_mass = 20000_r; ///< [m], [kg]
constexpr UnitVec3 up{Unit{}, unit_one, Unit{}};

struct Garage {
    std::array<VehicleId, car_count> cars;
    std::array<BodyId, car_count> bodies;
    VehicleId tank;
    std::array<std::uint32_t, car_count> help_ready; ///< the first tick at which push may help the car again
    friend bool operator==(const Garage&, const Garage&) = default;
};
template <class V> constexpr void describe(Garage& g, V&& v) {
    v("cars", g.cars), v("bodies", g.bodies), v("tank", g.tank), v("help_ready", g.help_ready);
}
constexpr Column<Garage> garage_column{0};

// ---- the start ------------------------------------------------------------------------------------------------

/// The height at a place [m]; the origin is the middle of the field. Flat within 24 m, hills beyond.
Real height_at(Real x, Real z) {
    const Real radius = sqrt(x * x + z * z);
    const Real rise = clamp((radius - 24_r) / 16_r, 0_r, 1_r);
    const Real hills =
        2.5_r + 1.6_r * sin(x * 0.13_r) * cos(z * 0.11_r) + 0.7_r * sin(x * 0.29_r + z * 0.21_r);
    return hills * rise * rise * (3_r - 2_r * rise) + 0.03_r * sin(x * 1.1_r) * sin(z * 1.3_r);
}

Result<AssetBytes> bake_hills() {
    std::vector<Length> heights;
    for (std::uint32_t row = 0; row < samples; ++row)
        for (std::uint32_t column = 0; column < samples; ++column)
            heights.push_back(to<Length>(height_at(Real(column) - half_side, Real(row) - half_side)));
    return bake_height_field(
        {.columns = samples, .rows = samples, .spacing = to<Length>(1_r), .heights = heights});
}

void build_ground(Builder& build, const Geometry& hills) {
    build.body({.kind = BodyKind::static_,
                .pose = at({-half_side, 0_r, -half_side}),
                .user_key = user_key_of(Role::terrain, 0)},
               {.geometry = hills, .friction = 0.6_r});
    for (std::uint32_t i = 0; i < 4; ++i) {
        const Quat turn = from_axis_angle(up, half_pi * Real(i));
        build.body({.kind = BodyKind::static_,
                    .pose = at(rotate(turn, Vec3{0_r, 4_r, half_side}), turn),
                    .user_key = user_key_of(Role::wall, 4 + i)},
                   {.geometry = box(half_side, 8_r, 1_r)});
    }
}

void build_ramps(Builder& build) {
    constexpr UnitVec3 across{unit_one, Unit{}, Unit{}};
    for (std::uint32_t i = 0; i < 4; ++i) {
        const Quat turn = from_axis_angle(up, half_pi * Real(i));
        const Vec3 place = rotate(turn, Vec3{0_r, 0.2_r, 15_r});
        build.body({.kind = BodyKind::static_,
                    .pose = at(place, normalized(turn * from_axis_angle(across, -0.22_r))),
                    .user_key = user_key_of(Role::wall, i)},
                   {.geometry = box(2_r, 0.3_r, 4_r), .friction = 0.6_r});
    }
}

/// Four walls of crates; each row has one crate less than the row below.
void build_crates(Builder& build) {
    constexpr Real half_edge = 0.4_r, step = 0.85_r;
    std::uint32_t number = 0;
    for (std::uint32_t wall = 0; wall < 4; ++wall) {
        const Quat turn = from_axis_angle(up, half_pi * (Real(wall) + half(Real(1))));
        for (std::uint32_t row = 0; row < crate_rows; ++row)
            for (std::uint32_t i = 0; i + row < crate_rows; ++i, ++number) {
                const Real aside = (Real(i) - half(Real(crate_rows - 1 - row))) * step;
                const Vec3 place = rotate(turn, Vec3{aside, half_edge + 0.05_r + Real(row) * 0.81_r, 17_r});
                build.body({.pose = at(place, turn), .user_key = user_key_of(Role::prop, number)},
                           {.geometry = box(half_edge, half_edge, half_edge), .density = 60_r});
            }
    }
}

VehicleDef car_def(BodyId body) {
    VehicleDef def = four_wheels(body, {0.78_r, -0.25_r, 1.35_r});
    for (std::uint32_t i = 0; i < 4; ++i) {
        def.wheel[i].frequency = 1.8_r;
        def.wheel[i].length_max = 0.4_r;
        def.wheel[i].attachment.y = 0.1_r;
    }
    def.anti_roll[0] = {0, 1, 15000_r};
    def.anti_roll[1] = {2, 3, 10000_r};
    def.differential[0] = {DifferentialKind::limited, 4, 8, 0, 80_r, 0.2_r};
    def.steer_speed = 4_r;
    return def;
}

VehicleDef tank_def(BodyId body) {
    VehicleDef def = two_tracks(body, {1.45_r, -0.5_r, 2.4_r}, 4);
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) def.wheel[i].radius = 0.4_r;
    return def;
}

/// Stores the ids that the vehicles will get. No vehicle has been destroyed yet, so ids are consecutive.
void build_vehicles(Builder& build, Garage& garage, std::uint32_t players) {
    for (std::uint32_t p = 0; p < car_count; ++p) {
        const Real x = 4_r * Real(p) - 6_r;
        const BodyId body =
            build.body({.pose = at({x, 0.9_r, -4_r}),
                        .mass = car_mass,
                        .user_key = user_key_of(p < players ? Role::player : Role::machine, p)},
                       {.geometry = box(0.85_r, 0.25_r, 2_r), .friction = 0.3_r});
        build.shape(body, {.geometry = box(0.7_r, 0.25_r, 1_r),
                           .local = at({0_r, 0.5_r, -0.2_r}),
                           .density = 150_r,
                           .friction = 0.3_r});
        garage.bodies[p] = body;
        garage.cars[p] = build.vehicle(car_def(body));
    }
    const BodyId tank = build.body({.pose = at({0_r, 1.4_r, -12_r}),
                                    .mass = tank_mass,
                                    .user_key = user_key_of(Role::machine, car_count)},
                                   {.geometry = box(1.3_r, 0.5_r, 2.8_r), .friction = 0.3_r});
    build.shape(tank,
                {.geometry = box(0.9_r, 0.3_r, 1.2_r), .local = at({0_r, 0.8_r, -0.3_r}), .density = 300_r});
    garage.tank = build.vehicle(tank_def(tank));
}

// ---- the rules ------------------------------------------------------------------------------------------------

/// The controls of a car whose driver wants to go in the direction of the stick.
VehicleInput drive(const World& world, BodyId body, ArenaInput input) {
    const Rotation axes = to_rotation(world.pose(body).rotation);
    const Vec3 stick{Real(input.move_x) / 127_r, 0_r, Real(input.move_z) / 127_r};
    const Real wish = min(length(stick), 1_r), ahead = dot<Real>(axes.z, stick),
               left = dot<Real>(axes.x, stick);
    const Real speed = dot<Real>(axes.z, world.linear_velocity(body));
    VehicleInput out;
    if ((input.buttons & arena_jump) != 0) out.hand_brake = 1_r;
    if (wish < 0.1_r) {
        out.brake = 0.15_r;
        return out;
    }
    const bool backwards = ahead < wish * -0.5_r;
    out.gear = backwards ? -1 : 1;
    const bool against = backwards ? speed > 1_r : speed < -1_r;
    (against ? out.brake : out.throttle) = wish;
    // The faster the car, the smaller the steering angle.
    const Real most = 1_r / (1_r + abs(speed) / 20_r);
    out.steer = clamp(left / wish * -1.5_r, -most, most);
    return out;
}

/// Drives straight on most of the time, then turns on the spot.
VehicleInput tank_round(std::uint64_t now) {
    VehicleInput out;
    out.throttle = 0.6_r;
    const std::uint64_t phase = now % 480;
    if (phase >= 300) {
        out.gear = 0;
        out.throttle = 1_r;
        out.steer = 0.7_r;
    }
    return out;
}

void set_input(Turn& turn, VehicleId vehicle, const VehicleInput& input) {
    if (turn.world.vehicle_input(vehicle) != input) turn.must(turn.world.set_vehicle_input(vehicle, input));
}

/// Lifts a car and turns it upright; the heading stays.
void help(Turn& turn, BodyId body) {
    World& world = turn.world;
    const Transform pose = world.pose(body);
    const UnitVec3 ahead = to_rotation(pose.rotation).z;
    const Quat upright = from_axis_angle(up, atan2(to<Real>(ahead.x), to<Real>(ahead.z)));
    turn.must(world.set_pose(body, at(pose.position + Vec3{0_r, 1_r, 0_r}, upright)));
    turn.must(world.set_velocity(body, {}, {}));
}

class Cars final : public Scene {
  public:
    using Scene::Scene;
    std::uint32_t input_size() const override { return input_size_of<ArenaInput>; }
    Controls controls(std::uint32_t) const override { return {"drive", "hand brake", "back on the wheels"}; }

    Result<World> start() const override {
        Shelf shelf;
        const Geometry hills = shelf.add(bake_hills());
        const auto assets = std::move(shelf).finish();
        if (!assets) return assets.error();
        GameSchema schema;
        const Column<Garage> column = schema.add_record<Garage>("game.garage");
        WorldDef def = world_for(crate_count + 2 * (car_count + 1), options.seed);
        def.vehicles_max = car_count + 1;
        Builder build(def, schema, *assets);
        Garage garage{};
        build_ground(build, hills);
        build_ramps(build);
        build_crates(build);
        build_vehicles(build, garage, options.players);
        build.record(column, garage);
        return std::move(build).finish();
    }

    void play(Turn& turn, std::span<const PlayerInput> inputs) const override {
        World& world = turn.world;
        const std::uint64_t now = world.tick_count();
        const Garage before = world.read(garage_column);
        Garage garage = before;
        for (std::uint32_t p = 0; p < inputs.size(); ++p) {
            const bool gone = inputs[p].status == InputStatus::disconnected;
            const ArenaInput input = gone ? ArenaInput{} : decode_input<ArenaInput>(inputs[p]);
            set_input(turn, garage.cars[p], drive(world, garage.bodies[p], input));
            if ((input.buttons & arena_push) == 0 || now < garage.help_ready[p]) continue;
            help(turn, garage.bodies[p]);
            garage.help_ready[p] = static_cast<std::uint32_t>(now) + help_pause;
        }
        set_input(turn, garage.tank, tank_round(now));
        if (garage != before) turn.must(world.write(garage_column, garage));
    }

    Status check(const World& world) const override {
        StateCheck found(world, "game.garage");
        const Garage& garage = world.read(garage_column);
        for (std::uint32_t p = 0; p < car_count; ++p)
            found.alive(garage.cars[p], "a car").dynamic(garage.bodies[p], "a car's body");
        return found.alive(garage.tank, "the tank").finish();
    }

    /// Holds a direction for a second, mostly at full speed.
    void script(std::uint64_t seed, std::uint64_t tick, std::uint32_t player,
                std::span<std::byte> input) const override {
        constexpr std::uint64_t hold = 60;
        Random held = Random::seeded(seed, 1 + player).split(tick / hold);
        const Real heading = held.range(-pi, pi);
        ArenaInput made;
        made.move_x = static_cast<std::int8_t>(floor_to_int(sin(heading) * 127));
        made.move_z = static_cast<std::int8_t>(floor_to_int(cos(heading) * 127));
        if (held.below(8) == 0) made.buttons |= arena_jump;
        if (tick % hold == 0 && held.below(16) == 0) made.buttons |= arena_push;
        const auto bytes = encode_input(made);
        std::copy(bytes.begin(), bytes.end(), input.begin());
    }
};

} // namespace

std::unique_ptr<Scene> make_cars(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<Cars>(info, options, 1);
}

} // namespace lockstone::scenes_detail
