// Casts the wheels of vehicles onto the ground, and wakes bodies accordingly.
#include "model/sleep.h"
#include "play/vehicle/vehicle_driver.h"

namespace lockstone::sim {

namespace {

constexpr Real steepest = 0.17_r; ///< least cosine between ground normal and suspension: 80 degrees

/// Geometry of the cast of a wheel, in world axes.
struct WheelCastWay {
    Vec3 from; ///< one radius above the attachment
    UnitVec3 down;
    Quat rotation;   ///< of a cylinder: y along the axle
    Real to_hub;     ///< largest distance from `from` to the hub [m]
    Vec3 raise, way; ///< `down` times the radius, and times to_hub
};

bool stands_on(const FirstHit& hit, UnitVec3 down) { return -dot<Real>(hit.normal, down) >= steepest; }

FirstHit first_of(const std::optional<QueryHit>& hit) {
    if (!hit) return {};
    return {hit->shape, hit->body, hit->distance, hit->point, hit->normal, hit->feature};
}

void cast_ray_wheel(const Scene& scene, const QueryFilter& filter, const WheelDef& wheel,
                    const WheelCastWay& way, WheelHit& out) {
    out.hit = first_of(
        cast_ray(scene, {way.from, lockstone::scale<Real>(way.down, way.to_hub + wheel.radius)}, filter));
    if (out.hit.shape && !stands_on(out.hit, way.down)) out.hit.shape = {};
    out.length = out.hit.distance - wheel.radius - wheel.radius;
}

/// Evaluates the hit of a cast wheel. If the cast hit a wall beside the wheel, or began inside a shape, a ray finds
/// the ground beyond.
void find_ground(const Scene& scene, const QueryFilter& filter, const WheelDef& wheel,
                 const WheelCastWay& way, WheelHit& out) {
    if (!out.hit.shape) return;
    if (!stands_on(out.hit, way.down)) return cast_ray_wheel(scene, filter, wheel, way, out);
    out.length = out.hit.distance - wheel.radius;
}

/// Largest cosine between a ground's normal and the axle at which the contact moves inwards: a lean of 6 degrees.
/// Beyond it, a cylinder bears on its rim alone.
constexpr Real rim_cosine = 0.1_r;

/// Moves the contact of a cylinder towards the middle of the wheel, where that of a soft tyre is; the more the wheel
/// leans, the nearer to the rim it stays. An upright cylinder touches level ground along a line, and a cast returns
/// the end of the line that a rounding error puts lower.
void bring_inwards(const WheelCastWay& way, FirstHit& hit) {
    if (!hit.shape) return;
    const UnitVec3 axle = to_rotation(way.rotation).y;
    const Real lean = abs(dot<Real>(hit.normal, axle));
    if (lean >= rim_cosine) return;
    // The projection of the axle onto the plane of the ground.
    const Vec3 along = to<Real>(axle) - lockstone::scale<Real>(hit.normal, dot<Real>(hit.normal, axle));
    const Vec3 hub = way.from + lockstone::scale<Real>(way.down, hit.distance);
    const Real aside = dot<Real>(axle, hit.point - hub);
    hit.point -= along * (aside / dot(along, to<Real>(axle)) * (Real(1) - lean / rim_cosine));
}

constexpr UnitVec3 up_axis{Unit{}, unit_one, Unit{}};
constexpr Unit half_root = Unit::from_raw(759250125); ///< 1 / sqrt(2)
constexpr Quat y_to_x{Unit{}, Unit{}, -half_root, half_root};

using WheelCastWays = std::array<WheelCastWay, vehicle_wheels_max>;

/// Computes the casts of all wheels from the present pose of the chassis.
void find_ways(const Model& w, const VehicleDef& def, const VehicleMemory& memory, WheelCastWays& out) {
    const std::uint32_t chassis = w.row_of(def.chassis);
    const Transform& pose = w.state.rows(w.m.body_pose)[chassis];
    const Vec3 center = w.mass_of(chassis).center;
    const Rotation axes = to_rotation(pose.rotation);
    const Speed speed = length(w.state.rows(w.m.body_velocity)[chassis].linear);
    const Real ahead = min(to<Real>(speed) / Real(w.state.rows(w.m.config)[0].tick_rate), Real(1));
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        const WheelDef& wheel = def.wheel[i];
        const bool as_before = i > 0 && wheel.direction == def.wheel[i - 1].direction;
        const UnitVec3 down = as_before ? out[i - 1].down : lockstone::mul<Unit>(axes, wheel.direction);
        const Vec3 attachment = pose.position + lockstone::mul<Real>(axes, wheel.attachment - center);
        const Real to_hub = wheel.radius + wheel.length_max + ahead;
        const bool is_alike =
            as_before && wheel.radius == def.wheel[i - 1].radius && to_hub == out[i - 1].to_hub;
        const Vec3 raise = is_alike ? out[i - 1].raise : lockstone::scale<Real>(down, wheel.radius),
                   way = is_alike ? out[i - 1].way : lockstone::scale<Real>(down, to_hub);
        out[i] = {attachment - raise, down, Quat::identity(), to_hub, raise, way};
        if (def.cast != WheelCast::cylinder) continue;
        out[i].rotation =
            normalized(pose.rotation * from_axis_angle(up_axis, memory.wheel[i].steer) * y_to_x);
    }
}

using WheelHits = std::array<WheelHit, vehicle_wheels_max>;

/// Finds the ground of all wheels of a vehicle.
void cast_wheels(const Scene& scene, const VehicleDef& def, const VehicleMemory& memory,
                 std::span<collide::NearFaces> near, WheelHits& out) {
    const QueryFilter filter{def.category, def.mask, 7, 0, def.chassis};
    WheelCastWays ways;
    find_ways(scene.model, def, memory, ways);
    if (def.cast == WheelCast::sphere) {
        static_assert(balls_max >= vehicle_wheels_max);
        std::array<BallCast, vehicle_wheels_max> balls;
        std::array<FirstHit, vehicle_wheels_max> hits;
        for (std::uint32_t i = 0; i < def.wheel_count; ++i)
            balls[i] = {def.wheel[i].radius, ways[i].from, ways[i].way, &near[i]};
        cast_balls(scene, std::span(balls).first(def.wheel_count), filter, hits);
        for (std::uint32_t i = 0; i < def.wheel_count; ++i) out[i].hit = hits[i];
    }
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        const WheelDef& wheel = def.wheel[i];
        if (def.cast == WheelCast::ray) {
            cast_ray_wheel(scene, filter, wheel, ways[i], out[i]);
            continue;
        }
        if (def.cast == WheelCast::cylinder)
            out[i].hit = first_of(cast_shape(scene, cylinder(wheel.radius, half(wheel.width)),
                                             {ways[i].from, ways[i].rotation}, ways[i].way, filter));
        find_ground(scene, filter, wheel, ways[i], out[i]);
        if (def.cast == WheelCast::cylinder) bring_inwards(ways[i], out[i].hit);
    }
}

} // namespace

