// Planks on hinges between two banks, and boxes that fall on them. Players' balls start on the banks. A ball that has
// fallen to the ground returns to its start.
#include "lockstone/math/math.h"
#include "lockstone/math/random.h"
#include "scenes/balls.h"

#include <algorithm>

namespace lockstone::scenes_detail {
namespace {

constexpr Real pitch = 0.4_r, half_plank = 0.19_r, half_thickness = 0.05_r, half_width = 0.9_r; ///< [m]
constexpr Real arc = 0.85_r; ///< angle of the arc of planks at the start [rad]: 3 % longer than the gap
constexpr std::uint32_t planks_per_box = 8;
constexpr UnitVec3 axis_y{Unit{}, unit_one, Unit{}}, axis_z{Unit{}, Unit{}, unit_one};

class Bridge final : public BallScene {
  public:
    using BallScene::BallScene;

    Result<World> start() const override {
        const std::uint32_t boxes = std::max(1u, options.size / planks_per_box);
        WorldDef def = world_for(options.size + boxes + options.players, options.seed);
        def.substeps = WorldDef::precise().substeps; // for long chains
        def.joints_max = options.size + 1;
        GameSchema schema;
        add_players(schema);
        Builder build(def, schema);
        build.ground();
        const Real height = bank_height(), span = gap();
        build_planks(build, height, span);
        Random random = Random::seeded(options.seed);
        for (std::uint32_t i = 0; i < boxes; ++i) {
            const Real x = span * ((Real(i) + 0.5_r) / Real(boxes) - 0.5_r);
            const Real side = random.range(-0.3_r, 0.3_r), turn = random.range(-pi, pi);
            build.body(
                {.pose = at({x, height + random.range(0.8_r, 3_r), side}, from_axis_angle(axis_y, turn)),
                 .user_key = user_key_of(Role::prop, 6 * options.size + i)},
                {.geometry = box(0.35_r, 0.35_r, 0.35_r), .density = 150_r, .friction = 0.9_r});
        }
        build_players(build);
        return std::move(build).finish();
    }

  private:
    Real slope(std::uint32_t plank) const {
        return arc * ((Real(plank) + 0.5_r) / Real(options.size) - 0.5_r);
    }

    Real bank_height() const { return 2_r + pitch * Real(options.size) * 0.12_r; }
    /// The distance between the banks [m].
    Real gap() const {
        Real span{};
        for (std::uint32_t i = 0; i < options.size; ++i) span += pitch * cos(slope(i));
        return span;
    }

    /// The balls start on alternate banks in the middle of the way, two behind each other.
    Vec3 start_of(std::uint32_t player) const override {
        const Real from_edge = player < 2 ? 1.2_r : 2.8_r, side = player % 2 == 0 ? -1_r : 1_r;
        return {side * (half(gap()) + from_edge), bank_height() + ball_radius, 0_r};
    }
    bool is_out(Vec3 position) const override { return position.y < ball_radius + 0.1_r; }
    /// Pushes move boxes and players, but no planks.
    bool is_loose(const Look& look) const override {
        return look.role == Role::player || look.number >= 6 * options.size;
    }

    /// A sagging arc of planks, its ends hinged to the banks.
    void build_planks(Builder& build, Real height, Real span) const {
        const Quat across = from_axis_angle(axis_y, -half_pi); // a hinge turns about x of its frame: here z
        BodyId before = build_bank(build, -half(span), -1_r, height);
        Vec3 hinge{-half(span), height, 0_r};
        for (std::uint32_t i = 0; i < options.size; ++i) {
            const Vec3 along{pitch * cos(slope(i)), pitch * sin(slope(i)), 0_r};
            const BodyId plank =
                build.body({.pose = at(hinge + along * 0.5_r, from_axis_angle(axis_z, slope(i))),
                            .linear_damping = 0.2_r,
                            .angular_damping = 0.5_r,
                            .user_key = user_key_of(Role::prop, 6 * i + (i % 2 == 0 ? 1 : 3))},
                           {.geometry = box(half_plank, half_thickness, half_width),
                            .density = 500_r,
                            .friction = 0.9_r});
            build.joint(hinge_joint(), before, plank, at(hinge, across));
            before = plank;
            hinge += along;
        }
        build.joint(hinge_joint(), build_bank(build, half(span), 1_r, height), before, at(hinge, across));
    }

    /// A bank whose edge is at `edge`; the rest lies on the side with the sign of `side`.
    static BodyId build_bank(Builder& build, Real edge, Real side, Real height) {
        return build.body({.kind = BodyKind::static_,
                           .pose = at({edge + side * 2_r, half(height), 0_r}),
                           .user_key = user_key_of(Role::wall, side < 0_r ? 0 : 1)},
                          {.geometry = box(2_r, half(height), 2_r)});
    }
};

} // namespace

std::unique_ptr<Scene> make_bridge(const SceneInfo& info, const SceneOptions& options) {
    return std::make_unique<Bridge>(info, options, 1);
}

} // namespace lockstone::scenes_detail
