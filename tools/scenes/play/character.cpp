// An obstacle course in a circle for one to four characters: stairs and a ramp, crates, a tunnel for crouching, a
// turning disc, a platform that moves to and fro, a lift, rocks, a seesaw, a shelf that characters jump onto from
// below.
#include "lockstone/math/math.h"
#include "scenes/scene.h"

#include <algorithm>
#include <array>

namespace lockstone::scenes_detail {
namespace {

constexpr std::uint32_t players_max = 4, crate_count = 9;
constexpr Real track = 9.5_r;             ///< [m]: radius of the middle of the course
constexpr Real inner = 6_r, outer = 13_r; ///< [m]: inner and outer radius of the walled course
constexpr Real speed = 4_r;               ///< [m/s]
constexpr std::uint32_t shuttle_ticks = 240;
constexpr std::int32_t round_ticks = 900;
constexpr UnitVec3 axis_y{Unit{}, unit_one, Unit{}}, axis_z{Unit{}, Unit{}, unit_one};

struct Cast {
    std::array<CharacterId, players_max> characters;
    BodyId shuttle, lift;
};
template <class V> constexpr void describe(Cast& c, V&& v) {
    v("characters", c.characters), v("shuttle", c.shuttle), v("lift", c.lift);
}
constexpr Column<Cast> cast_column{0}; ///< the only column

Real radians(std::int32_t degrees) { return pi * degrees / 180_r; }

/// A place on the course: its x axis points forwards, its y axis up, its z axis inwards.
Transform station(std::int32_t degrees) {
    const Real a = radians(degrees);
    return {{track * cos(a), 0_r, track * sin(a)}, from_axis_angle(axis_y, -a - half_pi)};
}

struct Course {
    Builder& build;
    std::uint32_t walls = 0, machines = 0, props = 0;

    void block(const Transform& from, Vec3 place, Vec3 half_extent, Quat turn = Quat::identity(),
               std::uint32_t one_way = 0) {
        build.body({.kind = BodyKind::static_,
                    .pose = from * Transform{place, turn},
                    .user_key = user_key_of(Role::wall, walls++)},
                   {.geometry = box(half_extent), .one_way = one_way});
    }
    BodyId machine(const Transform& pose, const Geometry& shape, Vec3 spin = {}) {
        return build.body({.kind = BodyKind::kinematic,
                           .pose = pose,
                           .angular_velocity = spin,
                           .user_key = user_key_of(Role::machine, machines++)},
                          {.geometry = shape});
    }

    void walls_around() {
        constexpr std::int32_t sides = 24;
        const Real width = outer * half(two_pi / Real(sides)) + 0.1_r;
        for (std::int32_t i = 0; i < sides; ++i) {
            const Real a = two_pi * i / Real(sides);
            block({{outer * cos(a), 0_r, outer * sin(a)}, from_axis_angle(axis_y, -a - half_pi)},
                  {0_r, 1_r, 0.15_r}, {width, 1_r, 0.15_r});
        }
        build.body({.kind = BodyKind::static_,
                    .pose = at({0_r, 1_r, 0_r}),
                    .user_key = user_key_of(Role::wall, walls++)},
                   {.geometry = cylinder(inner, 1_r)});
    }
    void stairs_and_ramp() {
        const Transform from = station(30);
        constexpr Real rise = 0.2_r, depth = 0.3_r, width = 1.6_r, top = 1.2_r;
        for (std::int32_t i = 0; i < 6; ++i)
            block(from, {depth * i, half(rise * (i + 1)), 0_r}, {half(depth), half(rise * (i + 1)), width});
        block(from, {2.7_r, half(top), 0_r}, {1.05_r, half(top), width});
        // The ramp goes down from 3.75 m at 25 degrees.
        const Real angle = radians(25), length = top / sin(angle);
        block(from,
              {3.75_r + half(length * cos(angle)) - 0.1_r * sin(angle), half(top) - 0.1_r * cos(angle), 0_r},
              {half(length), 0.1_r, width}, from_axis_angle(axis_z, -angle));
    }
    void crates() {
        const Transform from = station(95);
        for (std::uint32_t i = 0; i < crate_count; ++i) {
            const auto column = static_cast<std::int32_t>(i % 3), layer = static_cast<std::int32_t>(i / 3);
            build.body({.pose = from * at({0_r, 0.35_r + 0.7_r * layer, 0.9_r * (column - 1)}),
                        .user_key = user_key_of(Role::prop, props++)},
                       {.geometry = box(0.35_r, 0.35_r, 0.35_r), .density = 60_r, .friction = 0.4_r});
        }
    }
    void tunnel() {
        const Transform from = station(135);
        for (const Real side : {-1_r, 1_r}) block(from, {0_r, 0.6_r, side * 1.5_r}, {1.5_r, 0.6_r, 0.2_r});
        block(from, {0_r, 1.4_r, 0_r}, {1.5_r, 0.15_r, 1.7_r}); // its underside is at 1.25 m
    }
    void disc() { machine(station(175) * at({0_r, 0.1_r, 0_r}), cylinder(2.4_r, 0.2_r), {0_r, 0.8_r, 0_r}); }
    BodyId shuttle() { return machine(station(215) * at({-1.5_r, 0.1_r, 0_r}), box(1.2_r, 0.15_r, 1.5_r)); }
    BodyId lift() {
        const Transform from = station(250);
        block(from, {2.6_r, 1_r, 0_r}, {1.3_r, 1_r, 1.5_r});
        return machine(from * at({0_r, 0_r, 0_r}), box(1.25_r, 0.1_r, 1.5_r));
    }
    void rocks() {
        for (std::int32_t i = 0; i < 12; ++i) {
            const Transform from = station(285 + i);
            build.body({.kind = BodyKind::static_,
                        .pose = from * at({0_r, -0.15_r, 0.55_r * (i * 5 % 7 - 3)}),
                        .user_key = user_key_of(Role::wall, walls++)},
                       {.geometry = sphere(0.3_r + 0.02_r * (i % 5))});
        }
    }
    void seesaw() {
        const Transform from = station(318);
        const BodyId plank =
            build.body({.pose = from * at({0_r, 0.45_r, 0_r}), .user_key = user_key_of(Role::prop, props++)},
                       {.geometry = box(2_r, 0.06_r, 1_r), .density = 300_r});
        JointDef hinge = hinge_joint();
        hinge.axis[about_x].friction = 20_r;
        build.joint(hinge, BodyId{}, plank, from * at({0_r, 0.45_r, 0_r}, from_axis_angle(axis_y, -half_pi)));
    }
    void shelf() { block(station(345), {0_r, 1.3_r, 1.5_r}, {1_r, 0.05_r, 1_r}, Quat::identity(), 1); }
};

class CharacterScene final : public Scene {
  public:
    using Scene::Scene;
    std::uint32_t input_size() const override { return input_size_of<ArenaInput>; }
    Controls controls(std::uint32_t) const override { return {"walk", "jump", "crouch"}; }

