// Creation of objects in the order of user_key: equal definitions give equal worlds, in whatever order they
// come.
//
//   Level level;                                           // filled in any order, say from a hash map
//   level.bodies.push_back({{.user_key = 7}, {{.geometry = sphere(0.5_r)}}});
//   level.joints.push_back({.joint = hinge_joint(), .body_a = {}, .body_b = 7});
//   Assembled ids = assemble(world, level).value();        // each kind in the order of `level`
#pragma once

#include "lockstone/world.h"

#include <optional>
#include <span>
#include <vector>

namespace lockstone {

/// A body with its shapes.
struct Assembly {
    BodyDef body;                 ///< its user_key must be unique among the bodies of the call
    std::vector<ShapeDef> shapes; ///< their keys must be unique within the body
};

/// A joint; its bodies are keys of Level::bodies. The ids in `joint` are ignored.
struct JointAssembly {
    JointDef joint;                      ///< its user_key must be unique among the joints
    std::optional<std::uint64_t> body_a; ///< key of the first body; empty: the world
    std::uint64_t body_b = 0;            ///< key of the second body
};
/// A vehicle; its chassis is a key of Level::bodies. The id in `vehicle` is ignored.
struct VehicleAssembly {
    VehicleDef vehicle;        ///< its user_key must be unique among the vehicles
    std::uint64_t chassis = 0; ///< key of the chassis
};
/// A force field.
struct FieldAssembly {
    FieldDef field;             ///< the field
    std::uint64_t user_key = 0; ///< unique among the fields; the world does not store it
};

/// Everything to create, in any order.
struct Level {
    std::vector<Assembly> bodies;          ///< bodies with their shapes
    std::vector<CharacterDef> characters;  ///< their keys must be unique
    std::vector<JointAssembly> joints;     ///< joints between `bodies`
    std::vector<VehicleAssembly> vehicles; ///< vehicles on `bodies`
    std::vector<FieldAssembly> fields;     ///< force fields
};

/// Ids of the created objects: entry i of a list is that of entry i in the Level.
struct Assembled {
    std::vector<BodyId> bodies;          ///< of Level::bodies
    std::vector<CharacterId> characters; ///< of Level::characters
    std::vector<JointId> joints;         ///< of Level::joints
    std::vector<VehicleId> vehicles;     ///< of Level::vehicles
    std::vector<FieldId> fields;         ///< of Level::fields
};

/// Creates bodies with their shapes, then characters, joints, vehicles and fields, each kind in ascending
/// order of user_key. Ids, rows and hash do not depend on the order of `level`. Errors name the key; the
/// world is then as before and its journal received nothing, because a clone runs the commands first.
Result<Assembled> assemble(World& world, const Level& level);
/// assemble() for bodies with their shapes only.
Result<std::vector<BodyId>> assemble(World& world, std::span<const Assembly> assemblies);

} // namespace lockstone
