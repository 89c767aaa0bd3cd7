// The begin of a vehicle's tick: where its wheels stand, which gear is in, what is coupled to what.
#include "base/poison.h"
#include "lockstone/math/math.h"
#include "model/sleep.h"
#include "play/vehicle/vehicle.h"
#include "play/vehicle/vehicle_lines.h"
#include "scene/surface.h"

#include <algorithm>

namespace lockstone::sim {

using solve::BodyStep;
using solve::SolverBodies;
using solve::SolverBody;

namespace {

constexpr Real steepest = 0.17_r; ///< least cosine between a ground's normal and the suspension: 80 degrees
constexpr Real ratio_max =
    Real(65536); ///< of the masses of chassis and ground; a lighter ground acts as if it had this
constexpr std::int32_t arm_max = 64; ///< of a row's turning arm K^-1 (r x d)
constexpr Real impulse_max = Real(2048);
constexpr Real part_spin_max = Real(100000); ///< [rad/s], of wheels and engines

Arm bounded(Arm x) { return clamp(x, Arm(-arm_max), Arm(arm_max)); }

/// From a centre of mass [m].
struct Lever {
    Vec3 whole;
    Vector3<Arm> near{}; ///< the same, below 128 m
    bool is_near = false;

    explicit Lever(Vec3 lever) : whole(lever) {
        constexpr Real far = Real(128);
        is_near = abs(lever.x) < far && abs(lever.y) < far && abs(lever.z) < far;
        if (is_near) near = to<Arm>(lever);
    }
};

/// K^-1 (lever x d); in 64 bits below a lever of 128 m.
Vector3<Arm> arm_of(const BodyStep& body, const Lever& lever, UnitVec3 d, std::int32_t sign) {
    Vector3<Arm> x{};
    if (lever.is_near) {
        Vector3<Arm> turn = cross<Arm>(lever.near, d);
        for (int i = 0; i < 3; ++i)
            turn[i] = Arm::from_raw((body.angular_mask >> i & 1u) != 0 ? sign * turn[i].raw : 0);
        x = solve::over_gyration<Arm>(body, turn);
    } else {
        Vec3 turn = cross<Real>(lever.whole, d);
        for (int i = 0; i < 3; ++i) turn[i] = (body.angular_mask >> i & 1u) != 0 ? turn[i] * sign : Real{};
        x = solve::over_gyration<Arm>(body, turn);
    }
    return {bounded(x.x), bounded(x.y), bounded(x.z)};
}

/// Speed along a direction d_a of what an impulse along d_b does to a body; x: their turning arms.
Real mobility(const SolverBody& body, UnitVec3 d_a, Vector3<Arm> x_a, UnitVec3 d_b, Vector3<Arm> x_b) {
    SumOfProducts<Unit, Unit> moves;
    for (int i = 0; i < 3; ++i)
        if (body.keep[i] != 0) moves.add(d_a[i], d_b[i]);
    return moves.round<Real>() + dot<Real>(x_a, x_b);
}

/// Of a wheel's patch [m], and the speed of what it stands on beside its body's [m/s].
struct Levers {
    Lever chassis, ground;
    Vec3 surface;
};

WheelLine line_of(const SolverBodies& bodies, std::uint32_t chassis, const Wheel& wheel, UnitVec3 d,
                  const Levers& levers) {
    WheelLine line{};
    line.d = d;
    line.xc = arm_of(bodies.step[chassis], levers.chassis, d, 1);
    if (levers.surface != Vec3{}) line.belt = dot<Real>(levers.surface, d);
    line.kappa = mobility(bodies.body[chassis], d, line.xc, d, line.xc);
    if (wheel.ground == bodies.still()) return line;
    line.xg = arm_of(bodies.step[wheel.ground], levers.ground, d, -1);
    if (wheel.ratio > Real{})
        line.kappa += wheel.ratio * mobility(bodies.body[wheel.ground], d, line.xg, d, line.xg);
    return line;
}

/// What a wheel is cast with, in world axes.
struct WheelCastWay {
    Vec3 from; ///< a radius above the attachment
    UnitVec3 down;
    Quat rotation;   ///< y along the axle, of a cylinder
    Real to_hub;     ///< farthest [m]
    Vec3 raise, way; ///< down by a radius, and as far as the hub may be
};

bool stands_on(const QueryHit& hit, UnitVec3 down) { return -dot<Real>(hit.normal, down) >= steepest; }

WheelGround cast_ray_wheel(const Scene& scene, const QueryFilter& filter, const WheelDef& wheel,
                           const WheelCastWay& way) {
    const std::optional<QueryHit> hit =
        cast_ray(scene, {way.from, lockstone::scale<Real>(way.down, way.to_hub + wheel.radius)}, filter);
    if (!hit || !stands_on(*hit, way.down)) return {};
    return {true, *hit, hit->distance - wheel.radius - wheel.radius};
}

/// What the solid of a wheel found; from a wall beside the wheel, or something it starts in, a ray looks past it.
WheelGround ground_of(const Scene& scene, const QueryFilter& filter, const WheelDef& wheel,
                      const WheelCastWay& way, const std::optional<QueryHit>& solid_hit) {
    if (!solid_hit) return {};
    if (stands_on(*solid_hit, way.down)) return {true, *solid_hit, solid_hit->distance - wheel.radius};
    return cast_ray_wheel(scene, filter, wheel, way);
}

constexpr UnitVec3 up_axis{Unit{}, unit_one, Unit{}};
constexpr Unit half_root = Unit::from_raw(759250125); ///< 1 / sqrt(2)
constexpr Quat y_to_x{Unit{}, Unit{}, -half_root, half_root};

using WheelCastWays = std::array<WheelCastWay, vehicle_wheels_max>;

/// How the wheels are cast from where their chassis stands.
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

using WheelGrounds = std::array<WheelGround, vehicle_wheels_max>;

/// Finds the ground of all wheels of a vehicle.
void cast_wheels(const Scene& scene, const VehicleDef& def, const VehicleMemory& memory, WheelGrounds& out) {
    const QueryFilter filter{def.category, def.mask, 7, 0, def.chassis};
    WheelCastWays ways;
    find_ways(scene.model, def, memory, ways);
    std::array<std::optional<QueryHit>, vehicle_wheels_max> hits;
    if (def.cast == WheelCast::sphere) {
        static_assert(balls_max >= vehicle_wheels_max);
        std::array<BallCast, vehicle_wheels_max> balls;
        for (std::uint32_t i = 0; i < def.wheel_count; ++i)
            balls[i] = {def.wheel[i].radius, ways[i].from, ways[i].way};
        cast_balls(scene, std::span(balls).first(def.wheel_count), filter, hits);
    }
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        const WheelDef& wheel = def.wheel[i];
        if (def.cast == WheelCast::cylinder)
            hits[i] = cast_shape(scene, cylinder(wheel.radius, half(wheel.width)),
                                 {ways[i].from, ways[i].rotation}, ways[i].way, filter);
        out[i] = def.cast == WheelCast::ray ? cast_ray_wheel(scene, filter, wheel, ways[i])
                                            : ground_of(scene, filter, wheel, ways[i], hits[i]);
    }
}

void forget_ground(WheelMemory& m) {
    m.ground = {};
    m.spring = m.stop = m.along = m.across = m.slip = m.slip_side = Real{};
}

Real bounded(Real x, Real most) { return clamp(x, -most, most); }

} // namespace

