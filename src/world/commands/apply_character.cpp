// Characters come and go, and are told what to do.
#include "world/commands/applier.h"

#include "lockstone/math/math.h"
#include "model/checks.h"
#include "tick/sleep.h"

namespace lockstone::sim {

using Applied = World::Applied;
using base::join;

ShapeDef capsule_of(const CharacterDef& def, Real height) {
    ShapeDef shape;
    shape.geometry = capsule(def.radius, half(height) - def.radius);
    shape.local.position = {Real{}, half(height), Real{}};
    shape.category = def.category;
    shape.mask = def.mask;
    shape.group = def.group;
    shape.user_key = def.user_key;
    return shape;
}

void set_capsule(Data& w, const CharacterRow& row, Real height) {
    const ShapeDef def = capsule_of(row.def, height);
    const std::uint32_t shape = w.row_of(row.shape);
    ShapeTraits traits = w.traits_of(w.state.rows(w.m.shape)[shape]);
    traits.geometry = def.geometry;
    traits.local = def.local;
    set_shape_traits(w, shape, traits);
    update_mass(w, w.row_of(row.body));
}

static std::string check_input(const CharacterInput& input) {
    if (length(input.velocity) > character_speed_max) return "velocity must be at most 100 m/s long";
    if (input.jump > 1) return join("jump is ", input.jump, ", must be 0 or 1");
    if (input.crouch > 1) return join("crouch is ", input.crouch, ", must be 0 or 1");
    return {};
}

Result<World::Applied> Applier::operator()(const CreateCharacter& c) {
    if (std::string e = check(c.def); !e.empty()) return Error{"create_character: " + e};
    const std::uint32_t row = w.state.count(w.m.characters);
    if (row == w.state.rows_max(w.m.characters))
        return Error{join("create_character: the world is full: characters_max is ", row)};
    if (w.state.count(w.m.shapes) == w.state.rows_max(w.m.shapes))
        return Error{join("create_character: the world is full: shapes_max is ", w.state.count(w.m.shapes))};
    BodyDef body;
    body.kind = BodyKind::kinematic;
    body.pose = {c.def.position, from_to({Unit{}, unit_one, Unit{}}, c.def.up)};
    body.user_key = c.def.user_key;
    const Result<Applied> made_body = (*this)(CreateBody{body});
    if (!made_body) return Error{"create_character: " + made_body.error().message};
    const Result<Applied> made_shape = (*this)(CreateShape{made_body->body, capsule_of(c.def, c.def.height)});
    if (!made_shape) { // cannot be: the definition was checked, and there is room
        (void)(*this)(DestroyBody{made_body->body});
        return Error{"create_character: " + made_shape.error().message};
    }
    w.state.make_room({w.m.character_slots, w.m.characters}, 1);
    const std::uint32_t index =
        take_slot(w.state, w.m.character_slots, w.m.character_slot, w.edit_header().character_free, row);
    const CharacterId id{index, w.state.rows(w.m.character_slot)[index - 1].generation};
    w.state.resize(w.m.characters, row + 1);
    CharacterRow& fresh = w.state.edit_row(w.m.character, row);
    fresh = {};
    fresh.id = id;
    fresh.body = made_body->body;
    fresh.shape = made_shape->shape;
    fresh.def = c.def;
    fresh.def.up = normalized(c.def.up);
    fresh.state.air_ticks = 1u << 31; // no jump before it has stood
    return Applied{.body = fresh.body, .shape = fresh.shape, .character = id};
}

Result<World::Applied> Applier::operator()(const DestroyCharacter& c) {
    const std::uint32_t row = w.row_of(c.character);
    if (row == Data::dead) return dead("destroy_character", "character", c.character);
    return (*this)(DestroyBody{w.state.rows(w.m.character)[row].body});
}

Result<World::Applied> Applier::operator()(const SetCharacterInput& c) {
    const std::uint32_t row = w.row_of(c.character);
    if (row == Data::dead) return dead("set_character_input", "character", c.character);
    if (std::string e = check_input(c.input); !e.empty()) return Error{"set_character_input: " + e};
    w.state.edit_row(w.m.character, row).input = c.input;
    return Applied{};
}

void Applier::remove_character_of(BodyId body) {
    const std::span<const CharacterRow> rows = w.state.rows(w.m.character);
    for (std::uint32_t row = 0; row < rows.size(); ++row) {
        if (rows[row].body != body) continue;
        const std::uint32_t slot = rows[row].id.index;
        const CharacterId moved = rows.back().id;
        remove_row(w.state, w.m.characters, row);
        w.state.edit_row(w.m.character_slot, moved.index - 1).row = row;
        free_slot(w.state, w.m.character_slot, slot, w.edit_header().character_free);
        return;
    }
}

bool is_characters_shape(const Data& w, ShapeId shape) {
    for (const CharacterRow& row : w.state.rows(w.m.character))
        if (row.shape == shape) return true;
    return false;
}

// ---- checks ----------------------------------------------------------------------------------------------------

static std::string check_sizes(const CharacterDef& d) {
    if (std::string e = check_range("radius", d.radius, 0.05_r, Real(10), " m"); !e.empty()) return e;
    const Real least = d.radius * 2 + 0.01_r;
    if (std::string e = check_range("height", d.height, least, Real(50), " m"); !e.empty()) return e;
    if (std::string e = check_range("crouch_height", d.crouch_height, least, d.height, " m"); !e.empty())
        return e;
    if (std::string e = check_range("step_height", d.step_height, Real{}, Real(10), " m"); !e.empty())
        return e;
    if (std::string e = check_range("step_down", d.step_down, Real{}, Real(10), " m"); !e.empty()) return e;
    return check_range("slope_max", d.slope_max, Real{}, 1.3_r, " rad");
}

static std::string check_motion(const CharacterDef& d) {
    struct Range {
        const char* what;
        Real value, low, high;
        const char* unit;
    };
    const Range ranges[] = {{"mass", d.mass, 0.001_r, Real(1000000), " kg"},
                            {"push_force", d.push_force, Real{}, Real(100000000), " N"},
                            {"gravity", d.gravity, Real{}, Real(1000), " m/s^2"},
                            {"fall_speed_max", d.fall_speed_max, 0.1_r, Real(400), " m/s"},
                            {"jump_speed", d.jump_speed, Real{}, Real(100), " m/s"},
                            {"acceleration", d.acceleration, Real{}, Real(1000000), " m/s^2"},
                            {"air_acceleration", d.air_acceleration, Real{}, Real(1000000), " m/s^2"}};
    for (const Range& r : ranges)
        if (std::string e = check_range(r.what, r.value, r.low, r.high, r.unit); !e.empty()) return e;
    for (const auto& [what, ticks] :
         {std::pair("coyote_ticks", d.coyote_ticks), {"jump_buffer_ticks", d.jump_buffer_ticks}})
        if (ticks > 1000) return join(what, " is ", ticks, ", must be 0 to 1000");
    return {};
}

std::string check(const CharacterDef& d) {
    if (!within(d.position, position_max)) return "position must be within 1e9 m of the origin";
    if (abs(length(d.up) - unit_one) > Unit::from_raw(1 << 20))
        return "up must be a unit vector: use normalized";
    if (std::string e = check_sizes(d); !e.empty()) return e;
    return check_motion(d);
}

std::string check(const CharacterRow& r) {
    if (std::string e = check(r.def); !e.empty()) return e;
    if (std::string e = check_input(r.input); !e.empty()) return e;
    const CharacterState& s = r.state;
    if (s.ground > CharacterGround::walkable) return "no such ground can be";
    if ((s.crouched | s.squeezed | s.jump_was_held | s.has_jumped) > 1) return "a flag is neither 0 nor 1";
    if (s.jump_pending > 1001 || s.air_ticks > 1u << 31) return "a count of ticks is out of range";
    if (!within(s.velocity, Real(5000)) || !within(s.ground_velocity, Real(5000)))
        return "a velocity is out of range";
    return {};
}

} // namespace lockstone::sim
