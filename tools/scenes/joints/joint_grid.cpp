// A grid with one station for every kind of joint. Motors and pushes drive the joints forever. Players' balls roll
// below them and reach them by jumps and pushes.
#include "lockstone/math/math.h"
#include "scenes/balls.h"

#include <array>

namespace lockstone::scenes_detail {
namespace {

constexpr std::uint32_t columns = 5, station_count = 20, bodies_max = 48, joints_max = 40;
constexpr Real spacing = 4.5_r, height = 3_r; ///< of the grid; of a station's joint above the ground [m]
constexpr std::uint32_t push_period = 150, break_period = 600; ///< [ticks]
constexpr UnitVec3 axis_x{unit_one, Unit{}, Unit{}}, axis_y{Unit{}, unit_one, Unit{}},
    axis_z{Unit{}, Unit{}, unit_one};

/// The stations in the order of the grid. A joint's user_key is its station; a body's is that plus a multiple of
/// station_count.
enum Station : std::uint32_t {
    ball_cone,
    hinge_motor,
    hinge_limits,
    hinge_spring,
    hinge_friction,
    slider_motor,
    slider_spring,
    weld,
    weld_soft,
    six_dof_planar,
    wheel,
    motor,
    mouse,
    distance,
    rope,
    spring,
    pulley,
    gear,
    rack,
    breaking,
};

/// The bodies and joints that the rules act on.
struct Cast {
    std::array<BodyId, station_count> body;
    std::array<JointId, station_count> joint;
};
template <class V> constexpr void describe(Cast& c, V&& v) { v("body", c.body), v("joint", c.joint); }
constexpr Column<Cast> cast_record{0};

Vec3 place_of(std::uint32_t station) {
    return {spacing * (Real(station % columns) - 2_r), height, spacing * (Real(station / columns) - 1.5_r)};
}

JointDef brittle_weld() {
    JointDef def = weld_joint();
    def.break_torque = 400_r;
    def.user_key = breaking;
    return def;
}

// ---- the stations ---------------------------------------------------------------------------------------------

struct Grid {
    Builder& build;
    Cast cast{};
    std::array<std::uint32_t, station_count> count{}; ///< number of bodies of each station

    BodyId body(std::uint32_t station, Vec3 offset, const Geometry& geometry,
                Quat rotation = Quat::identity()) {
        const std::uint32_t key = station + station_count * count[station]++;
        const BodyId made = build.body(
            {.pose = at(place_of(station) + offset, rotation), .user_key = user_key_of(Role::prop, key)},
            {.geometry = geometry, .density = 200_r});
        if (!cast.body[station]) cast.body[station] = made;
        return made;
    }
    JointId join(std::uint32_t station, JointDef def, BodyId a, BodyId b, Vec3 offset,
                 Quat rotation = Quat::identity()) {
        def.user_key = station;
        const JointId made = build.joint(def, a, b, at(place_of(station) + offset, rotation));
        if (!cast.joint[station]) cast.joint[station] = made;
        return made;
    }
    /// A bar that hangs down or sticks out from a joint between the station and the world.
    void bar(std::uint32_t station, const JointDef& def, Vec3 offset, Quat rotation = Quat::identity()) {
        const Geometry shape = offset.x == 0_r ? box(0.12_r, 0.7_r, 0.12_r) : box(0.7_r, 0.12_r, 0.12_r);
        join(station, def, BodyId{}, body(station, offset, shape), {}, rotation);
    }
    void block(std::uint32_t station, JointDef def) {
        join(station, def, BodyId{}, body(station, {}, box(0.3_r, 0.3_r, 0.3_r)), {});
    }
    /// A ball that hangs on a joint of 1.5 m length.
    void hang(std::uint32_t station, const JointDef& def) {
        const BodyId made = body(station, {0_r, -1.5_r, 0_r}, sphere(0.35_r));
        JointDef line = def;
        line.frame_a.position = place_of(station);
        line.body_b = made, line.user_key = station;
        cast.joint[station] = build.joint(line);
    }