/// True if the wheels of a sleeping vehicle hit the same shapes as when it fell asleep.
bool VehicleDriver::stands_as_before(const Scene& scene, std::uint32_t k) {
    const Model& w = scene.model;
    const VehicleDef& def = w.state.rows(w.m.vehicle)[k].def;
    const VehicleMemory& memory = w.state.rows(w.m.vehicle_memory)[k];
    WheelHits found;
    cast_wheels(scene, def, memory, near[k], found);
    for (std::uint32_t i = 0; i < def.wheel_count; ++i)
        if (found[i].hit.shape != memory.wheel[i].ground) return false;
    return true;
}

bool VehicleDriver::cast(Model& w, const Scene& scene) {
    const std::uint32_t count = w.state.count(w.m.vehicles);
    if (count == 0) return false;
    hits.resize(count);
    near.resize(count);
    bool woke = false;
    for (std::uint32_t k = 0; k < count; ++k) {
        // The reference is valid until a body is woken, which moves rows of the state.
        const VehicleDef& def = w.state.rows(w.m.vehicle)[k].def;
        if (!is_awake(w, w.row_of(def.chassis))) {
            // Wheels are no shapes, so contacts do not wake the vehicle.
            if (w.header().bodies_awake == 0 || stands_as_before(scene, k)) continue;
            wake(w, def.chassis);
            woke = true;
            continue;
        }
        cast_wheels(scene, def, w.state.rows(w.m.vehicle_memory)[k], near[k], hits[k]);
        const std::uint32_t wheel_count = def.wheel_count;
        for (std::uint32_t i = 0; i < wheel_count; ++i) {
            const FirstHit& ground = hits[k][i].hit;
            if (!ground.shape || is_awake(w, w.row_of(ground.body))) continue;
            if (w.state.rows(w.m.body_info)[w.row_of(ground.body)].kind != BodyKind::dynamic) continue;
            wake(w, ground.body);
            woke = true;
        }
    }
    return woke;
}

} // namespace lockstone::sim
