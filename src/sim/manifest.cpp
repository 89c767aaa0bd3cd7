#include "sim/manifest.h"

namespace lockstone::sim {

/// A table that begins without memory and takes it as rows come.
static TableId add_growing(StateLayout& l, std::string name, std::uint32_t rows_max) {
    return l.add_table(std::move(name), 0, rows_max);
}

/// Objects with ids: the table "body_slots" with its column "body.slot", and the table "bodies", which is returned.
static TableId add_objects(StateLayout& l, const std::string& one, const std::string& many,
                           std::uint32_t rows_max, TableId& slots, Column<Slot>& slot) {
    slots = add_growing(l, one + "_slots", rows_max);
    slot = l.add_column<Slot>(slots, one + ".slot", Group::definition);
    return add_growing(l, many, rows_max);
}

/// Characters and vehicles.
static void add_bodies_of_play(StateLayout& l, const WorldDef& def, Manifest& m) {
    m.characters =
        add_objects(l, "character", "characters", def.characters_max, m.character_slots, m.character_slot);
    m.character = l.add_column<CharacterRow>(m.characters, "character.row", Group::definition);
    m.vehicles = add_objects(l, "vehicle", "vehicles", def.vehicles_max, m.vehicle_slots, m.vehicle_slot);
    m.vehicle = l.add_column<VehicleRow>(m.vehicles, "vehicle.row", Group::definition);
}

/// Of what is awake, and of what is not.
static void add_contacts(StateLayout& l, const WorldDef& def, Manifest& m) {
    m.contacts = add_growing(l, "contacts", def.contacts_max);
    m.contact_key = l.add_column<ContactKey>(m.contacts, "contact.key", Group::contact);
    m.contact_memory = l.add_column<ContactMemory>(m.contacts, "contact.memory", Group::contact);
    m.sleeping_contacts = add_growing(l, "sleeping_contacts", def.contacts_max);
    m.sleeping_key = l.add_column<ContactKey>(m.sleeping_contacts, "sleeping_contact.key", Group::contact);
    m.sleeping_memory =
        l.add_column<ContactMemory>(m.sleeping_contacts, "sleeping_contact.memory", Group::contact);
}

Manifest make_manifest(const WorldDef& def, const GameSchema& schema, std::uint64_t origin) {
    auto layout = std::make_shared<StateLayout>();
    StateLayout& l = *layout;
    Manifest m{};

    m.world = l.add_table("world", 1);
    m.header = l.add_column<Header>(m.world, "world.header", Group::world);
    m.config = l.add_column<Config>(m.world, "world.config", Group::world);
    m.faults = l.add_column<Faults>(m.world, "world.faults", Group::world);

    m.bodies = add_objects(l, "body", "bodies", def.bodies_max, m.body_slots, m.body_slot);
    m.body_info = l.add_column<BodyInfo>(m.bodies, "body.info", Group::definition);
    m.body_mass = l.add_column<BodyMass>(m.bodies, "body.mass", Group::definition);
    m.body_force = l.add_column<BodyForce>(m.bodies, "body.force", Group::definition);
    m.shapes = add_objects(l, "shape", "shapes", def.shapes_max, m.shape_slots, m.shape_slot);
    m.shape = l.add_column<ShapeRow>(m.shapes, "shape.row", Group::definition);
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

    add_contacts(l, def, m);
    m.joint_memory = l.add_column<JointMemory>(m.joints, "joint.memory", Group::contact);
    m.vehicle_memory = l.add_column<VehicleMemory>(m.vehicles, "vehicle.memory", Group::motion);

    m.records = l.add_table("game_records", 1);
    for (const GameSchema::Entry& e : schema.entries())
        m.game.push_back(
            l.add_column(e.per_body ? m.bodies : m.records, e.name, Group::game, e.row_size, e.leaves));
    l.set_origin(origin);
    m.layout = std::move(layout);
    return m;
}

} // namespace lockstone::sim