/// Whether the wheels of a vehicle that sleeps find what they found last, and that sleeps too.
bool VehicleSolver::stands_as_before(const Scene& scene, std::uint32_t k) const {
    const Model& w = scene.model;
    const VehicleDef& def = w.state.rows(w.m.vehicle)[k].def;
    const VehicleMemory& memory = w.state.rows(w.m.vehicle_memory)[k];
    WheelGrounds found;
    cast_wheels(scene, def, memory, found);
    for (std::uint32_t i = 0; i < def.wheel_count; ++i)
        if ((found[i].found ? found[i].hit.shape : ShapeId{}) != memory.wheel[i].ground) return false;
    return true;
}

bool VehicleSolver::cast(Model& w, const Scene& scene) {
    const std::span<const VehicleRow> rows = w.state.rows(w.m.vehicle);
    if (rows.empty()) return false;
    grounds.resize(rows.size());
    bool woke = false;
    for (std::uint32_t k = 0; k < rows.size(); ++k) {
        const VehicleDef& def = rows[k].def;
        if (!is_awake(w, w.row_of(def.chassis))) {
            // Wheels are no shapes: nothing touches them.
            if (w.header().bodies_awake == 0 || stands_as_before(scene, k)) continue;
            wake(w, def.chassis);
            woke = true;
            continue;
        }
        cast_wheels(scene, def, w.state.rows(w.m.vehicle_memory)[k], grounds[k]);
        for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
            const WheelGround& ground = grounds[k][i];
            if (!ground.found || is_awake(w, w.row_of(ground.hit.body))) continue;
            if (w.state.rows(w.m.body_info)[w.row_of(ground.hit.body)].kind != BodyKind::dynamic) continue;
            wake(w, ground.hit.body);
            woke = true;
        }
    }
    return woke;
}