    Result<World> start() const override {
        GameSchema schema;
        const Column<Cast> column = schema.add_record<Cast>("game.cast");
        WorldDef def = world_for(crate_count + 70, options.seed);
        def.characters_max = players_max;
        Builder build(def, schema);
        build.ground();
        Cast cast{};
        Course course{build};
        course.walls_around();
        course.stairs_and_ramp();
        course.crates();
        course.tunnel();
        course.disc();
        cast.shuttle = course.shuttle();
        cast.lift = course.lift();
        course.rocks();
        course.seesaw();
        course.shelf();
        for (std::uint32_t p = 0; p < options.players; ++p) {
            CharacterDef made;
            made.position =
                station(0) * Vec3{0_r, 0.01_r, Real(p) * 1.2_r - half(Real(options.players - 1)) * 1.2_r};
            made.user_key = user_key_of(Role::player, p);
            cast.characters[p] = build.character(made);
        }
        build.record(column, cast);
        return std::move(build).finish();
    }

    void play(Turn& turn, std::span<const PlayerInput> inputs) const override {
        World& world = turn.world;
        const Cast cast = world.read(cast_column);
        const std::uint64_t now = world.tick_count();
        if (now % shuttle_ticks == 0) turn_machines(turn, cast, now / shuttle_ticks % 2 == 0);
        for (std::uint32_t p = 0; p < inputs.size(); ++p) {
            CharacterInput wanted{};
            if (inputs[p].status != InputStatus::disconnected) {
                const ArenaInput input = decode_input<ArenaInput>(inputs[p]);
                wanted.velocity = {speed * Real(input.move_x) / 127_r, 0_r,
                                   speed * Real(input.move_z) / 127_r};
                wanted.jump = (input.buttons & arena_jump) != 0 ? 1 : 0;
                wanted.crouch = (input.buttons & arena_push) != 0 ? 1 : 0;
            }
            turn.must(world.set_character_input(cast.characters[p], wanted));
        }
    }

    Status check(const World& world) const override {
        StateCheck found(world, "game.cast");
        const Cast& cast = world.read(cast_column);
        for (std::uint32_t p = 0; p < options.players; ++p) found.alive(cast.characters[p], "a character");
        return found.alive(cast.shuttle, "the shuttle").alive(cast.lift, "the lift").finish();
    }

    /// The characters go round and round: the direction turns with time, and the walls guide them. They crouch at the
    /// tunnel.
    void script(std::uint64_t seed, std::uint64_t tick, std::uint32_t player,
                std::span<std::byte> input) const override {
        const auto at_round = static_cast<std::int32_t>((tick + seed * 7) % std::uint64_t{round_ticks});
        const Real angle = two_pi * at_round / Real(round_ticks) + half_pi + 0.2_r * Real(player);
        ArenaInput made;
        made.move_x = static_cast<std::int8_t>(floor_to_int(cos(angle) * 127));
        made.move_z = static_cast<std::int8_t>(floor_to_int(sin(angle) * 127));
        if (at_round > round_ticks * 110 / 360 && at_round < round_ticks * 175 / 360)
            made.buttons |= arena_push;
        if ((tick + 40 * player) % 150 < 10) made.buttons |= arena_jump;
        const auto bytes = encode_input(made);
        std::copy(bytes.begin(), bytes.end(), input.begin());
    }

  private:
    static void turn_machines(Turn& turn, const Cast& cast, bool onwards) {
        World& world = turn.world;
        const Real sign = onwards ? 1_r : -1_r;
        const Vec3 along = rotate(world.pose(cast.shuttle).rotation, Vec3{0.75_r * sign, 0_r, 0_r});
        turn.must(world.set_velocity(cast.shuttle, along, {}));
        turn.must(world.set_velocity(cast.lift, {0_r, 0.475_r * sign, 0_r}, {})); // up to 1.9 m
    }
};

} // namespace

std::unique_ptr<Scene> make_character(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<CharacterScene>(info, options, 1);
}

} // namespace lockstone::scenes_detail
