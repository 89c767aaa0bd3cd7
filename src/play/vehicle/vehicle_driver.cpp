// Steering, gearbox, and the data of a vehicle that is written back to the state.
#include "play/vehicle/vehicle_driver.h"

#include "base/poison.h"
#include "lockstone/math/math.h"
#include "model/sleep.h"
#include "scene/surface.h"

#include <algorithm>

namespace lockstone::sim {

namespace {

// ---- steering ------------------------------------------------------------------------------------------------------

/// Computes the angle of each wheel, positive to the left [rad].
void find_steer_angles(const VehicleDef& def, Real steer, VehicleMemory& out) {
    // The turning centre is on the line of the wheels that do not steer. If all wheels steer, it is on the line
    // through their mean.
    Real fixed{}, fixed_count{}, all{};
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        out.wheel[i].steer = Real{};
        all += def.wheel[i].attachment.z;
        if (def.wheel[i].steer_max != Real{}) continue;
        fixed += def.wheel[i].attachment.z;
        fixed_count += Real(1);
    }
    if (steer == Real{} || def.tracks.enabled != 0) return;
    const Real line = fixed_count > Real{} ? fixed / fixed_count : all / Real(def.wheel_count);
    Real known{}, known_slope{}; // cache of tan(parallel), for wheels with equal angles
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        const WheelDef& own = def.wheel[i];
        if (own.steer_max == Real{}) continue;
        const Real parallel = out.wheel[i].steer = -steer * own.steer_max;
        Real ahead = own.attachment.z - line;
        if (def.ackermann == Real{} || ahead == Real{}) continue;
        if (parallel != known) known = parallel, known_slope = tan(parallel);
        Real slope = known_slope;
        if (ahead < Real{}) ahead = -ahead, slope = -slope; // a rear axle is a mirrored front axle
        const Real ideal = atan2(ahead * slope, ahead - own.attachment.x * slope);
        const Real turned = own.attachment.z < line ? -ideal : ideal;
        out.wheel[i].steer = parallel + (turned - parallel) * def.ackermann;
    }
}

/// Moves the steering wheel towards the input, at most by steer_speed, and turns the wheels.
void steer(const Model& w, solve::DrivenVehicle& v) {
    const Real way = v.def->steer_speed / Real(w.config().tick_rate);
    const Real turn = v.input.steer - v.memory.steer;
    v.memory.steer = way > Real{} ? v.memory.steer + clamp(turn, -way, way) : v.input.steer;
    find_steer_angles(*v.def, v.memory.steer, v.memory);
}

// ---- the gearbox ---------------------------------------------------------------------------------------------------

std::uint32_t ticks_of(Real seconds, std::int32_t ticks_per_second) {
    const std::int64_t ticks = floor_to_int(seconds * ticks_per_second + half(Real(1)));
    return static_cast<std::uint32_t>(std::clamp<std::int64_t>(ticks, 0, 100000));
}

Real ratio_of(const GearboxDef& box, std::int32_t gear) {
    if (gear == 0) return Real{};
    if (gear < 0) return -(box.reverse * box.final_drive);
    return box.forward[static_cast<std::size_t>(gear - 1)] * box.final_drive;
}

/// The gear that an automatic gearbox selects. It shifts up only if the road speed is high enough too, because wheels
/// may spin.
std::int32_t automatic_gear(const GearboxDef& box, const VehicleInput& input, std::int32_t gear,
                            Real wheel_speed, Real road_speed) {
    if (input.gear <= 0) return input.gear < 0 ? -1 : 0;
    if (gear <= 0) return 1;
    const Real rpm = wheel_speed * ratio_of(box, gear) * solve::rpm_per_speed;
    const Real rpm_road = road_speed * ratio_of(box, gear) * solve::rpm_per_speed;
    if (rpm > box.rpm_up && rpm_road > box.rpm_up * decimal<Real>("0.7") &&
        gear < static_cast<std::int32_t>(box.forward_count))
        return gear + 1;
    if (rpm >= box.rpm_down || gear == 1) return gear;
    const Real rpm_below = wheel_speed * ratio_of(box, gear - 1) * solve::rpm_per_speed;
    return rpm_below < box.rpm_up ? gear - 1 : gear;
}

