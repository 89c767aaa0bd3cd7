// The bounds and trees that a tick caches beside the state are a function of the state: after any history of rollbacks
// and commands they equal those of a world without a history.
#include "base/hash.h"
#include "support/random.h"
#include "world/data.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

/// Hash of all data that update_bounds caches and a tick may read.
std::uint64_t derived_hash(sim::Data& w) {
    sim::PlacedShapes& s = w.placed;
    sim::update_bounds(w, s, nullptr);
    base::HashStream out;
    const auto add = [&](const auto&... numbers) { (out.add(static_cast<std::uint64_t>(numbers)), ...); };
    const auto add_bounds = [&](const collide::Bounds& b) {
        for (int i = 0; i < 3; ++i) add(b.lower[i].raw, b.upper[i].raw);
    };
    for (std::uint32_t slot = 0; slot < s.proxy_generation.size(); ++slot) {
        if (s.proxy_generation[slot] == 0 && !s.broad_phase.contains(slot)) continue;
        add(slot, s.proxy_generation[slot], s.broad_phase.contains(slot));
        if (s.broad_phase.contains(slot)) add_bounds(s.broad_phase.bounds(slot));
    }
    for (const sim::ShapeRow& shape : w.state.rows(w.m.shape)) {
        const sim::PlacedShapes::Shape& at = s.shape[shape.id.index - 1];
        add(at.margin.raw, at.reach.raw, at.rests);
        const sim::PlacedShapes::Filter& f = at.filter;
        add(f.generation, f.body, f.traits, f.category, f.mask, f.kind, f.is_plain);
        for (int i = 0; i < 3; ++i) add(at.pose.position[i].raw);
        for (const Unit u : {at.pose.rotation.x, at.pose.rotation.y, at.pose.rotation.z, at.pose.rotation.w})
            add(u.raw);
        add(at.solid.geometry == w.traits_of(shape).geometry);
        if (w.traits_of(shape).geometry.kind != ShapeKind::plane) add_bounds(at.bounds);
    }
    for (const std::uint32_t plane : s.planes) add(plane);
    // The results of the trees: the shapes in the world's range, and the pairs that may touch.
    std::vector<std::uint32_t> near;
    const Vector3<Bound> low{Bound::min(), Bound::min(), Bound::min()},
        high{Bound::max(), Bound::max(), Bound::max()};
    s.broad_phase.query(collide::Bounds{low, high}, near);
    for (const std::uint32_t slot : near) add(slot);
    std::vector<collide::ProxyPair> pairs;
    s.broad_phase.find_pairs(pairs);
    for (const collide::ProxyPair& pair : pairs) add(pair.a, pair.b);
    return out.digest();
}

std::uint64_t derived_anew(const sim::Data& w) {
    sim::Data fresh(w);
    return derived_hash(fresh);
}

/// A world without its public interface, and random operations on it.
struct Run {
    sim::Data w;
    test::scene::RandomPoint random;
    std::vector<Image> images;
    int restores = 0, planes = 0, sleepers = 0;

