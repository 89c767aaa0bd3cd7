// 72 bodies: the arena, 64 mixed props, four balls (the players drive the first two to four), a sweeper and two
// pillars. Players roll, jump and push. A player who touches a prop owns it. One player is "it" until he tags another.
// Every two seconds a geyser throws a prop. Scores, owners, cooldowns and the random stream are ordinary game state.
#include "lockstone/math/random.h"
#include "scenes/balls.h"

#include <algorithm>
#include <array>

namespace lockstone::scenes_detail {
namespace {

constexpr std::uint32_t ball_count = players_max, prop_count = 64, props_per_row = 8;
constexpr std::uint32_t tag_pause = 60, geyser_period = 120; ///< [ticks]
constexpr Real reach = 0.5_r;                                ///< [m] beyond the ball's surface

struct Match {
    std::array<std::uint32_t, ball_count> score;      ///< props owned, and tags made
    std::array<std::uint32_t, ball_count> jump_ready; ///< the first tick at which the player may jump again
    std::array<std::uint32_t, ball_count> push_ready;
    std::uint32_t tag_ready;
    std::uint32_t it; ///< index of the player who must tag another
    Random random;
    friend bool operator==(const Match&, const Match&) = default;
};
template <class V> constexpr void describe(Match& m, V&& v) {
    v("score", m.score), v("jump_ready", m.jump_ready), v("push_ready", m.push_ready);
    v("tag_ready", m.tag_ready), v("it", m.it), v("random", m.random.state);
}

struct Cast {
    std::array<BodyId, ball_count> balls;
    std::array<BodyId, prop_count> props;
};
template <class V> constexpr void describe(Cast& c, V&& v) { v("balls", c.balls), v("props", c.props); }

/// The claim on a prop: the player who touched it last, and the number of times that its owner changed.
struct Claim {
    std::uint32_t owner; ///< player + 1; 0: no owner
    std::uint32_t changes;
};
template <class V> constexpr void describe(Claim& c, V&& v) { v("owner", c.owner), v("changes", c.changes); }

struct Columns {
    Column<Match> match;
    Column<Cast> cast;
    Column<Claim> claim;
};
Columns add_columns(GameSchema& schema) {
    return {schema.add_record<Match>("game.match"), schema.add_record<Cast>("game.cast"),
            schema.add_body_column<Claim>("game.claim")};
}
constexpr Columns columns{{0}, {1}, {2}}; ///< in the order in which add_columns adds them

// ---- the start ------------------------------------------------------------------------------------------------

void build_arena(Builder& build) {
    constexpr Real half_side = 12_r, height = 1.5_r, thickness = 0.5_r;
    const BodyId arena = build.ground();
    for (const Real side : {-1_r, 1_r}) {
        const Real offset = side * (half_side + thickness);
        build.shape(
            arena, {.geometry = box(thickness, height, half_side + 1_r), .local = at({offset, height, 0_r})});
        build.shape(arena,
                    {.geometry = box(half_side, height, thickness), .local = at({0_r, height, offset})});
    }
}

void build_balls(Builder& build, Cast& cast) {
    constexpr std::array<std::array<Real, 2>, ball_count> corners{
        {{-10_r, -10_r}, {10_r, 10_r}, {10_r, -10_r}, {-10_r, 10_r}}};
    for (std::uint32_t p = 0; p < ball_count; ++p)
        cast.balls[p] = build_ball(build, p, {corners[p][0], ball_radius, corners[p][1]});
}

void build_props(Builder& build, Cast& cast, Random& random) {
    const std::array<Geometry, 3> geometries{sphere(0.35_r), box(0.4_r, 0.4_r, 0.4_r), capsule(0.3_r, 0.3_r)};
    constexpr UnitVec3 up{Unit{}, unit_one, Unit{}};
    for (std::uint32_t i = 0; i < prop_count; ++i) {
        const Real x = Real(i % props_per_row) * 2 - 7_r, z = Real(i / props_per_row) * 2 - 7_r;
        const Real turn = random.range(-pi, pi);
        cast.props[i] = build.body(
            {.pose = at({x, 0.8_r, z}, from_axis_angle(up, turn)),
             .linear_damping = 0.05_r,
             .angular_damping = 0.2_r,
             .user_key = user_key_of(Role::prop, i)},
            {.geometry = geometries[i % geometries.size()], .density = 60_r, .restitution = 0.2_r});
    }
}

void build_machines(Builder& build) {
    build.body({.kind = BodyKind::kinematic,
                .pose = at({0_r, 0.45_r, 0_r}),
                .angular_velocity = {0_r, 0.5_r, 0_r},
                .user_key = user_key_of(Role::machine, 0)},
               {.geometry = box(4_r, 0.25_r, 0.2_r), .friction = 0.3_r});
    for (std::uint32_t i = 0; i < 2; ++i)
        build.body({.kind = BodyKind::static_,
                    .pose = at({i == 0 ? -10_r : 10_r, 1.5_r, 0_r}),
                    .user_key = user_key_of(Role::wall, i)},
                   {.geometry = box(0.6_r, 1.5_r, 0.6_r)});
}

// ---- the rules ------------------------------------------------------------------------------------------------

/// True if the distance of two centres is below `limit`, which is at most 100 m.
bool within(Vec3 a, Vec3 b, Real limit) {
    const Vec3 apart = a - b;
    if (abs(apart.x) >= limit || abs(apart.z) >= limit) return false; // true for most pairs
    return length_squared(apart) < limit * limit;
}

/// Jumps only from the floor.
void jump(Turn& turn, BodyId ball) {
    constexpr Real floor_gap = 0.1_r;
    if (turn.world.pose(ball).position.y <= ball_radius + floor_gap) leap(turn, ball);
}

/// Throws the props around the ball away from it.
void push(Turn& turn, const Cast& cast, BodyId ball) {
    const Vec3 from = turn.world.pose(ball).position;
    for (const BodyId prop : cast.props) throw_away(turn, from, prop);
}

/// The positions of the props, read once for all players. A push applies a velocity, so it changes positions only in
/// the next tick.
using Places = std::array<Vec3, prop_count>;

void capture(Turn& turn, const Cast& cast, const Places& places, Match& match, std::uint32_t player) {
    World& world = turn.world;
    const Vec3 at_ball = world.pose(cast.balls[player]).position;
    for (std::size_t i = 0; i < places.size(); ++i) {
        if (!within(at_ball, places[i], ball_radius + reach)) continue;
        const BodyId prop = cast.props[i];
        const Claim claim = world.read(columns.claim, prop);
        if (claim.owner == player + 1) continue;
        if (claim.owner != 0) --match.score[claim.owner - 1];
        ++match.score[player];
        turn.must(world.write(columns.claim, prop, Claim{player + 1, claim.changes + 1}));
    }
}

void tag(const World& world, const Cast& cast, Match& match, std::uint32_t player, std::uint32_t now) {
    if (player == match.it || now < match.tag_ready) return;
    const Vec3 a = world.pose(cast.balls[match.it]).position, b = world.pose(cast.balls[player]).position;
    if (!within(a, b, ball_radius * 2 + 0.1_r)) return;
    match.score[match.it] += 3;
    match.it = player;
    match.tag_ready = now + tag_pause;
}

void geyser(Turn& turn, const Cast& cast, Match& match) {
    World& world = turn.world;
    const BodyId prop = cast.props[match.random.below(prop_count)];
    const Real speed = match.random.range(5_r, 9_r);
    turn.must(world.add_impulse(prop, {0_r, world.mass(prop) * speed, 0_r}));
}

class RollbackArena final : public Scene {
  public:
    using Scene::Scene;
    std::uint32_t input_size() const override { return input_size_of<ArenaInput>; }
    Controls controls(std::uint32_t) const override { return ball_controls; }

