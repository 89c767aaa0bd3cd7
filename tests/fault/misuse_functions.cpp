// Wrong arguments to the functions that misuse_world.cpp and misuse_play.cpp leave out: queries, shapes and their
// masses, ragdolls, pools, networks, proofs, verifying and branching. tests/tidy/misuse.py lists the functions.
#include "fault/misuse.h"
#include "support/sim_scenes.h"
#include "support/small_recording.h"

#include "lockstone/assemble.h"
#include "lockstone/asset.h"
#include "lockstone/math/random.h"
#include "lockstone/play/ragdoll.h"
#include "lockstone/play/vehicle.h"
#include "lockstone/prove.h"
#include "lockstone/session.h"
#include "lockstone/tasks.h"
#include "lockstone/testing.h"

#include <doctest/doctest.h>

#include <functional>
#include <type_traits>
#include <utility>
#include <vector>

using namespace lockstone;
using namespace lockstone::test;

namespace {

template <class Enum> constexpr Enum none_of = static_cast<Enum>(99);

/// A world with a live body and the id of a destroyed one.
struct Given {
    World w = World::create({}).value();
    BodyId body = w.create_body({}).value();
    BodyId dead = w.create_body({}).value();
    ShapeId shape = w.create_shape(body, {.geometry = sphere(0.5_r)}).value();
    Given() { REQUIRE(w.destroy(dead).ok()); }
};

constexpr std::int32_t edges[] = {std::numeric_limits<std::int32_t>::min(),
                                  std::numeric_limits<std::int32_t>::min() + 1,
                                  -(100 << 24),
                                  -1,
                                  0,
                                  1,
                                  41943, // 2.5 mm
                                  1 << 24,
                                  100 << 24,
                                  (100 << 24) + 1,
                                  std::numeric_limits<std::int32_t>::max()};

/// Geometries of every kind and of invalid kinds, of any size.
Geometry any_geometry(lockstone::Random& random) {
    const auto any = [&] {
        return Length::from_raw(random.below(2) == 0 ? edges[random.below(std::size(edges))]
                                                     : static_cast<std::int32_t>(random.next_u32()));
    };
    Geometry g{static_cast<ShapeKind>(random.below(12)), any(), {any(), any(), any()}};
    if (random.below(2) == 0) g.half_extent.z = g.half_extent.x;
    if (random.below(3) == 0) g.radius = Length{};
    if (random.below(2) == 0) g.scale = LengthVec3{any(), any(), any()};
    return g;
}

Real any_real(lockstone::Random& random) {
    return Real::from_raw(static_cast<std::int64_t>(random.next_u64() >> (1 + random.below(63))) *
                          (random.below(2) == 0 ? 1 : -1));
}

} // namespace

TEST_CASE("a value that is taken out of a temporary Result outlives it") {
    using List = Result<std::vector<int>>;
    static_assert(std::is_same_v<decltype(std::declval<List>().value()), std::vector<int>>);
    static_assert(std::is_same_v<decltype(*std::declval<List>()), std::vector<int>>);
    int sum = 0;
    for (const int x : List(std::vector<int>{1, 2, 4}).value()) sum += x; // under the address sanitizer too
    CHECK(sum == 7);
}

TEST_CASE("misuse: a read of a dead body's definition or mass or filter ends the program with a sentence") {
    Given g;
    for (const BodyId b : {BodyId{}, g.dead, BodyId{~0u, ~0u}}) {
        stops("body", [&] { (void)g.w.body(b); });
        stops("mass_properties", [&] { (void)g.w.mass_properties(b); });
        stops("may_touch a", [&] { (void)g.w.may_touch(b, g.body); });
        stops("may_touch b", [&] { (void)g.w.may_touch(g.body, b); });
    }
}

