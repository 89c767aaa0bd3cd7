// Ids, capacities, refused commands, game columns.
#include "support/refusal.h"
#include "support/sim_script.h"

#include <doctest/doctest.h>

#include <memory>
#include <utility>

using namespace lockstone;
using namespace lockstone::test::scene;

TEST_CASE("an id is dead after its object is destroyed even when its slot is used again") {
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

TEST_CASE("an id created after a snapshot is dead after its restore and creating again gives the same id") {
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

TEST_CASE("destroying bodies in any order keeps ids and rows and game columns of all other bodies") {
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

TEST_CASE("a full world rejects more objects of each kind and names the limit and stays unchanged") {
    WorldDef def = small_def();
    def.bodies_max = 3, def.shapes_max = 4, def.fields_max = 2, def.joints_max = 2;
    World w = made(World::create(def));
    for (int i = 0; i < 3; ++i) made(w.create_body({}));
    for (int i = 0; i < 4; ++i) made(w.create_shape(w.body_at(0), {}));
    for (int i = 0; i < 2; ++i) made(w.create_field({}));
    JointDef joint = ball_joint();
    joint.body_b = w.body_at(1);
    for (int i = 0; i < 2; ++i) made(w.create_joint(joint));
    CHECK(refusal_fault(w, CreateBody{}, "bodies_max is 3") == "");
    CHECK(refusal_fault(w, CreateShape{w.body_at(0), {}}, "shapes_max is 4") == "");
    CHECK(refusal_fault(w, CreateField{}, "fields_max is 2") == "");
    CHECK(refusal_fault(w, CreateJoint{joint}, "joints_max is 2") == "");
}

TEST_CASE("commands reject bad rotations and shape kinds and planes that move and forces out of range") {
    World w = made(World::create(small_def()));
    const BodyId body = made(w.create_body({}));
    const auto with = [](auto def, auto change) {
        change(def);
        return def;
    };
    const std::pair<Command, const char*> rows[] = {
        {CreateBody{with(BodyDef{}, [](BodyDef& d) { d.pose.rotation.w = Unit{}; })},
         "not a unit quaternion"},
        {CreateShape{body, {.geometry = sphere(Real{})}}, "radius"},
        {CreateShape{body, with(ShapeDef{}, [](ShapeDef& d) { d.geometry.kind = ShapeKind{10}; })}, "kind"},
        {CreateShape{body, {.geometry = plane()}}, "static body"},
        {SetGravity{vec(1001, 0, 0)}, "1000 m/s^2"},
        {AddForce{body, vec(2.1e9, 0, 0), {}}, "2e9"},
        {WriteGame{}, "does not exist"}};
    for (const auto& [command, words] : rows) CHECK(refusal_fault(w, command, words) == "");
}

TEST_CASE("planted fault: the test detects a command that is accepted or rejected for another reason") {
    World w = made(World::create(small_def()));
    CHECK(refusal_fault(w, CreateBody{}, "") == "create_body was accepted");
    CHECK(refusal_fault(w, DestroyBody{}, "bodies_max") != "");
}

TEST_CASE("game columns and records are saved and hashed and restored and portable and freed with the body") {
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
    CHECK(w.read(health_column, b).points == Real(5)); // b's row moved into a's row
    done(w.destroy(b));
    const BodyId c = made(w.create_body({}));
    CHECK(w.read(health_column, c).points == Real{});
    w.restore(image);
    CHECK(w.read(health_column, b).last_tick == 9);
    CHECK(w.read(tally_record).ended == 12);
}

namespace {

/// Checks that a definition held like that has value semantics: copies are independent, and the target of an assignment
/// or a move has the source's value. Returns an error sentence or an empty string.
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

TEST_CASE("a copy of a command with a large definition has a definition of its own") {
    CHECK(value_fault(Indirect<JointDef>(hinge_joint())) == "");
    Command command = CreateJoint{hinge_joint()};
    const Command copy = command;
    std::get<CreateJoint>(command).def->break_force = 7_r;
    CHECK(std::get<CreateJoint>(copy).def->break_force == 0_r);
    command = DestroyBody{};
    command = copy;
    CHECK(std::get<CreateJoint>(command).def->kind == JointKind::hinge);
}

TEST_CASE("planted: the test detects a definition that copies of a command share") {
    CHECK(value_fault(std::make_shared<JointDef>(hinge_joint())) == "a copy shares the definition");
}
