// Commands: each is checked as a whole first, then applied; an error leaves every byte as it was. One function a command.
#pragma once

#include "base/text.h"
#include "world/data.h"

namespace lockstone::sim {

struct Applier {
    Data& w;

    Result<World::Applied> operator()(const CreateBody& c);
    Result<World::Applied> operator()(const DestroyBody& c);
    Result<World::Applied> operator()(const CreateShape& c);
    Result<World::Applied> operator()(const DestroyShape& c);
    Result<World::Applied> operator()(const CreateField& c);
    Result<World::Applied> operator()(const DestroyField& c);
    Result<World::Applied> operator()(const SetPose& c);
    Result<World::Applied> operator()(const SetVelocity& c);
    Result<World::Applied> operator()(const AddForce& c);
    Result<World::Applied> operator()(const AddForceAt& c);
    Result<World::Applied> operator()(const AddImpulse& c);
    Result<World::Applied> operator()(const AddImpulseAt& c);
    Result<World::Applied> operator()(const SetBodyParameters& c);
    Result<World::Applied> operator()(const SetMaterial& c);
    Result<World::Applied> operator()(const SetGravity& c);
    Result<World::Applied> operator()(const WriteGame& c);
    Result<World::Applied> operator()(const SetFilter& c);
    Result<World::Applied> operator()(const SetPairFilter& c);
    Result<World::Applied> operator()(const SetMass& c);
    Result<World::Applied> operator()(const CreateJoint& c);
    Result<World::Applied> operator()(const DestroyJoint& c);
    Result<World::Applied> operator()(const SetJointAxis& c);
    Result<World::Applied> operator()(const SetJointFrames& c);
    Result<World::Applied> operator()(const WakeBody& c);
    Result<World::Applied> operator()(const CreateVehicle& c);
    Result<World::Applied> operator()(const DestroyVehicle& c);
    Result<World::Applied> operator()(const SetVehicleInput& c);

    Result<World::Applied> operator()(const CreateCharacter& c);
    Result<World::Applied> operator()(const DestroyCharacter& c);
    Result<World::Applied> operator()(const SetCharacterInput& c);
    Result<World::Applied> operator()(const SetField& c);
    Result<World::Applied> operator()(const Explode& c);

    void remove_character_of(BodyId body); ///< if it is one's; the body is left as it was
    void remove_shape(std::uint32_t body_row, std::uint32_t slot); ///< the mass is left as it was
    void remove_joint(std::uint32_t slot);
    void remove_vehicle(std::uint32_t slot);
    void remove_vehicle_of(BodyId chassis);
    void forget_filters_of(BodyId body);
};

// ---- errors ----

template <class Tag> std::string text_of(Id<Tag> id) { return base::join(id.index, ":", id.generation); }
/// "set_pose: body 3:1 is not alive: ..."
template <class Tag> Error dead(const char* command, const char* what, Id<Tag> id) {
    return {base::join(command, ": ", what, " ", text_of(id),
                       " is not alive: destroyed, null, or of another time")};
}
inline Error dead_body(const char* command, BodyId id) { return dead(command, "body", id); }
inline Error dead_shape(const char* command, ShapeId id) { return dead(command, "shape", id); }

// ---- slots and rows ----

/// A slot for a new object in row `row`; the caller has checked that there is room.
std::uint32_t take_slot(State& state, TableId table, Column<Slot> column, std::uint32_t& first_free,
                        std::uint32_t row);
void free_slot(State& state, Column<Slot> column, std::uint32_t index, std::uint32_t& first_free);
/// Moves the last row of a table into `row` and drops the last.
void remove_row(State& state, TableId table, std::uint32_t row);

// ---- traits and mass ----

/// What a checked definition says of a body, but its mass.
void define(BodyTraits& traits, const BodyDef& d);

/// Sums up the shapes of a body. The body's origin stays where it is, its centre of mass moves.
void update_mass(Data& w, std::uint32_t row);
/// Velocity changes by an impulse [N s] and an angular impulse [N m s] about the centre of mass.
void push(Data& w, std::uint32_t row, Vec3 linear, Vec3 angular);

} // namespace lockstone::sim
