// The row of a character. The rows of vehicles are in src/solve/vehicles.
#pragma once

#include "lockstone/play/character.h"
#include "lockstone/row.h"

#include <string>

namespace lockstone::sim {

struct CharacterRow {
    CharacterId id;
    BodyId body; ///< kinematic; its origin is at the feet, its y axis along def.up
    ShapeId shape;
    CharacterDef def;
    CharacterInput input;
    CharacterState state;
};
template <class V> constexpr void describe(CharacterRow& r, V&& v) {
    v("id", r.id), v("body", r.body), v("shape", r.shape), v("def", r.def), v("input", r.input);
    v("state", r.state);
}
static_assert(StateRow<CharacterRow>);

/// Checks the numbers of a row from outside. Returns an empty text if they are valid, else the error.
std::string check(const CharacterRow& row);
std::string check(const CharacterInput& input);

} // namespace lockstone::sim
