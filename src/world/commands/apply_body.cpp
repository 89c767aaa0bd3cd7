// Creates and destroys bodies and shapes, and sets masses.
#include "world/commands/applier.h"

#include "lockstone/math/math.h"
#include "model/checks.h"
#include "model/sleep.h"

#include <algorithm>

namespace lockstone::sim {

using Applied = World::Applied;
using base::join;

// ---- mass ----------------------------------------------------------------------------------------------------

static void set_mass_fixed(Model& w, std::uint32_t row, std::uint8_t fixed) {
    BodyTraits traits = w.traits_of(w.state.rows(w.m.body_info)[row]);
    traits.mass_fixed = fixed;
    set_traits(w, row, traits);
}

// ---- bodies and shapes ---------------------------------------------------------------------------------------

Result<World::Applied> Applier::operator()(const CreateBody& c) {
    if (std::string e = check(c.def); !e.empty()) return Error{"create_body: " + e};
    const std::uint32_t row = w.state.count(w.m.bodies);
    if (row == w.state.rows_max(w.m.bodies))
        return Error{join("create_body: the world is full: bodies_max is ", row)};
    w.state.make_room({w.m.body_slots, w.m.bodies}, 1);
    const std::uint32_t index = take_slot(w, w.m.body_slots, w.m.body_slot, &Header::body_free, row);
    const BodyId id{index, w.state.rows(w.m.body_slot)[index - 1].generation};
    w.state.resize(w.m.bodies, row + 1);
    const BodyDef& d = c.def;
    write_body(w, row, id, d);
    if (d.awake == 0 && d.kind == BodyKind::dynamic && w.config().sleeping != 0)
        start_asleep(w, row);
    else
        sim::wake(w, id); // it has no contact points
    update_mass(w, placed, w.row_of(id));
    return Applied{.body = id};
}

Result<World::Applied> Applier::operator()(const DestroyBody& c) {
    if (w.row_of(c.body) == Model::dead) return dead_body("destroy_body", c.body);
    std::uint32_t row = wake(c.body);
    while (const std::uint32_t slot = w.state.rows(w.m.body_info)[row].first_shape) remove_shape(row, slot);
    while (const std::uint32_t slot = w.state.rows(w.m.body_info)[row].first_joint) remove_joint(w, slot);
    remove_character_of(c.body);
    remove_vehicle_of(c.body);
    row = put_to_rest(w, row);
    const std::uint32_t last = w.state.count(w.m.bodies) - 1;
    const BodyId moved = w.state.rows(w.m.body_info)[last].id;
    forget_force(w, row);
    std::uint32_t free = w.header().body_traits_free;
    drop_shared(w.state, w.m.body_traits, w.state.rows(w.m.body_info)[row].traits, free);
    w.edit_header().body_traits_free = free;
    remove_row(w.state, w.m.bodies, row);
    w.state.edit_row(w.m.body_slot, moved.index - 1).row = row;
    free_slot(w.state, w.m.body_slot, c.body.index, w.edit_header().body_free);
    forget_filters_of(c.body);
    placed.structure_stale = true;
    return Applied{};
}

Result<World::Applied> Applier::operator()(const CreateShape& c) {
    std::uint32_t body_row = w.row_of(c.body);
    if (body_row == Model::dead) return dead_body("create_shape", c.body);
    if (std::string e = check(c.def, w.state.rows(w.m.body_info)[body_row].kind); !e.empty())
        return Error{"create_shape: " + e};
    if (const Result<shapes::Solid> solid = placed.solids.resolve(c.def.geometry); !solid)
        return Error{"create_shape: " + solid.error().message};
    const std::uint32_t row = w.state.count(w.m.shapes);
    if (row == w.state.rows_max(w.m.shapes))
        return Error{join("create_shape: the world is full: shapes_max is ", row)};
    if (w.state.rows(w.m.body_info)[body_row].first_shape != 0) keep_contact_points();
    if (!was_never_awake(w, body_row)) body_row = wake(c.body);
    w.state.make_room({w.m.shape_slots, w.m.shapes}, 1);
    placed.fit(w.state.capacity(w.m.shape_slots));
    const std::uint32_t index = take_slot(w, w.m.shape_slots, w.m.shape_slot, &Header::shape_free, row);
    const ShapeId id{index, w.state.rows(w.m.shape_slot)[index - 1].generation};
    w.state.resize(w.m.shapes, row + 1);
    std::uint32_t free = w.header().shape_traits_free;
    const std::uint32_t shared = take_shared(w.state, w.m.shape_traits, traits_of(c.def), free);
    w.edit_header().shape_traits_free = free;
    BodyInfo& info = w.state.edit_row(w.m.body_info, body_row);
    w.state.edit_row(w.m.shape, row) = {id, c.body, c.def.user_key, info.first_shape, shared};
    info.first_shape = index;
    update_mass(w, placed, body_row);
    placed.structure_stale = true;
    return Applied{.shape = id};
}

Result<World::Applied> Applier::operator()(const DestroyShape& c) {
    const std::uint32_t row = w.row_of(c.shape);
    if (row == Model::dead) return dead_shape("destroy_shape", c.shape);
    if (is_characters_shape(w, c.shape))
        return Error{join("destroy_shape: shape ", text_of(c.shape), " is a character's capsule")};
    const std::uint32_t body_row = wake(w.state.rows(w.m.shape)[row].body);
    remove_shape(body_row, c.shape.index);
    update_mass(w, placed, body_row);
    return Applied{};
}

void Applier::remove_shape(std::uint32_t body_row, std::uint32_t slot) {
    const auto row_at = [this](std::uint32_t at) { return w.state.rows(w.m.shape_slot)[at - 1].row; };
    BodyInfo& info = w.state.edit_row(w.m.body_info, body_row);
    const std::uint32_t row = row_at(slot);
    const std::uint32_t next = w.state.rows(w.m.shape)[row].next_shape;
    if (info.first_shape == slot) {
        info.first_shape = next;
    } else {
        std::uint32_t before = row_at(info.first_shape);
        while (w.state.rows(w.m.shape)[before].next_shape != slot)
            before = row_at(w.state.rows(w.m.shape)[before].next_shape);
        w.state.edit_row(w.m.shape, before).next_shape = next;
    }
    std::uint32_t free = w.header().shape_traits_free;
    drop_shared(w.state, w.m.shape_traits, w.state.rows(w.m.shape)[row].traits, free);
    w.edit_header().shape_traits_free = free;
    const ShapeId moved = w.state.rows(w.m.shape).back().id;
    remove_row(w.state, w.m.shapes, row);
    w.state.edit_row(w.m.shape_slot, moved.index - 1).row = row;
    free_slot(w.state, w.m.shape_slot, slot, w.edit_header().shape_free);
    placed.structure_stale = true;
}

Result<World::Applied> Applier::operator()(const SetMass& c) {
    std::uint32_t row = w.row_of(c.body);
    if (row == Model::dead) return dead_body("set_mass", c.body);
    if (std::string e = check_changes(c); !e.empty()) return Error{"set_mass: " + e};
    if (c.mass.given != 0 && c.mass.value == Real{}) {
        row = wake(c.body);
        set_mass_fixed(w, row, 0);
        update_mass(w, placed, row);
        return Applied{};
    }
    if (w.state.rows(w.m.body_info)[row].kind != BodyKind::dynamic)
        return Error{"set_mass: only a dynamic body has a mass"};
    const BodyMass now = w.mass_of(row);
    const BodyMass fresh{c.mass.or_else(now.mass), c.center.or_else(now.center),
                         c.gyration.or_else(now.gyration), c.principal.or_else(now.principal)};
    if (std::string e =
            check_range("mass", fresh.mass, mass_min, mass_max, " kg, or 0 for that of the shapes");
        !e.empty())
        return Error{"set_mass: " + e};
    if (!within(fresh.center, Real(64))) return Error{"set_mass: center must be within 64 m on each axis"};
    for (int i = 0; i < 3; ++i)
        if (std::string e = check_range("gyration", fresh.gyration[i], gyration_min, Real(100), " m");
            !e.empty())
            return Error{"set_mass: " + e};
    if (std::string e = check_unit("principal", fresh.principal); !e.empty()) return Error{"set_mass: " + e};
    row = wake(c.body);
    set_mass_fixed(w, row, 1);
    set_mass(w, row, {fresh.mass, fresh.center, fresh.gyration, normalized(fresh.principal)});
    placed.structure_stale = true;
    return Applied{};
}

} // namespace lockstone::sim
