// Each setter changes the settings that its command names and no other, and every setting can be read back.
#include "support/sim_scenes.h"

#include <doctest/doctest.h>

#include <map>
#include <set>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// Every setting that a setter can change, by name. All values differ from a definition's defaults.
using Settings = std::map<std::string, std::vector<std::int64_t>>;

template <class T> std::vector<std::int64_t> numbers_of(T value) {
    std::vector<std::int64_t> numbers;
    for_each_leaf(value, [&](auto& leaf) {
        if constexpr (FixedPoint<std::remove_reference_t<decltype(leaf)>>)
            numbers.push_back(leaf.raw);
        else
            numbers.push_back(static_cast<std::int64_t>(leaf));
    });
    return numbers;
}

struct Scene {
    World world;
    BodyId body;
    ShapeId shape;

    Settings settings() const {
        Settings all;
        const auto add = [&](const char* name, auto& field) { all[name] = numbers_of(field); };
        BodyDef b = world.body(body);
        describe(b, add);
        ShapeDef s = world.shape(shape);
        describe(s, add);
        SetMass m = world.mass_properties(body);
        describe(m, [&](const char* name, auto& field) {
            if constexpr (requires { field.given; })
                all["mass of all: " + std::string(name)] = numbers_of(field.value);
        });
        return all;
    }
};

Scene make_scene() {
    World world = made(World::create(small_def()));
    BodyDef b;
    b.linear_damping = 0.1_r, b.angular_damping = 0.2_r, b.gravity_scale = 0.3_r, b.drag_scale = 0.4_r;
    b.locks = lock_linear_x, b.gyroscopic = 0, b.bullet = 1, b.enable_fields = 0, b.mass = 7_r;
    const BodyId body = made(world.create_body(b));
    ShapeDef s;
    s.geometry = box(0.5_r, 1_r, 0.25_r);
    s.friction = 0.1_r, s.restitution = 0.2_r, s.rolling_resistance = 0.3_r,
    s.surface_velocity = vec(1, 2, 3);
    s.category = 6, s.mask = 5, s.group = 4;
    const ShapeId shape = made(world.create_shape(body, s));
    return {std::move(world), body, shape};
}

/// Names of the settings that differ.
std::set<std::string> changed(const Settings& before, const Settings& after) {
    std::set<std::string> names;
    for (const auto& [name, value] : before)
        if (after.at(name) != value) names.insert(name);
    return names;
}

/// Applies, for each setting of C, a command that names only that setting. `spoil` may plant a fault in the command.
/// Returns a sentence for each command that changes another setting.
template <class C, class Spoil>
std::vector<std::string> faults_of(const C& all_given, const std::map<std::string, std::string>& known_as,
                                   Spoil&& spoil) {
    std::vector<std::string> faults, names;
    C probe = all_given;
    describe(probe, [&](const char* name, auto& field) {
        if constexpr (requires { field.given; }) names.push_back(name);
    });
    for (const std::string& name : names) {
        Scene scene = make_scene();
        C command = all_given;
        describe(command, [&](const char* field_name, auto& field) {
            if constexpr (requires { field.given; })
                if (field_name != name) field = {};
            if constexpr (std::same_as<std::remove_reference_t<decltype(field)>, BodyId>) field = scene.body;
            if constexpr (std::same_as<std::remove_reference_t<decltype(field)>, ShapeId>)
                field = scene.shape;
        });
        spoil(command);
        const Settings before = scene.settings();
        done([&]() -> Status {
            Result<World::Applied> applied = scene.world.apply(command);
            return applied ? Status{} : applied.error();
        }());
        const std::set<std::string> names_changed = changed(before, scene.settings());
        const auto known = known_as.find(name);
        if (names_changed != std::set<std::string>{known == known_as.end() ? name : known->second}) {
            std::string fault = name + " alone changes";
            for (const std::string& other : names_changed) fault += " " + other;
            faults.push_back(fault);
        }
    }
    return faults;
}

const SetBodyParameters parameters{{}, 1_r, 2_r, 3_r, std::uint32_t{lock_angular_y}, 1u, 0u, 1u, 4_r};
const SetMaterial material{{}, 0.5_r, 0.6_r, 0.7_r, Vec3{4_r, 5_r, 6_r}};
const SetFilter filter{{}, 9u, 10u, 11};
const SetMass masses{{}, 9_r, Vec3{0.5_r, 0_r, 0_r}, Vec3{1_r, 2_r, 3_r}, Quat{unit_one, {}, {}, {}}};
const std::map<std::string, std::string> mass_names{{"mass", "mass of all: mass"},
                                                    {"center", "mass of all: center"},
                                                    {"gyration", "mass of all: gyration"},
                                                    {"principal", "mass of all: principal"}};
