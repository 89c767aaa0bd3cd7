#include "reference/scenes.h"

#include "lockstone/math/math.h"
#include "lockstone/world.h"

#include <array>

namespace reference {

using namespace lockstone;

namespace {

constexpr std::array<CompareScene, 7> infos{{
    {"two-blocks", "the thesis' figures 1 to 4: the same flight, then the first contact parts them", 0, 300},
    {"stack", "ten boxes that should not move", 10, 600},
    {"pile", "spheres, boxes and capsules that fall into a pit and should come to rest", 45, 600},
    {"domino", "dominoes that a ball topples", 40, 600},
    {"orbit", "a planet on an ellipse of eccentricity 0.6: energy by integrator", 0, 1200},
    {"top", "a flat cone that spins on its tip: the thesis leaves a term out of how it turns", 0, 480},
    {"pyramid", "a wall of 78 boxes that should stand", 12, 600},
}};

/// A game without players.
class Still final : public Game {
  public:
    Still(std::string_view named, Result<World> (*made)()) : title(named), make(made) {}
    std::string name() const override { return std::string(title); }
    std::uint64_t content_id() const override { return 1; }
    std::uint32_t player_count() const override { return 0; }
    std::uint32_t input_size() const override { return 0; }
    Result<World> start() const override { return make(); }
    Status advance(World& world, std::span<const PlayerInput>) const override {
        world.tick();
        return {};
    }

  private:
    std::string_view title;
    Result<World> (*make)();
};

Result<BodyId> add(World& world, const BodyDef& body, const ShapeDef& shape) {
    const Result<BodyId> id = world.create_body(body);
    if (!id) return id;
    const Result<ShapeId> made = world.create_shape(*id, shape);
    return made ? id : Result<BodyId>(made.error());
}

/// G M = 64 m^3/s^2 and a = 5 m give a period of 2 pi sqrt(a^3 / G M) = 8.78 s. At the farthest point, r = a (1 + e) =
/// 8 m, the planet's speed is sqrt(G M / a (1 - e) / (1 + e)) = 1.7889 m/s.
Result<World> start_orbit() {
    Result<World> world = World::create({.gravity = {}, .sleeping = 0});
    if (!world) return world;
    const FieldDef pull{.strength = 64_r};
    if (const Result<FieldId> field = world->create_field(pull); !field) return field.error();
    const Result<BodyId> sun =
        add(*world, {.kind = BodyKind::static_, .user_key = user_key_of(Role::terrain, 0)},
            {.geometry = sphere(0.5_r), .sensor = 1});
    if (!sun) return sun.error();
    const Result<BodyId> planet = add(*world,
                                      {.pose = {{8_r, 0_r, 0_r}, Quat::identity()},
                                       .linear_velocity = {0_r, 0_r, 1.788854382_r},
                                       .user_key = user_key_of(Role::prop, 0)},
                                      {.geometry = sphere(0.25_r)});
    if (!planet) return planet.error();
    return world;
}

/// A cone on its tip, leaning by 0.2 rad, at 60 rad/s about its own axis.
Result<World> start_top() {
    Result<World> world = World::create({.sleeping = 0});
    if (!world) return world;
    const Result<BodyId> ground =
        add(*world, {.kind = BodyKind::static_, .user_key = user_key_of(Role::terrain, 0)},
            {.geometry = plane()});
    if (!ground) return ground.error();
    constexpr Real half_height = 0.15_r; // flat, so that the inertia about the axis is the greatest
    const UnitVec3 about_z{Unit{}, Unit{}, unit_one};
    // Turns the tip down; in the cone's frame it points up.
    const Quat leaning = from_axis_angle(about_z, pi + 0.2_r);
    const Vec3 to_tip = rotate(leaning, Vec3{0_r, half_height, 0_r});
    const Vec3 axis = rotate(leaning, Vec3{0_r, 1_r, 0_r});
    const Result<BodyId> top = add(*world,
                                   {.pose = {{0_r, -to_tip.y, 0_r}, leaning},
                                    .angular_velocity = axis * -60_r,
                                    .user_key = user_key_of(Role::prop, 0)},
                                   {.geometry = cone(0.4_r, half_height), .friction = 1_r});
    if (!top) return top.error();
    return world;
}

std::string names() {
    std::string all;
    for (const CompareScene& scene : infos) all += (all.empty() ? "" : ", ") + std::string(scene.name);
    return all;
}

} // namespace

std::span<const CompareScene> compare_scenes() { return infos; }

const CompareScene* find_compare_scene(std::string_view name) {
    for (const CompareScene& scene : infos)
        if (scene.name == name) return &scene;
    return nullptr;
}

Result<std::unique_ptr<Game>> make_compare_scene(std::string_view name, SceneOptions options) {
    if (name == "orbit" || name == "top") {
        if (options.size != 0) return Error{std::string(name) + ": comes in one size"};
        return std::unique_ptr<Game>(
            std::make_unique<Still>(name, name == "orbit" ? start_orbit : start_top));
    }
    const CompareScene* scene = find_compare_scene(name);
    if (scene != nullptr && options.size == 0) options.size = scene->size;
    if (scene == nullptr && find_scene(name) == nullptr)
        return Error{"there is no scene '" + std::string(name) + "' to compare in: " + names() +
                     ", or one of `lockstone scenes`"};
    return make_scene(name, options);
}

} // namespace reference
