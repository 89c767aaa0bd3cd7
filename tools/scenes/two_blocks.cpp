// The scene of figures 1 to 4 of the thesis from which this engine grew. Two blocks in the air get initial forces and
// torques. The first bounces off the ground into the second; they part, reach the ground again and come to rest.
#include "scenes/scene.h"

namespace lockstone::scenes_detail {
namespace {

struct Cast {
    BodyId first, second;
};
template <class V> constexpr void describe(Cast& c, V&& v) { v("first", c.first), v("second", c.second); }

/// The initial forces act for this long, like the push of a hand [ticks].
constexpr std::uint64_t push_ticks = 6;

class TwoBlocks final : public Scene {
  public:
    using Scene::Scene;

    Result<World> start() const override {
        GameSchema schema;
        const Column<Cast> cast = schema.add_record<Cast>("game.cast");
        WorldDef def = world_for(2, options.seed);
        Builder build(def, schema);
        build.ground();
        const ShapeDef block{
            .geometry = box(0.5_r, 0.5_r, 0.5_r), .density = 10_r, .friction = 0.5_r, .restitution = 0.7_r};
        Cast blocks;
        blocks.first =
            build.body({.pose = at({-0.3_r, 3_r, 0_r}), .user_key = user_key_of(Role::prop, 0)}, block);
        blocks.second =
            build.body({.pose = at({0_r, 5.6_r, 0.1_r}), .user_key = user_key_of(Role::prop, 1)}, block);
        build.record(cast, blocks);
        return std::move(build).finish();
    }

    Status check(const World& world) const override {
        const Cast& blocks = world.read(Column<Cast>{0});
        return StateCheck(world, "game.cast")
            .alive(blocks.first, "first")
            .alive(blocks.second, "second")
            .finish();
    }

    void play(Turn& turn, std::span<const PlayerInput>) const override {
        World& world = turn.world;
        if (world.tick_count() < push_ticks) {
            const Cast blocks = world.read(Column<Cast>{0});
            turn.must(world.add_force(blocks.first, {40_r, 0_r, 0_r}, {1_r, 0_r, -6_r}));
            turn.must(world.add_force(blocks.second, {-30_r, -40_r, 0_r}, {-2_r, 1_r, 4_r}));
        }
    }
};

} // namespace

std::unique_ptr<Scene> make_two_blocks(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<TwoBlocks>(info, options, 1);
}

} // namespace lockstone::scenes_detail