TEST_CASE("misuse: a world answers senseless queries with an empty result and does not change") {
    Given g;
    World& w = g.w;
    const BodyId grounds[] = {w.create_body({.kind = BodyKind::static_}).value(),
                              w.create_body({.kind = BodyKind::static_}).value()};
    const ShapeId ground = w.create_shape(grounds[0], {.geometry = plane()}).value(),
                  other = w.create_shape(grounds[1], {.geometry = plane()}).value();
    w.tick();
    const std::uint64_t hash = w.hash();
    const Transform here = Transform::identity();
    const Vec3 far{query_length_max * 2, 0_r, 0_r}, way{0_r, 1_r, 0_r};
    const Geometry whole = sphere(1_r), wrong[] = {plane(),
                                                   sphere(Real{}),
                                                   sphere(Real(-1)),
                                                   box(1_r, 1000_r, 1_r),
                                                   instance(ShapeKind::hull, AssetId{7}),
                                                   instance(ShapeKind::mesh, {}),
                                                   {none_of<ShapeKind>, {}, {}}};
    std::vector<QueryHit> hits(3);
    std::vector<ShapeId> shapes(3);
    CHECK_FALSE(w.cast_ray({{}, far}).has_value());
    CHECK_FALSE(w.cast_ray_any({{}, far}));
    w.cast_ray_all({{}, far}, {}, hits);
    CHECK(hits.empty());
    CHECK_FALSE(w.cast_shape(whole, here, far).has_value());
    for (const Geometry& odd : wrong) {
        CHECK_FALSE(w.cast_shape(odd, here, way).has_value());
        CHECK_FALSE(w.cast_shape_any(odd, here, way));
        hits.resize(3);
        w.cast_shape_all(odd, here, way, {}, hits);
        CHECK(hits.empty());
        shapes.resize(3);
        w.overlap(odd, here, {}, shapes);
        CHECK(shapes.empty());
        CHECK_FALSE(w.nearest(odd, here, 10_r).has_value());
    }
    CHECK_FALSE(w.nearest(whole, {{9_r, 0_r, 0_r}, Quat::identity()}, Real(-1)).has_value());
    CHECK(w.cast_ray({{}, way}, {.ignore = g.dead}).has_value()); // a destroyed body has no shapes to ignore
    CHECK_FALSE(w.cast_ray({{Real::max(), Real::min(), Real::max()}, way}).has_value());
    CHECK_FALSE(w.cast_ray_any({{}, {Real::max(), Real::min(), Real::max()}}));
    CHECK(w.nearest(whole, {{9_r, 0_r, 0_r}, Quat{}}, Real::max()).has_value());
    CHECK(w.distance(g.shape, ground).has_value());
    CHECK_FALSE(w.distance(ground, other).has_value());
    CHECK_FALSE(w.distance({g.shape.index, g.shape.generation + 1}, g.shape).has_value());
    CHECK_FALSE(w.distance(g.shape, ShapeId{}).has_value());
    CHECK_FALSE(w.distance(ShapeId{~0u, ~0u}, g.shape).has_value());

    const Ray rays[] = {{{}, way}, {{}, way}, {{}, way}};
    std::optional<QueryHit> answers[2];
    w.cast_rays(rays, {}, answers); // fills the shorter of the two
    CHECK(answers[1].has_value());
    w.cast_rays({}, {}, answers);
    w.cast_rays(rays, {}, {});
    CHECK(w.hash() == hash);
}

TEST_CASE("misuse: a world rejects unknown instruction sets and rows above limits and bad blasts and skips "
          "bad leftovers") {
    Given g;
    World& w = g.w;
    const std::uint64_t hash = w.hash();
    CHECK_FALSE(w.set_simd(none_of<Simd>));
    CHECK_FALSE(has_simd(none_of<Simd>));
    refused("reserve", w.reserve({.bodies = ~0u}), "bodies");
    CHECK(w.capacity().bodies < 8192);
    WorldDef wrong;
    wrong.tick_rate = 0;
    refused("memory_of", status_of(World::memory_of(wrong)), "tick_rate");
    refused("create", status_of(World::create(wrong)), "tick_rate");
    refused("gravity", w.set_gravity({Real(1001), 0_r, 0_r}), "gravity");
    refused("explode", w.explode({.radius = Real(-1), .impulse = 1_r}), "radius");
    refused("restore_portable", w.restore_portable({}), "");
    refused("restore_portable", w.restore_portable(std::vector<std::byte>(400, std::byte{1})), "");
    testing::disturb(w, none_of<testing::Leftover>, 1);
    w.set_tasks(nullptr), w.set_journal(nullptr), w.observe_phases(nullptr); // back to none
    w.record_phase_hashes(false);
    CHECK(w.phase_hashes().empty());
    CHECK(w.hash() == hash);

    GameSchema schema;
    (void)schema.add_record<Faults>("game.x");
    stops("a record of the same name", [&] { (void)schema.add_record<Faults>("game.x"); });
    stops("a column of the same name", [&] { (void)schema.add_body_column<Faults>("game.x"); });
    stops("an entry of the same name", [&] { (void)schema.add({"game.x", true, 4, {}}); });
}

