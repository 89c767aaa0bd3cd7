// A wall of 1 m boxes that narrows by one box a row: 820 boxes with a base of 40.
#include "scenes/scene.h"

namespace lockstone::scenes_detail {
namespace {

class Pyramid final : public Scene {
  public:
    using Scene::Scene;

    Result<World> start() const override {
        // Between neighbours of a row: they touch without being squeezed.
        constexpr Real gap = 0.001_r;
        const std::uint32_t base = options.size;
        WorldDef def = world_for(base * (base + 1) / 2, options.seed);
        def.sleeping = 0; // the scene measures bodies that stand, so none may sleep
        Builder build(def);
        build.ground();
        std::uint32_t number = 0;
        for (std::uint32_t row = 0; row < base; ++row) {
            const std::uint32_t length = base - row;
            const Real left = half((1_r + gap) * -Real(length - 1));
            for (std::uint32_t i = 0; i < length; ++i, ++number)
                build.body({.pose = at({left + (1_r + gap) * Real(i), Real(row) + 0.5_r, 0_r}),
                            .user_key = user_key_of(Role::prop, number)},
                           {.geometry = box(0.5_r, 0.5_r, 0.5_r)});
        }
        return std::move(build).finish();
    }
};

} // namespace

std::unique_ptr<Scene> make_pyramid(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<Pyramid>(info, options, 1);
}

} // namespace lockstone::scenes_detail
