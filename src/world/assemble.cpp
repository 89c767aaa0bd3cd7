// Creates bodies, characters, joints, vehicles and fields in the order of the game's keys.
#include "lockstone/assemble.h"

#include "base/text.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace lockstone {

namespace {

using base::join;

/// Indices in ascending order of key. Returns an error if two definitions have the same key.
template <class Def, class Key>
Result<std::vector<std::size_t>> by_key(std::span<const Def> defs, const char* what, Key&& key) {
    std::vector<std::size_t> order(defs.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
        return std::pair(key(defs[a]), a) < std::pair(key(defs[b]), b);
    });
    for (std::size_t i = 1; i < order.size(); ++i)
        if (key(defs[order[i - 1]]) == key(defs[order[i]]))
            return Error{join("assemble: two ", what, " have the user_key ", key(defs[order[i]]))};
    return order;
}

std::uint64_t key_of(const Assembly& a) { return a.body.user_key; }
std::uint64_t key_of(const CharacterDef& d) { return d.user_key; }
std::uint64_t key_of(const JointAssembly& a) { return a.joint.user_key; }
std::uint64_t key_of(const VehicleAssembly& a) { return a.vehicle.user_key; }
std::uint64_t key_of(const FieldAssembly& a) { return a.user_key; }

/// The bodies of a level by their keys. The code looks up keys, and never iterates.
using Names = std::map<std::uint64_t, BodyId>;

Result<BodyId> named(const Names& names, const char* what, std::uint64_t key) {
    const auto found = names.find(key);
    if (found == names.end())
        return Error{join(what, " names ", key, ", which is the user_key of no body handed over")};
    return found->second;
}

Result<BodyId> create(World& world, const Names&, const Assembly& assembly) {
    const auto order = by_key(std::span<const ShapeDef>(assembly.shapes), "shapes of a body",
                              [](const ShapeDef& shape) { return shape.user_key; });
    if (!order) return order.error();
    const Result<BodyId> body = world.create_body(assembly.body);
    if (!body) return body;
    for (const std::size_t i : *order)
        if (const Result<ShapeId> shape = world.create_shape(*body, assembly.shapes[i]); !shape)
            return shape.error();
    return body;
}
Result<CharacterId> create(World& world, const Names&, const CharacterDef& def) {
    return world.create_character(def);
}
Result<JointId> create(World& world, const Names& names, const JointAssembly& assembly) {
    JointDef def = assembly.joint;
    def.body_a = {};
    if (assembly.body_a) {
        const Result<BodyId> a = named(names, "body_a", *assembly.body_a);
        if (!a) return a.error();
        def.body_a = *a;
    }
    const Result<BodyId> b = named(names, "body_b", assembly.body_b);
    if (!b) return b.error();
    def.body_b = *b;
    return world.create_joint(def);
}
Result<VehicleId> create(World& world, const Names& names, const VehicleAssembly& assembly) {
    const Result<BodyId> chassis = named(names, "chassis", assembly.chassis);
    if (!chassis) return chassis.error();
    VehicleDef def = assembly.vehicle;
    def.chassis = *chassis;
    return world.create_vehicle(def);
}
Result<FieldId> create(World& world, const Names&, const FieldAssembly& assembly) {
    return world.create_field(assembly.field);
}

/// Creates all objects of one kind in order of key; `ids` is in the order of `defs`.
template <class IdType, class Def>
Status create_all(World& world, const Names& names, std::span<const Def> defs, const char* what,
                  std::vector<IdType>& ids) {
    const auto order = by_key(defs, what, [](const Def& def) { return key_of(def); });
    if (!order) return order.error();
    ids.resize(defs.size());
    for (const std::size_t i : *order) {
        const Result<IdType> made = create(world, names, defs[i]);
        if (!made)
            return Error{
                join("assemble: ", what, ", user_key ", key_of(defs[i]), ": ", made.error().message)};
        ids[i] = *made;
    }
    return {};
}

/// The definitions of a level, without ownership.
struct Parts {
    std::span<const Assembly> bodies;
    std::span<const CharacterDef> characters = {};
    std::span<const JointAssembly> joints = {};
    std::span<const VehicleAssembly> vehicles = {};
    std::span<const FieldAssembly> fields = {};
};

Status create_level(World& world, const Parts& parts, Assembled& ids) {
    Names names;
    if (Status s = create_all(world, names, parts.bodies, "bodies", ids.bodies); !s) return s;
    for (std::size_t i = 0; i < ids.bodies.size(); ++i) names[key_of(parts.bodies[i])] = ids.bodies[i];
    if (Status s = create_all(world, names, parts.characters, "characters", ids.characters); !s) return s;
    if (Status s = create_all(world, names, parts.joints, "joints", ids.joints); !s) return s;
    if (Status s = create_all(world, names, parts.vehicles, "vehicles", ids.vehicles); !s) return s;
    return create_all(world, names, parts.fields, "fields", ids.fields);
}

Result<Assembled> assemble_parts(World& world, const Parts& parts) {
    Assembled ids;
    World trial = world.clone();
    if (const Status tried = create_level(trial, parts, ids); !tried) return tried.error();
    if (const Status made = create_level(world, parts, ids); !made)
        return made.error(); // cannot happen: the clone accepted the level
    return ids;
}

} // namespace

Result<Assembled> assemble(World& world, const Level& level) {
    return assemble_parts(world,
                          {level.bodies, level.characters, level.joints, level.vehicles, level.fields});
}

Result<std::vector<BodyId>> assemble(World& world, std::span<const Assembly> assemblies) {
    Result<Assembled> ids = assemble_parts(world, {assemblies});
    if (!ids) return ids.error();
    return std::move(ids->bodies);
}

} // namespace lockstone