TEST_CASE("misuse: a world rejects a level with a repeated key and does not change") {
    Given g;
    const std::uint64_t hash = g.w.hash();
    Level level;
    level.bodies = {{{.user_key = 7}, {}}, {{.user_key = 7}, {}}};
    refused("a key twice", status_of(assemble(g.w, level)), "7");
    refused("a key twice", status_of(assemble(g.w, std::span<const Assembly>(level.bodies))), "7");
    CHECK(g.w.hash() == hash);
}

TEST_CASE("misuse: a rejected geometry has zero mass and zero gyration and no triangles") {
    lockstone::Random random = lockstone::Random::seeded(11);
    const AssetLibrary none;
    int good = 0, bad = 0;
    for (int i = 0; i < 20000; ++i) {
        const Geometry g = any_geometry(random);
        const Real density = any_real(random);
        const MassProperties m = mass_properties(g, density);
        if (validate(g).empty() && density >= Real{}) {
            ++good;
            continue;
        }
        ++bad;
        CHECK(m.mass == Real{});
        CHECK(m.center == Vec3{});
        CHECK(m.gyration_squared.x.x == I20F44{});
        if (i % 16 == 0 && !validate(g).empty()) CHECK(triangulate(g, none, i - 10000).triangles.empty());
    }
    CHECK(good > 20);
    CHECK(bad > 10000);
    CHECK(mass_properties(box(1_r, 1_r, 1_r), 1_r).mass == 8_r); // negative control
    CHECK(triangulate(instance(ShapeKind::hull, AssetId{9}), none).triangles.empty());
    CHECK_FALSE(triangulate(sphere(1_r), none, -5).triangles.empty());
    CHECK(validate(scaled(sphere(60_r), 3_r)).find("scale") != std::string::npos);
    CHECK(validate(scaled(sphere(1_r), Real(-1))).find("scale") != std::string::npos);
    CHECK_FALSE(is_sized(sphere(Real(-1))));
    CHECK_FALSE(is_sized(plane()));
    CHECK(validate(rounded(box(1_r, 1_r, 1_r), Real(-1))).find("radius") != std::string::npos);
    CHECK(validate(capsule(1_r, 1000_r)) != "");
    CHECK(validate(cylinder(Real(-1), 1_r)) != "");
    CHECK(validate(cone(1_r, Real::max())) != "");
}

TEST_CASE("misuse: combined masses of arbitrary numbers have no negative mass and no negative radius") {
    lockstone::Random random = lockstone::Random::seeded(12);
    const auto any = [&] { return any_real(random); };
    const auto any_gyration = [&] { return I20F44::from_raw(any().raw); };
    for (int i = 0; i < 20000; ++i) {
        MassPart parts[2];
        for (MassPart& part : parts) {
            part.properties = MassProperties{any(), {any(), any(), any()}, {}};
            for (auto* column : {&part.properties.gyration_squared.x, &part.properties.gyration_squared.y,
                                 &part.properties.gyration_squared.z})
                *column = Vector3<I20F44>{any_gyration(), any_gyration(), any_gyration()};
            const Unit x = Unit::from_raw(static_cast<std::int32_t>(random.next_u32()));
            part.local =
                Transform{{any(), any(), any()}, normalized(Quat{x, {}, Unit::from_raw(7), unit_one})};
        }
        const MassProperties all = combine(parts);
        CHECK(all.mass >= Real{});
        const PrincipalGyration turned = principal_gyration(parts[0].properties);
        CHECK(turned.radii.x >= Real{});
        CHECK(turned.radii.y >= Real{});
        CHECK(turned.radii.z >= Real{});
    }
    CHECK(combine({}).mass == Real{});
}

