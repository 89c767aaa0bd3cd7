// Creates and destroys characters, and sets their input.
#include "world/commands/applier.h"

#include "lockstone/math/math.h"
#include "model/checks.h"
#include "model/sleep.h"

namespace lockstone::sim {

using Applied = World::Applied;
using base::join;

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
    if (!made_shape) { // cannot happen: the definition was checked, and there is room
        (void)(*this)(DestroyBody{made_body->body});
        return Error{"create_character: " + made_shape.error().message};
    }
    w.state.make_room({w.m.character_slots, w.m.characters}, 1);
    const std::uint32_t index =
        take_slot(w, w.m.character_slots, w.m.character_slot, &Header::character_free, row);
    const CharacterId id{index, w.state.rows(w.m.character_slot)[index - 1].generation};
    w.state.resize(w.m.characters, row + 1);
    CharacterRow& fresh = w.state.edit_row(w.m.character, row);
    fresh = {};
    fresh.id = id;
    fresh.body = made_body->body;
    fresh.shape = made_shape->shape;
    fresh.def = c.def;
    fresh.def.up = normalized(c.def.up);
    fresh.state.air_ticks = 1u << 31; // so that it cannot jump before it has stood
    return Applied{.body = fresh.body, .shape = fresh.shape, .character = id};
}

Result<World::Applied> Applier::operator()(const DestroyCharacter& c) {
    const std::uint32_t row = w.row_of(c.character);
    if (row == Model::dead) return dead("destroy_character", "character", c.character);
    return (*this)(DestroyBody{w.state.rows(w.m.character)[row].body});
}

Result<World::Applied> Applier::operator()(const SetCharacterInput& c) {
    const std::uint32_t row = w.row_of(c.character);
    if (row == Model::dead) return dead("set_character_input", "character", c.character);
    if (std::string e = check(c.input); !e.empty()) return Error{"set_character_input: " + e};
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

} // namespace lockstone::sim
