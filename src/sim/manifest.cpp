#include "sim/manifest.h"

namespace lockstone::sim {

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

    m.body_pose = l.add_column<Transform>(m.bodies, "body.pose", Group::motion);
    m.body_velocity = l.add_column<Velocity>(m.bodies, "body.velocity", Group::motion);

    m.contacts = l.add_table("contacts", def.contacts_max);
    m.contact_key = l.add_column<ContactKey>(m.contacts, "contact.key", Group::contact);
    m.contact_memory = l.add_column<ContactMemory>(m.contacts, "contact.memory", Group::contact);

    m.records = l.add_table("game_records", 1);
    for (const GameSchema::Entry& e : schema.entries())
        m.game.push_back(
            l.add_column(e.per_body ? m.bodies : m.records, e.name, Group::game, e.row_size, e.leaves));
    m.layout = std::move(layout);
    return m;
}

} // namespace lockstone::sim
