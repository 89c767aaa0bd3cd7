// Ids, capacities, refused commands, game columns.
#include "support/refusal.h"
#include "support/sim_script.h"

#include <doctest/doctest.h>

#include <memory>
#include <utility>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

BodyDef with(void (*change)(BodyDef&)) {
    BodyDef d;
    change(d);
    return d;
}
ShapeDef with(void (*change)(ShapeDef&)) {
    ShapeDef d;
    change(d);
    return d;
}

/// A world with one body and one shape, and every command on something dead in it.
std::vector<Command> commands_on(BodyId body, ShapeId shape, FieldId field) {
    return {DestroyBody{body},
            CreateShape{body, {}},
            DestroyShape{shape},
            DestroyField{field},
            SetPose{body, Transform::identity()},
            SetVelocity{body, {}, {}},
            AddForce{body, {}, {}},
            AddForceAt{body, {}, {}},
            AddImpulse{body, {}, {}},
            AddImpulseAt{body, {}, {}},
            SetBodyParameters{body, {}, {}, {}, 0, 0, 0},
            SetMaterial{shape, {}, {}, {}, {}},
            SetFilter{shape, 1, 1, 0},
            SetPairFilter{body, body, 0},
            SetMass{body, {}, {}, {}, Quat::identity()},
            WriteGame{1, 4, body, 0, {}}};
}

} // namespace

TEST_CASE("an id is dead once its object is destroyed, though its slot lives again") {
    World w = made(World::create(small_def()));
    const BodyId first = made(w.create_body({}));
    const ShapeId shape = made(w.create_shape(first, {}));
    done(w.destroy(first));
    CHECK(!w.is_alive(first));
    CHECK(!w.is_alive(shape));
    const BodyId second = made(w.create_body({}));
    CHECK(second.index == first.index);
    CHECK(second.generation == first.generation + 1);
    CHECK(!w.is_alive(first));
    CHECK(w.is_alive(second));
    CHECK(made(w.create_shape(second, {})).generation == shape.generation + 1);
}

TEST_CASE("every command on a null, a destroyed or a never minted id is refused and changes nothing") {
    World w = made(World::create(small_def(), script_schema()));
    const BodyId body = made(w.create_body({}));
    const ShapeId shape = made(w.create_shape(body, {}));
    const FieldId field = made(w.create_field({}));
    done(w.destroy(body)), done(w.destroy(field));
    add_ball(w, at(0, 0, 0)), made(w.create_field({})); // in the same slots
    const std::pair<std::uint32_t, std::uint32_t> ids[] = {
        {0, 0}, {body.index, body.generation}, {1, 7}, {2, 1}, {0xffffffffu, 1}, {1, 0}};
    for (const auto& [index, generation] : ids)
        for (const Command& c : commands_on({index, generation}, {index, generation}, {index, generation}))
            CHECK(refusal_fault(w, c, "is not alive") == "");
    CHECK(refusal_fault(w, DestroyShape{shape}, "destroyed, null, or of another time") == "");
}

TEST_CASE("an id minted after a snapshot is dead after its restore, and creating again gives the same id") {
    World w = made(World::create(small_def()));
    add_floor(w);
    Image image;
    w.save(image);
    const BodyId body = made(w.create_body({}));
    const ShapeId shape = made(w.create_shape(body, {}));
    w.tick();
    w.restore(image);
    CHECK(!w.is_alive(body));
    CHECK(!w.is_alive(shape));
    CHECK(refusal_fault(w, SetVelocity{body, {}, {}}, "of another time") == "");
    CHECK((made(w.create_body({})) == body));
    CHECK((made(w.create_shape(body, {})) == shape));
}

TEST_CASE("destroying bodies in any order leaves every other id, row and game column with its own body") {
    World w = made(World::create(small_def(), script_schema()));
    std::vector<std::pair<BodyId, int>> living;
    std::uint32_t random = 12345;
    for (int i = 0; i < 400; ++i) {
        random = random * 1664525u + 1013904223u;
        if (living.size() == 48 || (random >> 16) % 3 == 0) {
            if (living.empty()) continue;
            const std::size_t victim = (random >> 8) % living.size();
            done(w.destroy(living[victim].first));
            living.erase(living.begin() + static_cast<std::ptrdiff_t>(victim));
        } else {
            const BodyId b =
                made(w.create_body({.pose = at(i, 0, 0), .user_key = static_cast<std::uint64_t>(i)}));
            made(w.create_shape(b, {.geometry = sphere(real(0.1 + 0.001 * i))}));
            CHECK(w.read(health_column, b).last_tick == 0); // new rows are zero
            done(w.write(health_column, b, {real(i), 1, 2, static_cast<std::uint32_t>(i)}));
            living.push_back({b, i});
        }
        REQUIRE(w.body_count() == living.size());
        for (const auto& [b, number] : living) {
            REQUIRE(w.is_alive(b));
            REQUIRE(w.user_key(b) == static_cast<std::uint64_t>(number));
            REQUIRE(w.read(health_column, b).last_tick == static_cast<std::uint32_t>(number));
            REQUIRE(w.pose(b).position.x == Real(number));
            REQUIRE(w.shapes(b).size() == 1);
            REQUIRE((w.body_of(w.shapes(b)[0]) == b));
        }
    }
}

