// Wrong arguments to a world: commands return an error sentence and change nothing; a read with a wrong argument ends
// the program with a sentence.
#include "fault/misuse.h"
#include "support/sim_scenes.h"
#include "support/small_game.h"

#include "lockstone/play/vehicle.h"
#include "lockstone/session.h"
#include "lockstone/world.h"

#include <doctest/doctest.h>

#include <functional>

using namespace lockstone;
using namespace lockstone::test;

namespace {

struct Health {
    std::int32_t points, shield;
};
template <class V> constexpr void describe(Health& h, V&& v) { v("points", h.points), v("shield", h.shield); }
struct Score {
    std::int32_t points;
};
template <class V> constexpr void describe(Score& s, V&& v) { v("points", s.points); }
/// A row with the size of a Score.
struct Goals {
    std::int32_t goals;
};
template <class V> constexpr void describe(Goals& g, V&& v) { v("goals", g.goals); }
struct Range {
    std::int16_t points, range;
};
template <class V> constexpr void describe(Range& r, V&& v) { v("points", r.points), v("range", r.range); }

/// Two objects of every kind, and for each kind the id of a destroyed one, whose slot is used again.
struct Given {
    GameSchema schema;
    Column<Health> health = schema.add_body_column<Health>("game.health");
    World w = World::create({}, schema).value();
    BodyId body = w.create_body({}).value();
    BodyId dead_body = w.create_body({}).value();
    ShapeId shape = w.create_shape(body, {.geometry = sphere(0.5_r)}).value();
    ShapeId dead_shape = w.create_shape(body, {.geometry = sphere(0.5_r)}).value();
    FieldId dead_field = w.create_field({}).value();
    JointId dead_joint = w.create_joint(hinge_joint(), {}, body, Transform::identity()).value();

    Given() {
        REQUIRE(w.destroy(dead_body).ok());
        REQUIRE(w.destroy(dead_shape).ok());
        REQUIRE(w.destroy(dead_field).ok());
        REQUIRE(w.destroy(dead_joint).ok());
        w.create_body({}).value(); // reuse the slots of the destroyed objects
        w.create_shape(body, {.geometry = sphere(0.5_r)}).value(), w.create_field({}).value();
        w.create_joint(hinge_joint(), {}, body, Transform::identity()).value();
    }
};

template <class AnyId> std::vector<AnyId> wrong_ids(AnyId dead) {
    constexpr std::uint32_t most = ~0u;
    return {AnyId{}, dead, AnyId{1, most}, AnyId{most, 1}, AnyId{most, most}, AnyId{900, 1}, AnyId{0, 1}};
}

void refuses(World& w, const char* what, const std::function<Status()>& call) {
    CAPTURE(what);
    const std::uint64_t before = w.hash();
    const Status status = call();
    REQUIRE_FALSE(status.ok());
    CHECK(status.error().message.size() > 20);
    CHECK(w.hash() == before);
}
} // namespace

TEST_CASE("misuse: commands reject every wrong body with a sentence and do not change the world") {
    Given g;
    World& w = g.w;
    for (const BodyId b : wrong_ids(g.dead_body)) {
        CAPTURE(b.index);
        CHECK_FALSE(w.is_alive(b));
        refuses(w, "destroy", [&] { return w.destroy(b); });
        refuses(w, "create_shape", [&] { return status_of(w.create_shape(b, {.geometry = sphere(0.5_r)})); });
        refuses(w, "create_joint b",
                [&] { return status_of(w.create_joint(hinge_joint(), g.body, b, Transform::identity())); });
        refuses(w, "set_pose", [&] { return w.set_pose(b, Transform::identity()); });
        refuses(w, "set_velocity", [&] { return w.set_velocity(b, {}, {}); });
        refuses(w, "add_force", [&] { return w.add_force(b, {}); });
        refuses(w, "add_force_at", [&] { return w.add_force_at(b, {}, {}); });
        refuses(w, "add_impulse", [&] { return w.add_impulse(b, {}); });
        refuses(w, "add_impulse_at", [&] { return w.add_impulse_at(b, {}, {}); });
        SetBodyParameters parameters{};
        parameters.body = b;
        refuses(w, "set_body_parameters", [&] { return w.set_body_parameters(parameters); });
        SetMass mass{};
        mass.body = b;
        refuses(w, "set_mass", [&] { return w.set_mass(mass); });
        refuses(w, "set_pair_filter a", [&] { return w.set_pair_filter(b, g.body, false); });
        refuses(w, "set_pair_filter b", [&] { return w.set_pair_filter(g.body, b, true); });
        refuses(w, "wake_body", [&] { return w.wake_body(b); });
        refuses(w, "write", [&] { return w.write(g.health, b, Health{1, 2}); });
        VehicleDef vehicle{};
        vehicle.chassis = b;
        refuses(w, "create_vehicle", [&] { return status_of(w.create_vehicle(vehicle)); });
    }
}

