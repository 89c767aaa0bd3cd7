// Houses of crates. Every three seconds a charge explodes in one of them.
#include "scenes/scene.h"

namespace lockstone::scenes_detail {
namespace {

constexpr std::uint32_t first_tick = 60, ticks_between = 180;

class Blast final : public Scene {
  public:
    using Scene::Scene;

    Result<World> start() const override {
        Builder build(world_for(options.size * 13, options.seed));
        build.ground();
        for (std::uint32_t i = 0; i < options.size; ++i) add_house(build, i);
        return std::move(build).finish();
    }

    /// The next explosion is at the foot of the next house; after the last house comes the first.
    void play(Turn& turn, std::span<const PlayerInput>) const override {
        const std::uint64_t tick = turn.world.tick_count();
        if (tick % ticks_between == first_tick) {
            const auto house = static_cast<std::uint32_t>(tick / ticks_between % options.size);
            turn.must(turn.world.explode({.center = center_of(house) + Vec3{0_r, 0.2_r, 0_r},
                                          .radius = 12_r,
                                          .impulse = 3000_r,
                                          .core = 1_r}));
        }
    }

  private:
    static constexpr std::uint32_t row_length = 4;
    static constexpr std::uint32_t parts = 13; ///< of a house

    Vec3 center_of(std::uint32_t house) const {
        const Real edge = 3_r * Real(row_length - 1);
        return {Real(house % row_length) * 6_r - edge, 0_r, Real(house / row_length) * 6_r - edge};
    }

    /// Four pillars of three crates each, and a roof on them.
    void add_house(Builder& build, std::uint32_t house) const {
        const Vec3 center = center_of(house);
        std::uint32_t number = house * parts; // index of a part among the parts of all houses
        constexpr Real out = 1.2_r;
        const Vec3 pillars[4] = {{out, 0_r, 0_r}, {-out, 0_r, 0_r}, {0_r, 0_r, out}, {0_r, 0_r, -out}};
        for (const Vec3& pillar : pillars)
            for (std::uint32_t floor = 0; floor < 3; ++floor)
                build.body({.pose = at(center + pillar + Vec3{0_r, Real(floor) + 0.5_r, 0_r}),
                            .user_key = user_key_of(Role::prop, number++)},
                           {.geometry = box(0.5_r, 0.5_r, 0.5_r), .density = 300_r});
        build.body({.pose = at(center + Vec3{0_r, 3.1_r, 0_r}), .user_key = user_key_of(Role::prop, number)},
                   {.geometry = box(1.8_r, 0.1_r, 1.8_r), .density = 300_r});
    }
};

} // namespace

std::unique_ptr<Scene> make_blast(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<Blast>(info, options, 1);
}

} // namespace lockstone::scenes_detail