TEST_CASE("a full world refuses more of each kind, names the limit and stays as it was") {
    WorldDef def = small_def();
    def.bodies_max = 3, def.shapes_max = 4, def.fields_max = 2;
    World w = made(World::create(def));
    for (int i = 0; i < 3; ++i) made(w.create_body({}));
    for (int i = 0; i < 4; ++i) made(w.create_shape(w.body_at(0), {}));
    for (int i = 0; i < 2; ++i) made(w.create_field({}));
    CHECK(refusal_fault(w, CreateBody{}, "bodies_max is 3") == "");
    CHECK(refusal_fault(w, CreateShape{w.body_at(0), {}}, "shapes_max is 4") == "");
    CHECK(refusal_fault(w, CreateField{}, "fields_max is 2") == "");
}

TEST_CASE("contacts beyond the limit are dropped, counted and dropped alike in a replay") {
    WorldDef def = small_def();
    def.contacts_max = 5;
    World w = made(World::create(def));
    add_floor(w);
    for (int i = 0; i < 9; ++i) add_ball(w, at(2 * i, 0.5, 0));
    w.tick();
    CHECK(w.faults().contacts_dropped == 4);
    CHECK(w.contacts().size() == 5);
    World twin = w.clone();
    for (int t = 0; t < 30; ++t) w.tick(), twin.tick();
    CHECK(difference(w, twin) == "");
}

TEST_CASE("a definition out of range is refused with its field and its range") {
    World w = made(World::create(small_def()));
    const BodyId body = made(w.create_body({}));
    const std::pair<BodyDef, const char*> bodies[] = {
        {with([](BodyDef& d) { d.kind = static_cast<BodyKind>(3); }), "kind is 3"},
        {with([](BodyDef& d) { d.locks = 64; }), "locks is 64"},
        {with([](BodyDef& d) { d.gyroscopic = 2; }), "gyroscopic is 2"},
        {with([](BodyDef& d) { d.enable_fields = 9; }), "enable_fields is 9"},
        {with([](BodyDef& d) { d.bullet = 2; }), "bullet is 2"},
        {with([](BodyDef& d) { d.pose.position.x = Real(1000000001); }), "within 1000000000 m"},
        {with([](BodyDef& d) { d.pose.rotation.w = Unit{}; }), "not a unit quaternion"},
        {with([](BodyDef& d) { d.linear_velocity.y = Real(501); }), "500 m/s"},
        {with([](BodyDef& d) { d.angular_velocity.z = Real(4096); }), "4095 rad/s"},
        {with([](BodyDef& d) { d.linear_damping = Real(-1); }), "linear_damping is -1"},
        {with([](BodyDef& d) { d.angular_damping = Real(1001); }), "angular_damping is 1001"},
        {with([](BodyDef& d) { d.gravity_scale = Real(101); }), "gravity_scale is 101"},
        {with([](BodyDef& d) { d.mass = Real(-1); }), "mass is -1"}};
    for (const auto& [def, words] : bodies) CHECK(refusal_fault(w, CreateBody{def}, words) == "");
    const std::pair<ShapeDef, const char*> shapes[] = {
        {with([](ShapeDef& d) { d.geometry = sphere(Real{}); }), "radius"},
        {with([](ShapeDef& d) { d.geometry.kind = static_cast<ShapeKind>(10); }), "kind"},
        {with([](ShapeDef& d) { d.geometry = plane(); }), "static body"},
        {with([](ShapeDef& d) { d.local.position.x = Real(65); }), "within 64 m"},
        {with([](ShapeDef& d) { d.density = Real{}; }), "density is 0"},
        {with([](ShapeDef& d) { d.friction = Real(5); }), "friction is 5"},
        {with([](ShapeDef& d) { d.restitution = Real(2); }), "restitution is 2"},
        {with([](ShapeDef& d) { d.sensor = 2; }), "sensor is 2"}};
    for (const auto& [def, words] : shapes) CHECK(refusal_fault(w, CreateShape{body, def}, words) == "");
    CHECK(refusal_fault(w, CreateField{{.kind = static_cast<FieldKind>(4)}}, "kind is 4") == "");
    CHECK(refusal_fault(w, SetGravity{vec(1001, 0, 0)}, "1000 m/s^2") == "");
    CHECK(refusal_fault(w, AddForce{body, vec(2.1e9, 0, 0), {}}, "2e9") == "");
    CHECK(refusal_fault(w, WriteGame{}, "does not exist") == "");
}

