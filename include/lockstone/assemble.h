// Worlds by the game's own keys: the same definitions make the same world, in whatever order they are handed over.
//
//   Level level;                                           // filled from a hash map, a network, threads: in any order
//   level.bodies.push_back({{.user_key = 7}, {{.geometry = sphere(0.5_r)}}});
//   level.joints.push_back({.joint = hinge_joint(), .body_a = {}, .body_b = 7});
//   Assembled ids = assemble(world, level).value();        // each kind in the order of `level`
#pragma once

#include "lockstone/world.h"

#include <optional>
#include <span>
#include <vector>

namespace lockstone {

struct Assembly {
    BodyDef body;                 ///< `user_key` differs from those of all others that are handed over
    std::vector<ShapeDef> shapes; ///< those of one body have keys that differ
};

/// Its bodies are named by the keys of `Level::bodies`; the ids in `joint` are not read.
struct JointAssembly {
    JointDef joint;                      ///< `user_key` differs from those of the other joints
    std::optional<std::uint64_t> body_a; ///< none: the world
    std::uint64_t body_b = 0;
};
/// The chassis is named by its key; the id in `vehicle` is not read.
struct VehicleAssembly {
    VehicleDef vehicle; ///< `user_key` differs from those of the other vehicles
    std::uint64_t chassis = 0;
};
struct FieldAssembly {
    FieldDef field;
    std::uint64_t user_key = 0; ///< differs from those of the other fields; the world does not keep it
};

struct Level {
    std::vector<Assembly> bodies;
    std::vector<CharacterDef> characters; ///< their keys differ
    std::vector<JointAssembly> joints;
    std::vector<VehicleAssembly> vehicles;
    std::vector<FieldAssembly> fields;
};

/// Ids, each list in the order of the level's.
struct Assembled {
    std::vector<BodyId> bodies;
    std::vector<CharacterId> characters;
    std::vector<JointId> joints;
    std::vector<VehicleId> vehicles;
    std::vector<FieldId> fields;
};

/// Creates bodies with their shapes, then characters, joints, vehicles and fields, each kind in ascending order of user_key, so
/// that ids, rows and hash do not depend on the order here. On error, which names the key, the world is as it was and its journal
/// was told nothing: all is tried on a clone first.
Result<Assembled> assemble(World& world, const Level& level);
/// Bodies and their shapes alone.
Result<std::vector<BodyId>> assemble(World& world, std::span<const Assembly> assemblies);

} // namespace lockstone
