// World's members for vehicles.
#include "base/assert.h"
#include "lockstone/math/math.h"
#include "world/world_impl.h"

namespace lockstone {

namespace {

std::uint32_t living(const sim::Model& w, VehicleId id) {
    const std::uint32_t row = w.row_of(id);
    LOCKSTONE_ASSERT(row != sim::Model::dead, "vehicle ", id.index, ":", id.generation, " is not alive");
    return row;
}

} // namespace

Result<VehicleId> World::create_vehicle(const VehicleDef& def) {
    const Result<Applied> applied = apply(CreateVehicle{def});
    if (!applied) return applied.error();
    return applied->vehicle;
}
Status World::destroy(VehicleId vehicle) {
    const Result<Applied> applied = apply(DestroyVehicle{vehicle});
    return applied ? Status{} : Status{applied.error()};
}
Status World::set_vehicle_input(VehicleId vehicle, const VehicleInput& input) {
    const Result<Applied> applied = apply(SetVehicleInput{vehicle, input});
    return applied ? Status{} : Status{applied.error()};
}

bool World::is_alive(VehicleId vehicle) const { return impl->row_of(vehicle) != sim::Model::dead; }
std::uint32_t World::vehicle_count() const { return impl->state.count(impl->m.vehicles); }
VehicleId World::vehicle_at(std::uint32_t row) const {
    return sim::checked_row(impl->state.rows(impl->m.vehicle), row, "vehicle").id;
}
const VehicleDef& World::vehicle(VehicleId vehicle) const {
    return impl->state.rows(impl->m.vehicle)[living(*impl, vehicle)].def;
}
VehicleInput World::vehicle_input(VehicleId vehicle) const {
    return impl->state.rows(impl->m.vehicle)[living(*impl, vehicle)].input;
}

VehicleState World::vehicle_state(VehicleId id) const {
    constexpr UnitVec3 up{Unit{}, unit_one, Unit{}};
    constexpr Real rpm_per_speed = decimal<Real>("9.54929658551372014613"); // 60 / (2 pi)
    const std::uint32_t row = living(*impl, id);
    const VehicleDef& def = impl->state.rows(impl->m.vehicle)[row].def;
    const sim::VehicleMemory& memory = impl->state.rows(impl->m.vehicle_memory)[row];
    const Transform body = pose(def.chassis);
    const Real per_second = Real(std::int64_t{impl->def.tick_rate} * impl->def.substeps);
    const Real newtons = mass(def.chassis) * per_second;
    VehicleState out{};
    out.rpm = memory.engine_speed * rpm_per_speed;
    out.gear = memory.gear;
    out.shifting = memory.shift_ticks > 0 ? 1 : 0;
    out.clutch_torque = memory.clutch * per_second;
    out.wheel_count = def.wheel_count;
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        const sim::WheelMemory& m = memory.wheel[i];
        const WheelDef& d = def.wheel[i];
        WheelState& wheel = out.wheel[i];
        const Vec3 hub = d.attachment + scale<Real>(d.direction, m.length);
        wheel.pose = {body * hub, normalized(body.rotation * from_axis_angle(up, m.steer))};
        wheel.rotation = m.rotation;
        wheel.spin = m.spin;
        wheel.length = m.length;
        wheel.steer = m.steer;
        Real normal = m.spring + m.stop;
        for (std::uint32_t k = 0; k < vehicle_couplings_max; ++k) {
            if (def.anti_roll[k].wheel_a == def.anti_roll[k].wheel_b) continue;
            if (def.anti_roll[k].wheel_a == i) normal += memory.anti_roll[k];
            if (def.anti_roll[k].wheel_b == i) normal -= memory.anti_roll[k];
        }
        wheel.load = normal * newtons;
        wheel.along = m.along * newtons;
        wheel.across = m.across * newtons;
        wheel.slip = m.slip;
        wheel.slip_side = m.slip_side;
        wheel.ground = m.ground;
    }
    return out;
}

} // namespace lockstone