TEST_CASE(
    "planted fault: a command that is accepted, or refused for another reason, does not pass for refused") {
    World w = made(World::create(small_def()));
    CHECK(refusal_fault(w, CreateBody{}, "") == "create_body was accepted");
    CHECK(refusal_fault(w, DestroyBody{}, "bodies_max") != "");
}

TEST_CASE("a world definition out of range is refused with its field") {
    const std::pair<void (*)(WorldDef&), const char*> cases[] = {
        {[](WorldDef& d) { d.tick_rate = 0; }, "tick_rate is 0"},
        {[](WorldDef& d) { d.substeps = 17; }, "substeps is 17"},
        {[](WorldDef& d) { d.integrator = static_cast<Integrator>(4); }, "integrator is 4"},
        {[](WorldDef& d) { d.bodies_max = 0; }, "bodies_max is 0"},
        {[](WorldDef& d) { d.gravity.y = Real(-2000); }, "gravity.y is -2000"},
        {[](WorldDef& d) { d.contact_hertz = Real{}; }, "contact_hertz is 0"}};
    for (const auto& [change, words] : cases) {
        WorldDef def;
        change(def);
        const Result<World> result = World::create(def);
        REQUIRE(!result);
        CHECK(result.error().message.find(words) != std::string::npos);
    }
}

TEST_CASE("game columns and records are saved, hashed, restored, carried in portable images and freed with "
          "the body") {
    World w = made(World::create(small_def(), script_schema()));
    const BodyId a = made(w.create_body({})), b = made(w.create_body({}));
    const std::uint64_t empty = w.hash();
    done(w.write(health_column, b, {real(5), -3, 4, 9}));
    done(w.write(tally_record, {11, 12, {a, b, {}, {}}}));
    CHECK(w.hash() != empty);
    Image image;
    w.save(image);
    World other = made(World::create(small_def(), script_schema()));
    done(other.restore_portable(w.save_portable()));
    CHECK(difference(w, other) == "");
    CHECK(other.read(health_column, b).hits == -3);
    CHECK((other.read(tally_record).thrown[1] == b));
    done(w.destroy(a));
    CHECK(w.read(health_column, b).points == Real(5)); // b's row moved to a's place
    done(w.destroy(b));
    const BodyId c = made(w.create_body({}));
    CHECK(w.read(health_column, c).points == Real{});
    w.restore(image);
    CHECK(w.read(health_column, b).last_tick == 9);
    CHECK(w.read(tally_record).ended == 12);
}

namespace {

/// Empty when a definition held like that is a value: copies part, what is assigned or moved to has what the source had.
template <class Held> std::string value_fault(const Held& good) {
    Held copy = good;
    copy->break_force = 7_r;
    if (good->break_force == copy->break_force) return "a copy shares the definition";
    Held other = copy;
    other = good;
    if (other->break_force != good->break_force) return "an assignment changes nothing";
    Held& same = other;
    other = same;
    if (other->break_force != good->break_force) return "an assignment to itself loses the definition";
    const Held taken = std::move(copy);
    return taken->break_force == 7_r ? "" : "a move loses the definition";
}

} // namespace

TEST_CASE("a large definition in a command is a value, and so is the command") {
    CHECK(value_fault(Indirect<JointDef>(hinge_joint())) == "");
    Command command = CreateJoint{hinge_joint()};
    const Command copy = command;
    std::get<CreateJoint>(command).def->break_force = 7_r;
    CHECK(std::get<CreateJoint>(copy).def->break_force == 0_r);
    command = DestroyBody{};
    command = copy;
    CHECK(std::get<CreateJoint>(command).def->kind == JointKind::hinge);
}

TEST_CASE("planted: a definition that copies of a command share is noticed") {
    CHECK(value_fault(std::make_shared<JointDef>(hinge_joint())) == "a copy shares the definition");
}