    void hinges();
    void others();
    void lines();
    void machines();
};

constexpr Vec3 below{0_r, -0.7_r, 0_r}, beside{0.7_r, 0_r, 0_r};
/// A rotation that turns the x axis of the joint's frame to the z axis of the world.
Quat across() { return from_axis_angle(axis_y, -half_pi); }

void Grid::hinges() {
    JointDef cone = ball_joint();
    cone.swing = 0.6_r;
    cone.axis[about_x].mode = AxisMode::limited, cone.axis[about_x].lower = -0.5_r,
    cone.axis[about_x].upper = 0.5_r;
    bar(ball_cone, cone, below, from_axis_angle(axis_z, -half_pi));
    JointDef turning = hinge_joint();
    turning.axis[about_x].motor_speed = 3_r, turning.axis[about_x].motor_force = 200_r;
    bar(hinge_motor, turning, below, across());
    JointDef limited = hinge_joint();
    limited.axis[about_x].mode = AxisMode::limited, limited.axis[about_x].lower = -0.4_r,
    limited.axis[about_x].upper = 1_r;
    bar(hinge_limits, limited, below, across());
    JointDef sprung = hinge_joint();
    sprung.axis[about_x].spring = 1, sprung.axis[about_x].frequency = 1.5_r,
    sprung.axis[about_x].damping_ratio = 0.05_r;
    bar(hinge_spring, sprung, beside, across());
    JointDef braked = hinge_joint();
    braked.axis[about_x].friction = 8_r;
    bar(hinge_friction, braked, below, across());
}

void Grid::others() {
    JointDef driven = slider_joint();
    driven.axis[along_x] = {
        .mode = AxisMode::limited, .lower = -1_r, .upper = 1_r, .motor_speed = 1.5_r, .motor_force = 500_r};
    block(slider_motor, driven);
    JointDef sprung = slider_joint();
    sprung.axis[along_x] = {.mode = AxisMode::limited,
                            .spring = 1,
                            .lower = -1_r,
                            .upper = 1_r,
                            .frequency = 1_r,
                            .damping_ratio = 0.05_r};
    block(slider_spring, sprung);
    bar(weld, weld_joint(), beside);
    bar(weld_soft, weld_joint(2_r, 0.1_r), beside);
    JointDef planar = six_dof_joint();
    for (const std::uint32_t i : {along_z, about_x, about_y}) planar.axis[i].mode = AxisMode::locked;
    for (const std::uint32_t i : {along_x, along_y, about_z})
        planar.axis[i].spring = 1, planar.axis[i].frequency = i == about_z ? 2_r : 1_r,
        planar.axis[i].damping_ratio = 0.05_r;
    block(six_dof_planar, planar);
    JointDef rolling = wheel_joint(2_r, 0.2_r);
    rolling.axis[about_x].motor_speed = 6_r, rolling.axis[about_x].motor_force = 50_r;
    const BodyId tyre = body(wheel, {}, cylinder(0.6_r, 0.15_r), from_axis_angle(axis_x, half_pi));
    join(wheel, rolling, BodyId{}, tyre, {}, across());
    block(motor, motor_joint(1.5_r, 3000_r, 500_r));
    block(mouse, mouse_joint(1.5_r, 3000_r));
}

void Grid::lines() {
    hang(distance, distance_joint(1.5_r));
    hang(rope, rope_joint(1.5_r));
    hang(spring, spring_joint(1.5_r, 1_r, 0.02_r));
    const Vec3 left{-0.7_r, -1.2_r, 0_r}, right{0.7_r, -1.2_r, 0_r};
    const BodyId a = body(pulley, left, box(0.3_r, 0.3_r, 0.3_r)),
                 b = body(pulley, right, box(0.32_r, 0.3_r, 0.3_r));
    const Vec3 over = place_of(pulley);
    JointDef rope_over = pulley_joint(over + Vec3{-0.7_r, 0_r, 0_r}, over + Vec3{0.7_r, 0_r, 0_r}, 2.4_r);
    rope_over.body_a = a, rope_over.body_b = b, rope_over.user_key = pulley;
    cast.joint[pulley] = build.joint(rope_over);
}

void Grid::machines() {
    const Quat lying = from_axis_angle(axis_x, half_pi);
    const auto cog = [&](std::uint32_t station, Vec3 offset, Real radius, Real speed) {
        JointDef axle = hinge_joint();
        if (speed != 0_r) axle.axis[about_x].motor_speed = speed, axle.axis[about_x].motor_force = 300_r;
        const BodyId made = body(station, offset, cylinder(radius, 0.12_r), lying);
        join(station, axle, BodyId{}, made, offset, across());
        return made;
    };
    const BodyId driver = cog(gear, {-0.4_r, 0_r, 0_r}, 0.4_r, 4_r),
                 driven = cog(gear, {0.82_r, 0_r, 0_r}, 0.8_r, 0_r);
    join(gear, gear_joint(2_r), driver, driven, {}, across());
    const BodyId pinion = cog(rack, {0_r, 0.4_r, 0_r}, 0.35_r, 1_r);
    const BodyId teeth_bar = body(rack, {0_r, -0.1_r, 0_r}, box(1_r, 0.1_r, 0.12_r));
    join(rack, slider_joint(), BodyId{}, teeth_bar, {0_r, -0.1_r, 0_r});
    JointDef teeth = rack_and_pinion_joint(1_r / 0.35_r);
    teeth.body_a = pinion, teeth.body_b = teeth_bar, teeth.user_key = rack;
    teeth.frame_a.rotation = conjugate(lying) * across();
    build.joint(teeth);
    bar(breaking, brittle_weld(), beside);
}

// ---- the rules ------------------------------------------------------------------------------------------------

/// +1 and -1 in alternate periods.
Real sign_of(std::uint64_t period) { return period % 2 == 0 ? 1_r : -1_r; }

void push_all(Turn& turn, const Cast& cast, std::uint64_t period) {
    for (const Station station : {ball_cone, hinge_limits, hinge_spring, hinge_friction, slider_spring, weld,
                                  weld_soft, six_dof_planar, wheel, distance, rope, spring, pulley}) {
        const Real strength = turn.world.mass(cast.body[station]) * sign_of(period);
        turn.must(turn.world.add_impulse(cast.body[station], Vec3{2.5_r, 1.5_r, 0.8_r} * strength));
    }
}

/// True if the station's joint exists; otherwise the rules fail, since they need it.
bool has_joint(Turn& turn, JointId joint) {
    const bool lives = turn.world.is_alive(joint);
    if (!lives) turn.must(Error{"a joint of the grid broke that must hold"});
    return lives;
}

void turn_back(Turn& turn, JointId joint, JointAxisIndex index) {
    if (!has_joint(turn, joint)) return;
    World& world = turn.world;
    JointAxis axis = world.joint(joint).axis[index];
    axis.motor_speed = -axis.motor_speed;
    turn.must(world.set_joint_axis(joint, index, axis));
}

void move_targets(Turn& turn, const Cast& cast, std::uint64_t period) {
    if (!has_joint(turn, cast.joint[motor])) return;
    World& world = turn.world;
    for (const JointAxisIndex index : {along_y, about_y}) {
        JointAxis axis = world.joint(cast.joint[motor]).axis[index];
        axis.target = 0.7_r * sign_of(period);
        turn.must(world.set_joint_axis(cast.joint[motor], index, axis));
    }
    const Real angle = half_pi * Real(period % 4);
    const Vec3 to = place_of(mouse) + Vec3{cos(angle), sin(angle), 0_r};
    turn.must(world.set_joint_frames(cast.joint[mouse], at(to), Transform::identity()));
}

/// An impulse breaks the joint; later the rules create it again.
void break_and_mend(Turn& turn, Cast& cast, std::uint64_t now) {
    World& world = turn.world;
    const BodyId bar = cast.body[breaking];
    if (now % break_period == break_period / 2)
        turn.must(world.add_impulse(bar, {0_r, -3_r * world.mass(bar), 0_r}));
    if (now % break_period != 0 || world.is_alive(cast.joint[breaking])) return;
    turn.must(world.set_pose(bar, at(place_of(breaking) + beside)));
    turn.must(world.set_velocity(bar, {}, {}));
    const Result<JointId> joint = world.create_joint(brittle_weld(), BodyId{}, bar, at(place_of(breaking)));
    if (!joint) return turn.must(joint.error());
    cast.joint[breaking] = *joint;
    turn.must(world.write(cast_record, cast));
}

class JointGrid final : public BallScene {
  public:
    using BallScene::BallScene;

