// The table of contents of a world's state: every table and column, in hash order.
#pragma once

#include "lockstone/state.h"
#include "lockstone/world_def.h"
#include "model/character_row.h"
#include "model/contact_rows.h"
#include "model/shared_rows.h"
#include "solve/bodies/solver_body.h"
#include "solve/vehicles/vehicle_rows.h"

#include <memory>

namespace lockstone::sim {

using solve::BodyForce;
using solve::BodyInfo;
using solve::BodyMass;
using solve::BodySleep;
using solve::BodyTraits;
using solve::FieldRow;
using solve::JointMemory;
using solve::JointRow;
using solve::VehicleMemory;
using solve::VehicleRow;
using solve::Velocity;
using solve::WheelMemory;

/// Data of a world that belongs to no object.
struct Header {
    std::uint64_t tick;
    std::uint64_t commands; ///< number applied so far
    Vec3 gravity;
    /// First free slot + 1, 0: none
    std::uint32_t body_free, shape_free, field_free, joint_free, character_free, vehicle_free;
    std::uint32_t body_traits_free, shape_traits_free; ///< first free row + 1, 0: none
    std::uint32_t bodies_awake, joints_awake; ///< the number of first rows that are awake; see sleep.h
};

/// All of the definition from which the world was created; never changes.
struct Config {
    std::uint32_t tick_rate, substeps;
    Integrator integrator;
    std::uint32_t bounds_shift;
    std::uint32_t bodies_max, shapes_max, contacts_max, fields_max, pair_filters_max, joints_max;
    std::uint32_t characters_max, vehicles_max, continuous, sleeping;
    Vec3 gravity; ///< at the start; the header has the present one
    Real restitution_speed_min, contact_hertz, contact_damping, push_speed_max;
    Real sleep_speed, sleep_time;
    std::uint64_t seed;
};

/// The present row of the object with an id. The generation of a slot increases when its object is destroyed.
struct Slot {
    std::uint32_t row;        ///< in the dense table; if free: is_free plus the next free slot + 1, 0: last
    std::uint32_t generation; ///< of the living object, or if free, of the next one; never 0

    static constexpr std::uint32_t is_free = 0x80000000u; ///< bit
    constexpr bool is_alive() const { return (row & is_free) == 0; }
    constexpr std::uint32_t next_free() const { return row & ~is_free; }
};

struct ShapeRow {
    ShapeId id;
    BodyId body;
    std::uint64_t user_key;
    std::uint32_t next_shape; ///< of the same body: slot + 1, 0: last
    std::uint32_t traits;     ///< row of the table of ShapeTraits
};

/// The properties of a shape, from ShapeDef. Shapes with equal traits share one row.
struct ShapeTraits {
    Geometry geometry;
    Transform local;
    Real density, friction, restitution, rolling_resistance;
    Vec3 surface_velocity;
    Mix friction_mix, restitution_mix;
    std::uint32_t material, category, mask;
    std::int32_t group;
    std::uint32_t sensor, one_way;
};

/// Two bodies that a pair filter keeps from touching; a < b. The table is sorted.
struct PairFilterRow {
    BodyId a, b;
    friend constexpr auto operator<=>(const PairFilterRow&, const PairFilterRow&) = default;
};

template <class V> constexpr void describe(Header& h, V&& v) {
    v("tick", h.tick), v("commands", h.commands), v("gravity", h.gravity), v("body_free", h.body_free);
    v("shape_free", h.shape_free), v("field_free", h.field_free), v("joint_free", h.joint_free);
    v("character_free", h.character_free), v("vehicle_free", h.vehicle_free);
    v("body_traits_free", h.body_traits_free), v("shape_traits_free", h.shape_traits_free);
    v("bodies_awake", h.bodies_awake), v("joints_awake", h.joints_awake);
}
template <class V> constexpr void describe(Config& c, V&& v) {
    v("tick_rate", c.tick_rate), v("substeps", c.substeps), v("integrator", c.integrator);
    v("bounds_shift", c.bounds_shift), v("bodies_max", c.bodies_max), v("shapes_max", c.shapes_max);
    v("contacts_max", c.contacts_max), v("fields_max", c.fields_max);
    v("pair_filters_max", c.pair_filters_max), v("joints_max", c.joints_max);
    v("characters_max", c.characters_max), v("vehicles_max", c.vehicles_max);
    v("continuous", c.continuous), v("sleeping", c.sleeping), v("gravity", c.gravity);
    v("restitution_speed_min", c.restitution_speed_min), v("contact_hertz", c.contact_hertz);
    v("contact_damping", c.contact_damping), v("push_speed_max", c.push_speed_max);
    v("sleep_speed", c.sleep_speed), v("sleep_time", c.sleep_time), v("seed", c.seed);
}
template <class V> constexpr void describe(Slot& s, V&& v) { v("row", s.row), v("generation", s.generation); }
template <class V> constexpr void describe(ShapeRow& s, V&& v) {
    v("id", s.id), v("body", s.body), v("user_key", s.user_key), v("next_shape", s.next_shape);
    v("traits", s.traits);
}
template <class V> constexpr void describe(ShapeTraits& t, V&& v) {
    v("geometry", t.geometry), v("local", t.local);
    v("density", t.density), v("friction", t.friction), v("restitution", t.restitution);
    v("rolling_resistance", t.rolling_resistance), v("surface_velocity", t.surface_velocity);
    v("friction_mix", t.friction_mix), v("restitution_mix", t.restitution_mix);
    v("material", t.material), v("category", t.category), v("mask", t.mask), v("group", t.group);
    v("sensor", t.sensor), v("one_way", t.one_way);
}
template <class V> constexpr void describe(PairFilterRow& r, V&& v) { v("a", r.a), v("b", r.b); }

/// The manifest. Its order is the order of the hash, the dump and the portable image.
struct Manifest {
    std::shared_ptr<const StateLayout> layout;
    TableId character_slots, characters;
    TableId world, body_slots, bodies, forces, shape_slots, shapes, field_slots, fields, pair_filters,
        joint_slots, joints, vehicle_slots, vehicles, records;

    Column<Header> header;
    Column<Config> config;
    Column<Faults> faults;

    Column<Slot> body_slot;
    Column<BodyInfo> body_info;
    SharedTable<BodyTraits> body_traits;
    Column<std::uint32_t> body_push; ///< row + 1 in forces, 0: no force
    Column<BodyForce> force;
    Column<std::uint32_t> pushed; ///< slot + 1 of the body on which the force acts
    Column<Slot> shape_slot;
    Column<ShapeRow> shape;
    SharedTable<ShapeTraits> shape_traits;
    Column<Slot> field_slot;
    Column<FieldRow> field;
    Column<PairFilterRow> pair_filter;
    Column<Slot> joint_slot;
    Column<JointRow> joint;
    Column<Slot> character_slot;
    Column<CharacterRow> character;
    Column<Slot> vehicle_slot;
    Column<VehicleRow> vehicle;

    Column<Transform> body_pose;
    Column<Velocity> body_velocity;
    Column<BodySleep> body_sleep;

    ContactTables contacts, sleeping_contacts; ///< sleeping_contacts: contacts without an awake body
    Column<JointMemory> joint_memory;
    Column<VehicleMemory> vehicle_memory;

    std::vector<std::uint32_t> game; ///< column index in the layout, by game schema entry
};

/// `origin`: StateLayout::origin.
Manifest make_manifest(const WorldDef& def, const GameSchema& schema, std::uint64_t origin = 0);

} // namespace lockstone::sim