TEST_CASE("misuse: a world clears the list of contact points of a wrong body") {
    Given g;
    g.w.tick();
    for (const BodyId b : wrong_ids(g.dead_body)) {
        std::vector<World::ContactPoint> points(3);
        g.w.contacts(b, points);
        CHECK(points.empty());
    }
}

TEST_CASE("misuse: commands reject every wrong shape and field and joint and character and vehicle and "
          "change no state") {
    Given g;
    World& w = g.w;
    for (const ShapeId s : wrong_ids(g.dead_shape)) {
        CHECK_FALSE(w.is_alive(s));
        refuses(w, "destroy shape", [&] { return w.destroy(s); });
        SetMaterial material{};
        material.shape = s;
        refuses(w, "set_material", [&] { return w.set_material(material); });
        SetFilter filter{};
        filter.shape = s;
        refuses(w, "set_filter", [&] { return w.set_filter(filter); });
    }
    for (const FieldId f : wrong_ids(g.dead_field)) {
        CHECK_FALSE(w.is_alive(f));
        refuses(w, "destroy field", [&] { return w.destroy(f); });
        refuses(w, "set_field", [&] { return w.set_field(f, {}); });
    }
    for (const JointId j : wrong_ids(g.dead_joint)) {
        CHECK_FALSE(w.is_alive(j));
        refuses(w, "destroy joint", [&] { return w.destroy(j); });
        refuses(w, "set_joint_axis", [&] { return w.set_joint_axis(j, about_x, {}); });
        refuses(w, "set_joint_frames",
                [&] { return w.set_joint_frames(j, Transform::identity(), Transform::identity()); });
    }
    for (const CharacterId c : wrong_ids(CharacterId{1, 1})) {
        CHECK_FALSE(w.is_alive(c));
        refuses(w, "destroy character", [&] { return w.destroy(c); });
        refuses(w, "set_character_input", [&] { return w.set_character_input(c, {}); });
    }
    for (const VehicleId v : wrong_ids(VehicleId{1, 1})) {
        CHECK_FALSE(w.is_alive(v));
        refuses(w, "destroy vehicle", [&] { return w.destroy(v); });
        refuses(w, "set_vehicle_input", [&] { return w.set_vehicle_input(v, {}); });
    }
    const JointId joint = w.create_joint(hinge_joint(), {}, g.body, Transform::identity()).value();
    refuses(w, "no such axis", [&] { return w.set_joint_axis(joint, static_cast<JointAxisIndex>(99), {}); });
}

TEST_CASE("misuse: a read of an object that does not exist ends the program with a sentence") {
    Given g;
    World& w = g.w;
    for (const BodyId b : {BodyId{}, g.dead_body, BodyId{~0u, ~0u}}) {
        stops("pose", [&] { (void)w.pose(b); });
        stops("center_of_mass", [&] { (void)w.center_of_mass(b); });
        stops("linear_velocity", [&] { (void)w.linear_velocity(b); });
        stops("angular_velocity", [&] { (void)w.angular_velocity(b); });
        stops("mass", [&] { (void)w.mass(b); });
        stops("submersion", [&] { (void)w.submersion(b); });
        stops("kind", [&] { (void)w.kind(b); });
        stops("user_key", [&] { (void)w.user_key(b); });
        stops("is_awake", [&] { (void)w.is_awake(b); });
        stops("shapes", [&] { (void)w.shapes(b); });
        stops("joints", [&] { (void)w.joints(b); });
        stops("read", [&] { (void)w.read(g.health, b); });
    }
    stops("shape", [&] { (void)w.shape(g.dead_shape); });
    stops("body_of shape", [&] { (void)w.body_of(ShapeId{}); });
    stops("field", [&] { (void)w.field(g.dead_field); });
    stops("joint", [&] { (void)w.joint(g.dead_joint); });
    stops("joint_state", [&] { (void)w.joint_state(JointId{}); });
    stops("character", [&] { (void)w.character(CharacterId{1, 1}); });
    stops("character_input", [&] { (void)w.character_input(CharacterId{}); });
    stops("character_state", [&] { (void)w.character_state(CharacterId{}); });
    stops("body_of character", [&] { (void)w.body_of(CharacterId{}); });
    stops("vehicle", [&] { (void)w.vehicle(VehicleId{1, 1}); });
    stops("vehicle_input", [&] { (void)w.vehicle_input(VehicleId{}); });
    stops("vehicle_state", [&] { (void)w.vehicle_state(VehicleId{}); });
    for (const std::uint32_t row : {w.body_count(), ~0u}) {
        stops("body_at", [&] { (void)w.body_at(row); });
        stops("joint_at", [&] { (void)w.joint_at(row); });
        stops("field_at", [&] { (void)w.field_at(row); });
        stops("character_at", [&] { (void)w.character_at(row); });
        stops("vehicle_at", [&] { (void)w.vehicle_at(row); });
    }
    const World empty = World::create({}).value();
    stops("body_at of an empty world", [&] { (void)empty.body_at(0); });
    stops("a column of another schema", [&] { (void)empty.read(g.health, BodyId{}); });
    stops("a column of another type", [&] { (void)w.read(Column<Score>{g.health.index}, g.body); });
    stops("writing it", [&] { (void)w.write(Column<Score>{g.health.index}, g.body, Score{1}); });
}