/// To the left, of a wheel that is turned about the chassis' up axis.
static UnitVec3 axle_of(const Rotation& axes, Real steer) {
    if (steer == Real{}) return axes.x;
    const auto turn = sin_cos(steer);
    return lockstone::mul<Unit>(axes, UnitVec3{turn.cos, Unit{}, -turn.sin});
}

/// Implicit: a = h^2 k + h c. Small: below 50 Hz, of a share of up to 1, so rate stays below 2^17 and a below 2^18.
static void set_spring(Real substep, const WheelDef& def, Real share, Wheel& wheel) {
    const Small h = number<Small>(substep), omega = number<Small>(two_pi) * number<Small>(def.frequency),
                stiff = number<Small>(share) * omega * h;
    const Real rate = real(stiff * omega);
    const Real damping[2] = {def.damping_rebound, def.damping_compression};
    for (int side = 0; side < 2; ++side) {
        const Small of_damping = stiff * number<Small>(damping[side]);
        const Real a = real(number<Small>(rate) * h + of_damping + of_damping),
                   whole = Real(1) + a * wheel.normal.kappa;
        wheel.pull[side] = quotient(rate, whole);
        wheel.yield[side] = quotient(a, whole);
    }
}

void prepare_wheel(const VehicleTick& tick, const Rotation& axes, Vehicle& v, std::uint32_t i, Real share,
                   const WheelGround& ground) {
    const Model& w = tick.w;
    const SolverBodies& bodies = tick.bodies;
    const WheelDef& def = v.def->wheel[i];
    WheelMemory& memory = v.memory.wheel[i];
    Wheel& wheel = v.wheel[i] = Wheel{};
    wheel.ground = bodies.still();
    wheel.length = memory.length = def.length_max;
    if (!ground.found) return forget_ground(memory);

    const Transform& pose = w.state.rows(w.m.body_pose)[v.chassis];
    const UnitVec3 down = lockstone::mul<Unit>(axes, def.direction);
    const QueryHit& hit = ground.hit;
    const UnitVec3 n = hit.normal;
    const ShapeTraits& shape = w.traits_of(w.state.rows(w.m.shape)[w.row_of(hit.shape)]);
    const PlacedShapes::Shape& at_ground = tick.placed.shape[hit.shape.index - 1];
    const Touch touch = touch_of(shape, at_ground.solid, hit.feature);
    const std::uint32_t row = w.row_of(hit.body);
    const bool moves = row < bodies.still() && bodies.step[row].moves;
    wheel.ground = moves ? row : bodies.still();
    wheel.rides = moves;
    if (moves && bodies.step[row].movable) wheel.ratio = min(v.mass / w.mass_of(row).mass, ratio_max);
    const Levers levers{Lever(hit.point - pose.position),
                        Lever(hit.point - w.state.rows(w.m.body_pose)[row].position),
                        touch.velocity == Vec3{} ? Vec3{} : rotate(at_ground.pose.rotation, touch.velocity)};
    const UnitVec3 axle = axle_of(axes, memory.steer);
    const UnitVec3 sideways = axle - lockstone::scale<Unit>(n, dot<Unit>(n, axle)),
                   left = sideways == UnitVec3{} ? any_perpendicular(n) : normalized(sideways);
    wheel.normal = line_of(bodies, v.chassis, wheel, n, levers);
    wheel.touches = wheel.normal.kappa > Real{};
    if (!wheel.touches) return forget_ground(memory); // nothing can move
    wheel.along = line_of(bodies, v.chassis, wheel, cross<Unit>(left, n), levers);
    wheel.across = line_of(bodies, v.chassis, wheel, left, levers);
    wheel.mixed = mobility(bodies.body[v.chassis], wheel.along.d, wheel.along.xc, left, wheel.across.xc);
    if (wheel.ratio > Real{})
        wheel.mixed += wheel.ratio * mobility(bodies.body[wheel.ground], wheel.along.d, wheel.along.xg, left,
                                              wheel.across.xg);
    wheel.length_begin = ground.length;
    wheel.per_length = quotient(Real(1), max(-dot<Real>(n, down), 0.5_r));
    wheel.grip = quotient(touch.friction, v.def->tyre[def.tyre].ground_friction);
    set_spring(tick.substep, def, share, wheel);
    // Impulses against another ground are none to start from.
    if (memory.ground != hit.shape) forget_ground(memory);
    memory.ground = hit.shape;
    memory.normal = n;
    wheel.spring = clamp(memory.spring, Real{}, impulse_max);
    wheel.stop = clamp(memory.stop, Real{}, impulse_max);
    wheel.along_p = bounded(memory.along, impulse_max);
    wheel.across_p = bounded(memory.across, impulse_max);
}

