// A ball of a thousand links' mass, raised at the end of their chain, swings into a wall.
#include "lockstone/math.h"
#include "scenes/scene.h"

namespace lockstone::scenes_detail {
namespace {

constexpr Real link_length = 0.3_r, link_radius = 0.06_r, link_mass = 2_r; ///< [m], [m], [kg]
constexpr Real ball_radius = 0.8_r, ball_mass = 1000_r * link_mass;
constexpr Real raised = 1.1_r; ///< angle of the chain to the vertical at the start [rad]
constexpr std::uint32_t wall_columns = 9, wall_rows = 8;
constexpr UnitVec3 axis_z{Unit{}, Unit{}, unit_one};

class WreckingBall final : public Scene {
  public:
    using Scene::Scene;

    Result<World> start() const override {
        WorldDef def = world_for(options.size + 1 + wall_columns * wall_rows, options.seed);
        def.joints_max = options.size + 1;
        Builder build(def);
        build.ground();
        const Real chain = link_length * Real(options.size);
        const Real height = chain + ball_radius + 1_r;
        build_chain(build, build_crane(build, height), height);
        build_wall(build);
        return std::move(build).finish();
    }

  private:
    static BodyId build_crane(Builder& build, Real height) {
        const Real behind = -5_r; // the chain swings along x, the mast stands beside its way
        const BodyId crane =
            build.body({.kind = BodyKind::static_, .user_key = user_key_of(Role::machine, 0)},
                       {.geometry = box(0.4_r, half(height) + 0.4_r, 0.4_r),
                        .local = at({0_r, half(height) + 0.4_r, behind})});
        build.shape(crane, {.geometry = box(0.3_r, 0.3_r, half(-behind)),
                            .local = at({0_r, height + 0.5_r, half(behind)})});
        return crane;
    }

    void build_chain(Builder& build, BodyId crane, Real height) const {
        const Quat tilt = from_axis_angle(axis_z, -raised); // y of a link points to the crane
        const Vec3 down = rotate(tilt, Vec3{0_r, -1_r, 0_r});
        Vec3 joint{0_r, height, 0_r};
        BodyId before = crane;
        for (std::uint32_t i = 0; i < options.size; ++i) {
            const BodyId link =
                build.body({.pose = at(joint + down * half(link_length), tilt),
                            .angular_damping = 0.2_r,
                            .mass = link_mass,
                            .user_key = user_key_of(Role::machine, i + 1)},
                           {.geometry = capsule(link_radius, half(link_length) - link_radius), .group = -1});
            build.joint(ball_joint(), before, link, at(joint));
            before = link;
            joint += down * link_length;
        }
        const BodyId ball = build.body({.pose = at(joint + down * ball_radius, tilt),
                                        .mass = ball_mass,
                                        .bullet = 1,
                                        .user_key = user_key_of(Role::player, 0)},
                                       {.geometry = sphere(ball_radius), .group = -1});
        build.joint(ball_joint(), before, ball, at(joint));
    }

    /// Boxes of 0.8 m, every other row shifted by half a box, before the lowest point of the swing.
    static void build_wall(Builder& build) {
        constexpr Real size = 0.8_r;
        for (std::uint32_t i = 0; i < wall_columns * wall_rows; ++i) {
            const std::uint32_t row = i / wall_columns;
            const Real shift = row % 2 == 0 ? 0_r : half(size);
            const Real z = size * (Real(i % wall_columns) - half(Real(wall_columns))) + shift;
            build.body(
                {.pose = at({1.6_r, size * (Real(row) + 0.5_r), z}), .user_key = user_key_of(Role::prop, i)},
                {.geometry = box(half(size), half(size), half(size)), .density = 200_r});
        }
    }
};

} // namespace

std::unique_ptr<Scene> make_wrecking_ball(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<WreckingBall>(info, options, 1);
}

} // namespace lockstone::scenes_detail