void shift_gears(const Model& w, solve::DrivenVehicle& v) {
    VehicleMemory& m = v.memory;
    const GearboxDef& box = v.def->gearbox;
    const std::int32_t rate = static_cast<std::int32_t>(w.config().tick_rate);
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
    const Real speed = dot<Real>(v.axes.z, w.state.rows(w.m.body_velocity)[v.chassis].linear);
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

// ---- ground of the wheels ------------------------------------------------------------------------------------------

solve::WheelGround ground_of(const Scene& scene, const WheelHit& wheel) {
    const FirstHit& hit = wheel.hit;
    if (!hit.shape) return {};
    const Model& w = scene.model;
    const ShapeTraits& shape = w.traits_of(w.state.rows(w.m.shape)[w.row_of(hit.shape)]);
    const PlacedShapes::Shape& placed = scene.placed.shape[hit.shape.index - 1];
    const Touch touch = touch_of(shape, placed, hit.feature);
    return {hit.shape,
            std::min(w.row_of(hit.body), w.header().bodies_awake),
            hit.point,
            hit.normal,
            wheel.length,
            touch.friction,
            touch.velocity == Vec3{} ? Vec3{} : rotate(placed.pose.rotation, touch.velocity)};
}

// ---- sleep ---------------------------------------------------------------------------------------------------------

/// True if the vehicle is not driven and nothing in it turns. It may then sleep once its chassis is at rest.
bool is_parked(const Model& w, const solve::DrivenVehicle& v) {
    const Real slow = w.config().sleep_speed;
    const Real engine_before = w.state.rows(w.m.vehicle_memory)[v.row].engine_speed;
    if (v.input.throttle != Real{} || v.input.steer != v.memory.steer || v.memory.shift_ticks != 0)
        return false;
    if (abs(v.memory.engine_speed - engine_before) > Real(1)) return false; // [rad/s] per tick
    for (std::uint32_t i = 0; i < v.def->wheel_count; ++i)
        if (abs(v.memory.wheel[i].spin * v.def->wheel[i].radius) > slow) return false;
    return true;
}

} // namespace

std::span<solve::DrivenVehicle> VehicleDriver::drive(const Scene& scene) {
    const Model& w = scene.model;
    const std::span<const VehicleRow> rows = w.state.rows(w.m.vehicle);
    const std::span<const VehicleMemory> memories = w.state.rows(w.m.vehicle_memory);
    vehicles.resize(rows.size());
    std::size_t count = 0;
    for (std::uint32_t row = 0; row < rows.size(); ++row) {
        const std::uint32_t chassis = w.row_of(rows[row].def.chassis);
        if (!is_awake(w, chassis)) continue;
        solve::DrivenVehicle& v = vehicles[count++];
        v.def = &rows[row].def, v.input = rows[row].input, v.memory = memories[row];
        v.row = row, v.chassis = chassis;
        v.axes = to_rotation(w.state.rows(w.m.body_pose)[chassis].rotation);
        steer(w, v);
        shift_gears(w, v);
        for (std::uint32_t i = 0; i < v.def->wheel_count; ++i) v.ground[i] = ground_of(scene, hits[row][i]);
    }
    vehicles.resize(count);
    return vehicles;
}

void VehicleDriver::store(Model& w) const {
    for (const solve::DrivenVehicle& v : vehicles) {
        if (!is_parked(w, v)) restart(w.state.edit_row(w.m.body_sleep, v.chassis));
        w.state.edit_row(w.m.vehicle_memory, v.row) = v.memory;
    }
}

void VehicleDriver::poison(std::byte with) {
    auto& [near_list, hit_list, vehicle_list] = *this;
    near_list.clear();
    base::poison(with, hit_list, vehicle_list);
}

} // namespace lockstone::sim
