#include "model/manifest.h"

namespace lockstone::sim {

/// Adds a table that begins without memory and grows with its rows.
static TableId add_growing(StateLayout& l, std::string name, std::uint32_t rows_max) {
    return l.add_table(std::move(name), 0, rows_max);
}

/// Adds objects with ids: the table "body_slots" with its column "body.slot", and the table "bodies", which is
/// returned.
static TableId add_objects(StateLayout& l, const std::string& one, const std::string& many,
                           std::uint32_t rows_max, TableId& slots, Column<Slot>& slot) {
    slots = add_growing(l, one + "_slots", rows_max);
    slot = l.add_column<Slot>(slots, one + ".slot", Group::definition);
    return add_growing(l, many, rows_max);
}

/// Adds a table of shared rows: "body_traits.row" and "body_traits.uses".
template <class T>
static SharedTable<T> add_shared(StateLayout& l, const std::string& name, std::uint32_t rows_max) {
    SharedTable<T> t;
    t.table = add_growing(l, name, rows_max);
    t.row = l.add_column<T>(t.table, name + ".row", Group::definition);
    t.uses = l.add_column<SharedUses>(t.table, name + ".uses", Group::definition);
    return t;
}

/// Adds characters and vehicles.
static void add_bodies_of_play(StateLayout& l, const WorldDef& def, Manifest& m) {
    m.characters =
        add_objects(l, "character", "characters", def.characters_max, m.character_slots, m.character_slot);
    m.character = l.add_column<CharacterRow>(m.characters, "character.row", Group::definition);
    m.vehicles = add_objects(l, "vehicle", "vehicles", def.vehicles_max, m.vehicle_slots, m.vehicle_slot);
    m.vehicle = l.add_column<VehicleRow>(m.vehicles, "vehicle.row", Group::definition);
}

/// Adds contact tables; `one` is "contact" or "sleeping_contact".
static ContactTables add_contacts(StateLayout& l, const WorldDef& def, const std::string& one) {
    ContactTables t;
    t.contacts = add_growing(l, one + "s", def.contacts_max);
    t.key = l.add_column<ContactKey>(t.contacts, one + ".key", Group::contact);
    t.memory = l.add_column<ContactRow>(t.contacts, one + ".memory", Group::contact);
    t.points = add_growing(l, one + "_points", 4 * def.contacts_max);
    t.point = l.add_column<ContactPointMemory>(t.points, one + ".point", Group::contact);
    t.more = add_growing(l, one + "_more", def.contacts_max);
    t.beyond = l.add_column<ContactMore>(t.more, one + ".more", Group::contact);
    return t;
}

Manifest make_manifest(const WorldDef& def, const GameSchema& schema, std::uint64_t origin) {
    StateLayout l;
    Manifest m{};

    m.world = l.add_table("world", 1);
    m.header = l.add_column<Header>(m.world, "world.header", Group::world);
    m.config = l.add_column<Config>(m.world, "world.config", Group::world);
    m.faults = l.add_column<Faults>(m.world, "world.faults", Group::world);

    m.bodies = add_objects(l, "body", "bodies", def.bodies_max, m.body_slots, m.body_slot);
    m.body_info = l.add_column<BodyInfo>(m.bodies, "body.info", Group::definition);
    m.body_traits = add_shared<BodyTraits>(l, "body_traits", def.bodies_max);
    m.body_push = l.add_column<std::uint32_t>(m.bodies, "body.push", Group::definition);
    m.forces = add_growing(l, "forces", def.bodies_max);
    m.force = l.add_column<BodyForce>(m.forces, "body.force", Group::definition);
    m.pushed = l.add_column<std::uint32_t>(m.forces, "body.pushed", Group::definition);
    m.shapes = add_objects(l, "shape", "shapes", def.shapes_max, m.shape_slots, m.shape_slot);
    m.shape = l.add_column<ShapeRow>(m.shapes, "shape.row", Group::definition);
    m.shape_traits = add_shared<ShapeTraits>(l, "shape_traits", def.shapes_max);
    m.fields = add_objects(l, "field", "fields", def.fields_max, m.field_slots, m.field_slot);
    m.field = l.add_column<FieldRow>(m.fields, "field.row", Group::definition);

    m.pair_filters = add_growing(l, "pair_filters", def.pair_filters_max);
    m.pair_filter = l.add_column<PairFilterRow>(m.pair_filters, "pair_filter.row", Group::definition);

    m.joints = add_objects(l, "joint", "joints", def.joints_max, m.joint_slots, m.joint_slot);
    m.joint = l.add_column<JointRow>(m.joints, "joint.row", Group::definition);

    add_bodies_of_play(l, def, m);

    m.body_pose = l.add_column<Transform>(m.bodies, "body.pose", Group::motion);
    m.body_velocity = l.add_column<Velocity>(m.bodies, "body.velocity", Group::motion);

    m.body_sleep = l.add_column<BodySleep>(m.bodies, "body.sleep", Group::motion);

    m.contacts = add_contacts(l, def, "contact");
    m.sleeping_contacts = add_contacts(l, def, "sleeping_contact");
    m.joint_memory = l.add_column<JointMemory>(m.joints, "joint.memory", Group::contact);
    m.vehicle_memory = l.add_column<VehicleMemory>(m.vehicles, "vehicle.memory", Group::motion);

    m.records = l.add_table("game_records", 1);
    for (const GameSchema::Entry& e : schema.entries())
        m.game.push_back(
            l.add_column(e.per_body ? m.bodies : m.records, e.name, Group::game, e.row_size, e.leaves));
    l.set_origin(origin);
    m.layout = std::move(l).finished();
    return m;
}

} // namespace lockstone::sim

std::shared_ptr<const lockstone::StateLayout> lockstone::state_layout_of(const WorldDef& def,
                                                                         const GameSchema& schema) {
    return sim::make_manifest(def, schema).layout;
}
