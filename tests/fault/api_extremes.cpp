// Extreme values in every field of every definition and command. The world refuses each with an error sentence and does
// not change, or it continues to tick and the engine accepts its state.
#include "support/sim_scenes.h"

#include "lockstone/math/random.h"
#include "lockstone/play/ragdoll.h"
#include "lockstone/session.h"

#include <doctest/doctest.h>

#include <bit>
#include <cstdlib>
#include <functional>
#include <limits>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// Raw values of a leaf: the ends of its type, the steps next to them and to zero, and values at the documented limits.
template <class L> std::vector<std::int64_t> extremes() {
    std::vector<std::int64_t> raws{0, 1, 2, 3, 7, 64};
    const int bits = static_cast<int>(8 * sizeof(L));
    const std::int64_t top =
        static_cast<std::int64_t>(~std::uint64_t{0} >> (65 - bits)); // of the signed type
    for (const std::int64_t raw : {top, top - 1, top / 2, -top - 1, -top, std::int64_t{-1}})
        raws.push_back(raw);
    if constexpr (FixedPoint<L>)
        for (const std::int64_t whole : {1, 100, 1000, 1000000, 1000000000})
            if (const std::int64_t most = top >> L::fraction_bits; whole <= most) {
                const std::int64_t raw = whole << L::fraction_bits;
                for (const std::int64_t near : {raw - 1, raw, raw + 1, -raw, -raw - 1}) raws.push_back(near);
            }
    return raws;
}

template <class L> void put(L& leaf, std::int64_t raw) {
    if constexpr (FixedPoint<L>)
        leaf.raw = static_cast<typename L::rep>(raw);
    else
        leaf = static_cast<L>(raw);
}

/// A world with one object of every kind, and a valid command of every kind for it.
struct Stage {
    World world;
    std::vector<Command> commands;
};

// Long: one command of each kind, a line each.
Stage make_stage() {
    WorldDef def = small_def();
    def.joints_max = 8, def.characters_max = 4, def.vehicles_max = 4, def.pair_filters_max = 4;
    def.sleeping = 1;
    World w = made(World::create(def));
    const BodyId ground = made(w.create_body({.kind = BodyKind::static_}));
    made(w.create_shape(ground, {.geometry = plane()}));
    const BodyId a = made(w.create_body({.pose = {.position = {0_r, 1_r, 0_r}}}));
    const BodyId b = made(w.create_body({.pose = {.position = {2_r, 1_r, 0_r}}}));
    const ShapeId shape = made(w.create_shape(a, {.geometry = box(0.5_r, 0.5_r, 0.5_r)}));
    made(w.create_shape(b, {.geometry = sphere(0.5_r)}));
    const FieldId field = made(w.create_field(wind({1_r, 0_r, 0_r})));
    const JointId joint = made(w.create_joint(hinge_joint(), a, b, {.position = {1_r, 1_r, 0_r}}));
    CharacterDef walker;
    walker.position = {5_r, 0_r, 0_r};
    const CharacterId character = made(w.create_character(walker));
    VehicleDef car;
    car.chassis = b;
    car.wheel_count = 1;
    const VehicleId vehicle = made(w.create_vehicle(car));
    for (int i = 0; i < 3; ++i) w.tick();

    JointDef weld = weld_joint();
    weld.body_a = ground, weld.body_b = a;
    car.chassis = a;
    walker.position = {-5_r, 0_r, 0_r};
    Stage stage{std::move(w), {}};
    stage.commands = {CreateBody{},
                      CreateShape{a, {}},
                      CreateField{water({})},
                      SetPose{a, {}},
                      SetVelocity{a, {}, {}},
                      AddForce{a, {}, {}},
                      AddForceAt{a, {}, {}},
                      AddImpulse{a, {}, {}},
                      AddImpulseAt{a, {}, {}},
                      SetBodyParameters{a, 0_r, 0_r, 1_r, 0u, 1u, 0u, 1u, 1_r},
                      SetMaterial{shape, 0_r, 0_r, 0_r, Vec3{}},
                      SetGravity{{}},
                      WriteGame{},
                      SetFilter{shape, 1u, 1u, 0},
                      SetPairFilter{a, b, 0},
                      SetMass{a, 1_r, Vec3{}, Vec3{1_r, 1_r, 1_r}, Quat::identity()},
                      CreateJoint{weld},
                      SetJointAxis{joint, about_x, 0, {}},
                      SetJointFrames{joint, {}, {}},
                      WakeBody{a},
                      CreateVehicle{car},
                      SetVehicleInput{vehicle, {}},
                      CreateCharacter{walker},
                      SetCharacterInput{character, {}},
                      SetField{field, wind({})},
                      Explode{},
                      DestroyBody{b},
                      DestroyShape{shape},
                      DestroyField{field},
                      DestroyJoint{joint},
                      DestroyVehicle{vehicle},
                      DestroyCharacter{character}};
    return stage;
}