    explicit Run(std::uint64_t seed)
        : w(definition(), {}, std::make_shared<const AssetLibrary>()), random(seed), images(12) {
        add_body(BodyKind::static_, at(0, -1, 0), {.geometry = box(real(40), real(1), real(40))});
        for (int i = 0; i < 90; ++i) add_something();
        for (Image& image : images) w.state.save(image);
    }
    static WorldDef definition() {
        WorldDef def = drowsy_def();
        def.bodies_max = def.shapes_max = 400, def.contacts_max = 3000, def.joints_max = 60;
        def.sleep_time = real(0.1);
        return def;
    }
    bool chance(double p) { return random(0, 1) < p; }
    std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random(0, n)); }

    void add_body(BodyKind kind, const Transform& pose, const ShapeDef& shape) {
        const auto body = sim::apply(w, CreateBody{{.kind = kind, .pose = pose}});
        if (body) static_cast<void>(sim::apply(w, CreateShape{body->body, shape}));
    }
    void add_something() {
        const Transform pose = at(random(-35, 35), 0.5, random(-35, 35));
        if (chance(0.03)) return add_body(BodyKind::static_, at(0, random(-3, -1), 0), {.geometry = plane()});
        const double size = random(0.2, 0.5);
        const ShapeDef shape{.geometry =
                                 chance(0.3) ? sphere(real(size)) : box(real(size), real(0.5), real(size))};
        add_body(chance(0.2)   ? BodyKind::static_
                 : chance(0.1) ? BodyKind::kinematic
                               : BodyKind::dynamic,
                 pose, shape);
    }
    BodyId some_body() { return w.state.rows(w.m.body_info)[below(w.state.count(w.m.bodies))].id; }
    ShapeId some_shape() { return w.state.rows(w.m.shape)[below(w.state.count(w.m.shapes))].id; }
    void join_something() {
        JointDef def = ball_joint();
        def.body_a = some_body(), def.body_b = some_body();
        def.collide_connected = chance(0.2) ? 1 : 0;
        static_cast<void>(sim::apply(w, CreateJoint{def}));
    }
    void command() {
        if (chance(0.4)) add_something();
        if (chance(0.3)) join_something();
        if (chance(0.1))
            static_cast<void>(sim::apply(w, SetFilter{.shape = some_shape(), .mask = below(3) + 1}));
        if (const std::span<const sim::JointRow> joints = w.state.rows(w.m.joint);
            !joints.empty() && chance(0.1))
            static_cast<void>(
                sim::apply(w, DestroyJoint{joints[below(static_cast<std::uint32_t>(joints.size()))].id}));
        if (chance(0.3)) static_cast<void>(sim::apply(w, DestroyBody{some_body()}));
        if (chance(0.2))
            static_cast<void>(
                sim::apply(w, SetPose{some_body(), at(random(-35, 35), random(0.5, 2), random(-35, 35))}));
        if (chance(0.2)) static_cast<void>(sim::apply(w, WakeBody{some_body()}));
        if (chance(0.1))
            static_cast<void>(sim::apply(w, CreateShape{some_body(), {.geometry = sphere(real(0.7))}}));
        const std::span<const sim::ShapeRow> shapes = w.state.rows(w.m.shape);
        if (chance(0.1))
            static_cast<void>(
                sim::apply(w, DestroyShape{shapes[below(static_cast<std::uint32_t>(shapes.size()))].id}));
        if (chance(0.1))
            static_cast<void>(sim::apply(
                w, SetMass{some_body(), Real(3), vec(0, random(0, 0.2), 0), vec(1, 1, 1), Quat::identity()}));
    }
    void restore(const Image& image) {
        w.state.restore(image);
        sim::forget_derived(w);
        ++restores;
    }
    /// One tick with random operations before and after it. Calls `check` at each place where a game could run a query.
    template <class Check> void step(Check&& check) {
        for (std::uint32_t k = below(4); k > 0; --k) {
            command();
            if (chance(0.3)) check();
        }
        sim::tick(w);
        check();
        if (chance(0.3)) { // commands that a rollback removes before any tick
            w.state.save(images[0]);
            if (chance(0.7)) static_cast<void>(sim::apply(w, DestroyBody{some_body()}));
            for (std::uint32_t k = below(5); k > 0; --k) command();
            const std::uint32_t resting = w.header().bodies_awake;
            if (chance(0.5) && resting < w.state.count(w.m.bodies))
                static_cast<void>(sim::apply(w, WakeBody{w.state.rows(w.m.body_info)[resting].id}));
            if (chance(0.5)) check();
            restore(images[0]);
            check();
        }
        if (chance(0.4)) w.state.save(images[below(12)]);
        if (chance(0.3)) {
            restore(images[below(12)]);
            if (chance(0.5)) check();
        }
        if (chance(0.02)) { // a new state owns the versions
            State other(w.state.layout_shared());
            done(other.restore_portable(w.state.save_portable()));
            w.state = std::move(other);
            sim::forget_derived(w);
        }
        planes = std::max(planes, static_cast<int>(w.placed.planes.size()));
        sleepers = std::max(sleepers, static_cast<int>(w.state.count(w.m.bodies) - w.header().bodies_awake));
    }
};

} // namespace

