// The state rows of vehicles: definition, input, and the memory from tick to tick.
#pragma once

#include "lockstone/play/vehicle.h"

namespace lockstone::solve {

/// A vehicle as commands set it.
struct VehicleRow {
    VehicleId id;
    VehicleDef def;
    VehicleInput input;
};

/// The memory of a wheel from tick to tick. Impulses are per substep, divided by the mass of the chassis [m/s].
struct WheelMemory {
    ShapeId ground;  ///< null: in the air
    UnitVec3 normal; ///< of the ground
    std::uint32_t reserved;
    Real rotation;      ///< [rad], 0..2 pi
    Real spin;          ///< [rad/s]; all wheels of a track have the same spin
    Real length;        ///< of the suspension [m]
    Real steer;         ///< [rad], to the left
    Real spring, stop;  ///< along the normal, at least 0
    Real along, across; ///< of the tyre
    Real slip, slip_side;
};

struct VehicleMemory {
    Real engine_speed;           ///< [rad/s]
    Real steer;                  ///< position of the steering wheel, -1..1
    std::int32_t gear;           ///< engaged: -1..8
    std::int32_t gear_next;      ///< the next gear, while shifting
    std::uint32_t shift_ticks;   ///< ticks until the clutch closes again
    std::uint32_t pause_ticks;   ///< ticks until an automatic gearbox may shift again
    Real clutch, steer_coupling; ///< impulses per substep [N m s], at the engine; between the tracks
    std::array<Real, vehicle_couplings_max> differential; ///< [N m s] per substep
    std::array<Real, vehicle_couplings_max> anti_roll;    ///< on wheel_a, in the unit of WheelMemory::spring
    std::array<WheelMemory, vehicle_wheels_max> wheel;
};

template <class V> constexpr void describe(VehicleRow& r, V&& v) {
    v("id", r.id), v("def", r.def), v("input", r.input);
}
template <class V> constexpr void describe(WheelMemory& w, V&& v) {
    v("ground", w.ground), v("normal", w.normal), v("reserved", w.reserved), v("rotation", w.rotation);
    v("spin", w.spin), v("length", w.length), v("steer", w.steer), v("spring", w.spring), v("stop", w.stop);
    v("along", w.along), v("across", w.across), v("slip", w.slip), v("slip_side", w.slip_side);
}
template <class V> constexpr void describe(VehicleMemory& m, V&& v) {
    v("engine_speed", m.engine_speed), v("steer", m.steer), v("gear", m.gear), v("gear_next", m.gear_next);
    v("shift_ticks", m.shift_ticks), v("pause_ticks", m.pause_ticks), v("clutch", m.clutch);
    v("steer_coupling", m.steer_coupling), v("differential", m.differential), v("anti_roll", m.anti_roll);
    v("wheel", m.wheel);
}

static_assert(StateRow<VehicleRow> && StateRow<VehicleMemory>);

} // namespace lockstone::solve