struct Tally {
    std::uint64_t tried = 0, refused = 0;
    std::vector<std::string> faults;
};

using Apply = std::function<Result<World::Applied>(World&, const Command&)>;

/// Returns an error sentence about the world's reaction to the command, or an empty string.
std::string fault_of(World& world, World& reader, const Command& command, Tally& tally, const Apply& apply) {
    const std::uint64_t before = world.hash();
    const Result<World::Applied> result = apply(world, command);
    ++tally.tried;
    if (!result) {
        ++tally.refused;
        if (!result.error().message.starts_with(std::string(name_of(command)) + ": "))
            return "is refused without its name: " + result.error().message;
        return world.hash() == before ? "" : "is refused, but the world changed";
    }
    for (int i = 0; i < 2; ++i) world.tick();
    const Status read = reader.restore_portable(world.save_portable());
    if (!read) return "leaves a state that the engine refuses: " + read.error().message;
    return reader.hash() == world.hash() ? "" : "leaves a state that reads back as another";
}

/// Sets every leaf of the command to each of its extremes, one at a time; in a long run also random pairs of leaves.
void try_command(const Command& good, World& world, const Image& image, World& reader, Tally& tally,
                 const Apply& apply) {
    std::visit(
        [&]<class C>(const C& base) {
            const auto attempt = [&](const C& odd, const std::string& what) {
                world.restore(image);
                if (const std::string fault = fault_of(world, reader, odd, tally, apply); !fault.empty())
                    tally.faults.push_back(std::string(name_of(good)) + ", " + what + ": " + fault);
            };
            attempt(base, "as it is");
            std::vector<std::vector<std::int64_t>> values;
            C probe = base;
            for_each_leaf(probe, [&]<class L>(L&) { values.push_back(extremes<L>()); });
            const auto with = [&](C odd, std::size_t which, std::int64_t raw) {
                std::size_t at = 0;
                for_each_leaf(odd, [&](auto& leaf) {
                    if (at++ == which) put(leaf, raw);
                });
                return odd;
            };
            for (std::size_t leaf = 0; leaf < values.size(); ++leaf)
                for (const std::int64_t raw : values[leaf])
                    attempt(with(base, leaf, raw),
                            "leaf " + std::to_string(leaf) + " raw " + std::to_string(raw));
            if (std::getenv("LOCKSTONE_LONG") == nullptr) return;
            Random random = Random::seeded(good.index());
            const auto pick = [&](std::size_t count) {
                return random.below(static_cast<std::uint32_t>(count));
            };
            for (int i = 0; i < 20000; ++i) {
                const std::size_t one = pick(values.size()), two = pick(values.size());
                const std::int64_t first = values[one][pick(values[one].size())];
                const std::int64_t second = values[two][pick(values[two].size())];
                attempt(with(with(base, one, first), two, second),
                        "leaves " + std::to_string(one) + " and " + std::to_string(two));
            }
        },
        good);
}

/// Tries commands of every kind, or of the named one.
Tally try_all(const Apply& apply, std::string_view only = {}) {
    Stage stage = make_stage();
    World reader = made(World::create(stage.world.def()));
    Image image;
    stage.world.save(image);
    Tally tally;
    for (const Command& command : stage.commands)
        if (only.empty() || only == name_of(command))
            try_command(command, stage.world, image, reader, tally, apply);
    return tally;
}

const auto as_it_is = [](World& world, const Command& command) { return world.apply(command); };

} // namespace

TEST_CASE(
    "a world rejects an extreme value in any field of any command and names the command or stays valid") {
    const Tally tally = try_all(as_it_is);
    MESSAGE(tally.tried, " commands, ", tally.refused, " refused");
    for (std::size_t i = 0; i < std::min<std::size_t>(tally.faults.size(), 20); ++i)
        FAIL_CHECK(tally.faults[i]);
    CHECK(tally.tried > 5000);
    CHECK(tally.refused > tally.tried / 10);
    CHECK(tally.refused < tally.tried);
}

