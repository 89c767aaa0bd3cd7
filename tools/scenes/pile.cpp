// Spheres, boxes and capsules in equal parts fall into a walled pit of 10 x 10 m.
#include "lockstone/math/random.h"
#include "scenes/scene.h"

#include <array>

namespace lockstone::scenes_detail {
namespace {

constexpr std::uint32_t layer_side = 7; ///< bodies along each side of a layer
constexpr Real spacing = 1.4_r; ///< [m] between centres; boxes turned by 0.3 rad about two axes do not touch

class Pile final : public Scene {
  public:
    using Scene::Scene;

    Result<World> start() const override {
        Builder build(world_for(options.size, options.seed));
        build.ground();
        build_walls(build);
        const std::array<Geometry, 3> geometries{sphere(0.5_r), box(0.5_r, 0.5_r, 0.5_r),
                                                 capsule(0.3_r, 0.4_r)};
        Random random = Random::seeded(options.seed);
        for (std::uint32_t i = 0; i < options.size; ++i)
            build.body({.pose = place(i, random), .user_key = user_key_of(Role::prop, i)},
                       {.geometry = geometries[i % 3]});
        return std::move(build).finish();
    }

  private:
    static Transform place(std::uint32_t i, Random& random) {
        const std::uint32_t layer = i / (layer_side * layer_side), in_layer = i % (layer_side * layer_side);
        const Real edge = half(spacing * Real(layer_side - 1));
        const Real x = spacing * Real(in_layer % layer_side) - edge + random.range(-0.1_r, 0.1_r);
        const Real z = spacing * Real(in_layer / layer_side) - edge + random.range(-0.1_r, 0.1_r);
        const Real turn = random.range(-0.3_r, 0.3_r), tilt = random.range(-0.3_r, 0.3_r);
        return at({x, 1_r + spacing * Real(layer), z}, from_euler({tilt, turn, tilt}));
    }

    /// Thick walls, as high as the highest bodies at the start.
    void build_walls(Builder& build) const {
        const std::uint32_t layers = 1 + options.size / (layer_side * layer_side);
        const Real half_height = half(spacing * Real(layers) + 4_r);
        const BodyId walls =
            build.body({.kind = BodyKind::static_, .user_key = user_key_of(Role::wall, 0)},
                       {.geometry = box(1_r, half_height, 7_r), .local = at({-6_r, half_height, 0_r})});
        build.shape(walls, {.geometry = box(1_r, half_height, 7_r), .local = at({6_r, half_height, 0_r})});
        build.shape(walls, {.geometry = box(5_r, half_height, 1_r), .local = at({0_r, half_height, -6_r})});
        build.shape(walls, {.geometry = box(5_r, half_height, 1_r), .local = at({0_r, half_height, 6_r})});
    }
};

} // namespace

std::unique_ptr<Scene> make_pile(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<Pile>(info, options, 1);
}

} // namespace lockstone::scenes_detail