TEST_CASE("misuse: ragdoll functions reject wrong arguments and ignore ragdolls without live bodies") {
    Given g;
    const std::uint64_t hash = g.w.hash();
    for (const Real height : {Real{}, Real(-1), Real(4), Real::max()})
        refused("height", status_of(make_ragdoll(g.w, {.height = height})), "height");
    for (const Real mass : {Real{}, Real(-1), Real(501)})
        refused("mass", status_of(make_ragdoll(g.w, {.mass = mass})), "mass");
    refused("stiffness", status_of(make_ragdoll(g.w, {.stiffness = Real(-1)})), "stiffness");
    refused("place", status_of(make_ragdoll(g.w, {.place = {{Real::max(), 0_r, 0_r}, Quat::identity()}})),
            "make_ragdoll: ");
    refused("friction", status_of(make_ragdoll(g.w, {.friction = Real(-1)})), "friction");
    stops("the parent of no part", [] { (void)ragdoll_parent(none_of<RagdollPart>); });
    CHECK(ragdoll_parent(RagdollPart::pelvis) == RagdollPart::pelvis);

    const Ragdoll nobody{};
    destroy_ragdoll(g.w, nobody); // the ragdoll has no live body
    CHECK(set_ragdoll_drive(g.w, nobody, ragdoll_t_pose(), {.frequency = Real(-1)}).ok());
    CHECK(ragdoll_pose(g.w, nobody) == ragdoll_standing());
    CHECK(g.w.hash() == hash);
    const Ragdoll doll = make_ragdoll(g.w, {}).value();
    refused("frequency", set_ragdoll_drive(g.w, doll, ragdoll_t_pose(), {.frequency = Real(-1)}),
            "frequency");
    refused("torque",
            set_ragdoll_drive(g.w, doll, ragdoll_t_pose(), {.frequency = 9_r, .torque_max = Real(-1)}),
            "spring_force");
    destroy_ragdoll(g.w, doll);
    destroy_ragdoll(g.w, doll); // a second time
    CHECK(g.w.body_count() == 1);
}

TEST_CASE("misuse: a world rejects vehicles without a live chassis and vehicles with no or too many wheels") {
    Given g;
    refused("chassis", status_of(g.w.create_vehicle(four_wheels({}, {0.8_r, 0_r, 1_r}))), "is not alive");
    CHECK(two_tracks(g.body, {0.8_r, 0_r, 1_r}, 0).wheel_count == 2); // clamped to 1 to 4 wheels a track
    CHECK(two_tracks(g.body, {0.8_r, 0_r, 1_r}, ~0u).wheel_count == 8);
    VehicleDef wheels = four_wheels(g.body, {0.8_r, 0_r, 1_r});
    for (const std::uint32_t count : {0u, 9u, ~0u}) {
        wheels.wheel_count = count;
        CHECK(validate(wheels).find("wheel_count") != std::string::npos);
        refused("wheels", status_of(g.w.create_vehicle(wheels)), "wheel_count");
    }
    CHECK(validate(VehicleInput{.throttle = 2_r}).find("throttle") != std::string::npos);
}

TEST_CASE("misuse: a pool of no or too many workers and a link to a missing machine and an unsaved slot end "
          "the program") {
    stops("no workers", [] { (void)make_worker_pool(0); });
    stops("too many", [] { (void)make_worker_pool(workers_max + 1); });
    SimulatedNetwork network(2, {}, 1);
    stops("set_link", [&] { network.set_link(0, 2, {}); });
    stops("unplug", [&] { network.unplug(2); });
    stops("send", [&] { network.endpoint(0).send(~0u, {}); });
    SimulatedNetwork empty(0, {}, 1);
    stops("endpoint", [&] { (void)empty.endpoint(0); });
    CHECK_FALSE(network.endpoint(0).receive().has_value());
    struct Still final : Provable {
        std::unique_ptr<Provable> make() const override { return std::make_unique<Still>(); }
        void step(std::uint64_t) override {}
        std::vector<std::byte> save() const override { return {}; }
        Status load(std::span<const std::byte>) override { return {}; }
        std::uint64_t hash() const override { return 1; }
    } still;
    stops("back", [&] { (void)still.back(3); });
    CHECK_FALSE(still.load_delta({}, {}).ok());
}

TEST_CASE("misuse: a proof of zero ticks and zero depth runs one tick and rolls back by one with the most "
          "workers allowed") {
    const SmallGame game;
    const Result<Proof> proof = prove(game, {.ticks = 0, .depth = 0, .workers = ~0u, .bits_max = 10});
    REQUIRE(proof.ok());
    CHECK(proof->holds());
    CHECK(proof->checks.front().compared > 0);
}

