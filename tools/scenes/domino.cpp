// Dominoes along an Archimedean spiral, from the outside inwards. A rolling ball topples the first.
#include "lockstone/math/math.h"
#include "scenes/scene.h"

namespace lockstone::scenes_detail {
namespace {

constexpr Real step = 0.45_r;        ///< [m] from domino to domino along the spiral
constexpr Real arm_distance = 1.6_r; ///< [m] between neighbouring turns
/// [m] where the spiral begins; on tighter turns the dominoes would miss each other.
constexpr Real radius_min = 1.2_r;

class Domino final : public Scene {
  public:
    using Scene::Scene;

    Result<World> start() const override {
        Builder build(world_for(options.size + 1, options.seed));
        build.ground();
        Real radius = radius_min, angle{};
        for (std::uint32_t i = 0; i < options.size; ++i) {
            const std::uint32_t number = options.size - 1 - i; // the outermost domino falls first
            build.body({.pose = place(radius, angle, 0.5_r), .user_key = user_key_of(Role::prop, number)},
                       {.geometry = box(0.06_r, 0.5_r, 0.25_r), .density = 600_r, .friction = 0.4_r});
            angle += step / radius;
            radius = radius_min + arm_distance * angle / two_pi;
        }
        add_ball(build, radius, angle);
        return std::move(build).finish();
    }

  private:
    /// The local x axis points along the spiral, outwards.
    static Transform place(Real radius, Real angle, Real height) {
        constexpr UnitVec3 up{Unit{}, unit_one, Unit{}};
        return at({radius * cos(angle), height, radius * sin(angle)},
                  from_axis_angle(up, -(angle + half_pi)));
    }

    /// The ball starts beyond the last domino of the spiral and rolls towards it without slip.
    static void add_ball(Builder& build, Real radius, Real angle) {
        constexpr Real size = 0.3_r, speed = 3_r;
        Transform pose = place(radius, angle, size);
        const Vec3 inwards = rotate(pose.rotation, Vec3{-1_r, 0_r, 0_r});
        pose.position += inwards * -1_r;
        const Vec3 spin = cross(Vec3{0_r, 1_r, 0_r}, inwards) * (speed / size);
        build.body({.pose = pose,
                    .linear_velocity = inwards * speed,
                    .angular_velocity = spin,
                    .user_key = user_key_of(Role::machine, 0)},
                   {.geometry = sphere(size), .density = 2000_r});
    }
};

} // namespace

std::unique_ptr<Scene> make_domino(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<Domino>(info, options, 1);
}

} // namespace lockstone::scenes_detail
