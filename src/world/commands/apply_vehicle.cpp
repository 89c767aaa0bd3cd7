// Creates and destroys vehicles, and sets their input.
#include "world/commands/applier.h"

#include "model/sleep.h"

namespace lockstone::sim {

using Applied = World::Applied;
using base::join;

namespace {

/// The slot of the vehicle whose chassis is a body, 0: none.
std::uint32_t vehicle_of(const Model& w, BodyId body) {
    for (const VehicleRow& row : w.state.rows(w.m.vehicle))
        if (row.def.chassis == body) return row.id.index;
    return 0;
}

VehicleMemory parked(const VehicleDef& def) {
    constexpr Real speed_per_rpm = decimal<Real>("0.10471975511965977462"); // 2 pi / 60
    VehicleMemory m{};
    m.engine_speed = def.engine.rpm_idle * speed_per_rpm;
    m.gear = 1;
    for (std::uint32_t i = 0; i < def.wheel_count; ++i) {
        m.wheel[i].normal = {Unit{}, unit_one, Unit{}};
        m.wheel[i].length = def.wheel[i].length_max;
    }
    return m;
}

} // namespace

Result<World::Applied> Applier::operator()(const CreateVehicle& c) {
    const VehicleDef& def = *c.def;
    if (std::string e = validate(def); !e.empty()) return Error{"create_vehicle: " + e};
    const BodyId chassis = def.chassis;
    const std::uint32_t body = w.row_of(chassis);
    if (body == Model::dead) return dead_body("create_vehicle", chassis);
    if (w.state.rows(w.m.body_info)[body].kind != BodyKind::dynamic)
        return Error{"create_vehicle: the chassis must be a dynamic body"};
    if (vehicle_of(w, chassis) != 0)
        return Error{join("create_vehicle: body ", text_of(chassis), " already has a vehicle")};
    const std::uint32_t row = w.state.count(w.m.vehicles);
    if (row == w.state.rows_max(w.m.vehicles))
        return Error{join("create_vehicle: the world is full: vehicles_max is ", row)};
    w.state.make_room({w.m.vehicle_slots, w.m.vehicles}, 1);
    const std::uint32_t index = take_slot(w, w.m.vehicle_slots, w.m.vehicle_slot, &Header::vehicle_free, row);
    const VehicleId id{index, w.state.rows(w.m.vehicle_slot)[index - 1].generation};
    w.state.resize(w.m.vehicles, row + 1);
    w.state.edit_row(w.m.vehicle, row) = {id, def, VehicleInput{}};
    w.state.edit_row(w.m.vehicle_memory, row) = parked(def);
    wake(chassis);
    return Applied{.vehicle = id};
}

Result<World::Applied> Applier::operator()(const DestroyVehicle& c) {
    const std::uint32_t row = w.row_of(c.vehicle);
    if (row == Model::dead) return dead("destroy_vehicle", "vehicle", c.vehicle);
    wake(w.state.rows(w.m.vehicle)[row].def.chassis);
    remove_vehicle(c.vehicle.index);
    return Applied{};
}

Result<World::Applied> Applier::operator()(const SetVehicleInput& c) {
    const std::uint32_t row = w.row_of(c.vehicle);
    if (row == Model::dead) return dead("set_vehicle_input", "vehicle", c.vehicle);
    if (std::string e = validate(c.input); !e.empty()) return Error{"set_vehicle_input: " + e};
    if (w.state.rows(w.m.vehicle)[row].input == c.input) return Applied{}; // lets a parked car sleep
    w.state.edit_row(w.m.vehicle, row).input = c.input;
    wake(w.state.rows(w.m.vehicle)[row].def.chassis);
    return Applied{};
}

void Applier::remove_vehicle(std::uint32_t slot) {
    const std::uint32_t row = w.state.rows(w.m.vehicle_slot)[slot - 1].row;
    const VehicleId moved = w.state.rows(w.m.vehicle).back().id;
    remove_row(w.state, w.m.vehicles, row);
    w.state.edit_row(w.m.vehicle_slot, moved.index - 1).row = row;
    free_slot(w.state, w.m.vehicle_slot, slot, w.edit_header().vehicle_free);
}

void Applier::remove_vehicle_of(BodyId chassis) {
    if (const std::uint32_t slot = vehicle_of(w, chassis); slot != 0) remove_vehicle(slot);
}

} // namespace lockstone::sim
