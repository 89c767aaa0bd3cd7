// A tower of 1 m boxes: the hardest small test for the stiffness of a solver and for rest.
#include "scenes/scene.h"

namespace lockstone::scenes_detail {
namespace {

class Stack final : public Scene {
  public:
    using Scene::Scene;

    Result<World> start() const override {
        WorldDef def = world_for(options.size, options.seed);
        def.sleeping = 0; // the scene measures bodies that stand, so none may sleep
        Builder build(def);
        build.ground();
        for (std::uint32_t i = 0; i < options.size; ++i)
            build.body({.pose = at({0_r, Real(i) + 0.5_r, 0_r}), .user_key = user_key_of(Role::prop, i)},
                       {.geometry = box(0.5_r, 0.5_r, 0.5_r)});
        return std::move(build).finish();
    }
};

} // namespace

std::unique_ptr<Scene> make_stack(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<Stack>(info, options, 1);
}

} // namespace lockstone::scenes_detail