TEST_CASE("the stage for extreme values has every kind of command") {
    std::vector<bool> seen(std::variant_size_v<Command>, false);
    for (const Command& command : make_stage().commands) seen[command.index()] = true;
    CHECK(std::ranges::find(seen, false) == seen.end());
}

TEST_CASE("planted: the check finds a rejected command that changes the world and an error without the "
          "command's name") {
    const Tally unchecked = try_all(
        [](World& world, const Command& command) {
            Result<World::Applied> result = world.apply(command);
            if (const auto* gravity = std::get_if<SetGravity>(&command); gravity != nullptr && !result) {
                static_cast<void>(
                    world.apply(SetGravity{Vec3{1_r, 0_r, 0_r}})); // refused, but the world changes
            }
            return result;
        },
        "set_gravity");
    CHECK(!unchecked.faults.empty());
    const Tally nameless = try_all(
        [](World& world, const Command& command) -> Result<World::Applied> {
            Result<World::Applied> result = world.apply(command);
            return result ? std::move(result) : Result<World::Applied>(Error{"no"});
        },
        "create_body");
    CHECK(nameless.refused > 0);
    CHECK(nameless.faults.size() == nameless.refused);
}

TEST_CASE("World::create rejects an extreme value in any field of a definition or makes a world that ticks") {
    // Capacities stay small: the greatest valid ones take gigabytes.
    const auto is_count = [](std::string_view name) {
        return name.ends_with("_max") && name != "push_speed_max";
    };
    std::uint64_t tried = 0, refused = 0;
    const auto attempt = [&](const WorldDef& def, const char* name) {
        CAPTURE(name);
        ++tried;
        Result<World> world = World::create(def);
        if (!world) {
            ++refused;
            CHECK(world.error().message.find(name) != std::string::npos);
            return;
        }
        const BodyId body = world->create_body({}) ? world->body_at(0) : BodyId{};
        if (world->is_alive(body)) static_cast<void>(world->create_shape(body, {}));
        for (int i = 0; i < 3; ++i) world->tick();
    };
    std::vector<std::pair<const char*, std::vector<std::int64_t>>> leaves;
    WorldDef probe;
    describe(probe, [&](const char* name, auto& field) {
        for_each_leaf(field, [&]<class L>(L&) { leaves.emplace_back(name, extremes<L>()); });
    });
    for (std::size_t which = 0; which < leaves.size(); ++which)
        for (const auto& [name, raws] = leaves[which]; const std::int64_t raw : raws) {
            if (is_count(name) && (raw < -1 || raw > 64)) continue;
            WorldDef def = small_def();
            std::size_t at = 0;
            for_each_leaf(def, [&](auto& leaf) {
                if (at++ == which) put(leaf, raw);
            });
            attempt(def, name);
        }
    MESSAGE(tried, " definitions, ", refused, " refused");
    CHECK(refused > 50);
    CHECK(refused < tried);
}

TEST_CASE("a world answers extreme queries and does not change") {
    Stage stage = make_stage();
    World& world = stage.world;
    const std::uint64_t hash = world.hash();
    std::vector<QueryHit> hits;
    std::vector<ShapeId> shapes;
    std::uint64_t answered = 0;
    for (const std::int64_t x : extremes<Real>())
        for (const std::int64_t y : {std::int64_t{0}, x, std::numeric_limits<std::int64_t>::min()}) {
            const Vec3 from{Real::from_raw(x), Real::from_raw(y), 0_r},
                way{Real::from_raw(y), Real::from_raw(x), 1_r};
            const Transform pose{from, Quat{Unit::from_raw(static_cast<std::int32_t>(x)), {}, {}, {}}};
            const Geometry odd = sphere(Real::from_raw(x));
            for (const Geometry& geometry : {sphere(1_r), odd, plane()}) {
                answered += world.cast_shape(geometry, pose, way).has_value() ? 1u : 0u;
                answered += world.nearest(geometry, pose, Real::from_raw(y)).has_value() ? 1u : 0u;
                world.overlap(geometry, pose, {}, shapes);
            }
            answered += world.cast_ray({from, way}).has_value() ? 1u : 0u;
            world.cast_ray_all({from, way}, {}, hits);
        }
    CHECK(answered > 0);
    CHECK(world.hash() == hash);
}

