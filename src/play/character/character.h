// Characters: what moves them, and its memory. The mover is in character.cpp, what it sees in
// character_space.h.
#pragma once

#include "collide/narrow_phase.h"
#include "lockstone/event.h"
#include "scene/placed_shapes.h"

#include <vector>

namespace lockstone::sim {

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
    collide::NarrowScratch narrow;
    collide::Manifolds manifolds; ///< of the pair that is looked at
    Real motion_max;              ///< of any body that moves, in this tick [m], at most 4
};

/// Sets the velocity of every character's body for this tick, pushes what they walk into, and remembers what they stand
/// on. A pure function of the state. Wakes characters that move and what they push, step onto or leave; those that
/// stand rest.
void move_characters(Model& w, PlacedShapes& placed, CharacterScratch& scratch, Tasks* tasks);
/// Whether the mover, and not the solver, takes a contact between two bodies: that of a character with a dynamic body that does not lie on
/// its head. `normal` leads from a to b.
bool is_movers_contact(const Model& w, const CharacterScratch& scratch, BodyId body_a, BodyId body_b,
                       UnitVec3 normal);
/// Gives a character's capsule another height; the feet stay where they are.
void set_capsule(Model& w, PlacedShapes& placed, const CharacterRow& row, Real height);
/// Whether a shape is some character's capsule.
bool is_characters_shape(const Model& w, ShapeId shape);
/// The shape of a character of some height, in its body.
ShapeDef capsule_of(const CharacterDef& def, Real height);

} // namespace lockstone::sim
