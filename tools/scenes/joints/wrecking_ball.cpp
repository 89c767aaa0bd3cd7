// A ball on a chain swings into a wall; it has the mass of a thousand links and starts raised. The first player pulls
// it in the direction of the stick by a bounded force, slows it down, and rebuilds the wall. The other players roll
// about below.
#include "lockstone/math/math.h"
#include "scenes/balls.h"

namespace lockstone::scenes_detail {
namespace {

constexpr Real link_length = 0.3_r, link_radius = 0.06_r, link_mass = 2_r; ///< [m], [m], [kg]
constexpr Real load_radius = 0.8_r, load_mass = 1000_r * link_mass;        ///< of the ball on the chain
constexpr Real box_size = 0.8_r;                                           ///< [m]
constexpr Real raised = 1.1_r;      ///< angle of the chain to the vertical at the start [rad]
constexpr Real raised_most = 1.3_r; ///< largest angle that the player can swing it up to [rad]
constexpr std::uint32_t wall_columns = 9, wall_rows = 8, build_pause = 120; ///< build_pause in [ticks]
constexpr UnitVec3 axis_z{Unit{}, Unit{}, unit_one};

/// How far the player may swing the ball. Any further, and it would hit the mast, or the chain would become slack.
struct Reach {
    Real height;   ///< largest height of the ball's centre when it swings along x [m]
    Real aside;    ///< largest deflection when it swings along z [m]
    Real pendulum; ///< distance from the joint at the crane to the ball's centre [m]
};

/// Pulls the ball in the direction of the stick by at most a quarter of its weight, so that the player has to swing it
/// up.
void pull(Turn& turn, BodyId ball, ArenaInput input, const Reach& reach) {
    World& world = turn.world;
    constexpr Real acceleration = 2.5_r, gravity = 9.81_r; // [m/s^2]
    const Vec3 position = world.pose(ball).position, velocity = world.linear_velocity(ball);
    Vec3 wish{acceleration * Real(input.move_x) / 127_r, 0_r, acceleration * Real(input.move_z) / 127_r};
    // The height and the deflection that the ball still reaches with its current speed.
    const Real rise = half(dot<Real>(velocity, velocity)) / gravity;
    const Real drift = velocity.z * sqrt(reach.pendulum / gravity);
    if (wish.x * velocity.x > 0_r && position.y + rise > reach.height) wish.x = 0_r;
    if (wish.z * velocity.z > 0_r && position.z * position.z + drift * drift > reach.aside * reach.aside)
        wish.z = 0_r;
    turn.must(world.add_force(ball, wish * load_mass));
}

/// Brakes the ball by at most a quarter of its weight.
void slow_down(Turn& turn, BodyId ball) {
    World& world = turn.world;
    constexpr Real rate = 2_r, most = 2.5_r; // [1/s], [m/s^2]
    const Vec3 velocity = world.linear_velocity(ball);
    const auto along = [&](Real v) { return load_mass * clamp(-rate * v, -most, most); };
    turn.must(world.add_force(ball, {along(velocity.x), 0_r, along(velocity.z)}));
}

/// The place of the i-th box of the wall. Every other row is shifted by half a box.
Transform place_of_box(std::uint32_t i) {
    const std::uint32_t row = i / wall_columns;
    const Real shift = row % 2 == 0 ? 0_r : half(box_size);
    const Real z = box_size * (Real(i % wall_columns) - half(Real(wall_columns))) + shift;
    return at({1.6_r, box_size * (Real(row) + 0.5_r), z});
}

void build_wall_anew(Turn& turn) {
    World& world = turn.world;
    for (const BodyId body : world.bodies()) {
        const Look look = look_of(world.user_key(body));
        if (look.role != Role::prop) continue;
        turn.must(world.set_pose(body, place_of_box(look.number)));
        turn.must(world.set_velocity(body, {}, {}));
    }
}

class WreckingBall final : public BallScene {
  public:
    using BallScene::BallScene;

    Controls controls(std::uint32_t player) const override {
        return player == 0 ? Controls{"pull the ball", "slow it down", "rebuild the wall"} : ball_controls;
    }