    Result<World> start() const override {
        GameSchema schema;
        const Columns made = add_columns(schema);
        WorldDef def = world_for(prop_count + ball_count, options.seed);
        // The number of bodies never changes, so the tables have exactly this capacity: full tables are saved in one
        // copy.
        def.bodies_max = prop_count + ball_count + 4;
        def.shapes_max = def.bodies_max + 4;
        Builder build(def, schema);
        Match match{};
        match.random = Random::seeded(options.seed);
        Cast cast{};
        build_arena(build);
        build_balls(build, cast);
        build_props(build, cast, match.random);
        build_machines(build);
        build.record(made.match, match);
        build.record(made.cast, cast);
        return std::move(build).finish();
    }

    void play(Turn& turn, std::span<const PlayerInput> inputs) const override {
        World& world = turn.world;
        const auto now = static_cast<std::uint32_t>(world.tick_count());
        const Cast cast = world.read(columns.cast);
        const Match before = world.read(columns.match);
        Match match = before;
        Places places;
        for (std::size_t i = 0; i < places.size(); ++i) places[i] = world.pose(cast.props[i]).position;
        for (std::uint32_t p = 0; p < inputs.size(); ++p) {
            if (inputs[p].status == InputStatus::disconnected) continue;
            play_one(turn, cast, places, match, p, decode_input<ArenaInput>(inputs[p]), now);
        }
        if (now % geyser_period == geyser_period - 1) geyser(turn, cast, match);
        if (match != before) turn.must(world.write(columns.match, match));
    }

    Status check(const World& world) const override {
        StateCheck found(world, "game.cast, game.match or game.claim");
        const Cast& cast = world.read(columns.cast);
        const Match& match = world.read(columns.match);
        for (const BodyId ball : cast.balls) found.dynamic(ball, "a ball");
        for (const BodyId prop : cast.props) found.dynamic(prop, "a prop");
        found.holds(match.it < ball_count, "it", "is no player");
        for (const BodyId body : world.bodies())
            found.holds(world.read(columns.claim, body).owner <= ball_count, "owner", "is no player");
        return found.finish();
    }

    void script(std::uint64_t seed, std::uint64_t tick, std::uint32_t player,
                std::span<std::byte> input) const override {
        const auto bytes = encode_input(wander(seed, tick, player));
        std::copy(bytes.begin(), bytes.end(), input.begin());
    }

  private:
    static void play_one(Turn& turn, const Cast& cast, const Places& places, Match& match, std::uint32_t p,
                         ArenaInput input, std::uint32_t now) {
        const BodyId ball = cast.balls[p];
        roll(turn, ball, input);
        if ((input.buttons & arena_jump) != 0 && now >= match.jump_ready[p]) {
            jump(turn, ball);
            match.jump_ready[p] = now + jump_pause;
        }
        if ((input.buttons & arena_push) != 0 && now >= match.push_ready[p]) {
            push(turn, cast, ball);
            match.push_ready[p] = now + push_pause;
        }
        capture(turn, cast, places, match, p);
        tag(turn.world, cast, match, p, now);
    }
};

} // namespace

std::unique_ptr<Scene> make_rollback_arena(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<RollbackArena>(info, options, 1);
}

} // namespace lockstone::scenes_detail