    Result<World> start() const override {
        GameSchema schema;
        schema.add_record<Cast>("game.cast");
        add_players(schema);
        WorldDef def = world_for(bodies_max + options.players, options.seed);
        def.substeps = WorldDef::precise().substeps; // for long chains
        def.shapes_max += station_count;
        def.joints_max = joints_max;
        Builder build(def, schema);
        build.ground();
        build_posts(build);
        Grid grid{build};
        grid.hinges();
        grid.others();
        grid.lines();
        grid.machines();
        build.record(cast_record, grid.cast);
        build_players(build);
        return std::move(build).finish();
    }

    Status check(const World& world) const override {
        StateCheck found(world, "game.cast");
        for (const BodyId body : world.read(cast_record).body) found.dynamic(body, "a station's body");
        if (Status s = found.finish(); !s) return s;
        return BallScene::check(world);
    }

  protected:
    void play(Turn& turn, std::span<const PlayerInput> inputs) const override {
        World& world = turn.world;
        const std::uint64_t now = world.tick_count(), period = now / push_period;
        Cast cast = world.read(cast_record);
        if (now % push_period == 0) {
            push_all(turn, cast, period);
            move_targets(turn, cast, period);
            if (period != 0) turn_back(turn, cast.joint[slider_motor], along_x);
            if (period != 0) turn_back(turn, cast.joint[rack], about_x);
        }
        break_and_mend(turn, cast, now);
        BallScene::play(turn, inputs);
    }

  private:
    Column<Players> column() const override { return {1}; } // after the cast
    Vec3 start_of(std::uint32_t player) const override {
        return {spacing * (Real(player) - 1.5_r), ball_radius, spacing * 2.5_r};
    }

    /// One post behind each station.
    static void build_posts(Builder& build) {
        BodyId posts{};
        for (std::uint32_t i = 0; i < station_count; ++i) {
            const Vec3 place = place_of(i);
            const ShapeDef post{.geometry = box(0.06_r, half(height), 0.06_r),
                                .local = at({place.x, half(height), place.z - 1.2_r})};
            if (posts)
                build.shape(posts, post);
            else
                posts = build.body({.kind = BodyKind::static_, .user_key = user_key_of(Role::wall, 0)}, post);
        }
    }
};

} // namespace

std::unique_ptr<Scene> make_joint_grid(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<JointGrid>(info, options, 1);
}

} // namespace lockstone::scenes_detail