// ---- the gearbox ---------------------------------------------------------------------------------------------------

namespace {

std::uint32_t ticks_of(Real seconds, std::int32_t ticks_per_second) {
    const std::int64_t ticks = floor_to_int(seconds * ticks_per_second + half(Real(1)));
    return static_cast<std::uint32_t>(std::clamp<std::int64_t>(ticks, 0, 100000));
}

Real ratio_of(const GearboxDef& box, std::int32_t gear) {
    if (gear == 0) return Real{};
    if (gear < 0) return -(box.reverse * box.final_drive);
    return box.forward[static_cast<std::size_t>(gear - 1)] * box.final_drive;
}

/// The gear an automatic box wants. Wheels that spin do not shift it up: the road has to go by fast enough as well.
std::int32_t automatic_gear(const GearboxDef& box, const VehicleInput& input, std::int32_t gear,
                            Real wheel_speed, Real road_speed) {
    if (input.gear <= 0) return input.gear < 0 ? -1 : 0;
    if (gear <= 0) return 1;
    const Real rpm = wheel_speed * ratio_of(box, gear) * rpm_per_speed;
    const Real rpm_road = road_speed * ratio_of(box, gear) * rpm_per_speed;
    if (rpm > box.rpm_up && rpm_road > box.rpm_up * decimal<Real>("0.7") &&
        gear < static_cast<std::int32_t>(box.forward_count))
        return gear + 1;
    if (rpm >= box.rpm_down || gear == 1) return gear;
    const Real rpm_below = wheel_speed * ratio_of(box, gear - 1) * rpm_per_speed;
    return rpm_below < box.rpm_up ? gear - 1 : gear;
}

} // namespace

void shift_gears(const VehicleTick& tick, const Rotation& axes, Vehicle& v) {
    const Model& w = tick.w;
    VehicleMemory& m = v.memory;
    const GearboxDef& box = v.def->gearbox;
    const std::int32_t rate = tick.step.ticks_per_second;
    const std::int32_t count = static_cast<std::int32_t>(box.forward_count);
    if (m.pause_ticks > 0) --m.pause_ticks;
    if (m.shift_ticks > 0 && --m.shift_ticks == 0) {
        m.gear = m.gear_next;
        m.pause_ticks = ticks_of(box.shift_pause, rate);
    }
    Real turns{}, radius{}, driven{};
    for (std::uint32_t i = 0; i < v.def->wheel_count; ++i) {
        const WheelDef& wheel = v.def->wheel[i];
        const Real share =
            v.def->tracks.enabled != 0 ? Real(1) / Real(v.def->wheel_count) : wheel.drive_share;
        turns += m.wheel[i].spin * share;
        radius += wheel.radius * share;
        driven += share;
    }
    if (driven > Real{} && driven != Real(1)) turns = turns / driven, radius = radius / driven;
    const Real speed = dot<Real>(axes.z, w.state.rows(w.m.body_velocity)[v.chassis].linear);
    std::int32_t wanted = std::clamp(v.input.gear, -1, count);
    if (box.mode == GearboxMode::automatic)
        wanted = automatic_gear(box, v.input, m.gear, turns, radius > Real{} ? speed / radius : Real{});
    const bool chooses = box.mode == GearboxMode::automatic && wanted > 0 && m.gear > 0;
    if (m.shift_ticks == 0 && wanted != m.gear && !(chooses && m.pause_ticks > 0)) {
        m.gear_next = wanted;
        m.shift_ticks = ticks_of(box.shift_time, rate);
        if (m.shift_ticks == 0) m.gear = wanted, m.pause_ticks = ticks_of(box.shift_pause, rate);
    }
    v.ratio = m.shift_ticks > 0 ? Real{} : ratio_of(box, m.gear);
}

