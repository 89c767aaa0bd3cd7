#include "scenes/balls.h"

#include "lockstone/math/math.h"
#include "lockstone/math/random.h"

#include <algorithm>

namespace lockstone::scenes_detail {

BodyId build_ball(Builder& build, std::uint32_t player, Vec3 position) {
    return build.body({.pose = at(position),
                       .angular_damping = 0.5_r,
                       .mass = ball_mass,
                       .user_key = user_key_of(Role::player, player)},
                      {.geometry = sphere(ball_radius), .friction = 0.8_r, .restitution = 0.3_r});
}

void roll(Turn& turn, BodyId ball, ArenaInput input) {
    World& world = turn.world;
    constexpr Real acceleration = 25_r, drag = 2_r; // [m/s^2], [1/s]; the top speed is 12.5 m/s
    const Vec3 velocity = world.linear_velocity(ball);
    const auto along = [&](std::int8_t move, Real v) {
        return ball_mass * (acceleration * Real(move) / 127_r - drag * v);
    };
    turn.must(world.add_force(ball, {along(input.move_x, velocity.x), 0_r, along(input.move_z, velocity.z)}));
}

void leap(Turn& turn, BodyId ball) {
    constexpr Real speed = 6_r;
    turn.must(turn.world.add_impulse(ball, {0_r, ball_mass * speed, 0_r}));
}

void throw_away(Turn& turn, Vec3 from, BodyId body) {
    World& world = turn.world;
    constexpr Real range = 4_r, speed = 9_r;
    const Vec3 away = world.pose(body).position - from;
    const Real distance = length(away);
    if (distance >= range) return;
    const Real strength = world.mass(body) * speed * (1_r - distance / range);
    const Vec3 direction = to<Real>(normalized(away)) + Vec3{0_r, 0.4_r, 0_r};
    turn.must(world.add_impulse(body, direction * strength));
}

ArenaInput wander(std::uint64_t seed, std::uint64_t tick, std::uint32_t player) {
    constexpr std::uint64_t hold = 20;
    Random held = Random::seeded(seed, 1 + player).split(tick / hold);
    ArenaInput made;
    made.move_x = static_cast<std::int8_t>(held.range(-127, 127));
    made.move_z = static_cast<std::int8_t>(held.range(-127, 127));
    const bool at_start = tick % hold == 0;
    if (at_start && held.below(3) == 0) made.buttons |= arena_jump;
    if (at_start && held.below(3) == 0) made.buttons |= arena_push;
    return made;
}

// ---- scenes that balls may enter ------------------------------------------------------------------------------

void BallScene::script(std::uint64_t seed, std::uint64_t tick, std::uint32_t player,
                       std::span<std::byte> input) const {
    if (input.empty()) return;
    const auto bytes = encode_input(wander(seed, tick, player));
    std::copy(bytes.begin(), bytes.end(), input.begin());
}

void BallScene::add_players(GameSchema& schema) const {
    if (options.players != 0) schema.add_record<Players>("game.players");
}

void BallScene::build_players(Builder& build, Players players) const {
    if (options.players == 0) return;
    for (std::uint32_t p = 0; p < options.players; ++p)
        if (!players.balls[p]) players.balls[p] = build_ball(build, p, start_of(p));
    build.record(column(), players);
}

Status BallScene::check(const World& world) const {
    StateCheck found(world, "game.players");
    if (options.players == 0) return {};
    const Players players = world.read(column());
    for (std::uint32_t p = 0; p < options.players; ++p) found.dynamic(players.balls[p], "a player's ball");
    return found.finish();
}

void BallScene::play(Turn& turn, std::span<const PlayerInput> inputs) const {
    if (inputs.empty()) return;
    World& world = turn.world;
    const Players before = world.read(column());
    Players players = before;
    for (std::uint32_t p = 0; p < inputs.size(); ++p)
        if (inputs[p].status != InputStatus::disconnected)
            play_one(turn, players, p, decode_input<ArenaInput>(inputs[p]));
    if (players != before) turn.must(world.write(column(), players));
}

/// True if a body or the ground is close below the ball, however steep it is.
static bool is_grounded(const World& world, BodyId ball) {
    constexpr Real probe_radius = 0.5_r, reach = 0.2_r;
    return world.cast_shape_any(sphere(probe_radius), world.pose(ball), {0_r, -reach, 0_r}, {.ignore = ball});
}

/// True if the ball is slow and its player presses no direction. The rules then apply no force, which would keep the
/// ball awake.
static bool is_at_rest(const World& world, BodyId ball, ArenaInput input) {
    constexpr Real slow = 0.05_r; // [m/s]
    return input.move_x == 0 && input.move_z == 0 && length(world.linear_velocity(ball)) < slow;
}

void BallScene::play_one(Turn& turn, Players& players, std::uint32_t player, ArenaInput input) const {
    World& world = turn.world;
    const auto now = static_cast<std::uint32_t>(world.tick_count());
    const BodyId ball = players.balls[player];
    if (is_out(world.pose(ball).position)) {
        turn.must(world.set_pose(ball, at(start_of(player))));
        turn.must(world.set_velocity(ball, {}, {}));
    }
    if (!is_at_rest(world, ball, input)) roll(turn, ball, input);
    if ((input.buttons & arena_jump) != 0 && now >= players.jump_ready[player] && is_grounded(world, ball)) {
        leap(turn, ball);
        players.jump_ready[player] = now + jump_pause;
    }
    if ((input.buttons & arena_push) != 0 && now >= players.push_ready[player]) {
        push(turn, ball);
        players.push_ready[player] = now + push_pause;
    }
}

void BallScene::push(Turn& turn, BodyId ball) const {
    World& world = turn.world;
    const Vec3 from = world.pose(ball).position;
    for (const BodyId body : world.bodies())
        if (body != ball && world.kind(body) == BodyKind::dynamic && is_loose(look_of(world.user_key(body))))
            throw_away(turn, from, body);
}

} // namespace lockstone::scenes_detail
