// A drum with paddles turns forever about a horizontal axis, and small bodies tumble in it. The drum is one compound of
// boxes on a kinematic body. A plane that faces into the drum closes its open end.
#include "lockstone/math/math.h"
#include "scenes/props.h"

#include <array>

namespace lockstone::scenes_detail {
namespace {

constexpr Real radius = 3_r, half_depth = 1.2_r; ///< of the drum's inside [m]
constexpr Real spin = 1.4_r;                     ///< [rad/s]
constexpr Real height = 4_r;                     ///< of the axis above the ground [m]
constexpr std::uint32_t wall_count = 20, paddle_count = 4;
constexpr UnitVec3 along_axis{Unit{}, Unit{}, unit_one};

/// A compound about the z axis. The back is a disc; the walls overlap so that no gap opens between them.
Result<AssetBytes> bake_drum() {
    std::vector<CompoundPart> parts;
    const auto add_around = [&](Geometry geometry, Real distance, Real angle) {
        const Vec3 place{distance * cos(angle), distance * sin(angle), 0_r};
        parts.push_back({geometry, {place, from_axis_angle(along_axis, angle)}});
    };
    constexpr Real wall = 0.15_r;
    const Real half_width = (radius + 2_r * wall) * tan(pi / Real(wall_count));
    for (std::uint32_t i = 0; i < wall_count; ++i)
        add_around(box(wall, half_width, half_depth), radius + wall, two_pi * Real(i) / Real(wall_count));
    for (std::uint32_t i = 0; i < paddle_count; ++i)
        add_around(rounded(box(0.35_r, 0.05_r, half_depth - 0.1_r), 0.05_r), radius - 0.35_r,
                   two_pi * (Real(i) + 0.5_r) / Real(paddle_count));
    const Geometry back = cylinder(radius + 2_r * wall, 0.1_r);
    constexpr UnitVec3 along_x{unit_one, Unit{}, Unit{}};
    parts.push_back({back, {{0_r, 0_r, -half_depth - 0.1_r}, from_axis_angle(along_x, half_pi)}});
    return bake_compound(parts);
}

class Washer final : public Scene {
  public:
    using Scene::Scene;

    Result<World> start() const override {
        Shelf shelf;
        const Geometry drum = shelf.add(bake_drum());
        std::vector<Geometry> shapes = bake_props(shelf, 0.2_r);
        shapes.push_back(sphere(0.15_r));
        shapes.push_back(box(0.12_r, 0.12_r, 0.12_r));
        const auto assets = std::move(shelf).finish();
        if (!assets) return assets.error();
        Builder build(world_for(options.size, options.seed), {}, *assets);
        build.ground();
        build.body({.kind = BodyKind::kinematic,
                    .pose = at({0_r, height, 0_r}),
                    .angular_velocity = {0_r, 0_r, spin},
                    .user_key = user_key_of(Role::terrain, 1)},
                   {.geometry = drum});
        // The glass. Its normal is -z, so a viewer in front of the drum sees no face of it.
        constexpr UnitVec3 along_x{unit_one, Unit{}, Unit{}};
        build.body({.kind = BodyKind::static_,
                    .pose = at({0_r, 0_r, half_depth}, from_axis_angle(along_x, -half_pi)),
                    .user_key = user_key_of(Role::wall, 0)},
                   {.geometry = plane(), .friction = 0_r});
        add_props(build, options, shapes, place, {.friction = 0.5_r});
        return std::move(build).finish();
    }

  private:
    /// On a grid within the drum, nearer to its axis than the paddles. A second grid lies between the places of the
    /// first one, and so on.
    static Transform place(std::uint32_t i, Random& random) {
        constexpr std::int32_t side = 8, deep = 5;
        constexpr Real step = 0.42_r;
        const auto index = static_cast<std::int32_t>(i % (side * side * deep));
        const Real x = step * Real(index % side) - step * half(Real(side - 1));
        const Real y = step * Real(index / side % side) - step * half(Real(side - 1));
        const Real z = step * Real(index / (side * side)) - step * half(Real(deep - 1));
        const Real shift = half(step) * Real(static_cast<std::int32_t>(i / (side * side * deep) % 2));
        return at({x + shift, height + y + shift, z}, random_turn(random));
    }
};

} // namespace

std::unique_ptr<Scene> make_washer(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<Washer>(info, options, 1);
}

} // namespace lockstone::scenes_detail
