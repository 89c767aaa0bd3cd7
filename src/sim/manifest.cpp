#include "sim/manifest.h"

namespace lockstone::sim {

/// Characters and vehicles.
static void add_bodies_of_play(StateLayout& l, const WorldDef& def, Manifest& m) {
    m.character_slots = l.add_table("character_slots", def.characters_max);
    m.character_slot = l.add_column<Slot>(m.character_slots, "character.slot", Group::definition);
    m.characters = l.add_table("characters", def.characters_max);
    m.character = l.add_column<CharacterRow>(m.characters, "character.row", Group::definition);
    m.vehicle_slots = l.add_table("vehicle_slots", def.vehicles_max);
    m.vehicle_slot = l.add_column<Slot>(m.vehicle_slots, "vehicle.slot", Group::definition);
    m.vehicles = l.add_table("vehicles", def.vehicles_max);
    m.vehicle = l.add_column<VehicleRow>(m.vehicles, "vehicle.row", Group::definition);
}

/// Of what is awake, and of what is not.
static void add_contacts(StateLayout& l, const WorldDef& def, Manifest& m) {
    m.contacts = l.add_table("contacts", def.contacts_max);
    m.contact_key = l.add_column<ContactKey>(m.contacts, "contact.key", Group::contact);
    m.contact_memory = l.add_column<ContactMemory>(m.contacts, "contact.memory", Group::contact);
    m.sleeping_contacts = l.add_table("sleeping_contacts", def.contacts_max);
    m.sleeping_key = l.add_column<ContactKey>(m.sleeping_contacts, "sleeping_contact.key", Group::contact);
    m.sleeping_memory =
        l.add_column<ContactMemory>(m.sleeping_contacts, "sleeping_contact.memory", Group::contact);
}

Manifest make_manifest(const WorldDef& def, const GameSchema& schema) {
    auto layout = std::make_shared<StateLayout>();
    StateLayout& l = *layout;
    Manifest m{};

    m.world = l.add_table("world", 1);
    m.header = l.add_column<Header>(m.world, "world.header", Group::world);
    m.config = l.add_column<Config>(m.world, "world.config", Group::world);
    m.faults = l.add_column<Faults>(m.world, "world.faults", Group::world);

    m.body_slots = l.add_table("body_slots", def.bodies_max);
    m.body_slot = l.add_column<Slot>(m.body_slots, "body.slot", Group::definition);
    m.bodies = l.add_table("bodies", def.bodies_max);
    m.body_info = l.add_column<BodyInfo>(m.bodies, "body.info", Group::definition);
    m.body_mass = l.add_column<BodyMass>(m.bodies, "body.mass", Group::definition);
    m.body_force = l.add_column<BodyForce>(m.bodies, "body.force", Group::definition);
    m.shape_slots = l.add_table("shape_slots", def.shapes_max);
    m.shape_slot = l.add_column<Slot>(m.shape_slots, "shape.slot", Group::definition);
    m.shapes = l.add_table("shapes", def.shapes_max);
    m.shape = l.add_column<ShapeRow>(m.shapes, "shape.row", Group::definition);
    m.field_slots = l.add_table("field_slots", def.fields_max);
    m.field_slot = l.add_column<Slot>(m.field_slots, "field.slot", Group::definition);
    m.fields = l.add_table("fields", def.fields_max);
    m.field = l.add_column<FieldRow>(m.fields, "field.row", Group::definition);

    m.pair_filters = l.add_table("pair_filters", def.pair_filters_max);
    m.pair_filter = l.add_column<PairFilterRow>(m.pair_filters, "pair_filter.row", Group::definition);

    m.joint_slots = l.add_table("joint_slots", def.joints_max);
    m.joint_slot = l.add_column<Slot>(m.joint_slots, "joint.slot", Group::definition);
    m.joints = l.add_table("joints", def.joints_max);
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
    m.layout = std::move(layout);
    return m;
}

} // namespace lockstone::sim