TEST_CASE(
    "poses and bounds and trees depend only on the state after any restore and creation and destruction") {
    for (int seed = 1; seed <= samples(6, 60); ++seed) {
        INFO(seed);
        Run run(static_cast<std::uint64_t>(seed));
        int wrong = 0;
        for (int t = 0; t < samples(150, 600) && wrong == 0; ++t) {
            INFO(t);
            run.step([&] { wrong += derived_hash(run.w) != derived_anew(run.w) ? 1 : 0; });
            REQUIRE(wrong == 0);
        }
        CHECK(run.restores > 20);
        CHECK(run.planes > 0);
        CHECK(run.sleepers > 60);
    }
}

TEST_CASE("planted fault: the check finds changes that were taken but not processed") {
    int noticed = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
        Run run(seed);
        for (int t = 0; t < 30; ++t) run.step([] {});
        sim::update_bounds(run.w, run.w.placed, nullptr);
        run.restore(run.images[run.below(12)]);
        for (std::uint32_t c = 0; c < run.w.state.layout().columns().size(); ++c)
            run.w.state.take_changes(c, run.w.placed.proxies_of, run.w.placed.changed);
        noticed += derived_hash(run.w) != derived_anew(run.w) ? 1 : 0;
    }
    CHECK(noticed >= 3);
}

TEST_CASE("planted fault: the check finds a sleeper that moved without a recorded change") {
    Run run(4);
    for (int t = 0; t < 40; ++t) run.step([] {});
    REQUIRE(derived_hash(run.w) == derived_anew(run.w));
    const std::span<const Transform> poses = run.w.state.rows(run.w.m.body_pose);
    REQUIRE(run.w.header().bodies_awake < poses.size());
    const_cast<Transform&>(poses.back()).position.x += Real(1);
    sim::forget_derived(run.w);
    CHECK(derived_hash(run.w) != derived_anew(run.w));
}

TEST_CASE("a state lists each change of a column once and lists removed rows again after a restore") {
    StateLayout layout;
    const TableId table = layout.add_table("t", 5000);
    const Column<std::uint64_t> column = layout.add_column<std::uint64_t>(table, "t.number", Group::game);
    State state(std::move(layout).finished());
    state.resize(table, 1200); // pages of 512
    ChangeMark mark;
    std::vector<RowRange> changed;
    CHECK(state.take_changes(column.index, mark, changed) == 0);
    REQUIRE(changed.size() == 1);
    CHECK((changed[0].first == 0 && changed[0].end == 1200));
    CHECK(state.take_changes(column.index, mark, changed) == 1200);
    CHECK(changed.empty());
    state.edit_row(column, 600) = 7;
    Image image;
    state.save(image);
    state.take_changes(column.index, mark, changed);
    REQUIRE(changed.size() == 1);
    CHECK((changed[0].first == 512 && changed[0].end == 1024));
    for (const std::uint32_t rows : {500u, 0u}) {
        state.resize(table, rows);
        CHECK(state.take_changes(column.index, mark, changed) == 1200);
        state.restore(image);
        CHECK(state.take_changes(column.index, mark, changed) == rows);
        REQUIRE(changed.size() == 1);
        CHECK((changed[0].first == 0 && changed[0].end == 1200));
    }
    State other(state);
    state = State(other);
    CHECK(state.take_changes(column.index, mark, changed) == 1200);
    CHECK(changed.size() == 1);
}

TEST_CASE(
    "the cache of joined bodies matches the rows of joints after any restore and creation and destruction") {
    Run run(3);
    std::size_t found = 0;
    for (int t = 0; t < samples(100, 600); ++t) {
        INFO(t);
        run.step([] {});
        sim::JoinedBodies& joined = run.w.scratch.pair_scratch.joined;
        joined.find(run.w);
        int wrong = 0;
        const std::span<const sim::BodyInfo> bodies = run.w.state.rows(run.w.m.body_info);
        for (const sim::BodyInfo& a : bodies)
            for (const sim::BodyInfo& b : bodies) {
                const bool is = a.id != b.id && sim::are_joined(run.w, a.id, b.id);
                found += is ? 1 : 0;
                wrong += is != joined.contain(a.id.index - 1, b.id.index - 1) ? 1 : 0;
            }
        REQUIRE(wrong == 0);
    }
    CHECK(found > 100);
}