TEST_CASE("the library rejects extreme ragdolls and hulls and meshes and height fields with a sentence or "
          "makes them") {
    std::uint64_t refused = 0, taken = 0;
    for (const std::int64_t raw : extremes<Real>()) {
        World world = made(World::create(small_def()));
        RagdollDef doll;
        doll.height = Real::from_raw(raw);
        const Result<Ragdoll> tall = make_ragdoll(world, doll);
        doll.height = 2_r, doll.mass = Real::from_raw(raw);
        const Result<Ragdoll> heavy = make_ragdoll(world, doll);
        taken += tall.ok(), taken += heavy.ok();
        for (const Result<Ragdoll>* one : {&tall, &heavy})
            if (!*one) {
                ++refused;
                CHECK(!one->error().message.empty());
            }
        for (int i = 0; i < 2; ++i) world.tick();

        const Vec3 corner{Real::from_raw(raw), 0_r, 1_r};
        const Vec3 vertices[] = {{0_r, 0_r, 0_r}, {1_r, 0_r, 0_r}, corner};
        const std::array<std::uint32_t, 3> triangles[] = {{0, 1, 2}}, strangers[] = {{0, 1, 4000000000u}};
        const Result<AssetBytes> mesh = bake_mesh({.vertices = vertices, .triangles = triangles});
        const Result<AssetBytes> odd_mesh = bake_mesh({.vertices = vertices, .triangles = strangers});
        CHECK(!odd_mesh.ok());
        const LengthVec3 points[] = {
            to<Length>(corner), {}, to<Length>(Vec3{1_r, 0_r, 0_r}), to<Length>(Vec3{0_r, 1_r, 0_r})};
        const Result<AssetBytes> hull = bake_hull(points);
        const Length heights[] = {to<Length>(Real::from_raw(raw)), {}, {}, {}};
        const Result<AssetBytes> field = bake_height_field(
            {.columns = 2, .rows = 2, .spacing = to<Length>(Real::from_raw(raw)), .heights = heights});
        const Result<AssetBytes> vast = bake_height_field({.columns = static_cast<std::uint32_t>(raw),
                                                           .rows = 4000000000u,
                                                           .spacing = Length(1),
                                                           .heights = heights});
        CHECK(!vast.ok());
        for (const Result<AssetBytes>* baked : {&mesh, &hull, &field}) {
            AssetLibrary library;
            ++(*baked ? taken : refused);
            if (!*baked)
                CHECK(!baked->error().message.empty());
            else
                CHECK(library.add(**baked).ok()); // a baked asset is accepted
        }
    }
    CHECK(refused > 20);
    CHECK(taken > 20);
}

TEST_CASE("the session makers reject extreme definitions with a sentence or make a session") {
    SimulatedNetwork network(2, {}, 1);
    std::uint64_t refused = 0, taken = 0;
    const auto attempt = [&](const SessionDef& def) {
        const auto rollback = make_rollback_session(def, network.endpoint(0));
        const auto lockstep = make_lockstep_session(def, network.endpoint(0));
        taken += rollback.ok(), taken += lockstep.ok();
        if (!rollback) {
            ++refused;
            CHECK(!rollback.error().message.empty());
        }
        if (!lockstep) {
            ++refused;
            CHECK(!lockstep.error().message.empty());
        }
    };
    for (const std::uint32_t odd : {0u, 1u, 2u, 16u, 17u, 32u, 33u, 64u, 65u, 0x7fffffffu, 0xffffffffu}) {
        SessionDef good;
        good.input_size = 1;
        good.players = {0, 1};
        SessionDef d = good;
        d.input_size = odd, attempt(d), d = good;
        d.self = odd, attempt(d), d = good;
        d.input_delay = odd, attempt(d), d = good;
        d.prediction_max = odd, attempt(d), d = good;
        d.disconnect_ms = odd, attempt(d), d = good;
        d.players = {0, odd}, attempt(d);
        d.players.assign(std::min(odd, 100u), 0), attempt(d);
        static_cast<void>(make_sync_test_session(good, odd));
    }
    CHECK(refused > 10);
    CHECK(taken > 10);
}
