// A basin of water with a current and a wind: boats with sails, crates, and balls of several densities.
#include "lockstone/math/random.h"
#include "scenes/scene.h"

namespace lockstone::scenes_detail {
namespace {

constexpr Real half_side = 16_r, depth = 4_r; ///< of the basin [m]; the water's surface is at y = depth
constexpr std::uint32_t balls = 11, boats = 3;

class Water final : public Scene {
  public:
    using Scene::Scene;

    Result<World> start() const override {
        WorldDef def = world_for(options.size + balls + boats, options.seed);
        def.shapes_max += 4 * boats;
        Builder build(def);
        build.ground();
        build_basin(build);
        FieldDef sea = water({.kind = RegionKind::box,
                              .pose = at({0_r, half(depth), 0_r}),
                              .half_extent = {half_side, half(depth), half_side}});
        sea.velocity = {0_r, 0_r, 0.3_r};
        build.field(sea);
        build.field(wind({9_r, 0_r, 4_r}));
        add_balls(build);
        for (std::uint32_t i = 0; i < boats; ++i) add_boat(build, i);
        add_crates(build);
        return std::move(build).finish();
    }

  private:
    static void build_basin(Builder& build) {
        const Real high = half(depth + 1_r), far = half_side + 0.5_r;
        const BodyId walls =
            build.body({.kind = BodyKind::static_, .user_key = user_key_of(Role::wall, 0)},
                       {.geometry = box(0.5_r, high, far + 0.5_r), .local = at({-far, high, 0_r})});
        const auto wall = [&](Vec3 half_extent, Vec3 place) {
            build.shape(walls, {.geometry = box(half_extent), .local = at(place)});
        };
        wall({0.5_r, high, far + 0.5_r}, {far, high, 0_r});
        wall({half_side, high, 0.5_r}, {0_r, high, -far});
        wall({half_side, high, 0.5_r}, {0_r, high, far});
    }

    /// Balls from a tenth of the density of water upwards, each a tenth of it denser than the last.
    static void add_balls(Builder& build) {
        for (std::uint32_t i = 0; i < balls; ++i)
            build.body({.pose = at({Real(i) * 1.6_r - 8_r, depth + 1_r, -11_r}),
                        .user_key = user_key_of(Role::machine, i)},
                       {.geometry = sphere(0.5_r), .density = Real(100 * (i + 1))});
    }

    /// A hull of boards, ballast below, a mast, and a sail for the wind.
    static void add_boat(Builder& build, std::uint32_t number) {
        const BodyId boat = build.body({.pose = at({-10_r, depth + 0.2_r, Real(number) * 7_r - 5_r}),
                                        .user_key = user_key_of(Role::player, number)},
                                       {.geometry = box(1.5_r, 0.4_r, 0.6_r), .density = 150_r});
        build.shape(
            boat, {.geometry = box(1_r, 0.12_r, 0.3_r), .local = at({0_r, -0.5_r, 0_r}), .density = 3000_r});
        build.shape(boat,
                    {.geometry = cylinder(0.06_r, 1.2_r), .local = at({0.2_r, 1.6_r, 0_r}), .density = 60_r});
        build.shape(
            boat, {.geometry = box(0.02_r, 0.8_r, 0.9_r), .local = at({0.1_r, 1.8_r, 0_r}), .density = 20_r});
    }

    void add_crates(Builder& build) const {
        Random random = Random::seeded(options.seed);
        for (std::uint32_t i = 0; i < options.size; ++i) {
            const Real height = depth + 1_r + Real(i / 16) * 1.2_r;
            const Vec3 place{random.range(-8_r, 12_r), height, random.range(-6_r, 12_r)};
            // The numbers are drawn in separate statements: C++ leaves the order of the arguments of a call to the
            // compiler.
            const Real size = random.range(0.25_r, 0.55_r), density = random.range(200_r, 900_r);
            const Real tilt = random.range(-1_r, 1_r), turn = random.range(-3_r, 3_r);
            build.body(
                {.pose = at(place, from_euler({tilt, turn, 0_r})), .user_key = user_key_of(Role::prop, i)},
                {.geometry = box(size, size, size), .density = density});
        }
    }
};

} // namespace

std::unique_ptr<Scene> make_water(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<Water>(info, options, 1);
}

} // namespace lockstone::scenes_detail
