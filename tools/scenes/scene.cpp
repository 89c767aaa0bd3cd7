#include "scenes/scene.h"

namespace lockstone::scenes_detail {

Scene::Scene(const SceneInfo& about, const SceneOptions& chosen, std::uint32_t version)
    : info(about), options(chosen), rules_version(version) {}

std::string Scene::name() const {
    return std::string(info.name) + " size=" + std::to_string(options.size) +
           " seed=" + std::to_string(options.seed) + " players=" + std::to_string(options.players);
}

std::uint64_t Scene::content_id() const {
    const std::string text = name();
    return hash_bytes(std::as_bytes(std::span(text)), rules_version);
}

void Scene::script(std::uint64_t, std::uint64_t, std::uint32_t, std::span<std::byte>) const {}

Geometry Shelf::add(const Result<AssetBytes>& baked) {
    if (!status) return {};
    const Result<AssetId> id = library.add(baked);
    const Result<Geometry> geometry = id ? library.geometry(*id) : Result<Geometry>(id.error());
    if (geometry) return *geometry;
    status = geometry.error();
    return {};
}

Result<std::shared_ptr<const AssetLibrary>> Shelf::finish() && {
    if (!status) return status.error();
    return std::make_shared<const AssetLibrary>(std::move(library));
}

Builder::Builder(const WorldDef& def, const GameSchema& schema, std::shared_ptr<const AssetLibrary> assets)
    : made(World::create(def, schema, std::move(assets))) {}

BodyId Builder::body(const BodyDef& def, const ShapeDef& shape_def) {
    if (!made.ok()) return {};
    const Result<BodyId> body = made->create_body(def);
    if (!body) {
        made = body.error();
        return {};
    }
    shape(*body, shape_def);
    return *body;
}

void Builder::shape(BodyId body, const ShapeDef& shape_def) {
    if (!made.ok()) return;
    if (const Result<ShapeId> shape = made->create_shape(body, shape_def); !shape) made = shape.error();
}

VehicleId Builder::vehicle(const VehicleDef& def) {
    if (!made.ok()) return {};
    const Result<VehicleId> vehicle = made->create_vehicle(def);
    if (!vehicle) made = vehicle.error();
    return vehicle.ok() ? *vehicle : VehicleId{};
}

BodyId Builder::ground() {
    return body({.kind = BodyKind::static_, .user_key = user_key_of(Role::terrain, 0)},
                {.geometry = plane()});
}

JointId Builder::joint(const JointDef& def, BodyId a, BodyId b, const Transform& at) {
    if (!made.ok()) return {};
    return keep(made->create_joint(def, a, b, at));
}

FieldId Builder::field(const FieldDef& def) {
    if (!made.ok()) return {};
    return keep(made->create_field(def));
}
JointId Builder::joint(const JointDef& def) {
    if (!made.ok()) return {};
    return keep(made->create_joint(def));
}

CharacterId Builder::character(const CharacterDef& def) {
    if (!made.ok()) return {};
    return keep(made->create_character(def));
}

Ragdoll Builder::ragdoll(const RagdollDef& def) {
    if (!made.ok()) return {};
    return keep(make_ragdoll(*made, def));
}

void Builder::keep(const Status& status) {
    if (!status) made = status.error();
}

WorldDef world_for(std::uint32_t dynamic_bodies, std::uint64_t seed) {
    constexpr std::uint32_t scenery = 16, pairs_per_body = 12;
    WorldDef def;
    // Capacities are part of the hash: the scenes keep the values of their recordings.
    def.fields_max = def.characters_max = def.vehicles_max = 16;
    def.pair_filters_max = 64, def.joints_max = 256;
    def.bodies_max = dynamic_bodies + scenery;
    def.shapes_max = dynamic_bodies + scenery;
    def.contacts_max = pairs_per_body * (dynamic_bodies + scenery);
    def.seed = seed;
    return def;
}

StateCheck& StateCheck::holds(bool condition, std::string_view what, std::string_view why) {
    if (!condition && status)
        status = Error{"column " + std::string(where) + ": " + std::string(what) + " " + std::string(why)};
    return *this;
}

Transform at(Vec3 position) { return {position, Quat::identity()}; }
Transform at(Vec3 position, Quat rotation) { return {position, rotation}; }

} // namespace lockstone::scenes_detail