TEST_CASE("misuse: reading the value of an error or the error of a value ends the program with a sentence") {
    const Result<int> error = Error{"the cup is empty"}, value = 7;
    const std::string words = last_words([&] { (void)error.value(); });
    CHECK(words.find("the cup is empty") != std::string::npos);
    stops("*", [&] { (void)*error; });
    stops("moved", [&] { (void)Result<int>(Error{"x"}).value(); });
    stops("->", [&] { (void)Result<std::string>(Error{"x"})->size(); });
    stops("error", [&] { (void)value.error(); });
    stops("error of a status", [&] { (void)Status{}.error(); });
    CHECK(last_words([&] { (void)value.value(); }) == "");
}

TEST_CASE("misuse: a world rejects an image of another definition or schema or asset library before it "
          "changes anything") {
    const auto made = [](auto change) {
        WorldDef def;
        change(def);
        return World::create(def).value();
    };
    World here = made([](WorldDef&) {}), same = made([](WorldDef&) {});
    here.create_body({}).value();
    Image image;
    CHECK_FALSE(here.can_restore(image).ok());
    same.save(image);
    CHECK(here.can_restore(image).ok());
    here.restore(image);
    CHECK(here.hash() == same.hash());

    std::vector<World> others;
    others.push_back(made([](WorldDef& d) { d.tick_rate = 30; }));
    others.push_back(made([](WorldDef& d) { d.substeps = 5; }));
    others.push_back(made([](WorldDef& d) { d.bodies_max = 7; }));
    others.push_back(made([](WorldDef& d) { d.contacts_max = 7; }));
    others.push_back(made([](WorldDef& d) { d.contact_hertz = 30_r; }));
    GameSchema schema;
    schema.add_record<Score>("game.score");
    others.push_back(World::create({}, schema).value());
    AssetLibrary assets;
    const LengthVec3 corners[] = {{}, {Length(1), {}, {}}, {{}, Length(1), {}}, {{}, {}, Length(1)}};
    assets.add(bake_hull(corners)).value();
    others.push_back(World::create({}, {}, std::make_shared<const AssetLibrary>(std::move(assets))).value());
    const std::uint64_t before = here.hash();
    for (const World& other : others) {
        Image foreign;
        other.save(foreign);
        const Status status = here.can_restore(foreign);
        REQUIRE_FALSE(status.ok());
        CHECK(status.error().message.starts_with("restore: the image is of a "));
        CHECK_FALSE(here.restore_delta(foreign, {}).ok());
        stops("restore", [&] { here.restore(foreign); });
        stops("save_delta", [&] { (void)here.save_delta(foreign); });
        CHECK(here.hash() == before);
    }
}

