// Humans start in the air above a flight of stairs, fall, tumble down and pile up at a wall. Players' balls start
// below.
#include "lockstone/math/math.h"
#include "lockstone/math/random.h"
#include "scenes/balls.h"

namespace lockstone::scenes_detail {
namespace {

constexpr std::uint32_t step_count = 12, abreast = 4;
constexpr Real rise = 0.3_r, depth = 0.45_r, half_width = 4_r; ///< of a step [m]
constexpr Real floor_end = depth * Real(step_count) + 4_r;     ///< z of the wall below [m]
constexpr UnitVec3 up{Unit{}, unit_one, Unit{}};

class Ragdolls final : public BallScene {
  public:
    using BallScene::BallScene;

    Result<World> start() const override {
        WorldDef def = world_for(ragdoll_part_count * options.size + options.players, options.seed);
        def.shapes_max += step_count;
        // With 8 substeps a foot that is pinned at its limit trembles and keeps the heap awake.
        def.substeps = 16;
        def.joints_max = ragdoll_part_count * options.size;
        GameSchema schema;
        add_players(schema);
        Builder build(def, schema);
        build.ground();
        build_stairs(build);
        Random random = Random::seeded(options.seed);
        for (std::uint32_t i = 0; i < options.size; ++i)
            build.ragdoll({.place = place(i, random),
                           .linear_velocity = {0_r, 0_r, random.range(1_r, 3_r)},
                           .height = random.range(1.55_r, 1.95_r),
                           .mass = random.range(55_r, 95_r),
                           .pose = random.below(2) == 0 ? ragdoll_standing() : ragdoll_t_pose(),
                           .user_key = user_key_of(Role::human, i * human_stride)});
        build_players(build);
        return std::move(build).finish();
    }

  private:
    Vec3 start_of(std::uint32_t player) const override {
        const Real x = half(Real(player + 1)) * (player % 2 == 0 ? 1_r : -1_r) * 1.6_r;
        return {x, ball_radius, floor_end - 1.2_r};
    }

    /// True beyond the walls or behind the landing, from where no way leads back.
    bool is_out(Vec3 position) const override {
        return position.z < -2.5_r || position.z > floor_end + 1_r || abs(position.x) > half_width + 1_r;
    }

    /// Rows of four above the upper steps, each row higher than the one before.
    static Transform place(std::uint32_t i, Random& random) {
        const std::uint32_t row = i / abreast;
        const Real x = 2_r * Real(i % abreast) - 3_r + random.range(-0.2_r, 0.2_r);
        const Real y = rise * Real(step_count) + 0.6_r + 2.2_r * Real(row);
        const Real turn = random.range(-0.8_r, 0.8_r);
        return at({x, y, 0.3_r * Real(row % 3)}, from_axis_angle(up, turn));
    }

    /// Stairs that lead down along +z from a landing, and walls behind the landing, beside the steps and across the
    /// floor below.
    static void build_stairs(Builder& build) {
        const BodyId stairs =
            build.body({.kind = BodyKind::static_, .user_key = user_key_of(Role::terrain, 1)},
                       {.geometry = box(half_width, half(rise * Real(step_count)), 1_r),
                        .local = at({0_r, half(rise * Real(step_count)), -1_r})});
        for (std::uint32_t i = 0; i + 1 < step_count; ++i) {
            const Real half_height = half(rise * Real(step_count - 1 - i));
            build.shape(stairs, {.geometry = box(half_width, half_height, half(depth)),
                                 .local = at({0_r, half_height, depth * (Real(i) + 0.5_r)})});
        }
        const Real end = floor_end, half_length = half(end) + 1_r;
        const BodyId walls =
            build.body({.kind = BodyKind::static_, .user_key = user_key_of(Role::wall, 0)},
                       {.geometry = box(half_width, 1_r, 0.2_r), .local = at({0_r, 1_r, end})});
        for (const Real side : {-1_r, 1_r})
            build.shape(walls, {.geometry = box(0.2_r, 3_r, half_length),
                                .local = at({side * (half_width + 0.2_r), 3_r, half(end) - 1_r})});
    }
};

} // namespace

std::unique_ptr<Scene> make_ragdolls(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<Ragdolls>(info, options, 1);
}

} // namespace lockstone::scenes_detail
