// A world's state with its definition: what every phase reads, and what commands write. All of it is in the state, but for memory
// that is kept from call to call.
#pragma once

#include "model/manifest.h"
#include "shapes/asset/asset.h"
#include "solve/bodies/integrate.h"

#include <vector>

namespace lockstone::sim {

/// Memory for moving rows between awake and resting (sleep.h).
struct RowMoves {
    std::vector<BodyId> joined;
    /// Rows of one table, those that leave it, those of the table they go to
    ContactList here, moving, there;
};

struct Model {
    Model(const WorldDef& definition, const GameSchema& game, std::uint64_t origin)
        : def(definition), schema(game), m(make_manifest(def, schema, origin)), state(m.layout) {}

    WorldDef def;
    GameSchema schema;
    Manifest m;
    State state;
    RowMoves moves;                   ///< memory
    std::vector<MassPart> mass_parts; ///< memory, of update_mass()

    const Header& header() const { return state.rows(m.header)[0]; }
    Header& edit_header() { return state.edit_row(m.header, 0); }
    const Config& config() const { return state.rows(m.config)[0]; }
    /// The columns of what is awake.
    solve::BodyColumns body_columns() {
        const std::uint32_t awake = header().bodies_awake;
        return {state.rows(m.body_info).first(awake), state.rows(m.body_traits.row),
                state.rows(m.body_push).first(awake), state.rows(m.force),
                state.edit(m.body_pose, 0, awake),    state.edit(m.body_velocity, 0, awake)};
    }
    /// Of all bodies.
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
    /// Row of what an id names; `dead` when it lives no more.
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

/// Empty when good, else what is wrong.
std::string check(const WorldDef& def);
/// contacts_max where the definition leaves it to the other limits.
WorldDef with_derived_limits(WorldDef def);
Config config_of(const WorldDef& def);

// ---- bodies and shapes as they are defined, and as rows (definitions.cpp) ---

/// Fills in the rows of a body that is new: all but its mass, its shapes and whether it sleeps. Moves rows of the state: references
/// end.
void write_body(Model& w, std::uint32_t row, BodyId id, const BodyDef& def);
/// What would make the body as it is now.
BodyDef body_def(const Model& w, std::uint32_t row);
/// Where its origin is: rows hold the centre of mass.
Transform body_origin(const Model& w, std::uint32_t row);
ShapeTraits traits_of(const ShapeDef& def);
ShapeDef shape_def(const Model& w, std::uint32_t row);

// ---- rows that bodies and shapes name (traits.cpp) ---

/// The force that pushes a body in the next tick, to be added to. Valid until the state grows.
BodyForce& force_on(Model& w, std::uint32_t body_row);
/// Nothing pushes it, or nothing pushes any body.
void forget_force(Model& w, std::uint32_t body_row);
void forget_forces(Model& w);
/// From now on a body or shape is like this. Moves rows of the state: references end.
void set_traits(Model& w, std::uint32_t body_row, const BodyTraits& traits);
void set_shape_traits(Model& w, std::uint32_t shape_row, const ShapeTraits& traits);

// ---- what a body does at once (traits.cpp) ---

/// Velocity changes by an impulse [N s] and an angular impulse [N m s] about the centre of mass.
void apply_impulse(Model& w, std::uint32_t body_row, Vec3 linear, Vec3 angular);
/// Moves the centre of mass within a body whose origin stays where it is.
void set_mass(Model& w, std::uint32_t body_row, const BodyMass& fresh);

// ---- which bodies and shapes may meet (filters.cpp) ---

/// Whether two shapes may meet: a pure function of the state.
bool may_meet(const Model& w, const ShapeRow& a, const ShapeRow& b);
/// Whether groups, categories and pair filters let two shapes of different bodies touch.
bool filters_allow(const Model& w, const ShapeRow& a, const ShapeRow& b);
/// Whether a joint that does not let its bodies touch holds two bodies together.
bool are_joined(const Model& w, BodyId a, BodyId b);

/// Whether a state from outside can be this world's: same definition, every reference within its table.
Status check_state(const Model& w, shapes::SolidCache& solids, const State& state);

} // namespace lockstone::sim