TEST_CASE("misuse: use of a moved-from world or of a world destroyed before its runner ends the program with "
          "a sentence") {
    World w = World::create({}).value();
    World moved = std::move(w);
    stops("tick", [&] { w.tick(); });
    stops("hash", [&] { (void)w.hash(); });
    stops("create_body", [&] { (void)w.create_body({}); });
    stops("cast_ray", [&] { (void)w.cast_ray({}); });
    stops("clone", [&] { (void)w.clone(); });
    w = std::move(moved);
    w.tick(); // the world has a state again

    struct Nothing final : Game {
        std::string name() const override { return "nothing"; }
        std::uint64_t content_id() const override { return 1; }
        std::uint32_t player_count() const override { return 1; }
        std::uint32_t input_size() const override { return 1; }
        Result<World> start() const override { return World::create({}); }
        Status advance(World& world, std::span<const PlayerInput>) const override {
            world.tick();
            return {};
        }
    } game;
    SimulatedNetwork network(1, {}, 1);
    auto session = make_rollback_session(session_def(game, 0, {0}), network.endpoint(0)).value();
    std::optional<World> driven = World::create({}).value();
    WorldSimulation simulation(*driven, game);
    SessionRunner runner(*session, simulation);
    const auto frame = [&](SessionRunner& by) {
        session->add_local_input(0, std::array{std::byte{}});
        by.frame(1);
    };
    frame(runner);
    SessionRunner other = std::move(runner);
    stops("a runner that was moved from", [&] { frame(runner); });
    stops("waits", [&] { runner.wait(1); });
    stops("is drained", [&] { (void)runner.drain(1); });
    stops("is asked for events", [&] { (void)runner.events(); });
    stops("is asked for failures", [&] { (void)runner.sync_failure(); });
    stops("is asked for its inspector", [&] { (void)runner.inspector(); });
    frame(other);
    for (const std::uint64_t tick : {std::uint64_t{9}, ~std::uint64_t{0}}) { // these ticks never ran
        CHECK(other.inspector().state_after(tick) == nullptr);
        CHECK(other.inspector().run_again(tick, {}).phases.empty());
    }
    const std::string of_session = last_words([&] {
        session.reset();
        other.frame(2);
    });
    CHECK(of_session.find("the session was destroyed before its runner") != std::string::npos);
    driven.reset();
    const std::string words = last_words([&] { frame(other); });
    CHECK(words.find("destroyed before what drives it") != std::string::npos);
}

TEST_CASE("misuse: a session may be destroyed before its runner if the runner is only destroyed afterwards") {
    const SmallGame game;
    SimulatedNetwork network(1, {}, 1);
    World world = game.start().value();
    WorldSimulation simulation(world, game);
    for (const std::uint32_t inspected : {0u, 8u}) {
        auto session =
            make_rollback_session(session_def(game, 0, std::vector<PeerId>(game.player_count(), 0)),
                                  network.endpoint(0))
                .value();
        const SessionRunner runner(*session, simulation, {.inspected_ticks = inspected});
        session.reset();
    }
    CHECK(world.tick_count() == 0);
}

TEST_CASE("misuse: a world rejects an image whose game columns differ in more than their values") {
    struct Schema {
        const char* what;
        void (*add)(GameSchema&);
    };
    const Schema schemas[] = {
        {"a record", [](GameSchema& s) { s.add_record<Score>("game.score"); }},
        {"another field of the same size", [](GameSchema& s) { s.add_record<Goals>("game.score"); }},
        {"another type of the same size", [](GameSchema& s) { s.add_record<Range>("game.score"); }},
        {"a column of bodies", [](GameSchema& s) { s.add_body_column<Score>("game.score"); }},
        {"another name", [](GameSchema& s) { s.add_record<Score>("game.scores"); }},
        {"two columns",
         [](GameSchema& s) { s.add_record<Score>("game.score"), s.add_record<Goals>("game.goals"); }},
        {"two columns in the other order",
         [](GameSchema& s) { s.add_record<Goals>("game.goals"), s.add_record<Score>("game.score"); }},
        {"no column", [](GameSchema&) {}},
    };
    const auto world_of = [](const Schema& from) {
        GameSchema schema;
        from.add(schema);
        return World::create({}, schema).value();
    };
    for (const Schema& mine : schemas)
        for (const Schema& other : schemas) {
            INFO(mine.what, ", image of ", other.what);
            World here = world_of(mine);
            Image image;
            world_of(other).save(image);
            const bool is_same = &mine == &other;
            CHECK(here.can_restore(image).ok() == is_same);
            if (is_same) {
                here.restore(image);
                CHECK_FALSE(here.save_delta(image).empty());
            } else {
                CHECK_FALSE(here.restore_delta(image, {}).ok());
            }
        }
}