// ---- what turns ---------------------------------------------------------------------------------------------------

void prepare_train(Vehicle& v) {
    const VehicleDef& def = *v.def;
    const bool tracked = def.tracks.enabled != 0;
    v.group_count = tracked ? 2 : def.wheel_count;
    v.coupling_count = 0;
    for (std::uint32_t k = 0; k < v.group_count; ++k) {
        SpinGroup& g = v.group[k];
        const Divisor known = g.by_inertia;
        g = SpinGroup{};
        g.by_inertia = known;
    }
    std::array<Real, vehicle_wheels_max> share{};
    Real driven{};
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        const std::uint32_t group = v.wheel[i].group = tracked ? def.wheel[i].track : i;
        SpinGroup& g = v.group[group];
        g.inertia += def.wheel[i].inertia;
        g.first = tracked ? 0 : i, g.last = tracked ? def.wheel_count - 1 : i;
        g.spin = bounded(v.memory.wheel[i].spin, part_spin_max);
        share[group] = tracked ? half(Real(1)) : def.wheel[i].drive_share;
        driven += def.wheel[i].drive_share;
    }
    v.engine_speed = clamp(v.memory.engine_speed, Real{}, part_spin_max);
    if (v.ratio != Real{} && (tracked || driven > Real{})) {
        Coupling& c = v.coupling[v.coupling_count++];
        c = Coupling{};
        c.source = coupling_clutch, c.engine = Real(1), c.impulse = v.memory.clutch;
        for (std::uint32_t g = 0; g < v.group_count; ++g) c.group[g] = -(v.ratio * share[g]);
    } else {
        v.memory.clutch = Real{};
    }
    for (std::uint32_t d = 0; d < vehicle_couplings_max && !tracked; ++d) {
        const Differential& diff = def.differential[d];
        if (diff.kind == DifferentialKind::open || diff.wheels_a == 0 || diff.wheels_b == 0) continue;
        Coupling& c = v.coupling[v.coupling_count++];
        c = Coupling{};
        c.source = d, c.impulse = v.memory.differential[d];
        for (std::uint32_t g = 0; g < v.group_count; ++g) {
            if ((diff.wheels_a >> g & 1u) != 0) c.group[g] = Real(1) / Real(std::popcount(diff.wheels_a));
            if ((diff.wheels_b >> g & 1u) != 0) c.group[g] = -(Real(1) / Real(std::popcount(diff.wheels_b)));
        }
    }
    if (tracked) { // left faster than right by steer / ratio of the engine's speed
        Coupling& c = v.coupling[v.coupling_count++];
        c = Coupling{};
        c.source = coupling_steering, c.engine = v.memory.steer / def.tracks.steer_ratio;
        c.impulse = v.memory.steer_coupling;
        c.group[0] = Real(-1);
        c.group[1] = Real(1);
    }
    for (std::uint32_t k = 0; k < v.coupling_count; ++k)
        for (std::uint32_t g = 0; g < v.group_count; ++g)
            v.group[g].coupled = v.group[g].coupled || v.coupling[k].group[g] != Real{};
}