const auto as_it_is = [](auto&) {};
/// A planted fault, the setters' former behaviour: a setting that the command does not name becomes zero.
const auto zero_the_rest = [](auto& command) {
    describe(command, [](const char*, auto& field) {
        if constexpr (requires { field.given; }) field.given = 1;
    });
};

} // namespace

TEST_CASE(
    "setters of bodies and surfaces and filters and masses change only the settings that they are given") {
    CHECK(faults_of(parameters, {}, as_it_is) == std::vector<std::string>{});
    CHECK(faults_of(material, {}, as_it_is) == std::vector<std::string>{});
    CHECK(faults_of(filter, {}, as_it_is) == std::vector<std::string>{});
    CHECK(faults_of(masses, mass_names, as_it_is) == std::vector<std::string>{});
}

TEST_CASE("planted: the test detects setters that zero the settings that are not given") {
    CHECK(faults_of(parameters, {}, zero_the_rest).size() == 8);
    CHECK(faults_of(material, {}, zero_the_rest).size() == 4);
    CHECK(faults_of(filter, {}, zero_the_rest).size() == 3);
}

TEST_CASE("a setter rejects a setting that is neither given nor left out and names it") {
    Scene scene = make_scene();
    SetBodyParameters bad{.body = scene.body};
    bad.drag_scale.given = 2;
    const Status status = scene.world.set_body_parameters(bad);
    REQUIRE(!status);
    CHECK(status.error().message == "set_body_parameters: drag_scale.given must be 0 or 1");
    SetFilter odd{.shape = scene.shape};
    odd.mask.given = 7;
    REQUIRE(!scene.world.set_filter(odd));
}

TEST_CASE("World returns each setting that was set") {
    Scene scene = make_scene();
    World& world = scene.world;
    const BodyId other = made(world.create_body({}));
    CHECK(world.may_touch(scene.body, other));
    done(world.set_pair_filter(scene.body, other, false));
    CHECK(!world.may_touch(other, scene.body));
    done(world.set_pair_filter(scene.body, other, true));
    CHECK(world.may_touch(scene.body, other));

    CHECK(world.gravity() == world.def().gravity);
    done(world.set_gravity(vec(1, 2, 3)));
    CHECK(world.gravity() == vec(1, 2, 3));

    SetMass mass = masses;
    mass.body = scene.body;
    done(world.set_mass(mass));
    const SetMass told = world.mass_properties(scene.body);
    CHECK(told.mass.value == 9_r);
    CHECK(told.center.value == mass.center.value);
    CHECK(told.gyration.value == mass.gyration.value);

    const std::uint64_t hash = world.hash();
    done(world.set_pose(scene.body, world.body(scene.body).pose));
    const BodyDef now = world.body(scene.body);
    done(world.set_body_parameters({.body = scene.body,
                                    .linear_damping = now.linear_damping,
                                    .angular_damping = now.angular_damping,
                                    .gravity_scale = now.gravity_scale,
                                    .locks = now.locks,
                                    .gyroscopic = now.gyroscopic,
                                    .bullet = now.bullet,
                                    .enable_fields = now.enable_fields,
                                    .drag_scale = now.drag_scale}));
    CHECK(world.hash() != hash); // the count of commands is in the state
    CHECK(numbers_of(world.body(scene.body)) == numbers_of(now));
}

TEST_CASE("a pose without a rotation has the identity rotation") {
    CHECK(Transform{.position = vec(1, 2, 3)}.rotation == Quat::identity());
    CHECK(Transform{} == Transform::identity());
    World world = made(World::create(small_def()));
    const BodyId body = made(world.create_body({.pose = {.position = {1_r, 2_r, 3_r}}}));
    CHECK(world.pose(body).rotation == Quat::identity());
}

TEST_CASE("validate() reports a size beyond the range of Length with the limit and the way around it") {
    const std::string fault = validate(sphere(500_r));
    CHECK(
        fault ==
        "sphere radius is 128 m or more, it must be in 0.0025 m .. 100 m; on a static body scaled() makes a "
        "smaller one up to 8 times as large");
    CHECK(validate(scaled(sphere(62.5_r), 8_r)) == "");
    CHECK(validate(sphere(100_r)) == "");
}
