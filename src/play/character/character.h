// Characters: the data of their mover. The mover is in character.cpp, and its view of the world in character_space.h.
#pragma once

#include "collide/narrow_phase.h"
#include "lockstone/event.h"
#include "scene/placed_shapes.h"

#include <vector>

namespace lockstone::sim {

/// A shape near a character, with its poses at the start and at the end of the tick, as predicted before the solver
/// runs.
struct Neighbour {
    std::uint32_t slot;
    BodyId body; ///< its row may change within the tick, when a body is woken
    const shapes::Solid* solid;
    Transform begin, end; ///< world
    Coordinate reach;     ///< largest distance of its points from its origin [m]; 0 for a plane
    BodyKind kind;
    bool is_plane, one_way, moves;
};

/// A dynamic body that a character walks into.
struct CharacterPush {
    BodyId body;
    Vec3 point;      ///< world [m]
    UnitVec3 normal; ///< of the body's surface, towards the character
};

struct CharacterScratch {
    std::vector<std::uint32_t> order_of_body; ///< by body slot: 1 + row of its character, 0: none
    std::vector<std::uint32_t> slots;
    std::vector<Neighbour> neighbours;
    std::vector<CharacterPush> pushes;
    std::vector<Event> landings; ///< events of this tick
    collide::NarrowScratch narrow;
    collide::Manifolds manifolds; ///< of the pair that is tested at present
    Real motion_max;              ///< upper bound of the motion of any body in this tick [m], at most 4
};

/// Sets the velocity of every character's body for this tick, pushes the bodies that characters walk into, and stores
/// the ground of each character. The result depends on the state alone. Wakes characters that move, and bodies that
/// they push, step onto or leave. Characters that do not move stay at rest.
void move_characters(Model& w, PlacedShapes& placed, CharacterScratch& scratch, Tasks* tasks);
/// True if the mover and not the solver handles a contact between two bodies: that of a character with a dynamic body
/// that does not lie on its head. `normal` points from a to b.
bool is_movers_contact(const Model& w, const CharacterScratch& scratch, BodyId body_a, BodyId body_b,
                       UnitVec3 normal);
/// Changes the height of a character's capsule. The position of the feet stays the same.
void set_capsule(Model& w, PlacedShapes& placed, const CharacterRow& row, Real height);
/// True if a shape is the capsule of any character.
bool is_characters_shape(const Model& w, ShapeId shape);
/// The capsule of a character with the given height, in the frame of its body.
ShapeDef capsule_of(const CharacterDef& def, Real height);

} // namespace lockstone::sim