TEST_CASE("misuse: wrong arguments to verify and branch and record and diff give an error or end the program "
          "or do no harm") {
    const SmallGame game;
    const replay::Recording inputs = must(read(record_inputs(30))), commands = must(read(record_commands(8)));
    CHECK(replay::verify(inputs, nullptr).verdict == replay::Verdict::unusable);
    CHECK(replay::verify(inputs, &game, {.shard = 3, .shards = 3}).verdict == replay::Verdict::unusable);
    CHECK(replay::verify(inputs, &game, {.shard = 0, .shards = 0}).verdict == replay::Verdict::unusable);
    CHECK(replay::verify(inputs, &game, {.jobs = 0, .threads = 0}).good());
    stops("threads", [&] { (void)replay::verify(inputs, &game, {.threads = workers_max + 1}); });
    replay::MemorySink sink;
    refused("beyond the end", status_of(replay::branch_inputs(inputs, game, 31, sink)), "31");
    refused("of commands", status_of(replay::branch_inputs(commands, game, 1, sink)), "commands");
    refused("of inputs", status_of(replay::branch_commands(inputs, 1, sink)), "inputs");
    refused("far beyond", status_of(replay::branch_commands(commands, ~std::uint64_t{0}, sink)), "");
    refused("no game", replay::add_keyframes(inputs, nullptr, sink), "needs the game");
    for (const std::uint32_t block_ticks : {0u, replay::block_ticks_max + 1, ~0u}) {
        World world = must(game.start());
        refused("block",
                status_of(replay::InputRecorder::begin(sink, game, world, {.block_ticks = block_ticks})),
                "block_ticks");
        refused("block",
                status_of(replay::CommandRecorder::begin(sink, world, "x", {.block_ticks = block_ticks})),
                "block_ticks");
    }
    World world = must(game.start());
    refused("a key twice",
            status_of(replay::InputRecorder::begin(sink, game, world, {.options = {{"a", "1"}, {"a", "2"}}})),
            "a");
    CHECK(
        must(replay::diff({inputs, nullptr}, {inputs, nullptr})).states_agree); // compares the stored states
    stops("a hash of no time", [&] { (void)inputs.hash_at(31); });
    stops("a keyframe of no number", [&] { (void)inputs.keyframe_image(99); });
    stops("a block of no tick", [&] { (void)inputs.block_with(30); });
    stops("a cursor at no tick", [&] { (void)replay::BlockCursor(inputs).at(30); });
    refused("no path", status_of(replay::Recording::open("")), "");
    refused("no bytes", status_of(replay::Recording::from_bytes({}, "empty")), "empty");
    refused("no folder", status_of(replay::FileSink::create("/nowhere/at/all.lsr")), "/nowhere/at/all.lsr");
}

TEST_CASE("misuse: a recorder of another mode or world and a full sink and a time before the start fail") {
    const SmallGame game;
    const replay::Recording commands = must(read(record_commands(8)));
    replay::MemorySink sink;
    stops("inputs after commands", [&] {
        auto branch = must(replay::branch_commands(commands, 4, sink));
        const SmallInputs inputs(SmallGame::script(4));
        (void)replay::InputRecorder::resume(std::move(branch.writer), 0).on_tick(4, inputs.list, 1);
    });
    auto branch = must(replay::branch_commands(commands, 4, sink));
    World other = must(game.start());
    const auto recorder = replay::CommandRecorder::resume(std::move(branch.writer), other, 0);
    other.tick();
    refused("a world of another time", recorder->status(), "tick 4 comes next");
    refused("and closed", recorder->close(), "tick 4 comes next");

    struct Full final : replay::Sink {
        Status append(std::span<const std::byte>) override { return Error{"the sink is full"}; }
    } full;
    refused("a full sink", replay::repair(commands, full), "the sink is full");
    refused("a full sink", status_of(replay::branch_commands(commands, 4, full)), "the sink is full");
    CHECK_FALSE(replay::is_being_written("/nowhere/at/all.lsr"));

    World late = must(game.start());
    for (std::uint64_t t = 0; t < 3; ++t) must(game.advance(late, SmallInputs(SmallGame::script(t)).list));
    replay::MemorySink middle;
    auto begun = must(replay::InputRecorder::begin(middle, game, late));
    must(begun.close());
    const replay::Recording from_three = must(read(middle.bytes));
    stops("a time before the start", [&] { (void)from_three.keyframe_before(2); });
    stops("a hash from before the start", [&] { (void)from_three.hash_at(2); });
}

TEST_CASE("misuse: the name of an invalid enum value is the word unknown") {
    CHECK(std::string_view(name_of(none_of<Integrator>)) == "unknown");
    CHECK(std::string_view(name_of(none_of<Stall>)) == "unknown");
    CHECK(std::string_view(name_of(none_of<PacketFault>)) == "unknown");
    CHECK(std::string_view(name_of(none_of<ShapeKind>)) == "unknown");
    CHECK(std::string_view(name_of(none_of<JointKind>)) == "unknown");
    CHECK(std::string_view(name_of(none_of<RagdollPart>)) == "unknown");
    CHECK(name_of(none_of<Simd>) == "unknown");
    CHECK(name_of(none_of<Group>) == "unknown");
    CHECK(replay::name_of(none_of<replay::Mode>) == "unknown");
    CHECK(replay::name_of(none_of<replay::Verdict>) == "unknown");
}
