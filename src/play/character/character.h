// Characters: the row of each, and the mover's scratch. The mover is in character.cpp, what it sees in
// character_space.h.
#pragma once

#include "lockstone/character.h"
#include "lockstone/command.h"
#include "lockstone/event.h"
#include "shapes/asset/asset.h"

#include <string>
#include <vector>

namespace lockstone::sim {

struct Data;

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

/// A shape near a character, and where it is when the tick begins and ends, as far as that is known before the solver.
struct Neighbour {
    std::uint32_t slot;
    BodyId body; ///< its row may change within the tick, when something is woken
    const shapes::Solid* solid;
    Transform begin, end; ///< world
    Coordinate reach;     ///< of its points from its origin [m]; 0 for a plane
    BodyKind kind;
    bool is_plane, one_way, moves;
};

/// A dynamic body that a character walks into.
struct CharacterPush {
    BodyId body;
    Vec3 point;      ///< world [m]
    UnitVec3 normal; ///< of the body's surface, to the character
};

struct CharacterScratch {
    std::vector<std::uint32_t> order_of_body; ///< by body slot: 1 + row of its character, 0: none
    std::vector<std::uint32_t> slots;
    std::vector<Neighbour> neighbours;
    std::vector<CharacterPush> pushes;
    std::vector<Event> landings; ///< of this tick
    Real motion_max;             ///< of any body that moves, in this tick [m], at most 4
};

/// Sets the velocity of every character's body for this tick, pushes what they walk into, and remembers what they stand
/// on. A pure function of the state. Wakes characters that move and what they push, step onto or leave; those that
/// stand rest.
void move_characters(Data& w);
/// Whether a contact between two bodies is left to the mover: a character's with a dynamic body that does not lie on
/// its head. `normal` leads from a to b.
bool is_movers_contact(const Data& w, BodyId body_a, BodyId body_b, UnitVec3 normal);
/// Gives a character's capsule a height, at the same place of the feet.
void set_capsule(Data& w, const CharacterRow& row, Real height);
/// Whether a shape is some character's capsule.
bool is_characters_shape(const Data& w, ShapeId shape);
/// Numbers of a row from outside; empty when good, else what is wrong.
std::string check(const CharacterRow& row);
/// The shape of a character of some height, in its body.
ShapeDef capsule_of(const CharacterDef& def, Real height);

} // namespace lockstone::sim
