// A world's definition and state: all phases read it, and commands write it. Everything in it is part of the state,
// except the scratch memory that is kept from call to call.
#pragma once

#include "model/manifest.h"
#include "shapes/asset/asset.h"
#include "solve/bodies/integrate.h"

#include <vector>

namespace lockstone::sim {

/// Two rows of a table that change places.
struct RowSwap {
    std::uint32_t x, y;
};

/// Scratch memory for moving rows between the awake and the resting part of a table (sleep.h).
struct RowMoves {
    std::vector<BodyId> joined;
    /// Rows of one table, rows that leave it, and rows of the table to which they go
    ContactList here, moving, there;
    std::vector<RowSwap> swaps;
};

struct Model {
    Model(const WorldDef& definition, const GameSchema& game, std::uint64_t origin)
        : def(definition), schema(game), m(make_manifest(def, schema, origin)), state(m.layout) {}

    WorldDef def;
    GameSchema schema;
    Manifest m;
    State state;
    RowMoves moves;                   ///< scratch memory
    std::vector<MassPart> mass_parts; ///< scratch memory of update_mass()

    const Header& header() const { return state.rows(m.header)[0]; }
    Header& edit_header() { return state.edit_row(m.header, 0); }
    const Config& config() const { return state.rows(m.config)[0]; }
    /// The columns of the awake bodies.
    solve::BodyColumns body_columns() {
        const std::uint32_t awake = header().bodies_awake;
        return {state.rows(m.body_info).first(awake), state.rows(m.body_traits.row),
                state.rows(m.body_push).first(awake), state.rows(m.force),
                state.edit(m.body_pose, 0, awake),    state.edit(m.body_velocity, 0, awake)};
    }
    /// The masses of all bodies.
    solve::MassView masses() const { return {state.rows(m.body_info), state.rows(m.body_traits.row)}; }
    const BodyTraits& traits_of(const BodyInfo& info) const {
        return state.rows(m.body_traits.row)[info.traits];
    }
    const ShapeTraits& traits_of(const ShapeRow& shape) const {
        return state.rows(m.shape_traits.row)[shape.traits];
    }
    const BodyMass& mass_of(std::uint32_t body_row) const {
        return traits_of(state.rows(m.body_info)[body_row]).mass;
    }
    /// The row of the object with this id; `dead` if it no longer exists.
    std::uint32_t row_of(BodyId id) const { return row_of(state.rows(m.body_slot), id.index, id.generation); }
    std::uint32_t row_of(ShapeId id) const {
        return row_of(state.rows(m.shape_slot), id.index, id.generation);
    }
    std::uint32_t row_of(FieldId id) const {
        return row_of(state.rows(m.field_slot), id.index, id.generation);
    }
    std::uint32_t row_of(JointId id) const {
        return row_of(state.rows(m.joint_slot), id.index, id.generation);
    }
    std::uint32_t row_of(CharacterId id) const {
        return row_of(state.rows(m.character_slot), id.index, id.generation);
    }
    std::uint32_t row_of(VehicleId id) const {
        return row_of(state.rows(m.vehicle_slot), id.index, id.generation);
    }
    static constexpr std::uint32_t dead = 0xffffffffu;

  private:
    static std::uint32_t row_of(std::span<const Slot> slots, std::uint32_t index, std::uint32_t generation) {
        if (index == 0 || index > slots.size()) return dead;
        const Slot& slot = slots[index - 1];
        return slot.is_alive() && slot.generation == generation ? slot.row : dead;
    }
};

// ---- the definition (world_def.cpp) ---

/// Returns an empty text if the definition is valid, else the error.
std::string check(const WorldDef& def);
/// Computes contacts_max from the other limits if the definition leaves it 0.
WorldDef with_derived_limits(WorldDef def);
Config config_of(const WorldDef& def);

// ---- definitions of bodies and shapes, and their rows (definitions.cpp) ---

/// Fills in the rows of a new body, except its mass, its shapes and its sleep state. May move rows of the state:
/// references into it become invalid.
void write_body(Model& w, std::uint32_t row, BodyId id, const BodyDef& def);
/// A definition that would create the body as it is now.
BodyDef body_def(const Model& w, std::uint32_t row);
/// The pose of the body's origin; rows hold the pose of the centre of mass.
Transform body_origin(const Model& w, std::uint32_t row);
ShapeTraits traits_of(const ShapeDef& def);
ShapeDef shape_def(const Model& w, std::uint32_t row);

// ---- rows to which bodies and shapes refer (traits.cpp) ---

/// The force that acts on a body in the next tick; callers add to it. The reference is valid until the state grows.
BodyForce& force_on(Model& w, std::uint32_t body_row);
/// Removes the force on a body, or on all bodies.
void forget_force(Model& w, std::uint32_t body_row);
void forget_forces(Model& w);
/// Sets the traits of a body or a shape. May move rows of the state: references into it become invalid.
void set_traits(Model& w, std::uint32_t body_row, const BodyTraits& traits);
void set_shape_traits(Model& w, std::uint32_t shape_row, const ShapeTraits& traits);

// ---- immediate changes of a body (traits.cpp) ---

/// Changes the velocity by an impulse [N s] and an angular impulse [N m s] about the centre of mass.
void apply_impulse(Model& w, std::uint32_t body_row, Vec3 linear, Vec3 angular);
/// Sets the mass of a body and moves its centre of mass; the origin of the body stays in place.
void set_mass(Model& w, std::uint32_t body_row, const BodyMass& fresh);

// ---- which bodies and shapes may collide (filters.cpp) ---

/// Returns true if two shapes may collide: a pure function of the state.
bool may_meet(const Model& w, const ShapeRow& a, const ShapeRow& b);
/// Returns true if groups, categories and pair filters let two shapes of different bodies touch.
bool filters_allow(const Model& w, const ShapeRow& a, const ShapeRow& b);
/// Returns true if the two bodies have a common joint that does not let them touch.
bool are_joined(const Model& w, BodyId a, BodyId b);

/// Checks if a state from outside fits this world: the definition is the world's, and every reference lies within its
/// table.
Status check_state(const Model& w, shapes::SolidCache& solids, const State& state);

} // namespace lockstone::sim
