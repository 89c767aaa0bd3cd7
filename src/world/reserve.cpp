// Reserves memory ahead of need. The capacity changes no bit of the state and no result.
#include "base/text.h"
#include "world/world_impl.h"

#include <algorithm>

namespace lockstone::sim {

namespace {

struct Wish {
    const char* limit;
    std::uint32_t rows, rows_max;
};

} // namespace

Status reserve(Data& w, const WorldRows& rows) {
    const WorldDef& d = w.def;
    for (const Wish& wish :
         {Wish{"bodies_max", rows.bodies, d.bodies_max}, Wish{"shapes_max", rows.shapes, d.shapes_max},
          Wish{"contacts_max", rows.contacts, d.contacts_max}, Wish{"fields_max", rows.fields, d.fields_max},
          Wish{"pair_filters_max", rows.pair_filters, d.pair_filters_max},
          Wish{"joints_max", rows.joints, d.joints_max},
          Wish{"characters_max", rows.characters, d.characters_max},
          Wish{"vehicles_max", rows.vehicles, d.vehicles_max}})
        if (wish.rows > wish.rows_max)
            return Error{
                base::join("reserve: ", wish.rows, " rows, but ", wish.limit, " is ", wish.rows_max)};
    std::vector<std::uint32_t> capacities(w.state.layout().tables().size(), 0);
    const Manifest& m = w.m;
    const auto take = [&](std::uint32_t count, std::initializer_list<TableId> tables) {
        for (const TableId table : tables) capacities[table.index] = count;
    };
    take(rows.bodies, {m.bodies, m.body_slots, m.forces, m.body_traits.table});
    take(rows.shapes, {m.shapes, m.shape_slots, m.shape_traits.table});
    for (const ContactTables* t : {&m.contacts, &m.sleeping_contacts})
        take(rows.contacts, {t->contacts, t->more}), take(4 * rows.contacts, {t->points});
    take(rows.fields, {m.fields, m.field_slots});
    take(rows.pair_filters, {m.pair_filters}), take(rows.joints, {m.joints, m.joint_slots});
    take(rows.characters, {m.characters, m.character_slots});
    take(rows.vehicles, {m.vehicles, m.vehicle_slots});
    w.state.reserve(capacities);
    w.placed.reserve(std::max(rows.shapes, w.state.capacity(m.shape_slots)));
    w.scratch.reserve(rows), w.output.reserve(rows);
    for (ContactList* list : {&w.moves.here, &w.moves.there, &w.moves.moving}) list->reserve(rows.contacts);
    w.moves.swaps.reserve(rows.bodies);
    return {};
}

} // namespace lockstone::sim

namespace lockstone {

Status World::reserve(const WorldRows& rows) { return sim::reserve(*impl, rows); }

WorldRows World::capacity() const {
    const State& s = impl->state;
    const sim::Manifest& m = impl->m;
    return {s.capacity(m.bodies),     s.capacity(m.shapes),       s.capacity(m.contacts.contacts),
            s.capacity(m.fields),     s.capacity(m.pair_filters), s.capacity(m.joints),
            s.capacity(m.characters), s.capacity(m.vehicles)};
}

} // namespace lockstone
