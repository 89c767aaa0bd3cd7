// Commands. Each command is checked as a whole, then applied; an error leaves every byte unchanged. One function for
// each command.
#pragma once

#include "base/text.h"
#include "model/slots.h"
#include "world/data.h"

namespace lockstone::sim {

struct Applier {
    Model& w;
    PlacedShapes& placed;
    const TickScratch& last_tick; ///< source of the contact points
    ContactPoints& contact_points;
    std::vector<std::byte>& canonical_row; ///< scratch memory

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

    /// Call this before a change of a row, pose or material from which the contact points of the last tick are
    /// computed.
    void keep_contact_points() const {
        find_contact_points(w, placed, last_tick.pose_before, last_tick.table.list, last_tick.found,
                            contact_points);
    }
    /// Like sim::wake and sim::wake_all, but keep the contact points first.
    std::uint32_t wake(BodyId body);
    void wake_all();
    void remove_character_of(BodyId body);                         ///< if the body has one; the body stays
    void remove_shape(std::uint32_t body_row, std::uint32_t slot); ///< the mass of the body stays
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

} // namespace lockstone::sim