    Result<World> start() const override {
        WorldDef def = world_for(options.size + 1 + wall_columns * wall_rows + options.players, options.seed);
        def.substeps = 16; // with 8 substeps a chain of 30 links parts by 7 cm under a jerk
        def.joints_max = options.size + 1;
        GameSchema schema;
        add_players(schema);
        Builder build(def, schema);
        build.ground();
        const Real height = pivot_height();
        Players players{};
        players.balls[0] = build_chain(build, build_crane(build, height), height);
        build_wall(build);
        build_players(build, players);
        return std::move(build).finish();
    }

  private:
    Real chain_length() const { return link_length * Real(options.size); }
    Real pivot_height() const { return chain_length() + load_radius + 1_r; }
    Reach reach() const {
        const Real pendulum = chain_length() + load_radius;
        return {pivot_height() - pendulum * cos(raised_most), min(2.5_r, half(pendulum)), pendulum};
    }
    Vec3 start_of(std::uint32_t player) const override {
        return {3_r * Real(player) - 6_r, ball_radius, 7_r};
    }
    /// Pushes do not move the chain and its ball: they are too heavy.
    bool is_loose(const Look& look) const override {
        return look.role == Role::prop || (look.role == Role::player && look.number != 0);
    }
    void play_one(Turn& turn, Players& players, std::uint32_t player, ArenaInput input) const override {
        if (player != 0) return BallScene::play_one(turn, players, player, input);
        const auto now = static_cast<std::uint32_t>(turn.world.tick_count());
        if (input.move_x != 0 || input.move_z != 0) pull(turn, players.balls[0], input, reach());
        if ((input.buttons & arena_jump) != 0) slow_down(turn, players.balls[0]);
        if ((input.buttons & arena_push) == 0 || now < players.push_ready[0]) return;
        build_wall_anew(turn);
        players.push_ready[0] = now + build_pause;
    }

    static BodyId build_crane(Builder& build, Real height) {
        const Real behind = -5_r; // the chain swings along x, past the mast
        const BodyId crane =
            build.body({.kind = BodyKind::static_, .user_key = user_key_of(Role::machine, 0)},
                       {.geometry = box(0.4_r, half(height) + 0.4_r, 0.4_r),
                        .local = at({0_r, half(height) + 0.4_r, behind})});
        build.shape(crane, {.geometry = box(0.3_r, 0.3_r, half(-behind)),
                            .local = at({0_r, height + 0.5_r, half(behind)})});
        return crane;
    }

    /// Returns the ball.
    BodyId build_chain(Builder& build, BodyId crane, Real height) const {
        const Quat tilt = from_axis_angle(axis_z, -raised); // y of a link points to the crane
        const Vec3 down = rotate(tilt, Vec3{0_r, -1_r, 0_r});
        Vec3 joint{0_r, height, 0_r};
        BodyId before = crane;
        for (std::uint32_t i = 0; i < options.size; ++i) {
            const BodyId link =
                build.body({.pose = at(joint + down * half(link_length), tilt),
                            .angular_damping = 0.2_r,
                            .mass = link_mass,
                            .user_key = user_key_of(Role::machine, i + 1)},
                           {.geometry = capsule(link_radius, half(link_length) - link_radius), .group = -1});
            build.joint(ball_joint(), before, link, at(joint));
            before = link;
            joint += down * link_length;
        }
        const BodyId ball = build.body({.pose = at(joint + down * load_radius, tilt),
                                        .mass = load_mass,
                                        .bullet = 1,
                                        .user_key = user_key_of(Role::player, 0)},
                                       {.geometry = sphere(load_radius), .group = -1});
        build.joint(ball_joint(), before, ball, at(joint));
        return ball;
    }

    /// Boxes of 0.8 m in front of the lowest point of the swing.
    static void build_wall(Builder& build) {
        for (std::uint32_t i = 0; i < wall_columns * wall_rows; ++i)
            build.body({.pose = place_of_box(i), .user_key = user_key_of(Role::prop, i)},
                       {.geometry = box(half(box_size), half(box_size), half(box_size)), .density = 200_r});
    }
};

} // namespace

std::unique_ptr<Scene> make_wrecking_ball(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<WreckingBall>(info, options, 1);
}

} // namespace lockstone::scenes_detail