static TyreCurve curve_of(const std::array<CurvePoint, 4>& points) {
    TyreCurve out{};
    out.from_zero = points[0].x == Real{} && points[0].y == Real{};
    for (std::size_t i = 0; i < points.size(); ++i) {
        out.x[i] = points[i].x, out.y[i] = points[i].y;
        out.peak = max(out.peak, points[i].y);
        if (i == 0) continue;
        out.run[i - 1] = points[i].x - points[i - 1].x;
        out.rise[i - 1] = points[i].y - points[i - 1].y;
    }
    return out;
}

void prepare_rims(const solve::StepConstants& step, Vehicle& v) {
    std::uint32_t tyres = 0;
    for (std::uint32_t k = 0; k < v.group_count; ++k)
        if (SpinGroup& g = v.group[k]; g.by_inertia.of != g.inertia || g.inertia <= Real{})
            g.by_inertia = Divisor::make(g.inertia);
    const Real per_second = Real(step.substeps_per_second);
    for (std::uint32_t i = 0; i < v.def->wheel_count; ++i) {
        const WheelDef& def = v.def->wheel[i];
        Wheel& wheel = v.wheel[i];
        SpinGroup& g = v.group[wheel.group];
        tyres |= 1u << def.tyre;
        wheel.tyre = def.tyre, wheel.radius = def.radius;
        wheel.brake_torque = v.input.brake * def.brake_torque + v.input.hand_brake * def.hand_brake_torque;
        if (wheel.brake_torque != Real{}) wheel.brake_torque = wheel.brake_torque / per_second;
        if (!wheel.touches) continue;
        ++g.on_ground;
        const Real lever = def.radius * v.mass;
        wheel.rolling = v.def->tyre[def.tyre].rolling_resistance * lever;
        wheel.arm = lever / g.by_inertia;
        wheel.kappa_rim = wheel.along.kappa + wheel.arm * def.radius;
        wheel.stiff = def.radius * lever;
        wheel.ordinary = wheel.arm < small_arm && wheel.kappa_rim < small_kappa_rim &&
                         max(max(wheel.normal.kappa, wheel.along.kappa),
                             max(wheel.across.kappa, abs(wheel.mixed))) < small_kappa;
    }
    v.any_in_air = false;
    for (std::uint32_t k = 0; k < v.group_count; ++k) {
        SpinGroup& g = v.group[k];
        v.any_in_air = v.any_in_air || g.on_ground == 0;
        if (g.coupled) g.answer_free = quotient(Real(1), g.inertia);
    }
    for (std::uint32_t t = 0; t < vehicle_tyres_max; ++t) {
        if ((tyres >> t & 1u) == 0) continue;
        v.along[t] = curve_of(v.def->tyre[t].along);
        v.across[t] = curve_of(v.def->tyre[t].across);
    }
}

namespace {

void prepare_bars(const solve::StepConstants& step, const SolverBodies& bodies, Vehicle& v) {
    for (std::uint32_t k = 0; k < vehicle_couplings_max; ++k) {
        const AntiRollBar& bar = v.def->anti_roll[k];
        Wheel &a = v.wheel[bar.wheel_a], &b = v.wheel[bar.wheel_b];
        Real& p = v.memory.anti_roll[k];
        BarRow& row = v.bar[k] = BarRow{};
        row.holds = bar.wheel_a != bar.wheel_b && bar.stiffness > Real{} && a.touches && b.touches;
        p = row.holds ? bounded(p, impulse_max) : Real{};
        a.bars += p;
        b.bars -= p;
        if (!row.holds) continue;
        const WheelLine &of_a = a.normal, &of_b = b.normal;
        const Real shared = mobility(bodies.body[v.chassis], of_a.d, of_a.xc, of_b.d, of_b.xc);
        row.kappa = max(of_a.kappa + of_b.kappa - shared * 2, Real{});
        const Real rate = bar.stiffness / v.mass / Real(step.substeps_per_second);
        const Real soft = rate / Real(step.substeps_per_second), whole = Real(1) + soft * row.kappa;
        row.pull = quotient(rate, whole), row.yield = quotient(soft, whole);
    }
}

} // namespace

/// Vehicles that push the same body belong together: the chassis of one may be what another stands on. A ground that
/// nothing pushes may be shared.
void VehicleSolver::find_convoys(const SolverBodies& bodies) {
    const std::uint32_t count = static_cast<std::uint32_t>(vehicles.size());
    pushed.clear(), order.clear(), convoy.clear(), convoy_begin.clear();
    for (std::uint32_t k = 0; k < count; ++k) {
        convoy.push_back(k);
        order.push_back(k);
        pushed.push_back({vehicles[k].chassis, k});
        for (std::uint32_t i = 0; i < vehicles[k].def->wheel_count; ++i)
            if (bodies.step[vehicles[k].wheel[i].ground].movable)
                pushed.push_back({vehicles[k].wheel[i].ground, k});
    }
    std::sort(pushed.begin(), pushed.end());
    const auto first_of = [&](std::uint32_t k) {
        while (convoy[k] != k) k = convoy[k];
        return k;
    };
    for (std::size_t i = 1; i < pushed.size(); ++i) {
        if (pushed[i].body != pushed[i - 1].body) continue;
        const std::uint32_t a = first_of(pushed[i].vehicle), b = first_of(pushed[i - 1].vehicle);
        convoy[std::max(a, b)] = std::min(a, b);
    }
    for (std::uint32_t k = 0; k < count; ++k) convoy[k] = first_of(k);
    std::sort(order.begin(), order.end(), [&](std::uint32_t x, std::uint32_t y) {
        return std::pair(convoy[x], x) < std::pair(convoy[y], y);
    });
    for (std::uint32_t i = 0; i < count; ++i)
        if (i == 0 || convoy[order[i]] != convoy[order[i - 1]]) convoy_begin.push_back(i);
    convoy_begin.push_back(count);
}

void VehicleSolver::prepare(const Scene& scene, const solve::StepConstants& step,
                            const SolverBodies& bodies) {
    const Model& w = scene.model;
    const std::span<const VehicleRow> rows = w.state.rows(w.m.vehicle);
    const std::span<const VehicleMemory> memories = w.state.rows(w.m.vehicle_memory);
    tasks = scene.tasks;
    substeps_left = step.substeps;
    vehicles.resize(rows.size()), shares.resize(rows.size());
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < rows.size(); ++i) {
        const std::uint32_t chassis = w.row_of(rows[i].def.chassis);
        if (chassis >= bodies.still()) continue; // it sleeps
        Vehicle& v = vehicles[count++];
        v.row = i;
        v.chassis = chassis;
    }
    vehicles.resize(count);
    const VehicleTick tick{w, scene.placed, step, bodies, Real(1) / Real(step.substeps_per_second)};
    base::for_chunks(tasks, count, 1, [&](std::uint32_t k, std::uint32_t, std::uint32_t) {
        Vehicle& v = vehicles[k];
        v.def = &rows[v.row].def;
        v.input = rows[v.row].input;
        v.memory = memories[v.row];
        v.mass = w.mass_of(v.chassis).mass;
        const Real way = v.def->steer_speed / Real(step.ticks_per_second);
        const Real turn = v.input.steer - v.memory.steer;
        v.memory.steer = way > Real{} ? v.memory.steer + bounded(turn, way) : v.input.steer;
        find_shares(*v.def, w.mass_of(v.chassis).center, shares[v.row]);
        const Rotation axes = to_rotation(w.state.rows(w.m.body_pose)[v.chassis].rotation);
        find_steer_angles(*v.def, v.memory.steer, v.memory);
        for (std::uint32_t i = 0; i < v.def->wheel_count; ++i)
            prepare_wheel(tick, axes, v, i, shares[v.row].share[i], grounds[v.row][i]);
        prepare_bars(step, bodies, v);
        shift_gears(tick, axes, v);
        prepare_train(v);
        prepare_rims(step, v);
        prepare_engine(step, v);
    });
    find_convoys(bodies);
}

void VehicleSolver::poison(std::byte with) {
    auto& [left, stand_list, vehicle_list, share_list, pool, order_list, begin_list, pushed_list, convoy_list,
           ground_list] = *this;
    base::poison(with, stand_list, vehicle_list, share_list, pool, order_list, begin_list, pushed_list,
                 convoy_list, ground_list);
}

} // namespace lockstone::sim
