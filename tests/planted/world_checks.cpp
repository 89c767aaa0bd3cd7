// Worlds: the properties of lockstone::prove, the golden table, states and their bytes, events, ids, changing joints,
// planes.
#include "../matrix/host.h"
#include "checks.h"
#include "lockstone/prove.h"
#include "state/canonical.h"
#include "support/contact_points.h"
#include "support/rigs/joint_chains.h"
#include "support/rigs/moving_state.h"
#include "support/task_worlds.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>

namespace planted {

namespace {

/// A game that pushes balls by forces in proportion to their distances, which it queries before a tick. It does so
/// rarely, so that a rollback may run the tick of the last query without an earlier one.
class AskingGame final : public Game {
  public:
    std::string name() const override { return "asking"; }
    std::uint64_t content_id() const override { return 2; }
    std::uint32_t player_count() const override { return 0; }
    std::uint32_t input_size() const override { return 0; }
    Result<World> start() const override {
        World world = scene::made(World::create(scene::small_def()));
        scene::add_floor(world);
        for (int i = 0; i < 5; ++i) scene::add_ball(world, scene::at(1.5 * i, 1 + i, 0));
        return world;
    }
    Status advance(World& world, std::span<const PlayerInput>) const override {
        if (world.tick_count() % 10 == 9) push(world);
        world.tick();
        return {};
    }

  private:
    static void push(World& world) {
        std::vector<BodyId> balls;
        for (const BodyId body : world.bodies())
            if (world.kind(body) == BodyKind::dynamic) balls.push_back(body);
        std::vector<Vec3> forces;
        for (std::size_t i = 0; i < balls.size(); ++i) {
            const BodyId other = balls[(i + 1) % balls.size()];
            const auto apart = world.distance(world.shapes(balls[i])[0], world.shapes(other)[0]);
            forces.push_back({apart ? apart->distance * 100 : Real{}, Real{}, Real{}});
        }
        for (std::size_t i = 0; i < balls.size(); ++i) scene::done(world.add_force(balls[i], forces[i]));
    }
};

std::vector<std::unique_ptr<Game>> games() {
    std::vector<std::unique_ptr<Game>> list;
    list.push_back(std::make_unique<ScriptGame>());
    list.push_back(std::make_unique<AskingGame>());
    for (const auto& [name, options] : std::initializer_list<std::pair<const char*, SceneOptions>>{
             {"rollback-arena", {}}, {"ragdolls", {.size = 1}}, {"cars", {}}, {"character", {}}})
        list.push_back(make_scene(name, options).value());
    return list;
}

/// One check of lockstone::prove, on each game.
Check proof_check(const std::string& name) {
    return [name]() -> std::string {
        for (const auto& game : games()) {
            ProofOptions options;
            options.ticks = 24;
            options.bits_max = name == "every bit counts" ? 40000 : 0;
            const Proof proof = prove(*game, options).value();
            for (const ProofCheck& check : proof.checks)
                if (check.name == name && !check.passed) return game->name() + ": " + check.sentence;
        }
        return {};
    };
}

/// Compares hashes of a game with the table.
std::string golden_rows(const std::string& name) {
    std::map<std::uint64_t, std::string> wanted;
    std::ifstream file(LOCKSTONE_SOURCE_DIR "/tests/golden/hashes.tsv");
    for (std::string line; std::getline(file, line);) {
        std::istringstream fields(line);
        std::string game, tick, hash;
        if (std::getline(fields, game, '\t') && game == name && std::getline(fields, tick, '\t') &&
            std::getline(fields, hash))
            wanted[std::stoull(tick)] = hash;
    }
    if (wanted.size() < 3) return "the table has no rows of " + name;
    const auto game = make_scene_named(name).value();
    ScriptedInputs inputs(*game);
    World world = game->start().value();
    for (std::uint64_t tick = 0; tick <= std::min<std::uint64_t>(wanted.rbegin()->first, 120); ++tick) {
        char hash[17];
        std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(world.hash()));
        if (wanted.contains(tick) && wanted[tick] != hash)
            return name + ", tick " + std::to_string(tick) + ": " + hash;
        scene::done(game->advance(world, inputs.at(tick)));
    }
    return {};
}

/// A game; boxes of equal mass; hulls of many kinds that fall on each other; joints; vehicles.
std::string golden_table() {
    for (const char* name : {"rollback-arena size=0 seed=1 players=2", "pyramid size=12 seed=1 players=0",
                             "convex-pile size=60 seed=1 players=0", "ragdolls size=4 seed=1 players=0",
                             "joint-grid size=0 seed=1 players=0", "cars size=0 seed=1 players=1"})
        if (std::string found = golden_rows(name); !found.empty()) return found;
    return {};
}

std::string rounding_modes() {
    World usual = scene::start_script(scene::Scenery::pile), odd = scene::start_script(scene::Scenery::pile);
    for (std::uint64_t t = 0; t < 60; ++t) {
        scene::step_script(usual);
        {
            const host::FloatingPoint mode(true, t);
            scene::step_script(odd);
        }
        if (usual.hash() != odd.hash()) return scene::difference(usual, odd);
    }
    return {};
}

std::string damaged_snapshots() {
    World world = scene::start_script(scene::Scenery::stack);
    const std::vector<std::byte> image = world.save_portable();
    std::vector<std::byte> cut(image.begin(), image.end() - 8), longer = image;
    longer.push_back({});
    if (world.restore_portable(longer).ok()) return "a byte too many was taken";
    if (world.restore_portable(cut).ok()) return "eight bytes too few were taken";
    const std::string sentence = world.restore_portable(longer).error().message;
    if (sentence.find("bytes long") == std::string::npos) return "a byte too many is told of as: " + sentence;
    for (std::size_t at = image.size() / 3; at < image.size() - 8; at += image.size() / 50) {
        std::vector<std::byte> damaged = image;
        damaged[at] ^= std::byte{1};
        const Status status = world.restore_portable(damaged);
        if (status.ok() || status.error().message.find("checksum") == std::string::npos)
            return "byte " + std::to_string(at) +
                   (status.ok() ? " was taken" : ": " + status.error().message);
    }
    return {};
}

/// Rows with the leaves' bytes reversed, as on a host of the other byte order. Both must give one hash and one image.
std::string byte_orders() {
    World world = scene::start_script(scene::Scenery::pile);
    for (int i = 0; i < 20; ++i) scene::step_script(world);
    constexpr std::size_t least = 20'000; // bytes of a column: several full buffers of 4096
    constexpr std::endian other =
        std::endian::native == std::endian::little ? std::endian::big : std::endian::little;
    for (std::uint32_t c = 0; c < world.state().layout().columns().size(); ++c) {
        const ColumnInfo& column = world.state().layout().columns()[c];
        const std::span<const std::byte> rows = world.state().bytes(c);
        if (rows.empty()) continue;
        std::vector<std::byte> foreign(rows.begin(), rows.end());
        while (foreign.size() < least) foreign.insert(foreign.end(), rows.begin(), rows.end());
        const std::vector<std::byte> own = foreign;
        for (std::size_t row = 0; row < foreign.size(); row += column.row_size)
            for (const LeafInfo& leaf : column.leaves)
                std::reverse(foreign.begin() + static_cast<std::ptrdiff_t>(row + leaf.offset),
                             foreign.begin() + static_cast<std::ptrdiff_t>(row + leaf.offset + leaf.size));
        if (hash_canonical(std::endian::native, column.leaves, own) !=
            hash_canonical(other, column.leaves, foreign))
            return "hashes of " + column.name;
        std::vector<std::byte> canonical(own.size());
        copy_canonical(other, column.leaves, foreign, canonical);
        if (!std::ranges::equal(canonical, own) && std::endian::native == std::endian::little)
            return "bytes of " + column.name;
    }
    return {};
}

std::string events_in_order() {
    World world = scene::start_script(scene::Scenery::pile);
    std::map<std::pair<std::uint64_t, std::uint64_t>, bool> touching;
    const auto raw = [](ShapeId id) { return std::uint64_t{id.index} << 32 | id.generation; };
    for (int t = 0; t < 150; ++t) {
        scene::step_script(world);
        const Event* last = nullptr;
        for (const Event& e : world.events()) {
            const auto key = [](const Event& x) {
                return std::tie(x.kind, x.shape_a, x.shape_b, x.joint, x.body_a);
            };
            if (last != nullptr && !(key(*last) < key(e)))
                return "tick " + std::to_string(t) + ": events out of order";
            last = &e;
            if (e.kind != EventKind::contact_begin && e.kind != EventKind::contact_end) continue;
            bool& touches = touching[{raw(e.shape_a), raw(e.shape_b)}];
            const bool begins = e.kind == EventKind::contact_begin;
            if (touches == begins) return "tick " + std::to_string(t) + ": a contact began or ended twice";
            touches = begins;
        }
    }
    return {};
}

std::string dead_ids() {
    World world = scene::made(World::create(scene::small_def()));
    const BodyId first = scene::add_ball(world, scene::at(0, 1, 0));
    scene::done(world.destroy(first));
    const BodyId second = scene::add_ball(world, scene::at(0, 1, 0));
    if (world.is_alive(first)) return "an id that was destroyed is alive again";
    return world.is_alive(second) ? "" : "a new id is dead";
}

/// So many balls in one place that the broad phase skips or even does not list some pairs. Later the balls part.
std::string crowds_agree() {
    WorldDef def = scene::small_def();
    def.bodies_max = def.shapes_max = 400;
    def.contacts_max = 100; // so it visits 1,224 pairs, and may list 9,792
    World world = scene::made(World::create(def)), other = scene::made(World::create(def));
    scene::add_floor(world);
    Image image;
    for (int t = 0; t < 60; ++t) {
        for (int i = 0; i < (t == 0 ? 100 : t == 3 ? 70 : 0); ++i)
            scene::add_ball(world, scene::at(i % 7 * 0.01, 0.5 + i % 11 * 0.01, i % 13 * 0.01));
        if (t % 6 == 0 || t == 3) {
            world.save(image);
            other = scene::made(World::create(def));
            other.restore(image);
        }
        world.tick(), other.tick();
        if (world.hash() != other.hash()) return "tick " + std::to_string(t) + ": a restored crowd parts";
    }
    return world.faults().contacts_dropped > 0 ? "" : "nothing was dropped";
}

/// Many bodies come to rest in one tick: static ones among dynamic ones that fall, each at its own place.
std::string rest_together() {
    WorldDef def = scene::small_def();
    def.bodies_max = def.shapes_max = 400;
    World world = scene::made(World::create(def));
    std::vector<BodyId> still;
    for (int i = 0; i < 150; ++i) {
        scene::add_ball(world, scene::at(i, 50, 0));
        const BodyKind kind = i % 5 == 0 ? BodyKind::kinematic : BodyKind::static_;
        still.push_back(scene::made(world.create_body({.kind = kind, .pose = scene::at(i, 0, 0)})));
    }
    world.tick();
    for (int i = 0; i < 150; ++i)
        if (world.pose(still[static_cast<std::size_t>(i)]).position != scene::at(i, 0, 0).position)
            return "body " + std::to_string(i) + " has left its place";
    return {};
}

/// A table that grows moves the pages of the next table, and the cached data about these pages.
std::string pages_move() {
    constexpr std::uint32_t most = 4096;
    struct Pair {
        State state;
        TableId first, second;
        Column<Transform> behind;
    };
    const auto start = [](std::uint32_t capacity) {
        StateLayout layout;
        const TableId first = layout.add_table("first", capacity, most),
                      second = layout.add_table("second", most, most);
        layout.add_column<Transform>(first, "first.row", Group::motion);
        const Column<Transform> behind = layout.add_column<Transform>(second, "second.row", Group::game);
        Pair pair{State(std::move(layout).finished()), first, second, behind};
        pair.state.resize(second, most);
        for (std::uint32_t row = 0; row < most; ++row)
            pair.state.edit_row(behind, row).position.x = Real(static_cast<int>(row));
        return pair;
    };
    Pair grows = start(0), has_all = start(most);
    for (Pair* pair : {&grows, &has_all}) {
        pair->state.hash();
        pair->state.resize(pair->first, most);
        pair->state.edit_row(pair->behind, most / 2).position.y = Real(1);
    }
    return grows.state.hash() == has_all.state.hash() ? "" : "a table that grew has another hash";
}

/// A world whose memory grows with its bodies, and one that reserved it; then both roll back past the growth.
std::string grows() {
    if (std::string found = pages_move(); !found.empty()) return found;
    const auto start = [] {
        WorldDef def = scene::drowsy_def();
        def.bodies_max = def.shapes_max = 512, def.contacts_max = 4096;
        World world = scene::made(World::create(def));
        scene::add_floor(world);
        return world;
    };
    const auto step = [](World& world) {
        const int i = static_cast<int>(world.tick_count());
        for (int k = 0; k < 8; ++k) // several pages of each column at the end
            scene::add_crate(world, scene::at(1.1 * k - 4, 0.5 + i / 4, 1.2 * (i % 4)));
        world.tick();
    };
    World has_all = start(), grows = start();
    scene::done(has_all.reserve({.bodies = 512, .shapes = 512, .contacts = 4096}));
    std::vector<Image> images(30);
    std::vector<std::uint64_t> hashes;
    for (Image& image : images) {
        grows.save(image);
        hashes.push_back(grows.hash());
        step(has_all), step(grows);
        if (has_all.hash() != grows.hash()) return scene::difference(has_all, grows);
    }
    for (std::size_t back = images.size(); back-- > 0;) {
        grows.restore(images[back]);
        if (grows.hash() != hashes[back])
            return "an image of " + std::to_string(back) + " gives another hash";
        step(grows);
        if (back + 1 < hashes.size() && grows.hash() != hashes[back + 1])
            return "from the image of " + std::to_string(back) + " it goes another way";
    }
    return {};
}

std::string late_points() {
    for (const scene::Scenery scenery : {scene::Scenery::stack, scene::Scenery::pile})
        if (std::string found = scene::late_points_difference(scenery, 400); !found.empty()) return found;
    return scene::points_of_sleepers_difference(400);
}

/// Two equal shapes share a row of traits. A change of one must not change the other.
std::string alike_shapes() {
    World world = World::create({}).value();
    const BodyId body = world.create_body({.kind = BodyKind::static_}).value();
    const ShapeId one = world.create_shape(body, {.geometry = sphere(1_r)}).value(),
                  other = world.create_shape(body, {.geometry = sphere(1_r)}).value();
    const Real before = world.shape(other).friction;
    world.set_material({one, 0.125_r}).value();
    if (world.shape(other).friction != before) return "a shape has another one's friction";
    return world.shape(one).friction == 0.125_r ? "" : "a shape has not the friction that it was given";
}

/// Joints and bodies of a world change. A copy whose memory is overwritten before every tick must have equal states.
std::string joints_planned() {
    const ChainRun run = run_chains(100);
    return run.parted_at < 0 ? "" : "they part at tick " + std::to_string(run.parted_at);
}

/// Two overlapping balls have contacts, except while a joint connects them.
std::string joints_part() {
    World world = scene::made(World::create(scene::small_def()));
    JointDef def = ball_joint();
    def.body_a = scene::add_ball(world, scene::at(0, 5, 0), 0.5);
    def.body_b = scene::add_ball(world, scene::at(0.9, 5, 0), 0.5);
    world.tick();
    if (world.contacts().empty()) return "they do not touch";
    const JointId joint = scene::made(world.create_joint(def));
    world.tick();
    if (!world.contacts().empty()) return "they touch in spite of a joint";
    scene::done(world.destroy(joint));
    world.tick();
    return world.contacts().empty() ? "they do not touch after the joint is gone" : "";
}

/// Two overlapping balls have contacts, except while a filter separates them.
std::string filters_part() {
    World world = scene::made(World::create(scene::small_def()));
    const BodyId a = scene::add_ball(world, scene::at(0, 5, 0), 0.5),
                 b = scene::add_ball(world, scene::at(0.9, 5, 0), 0.5);
    const ShapeId shape = world.shapes(b)[0];
    const auto touch = [&] {
        world.tick();
        return !world.contacts().empty();
    };
    if (!touch()) return "they do not touch";
    scene::done(world.set_filter({shape, 1, 0, 0}));
    if (touch()) return "they touch in spite of a mask";
    scene::done(world.set_filter({shape, 1, ~0u, 0}));
    if (!touch()) return "they do not touch after the mask is gone";
    scene::done(world.set_pair_filter(a, b, false));
    if (touch()) return "they touch in spite of a filter of the two";
    scene::done(world.set_pair_filter(a, b, true));
    return touch() ? "" : "they do not touch after the filter of the two is gone";
}

Vec3 end_of(const World& w, BodyId body, Vec3 at) {
    const Transform pose = w.pose(body);
    return pose.position + rotate(pose.rotation, at);
}

/// Four bodies in a ring of ball joints, a metre apart.
struct Ring {
    World& world;
    std::vector<BodyId> bodies;
    std::vector<JointDef> joints;

    Ring(World& w, Vec3 corner, const ShapeDef& shape) : world(w) {
        for (int i = 0; i < 4; ++i) {
            const Vec3 place = corner + Vec3{Real(i % 2), Real(i / 2), 0_r};
            bodies.push_back(
                scene::made(w.create_body({.kind = BodyKind::dynamic, .pose = {place, Quat::identity()}})));
            scene::made(w.create_shape(bodies.back(), shape));
        }
        for (const auto& [a, b] : {std::pair{0, 1}, {2, 3}, {0, 2}, {1, 3}}) {
            JointDef def = ball_joint();
            def.body_a = bodies[static_cast<std::size_t>(a)],
            def.body_b = bodies[static_cast<std::size_t>(b)];
            def.frame_a.position = a + 1 == b ? Vec3{0.5_r, 0_r, 0_r} : Vec3{0_r, 0.5_r, 0_r};
            def.frame_b.position = -def.frame_a.position;
            scene::made(w.create_joint(def));
            joints.push_back(def);
        }
    }
    void hit(Real speed) const { scene::done(world.set_velocity(bodies[3], {speed, speed, 0_r}, Vec3{})); }
    /// The widest gap along an axis.
    Real widest() const {
        Real out{};
        for (const JointDef& def : joints) {
            const Vec3 gap = abs(end_of(world, def.body_a, def.frame_a.position) -
                                 end_of(world, def.body_b, def.frame_b.position));
            out = max(out, max(gap.x, max(gap.y, gap.z)));
        }
        return out;
    }
};

/// Long boxes in a ring turn about its middle by more than 1 / 16 rad in a tick: the ring keeps together and keeps its
/// spin. A joint deflects by 1 mm under the 102 m/s^2 of a box, by twice that as the ring starts to turn, and the
/// slanted boxes may twist by as much again.
std::string rings_spin() {
    World w = scene::made(World::create({.gravity = {}, .sleeping = 0}));
    constexpr Real spin = 12_r;
    const Quat tilted = normalized(
        Quat{Unit::from_raw(unit_one.raw / 4), Unit{}, Unit::from_raw(unit_one.raw / 4), unit_one});
    const Ring ring(w, Vec3{}, {.geometry = box({0.4_r, 0.05_r, 0.1_r}), .local = {Vec3{}, tilted}});
    const Vec3 middle{0.5_r, 0.5_r, 0_r}, axis{0_r, 0_r, spin};
    for (const BodyId body : ring.bodies)
        scene::done(w.set_velocity(body, cross(axis, w.pose(body).position - middle), axis));
    Real widest{};
    for (int tick = 0; tick < 60; ++tick) {
        w.tick();
        widest = max(widest, ring.widest());
    }
    if (widest > 0.004_r) return "the ring comes apart";
    return abs(w.angular_velocity(ring.bodies[0]).z - spin) > 0.25_r ? "the ring spins at another speed" : "";
}

/// One ball of a ring is hit: after the tick the ring is closed and keeps its momentum.
std::string open_points_close() {
    World w = scene::made(World::create({.gravity = {}, .sleeping = 0}));
    const Ring ring(w, Vec3{}, {.geometry = sphere(0.3_r)});
    ring.hit(10_r);
    w.tick();
    if (ring.widest() > 0.008_r) return "points stay open";
    Vec3 sum{};
    for (const BodyId ball : ring.bodies) sum += w.linear_velocity(ball);
    return length(sum - Vec3{10_r, 10_r, 0_r}) > 0.1_r ? "the ring has another speed" : "";
}

/// A ring that is hit and closed does not move another ring, which is open by less.
std::string whole_figures_stay() {
    std::vector<Transform> poses[2];
    for (const bool is_hit : {false, true}) {
        World w = scene::made(World::create({.gravity = {}, .sleeping = 0}));
        const Ring quiet(w, Vec3{}, {.geometry = sphere(0.3_r)}),
            other(w, {100_r, 0_r, 0_r}, {.geometry = sphere(0.3_r)});
        quiet.hit(1_r);
        if (is_hit) other.hit(10_r);
        w.tick();
        for (const BodyId ball : quiet.bodies) poses[is_hit].push_back(w.pose(ball));
    }
    return poses[0] == poses[1] ? "" : "another figure moves";
}

/// A net of 4 x 60 balls hangs from the ends of its top row. Its weight keeps that row open by more than 8 mm, and the
/// net comes to rest.
std::string loads_keep_open() {
    constexpr int width = 4, height = 60;
    World w = scene::made(World::create({.sleeping = 0}));
    std::vector<BodyId> balls;
    const auto join = [&](int a, int b, Vec3 half) {
        JointDef def = ball_joint();
        def.body_a = balls[static_cast<std::size_t>(a)], def.body_b = balls[static_cast<std::size_t>(b)];
        def.frame_a.position = half, def.frame_b.position = -half;
        scene::made(w.create_joint(def));
    };
    for (int i = 0; i < width * height; ++i) {
        const BodyDef ball{.kind = i == 0 || i == width - 1 ? BodyKind::static_ : BodyKind::dynamic,
                           .pose = {{Real(i % width), Real(-(i / width)), 0_r}, Quat::identity()},
                           .linear_damping = 1_r,
                           .angular_damping = 1_r};
        balls.push_back(scene::made(w.create_body(ball)));
        scene::made(w.create_shape(balls.back(), {.geometry = sphere(0.4_r)}));
        if (i % width != 0) join(i - 1, i, {0.5_r, 0_r, 0_r});
        if (i >= width) join(i - width, i, {0_r, -0.5_r, 0_r});
    }
    for (int tick = 0; tick < 600; ++tick) w.tick();
    for (const BodyId ball : balls)
        if (length(w.linear_velocity(ball)) > 0.01_r) return "the net does not come to rest";
    return {};
}

/// A rod of twice `half`, hinged to the world about x at its middle or `lever` below it.
World hinged_rod(Quat frame, Vec3 spin, Real limit, Vec3 gravity = {}, Real lever = {}, Real half = 0.5_r) {
    World w = scene::made(World::create({.gravity = gravity, .sleeping = 0}));
    const BodyId rod = scene::made(w.create_body({.kind = BodyKind::dynamic}));
    scene::made(w.create_shape(
        rod, {.geometry = box({0.1_r, half, 0.1_r}), .local = {{Real{}, lever, Real{}}, Quat::identity()}}));
    scene::done(w.set_velocity(rod, Vec3{}, spin));
    JointDef hinge = hinge_joint();
    hinge.body_b = rod;
    hinge.frame_a.rotation = frame;
    hinge.axis[about_x].mode = AxisMode::limited;
    hinge.axis[about_x].lower = -limit, hinge.axis[about_x].upper = limit;
    scene::made(w.create_joint(hinge));
    return w;
}

/// Returns whether the rod ever passes its limit of a radian by more than `beyond`.
bool passes_limit(World world, int ticks, Real beyond = 0.02_r) {
    for (int tick = 0; tick < ticks; ++tick) {
        world.tick();
        const Quat q = world.pose(world.bodies()[0]).rotation;
        if (abs(atan2(to<Real>(q.x), to<Real>(q.w)) * 2) > 1_r + beyond) return true;
    }
    return false;
}

constexpr Vec3 sideways{Real{}, Real{}, -10_r}; ///< gravity across rods

/// A crate on a ball joint beyond a small weight, which falls onto the limits of its hinge a metre away. Returns the
/// crate's greatest speed.
Real speed_of_flail() {
    World w = hinged_rod(Quat::identity(), Vec3{}, 1_r, sideways, 1_r, 0.1_r);
    const BodyId rod = w.bodies()[0], crate = scene::add(w, {.pose = scene::at(0, 1.3, 0)},
                                                         {.geometry = box({0.1_r, 0.1_r, 0.1_r})});
    JointDef joint = ball_joint();
    joint.body_a = rod, joint.body_b = crate, joint.frame_a.position = scene::vec(0, 1.3, 0);
    scene::made(w.create_joint(joint));
    Real most{};
    for (int tick = 0; tick < 120; ++tick) w.tick(), most = max(most, length(w.linear_velocity(crate)));
    return most;
}

/// A hinge with a spin of 20 rad/s stops at its limits, and so do falling weights, without a gain of speed. A hinge
/// whose axes begin 170 degrees apart aligns them.
std::string hinges_hold() {
    if (passes_limit(hinged_rod(Quat::identity(), {20_r, 0_r, 0_r}, 1_r), 60))
        return "a hinge passes its limit";
    if (passes_limit(hinged_rod(Quat::identity(), Vec3{}, 1_r, sideways, 1_r), 120))
        return "a hinge that falls passes its limit";
    if (passes_limit(hinged_rod(Quat::identity(), Vec3{}, 1_r, sideways, 1_r, 0.1_r), 120, 0.1_r))
        return "a small weight on a long arm passes its limit";
    if (speed_of_flail() > 6_r) return "a flail gains speed at its limit";
    const Quat frame = from_axis_angle(UnitVec3{Unit{}, unit_one, Unit{}}, pi * Real(17) / Real(18));
    World turned = hinged_rod(frame, Vec3{}, 3_r);
    for (int tick = 0; tick < 240; ++tick) turned.tick();
    const Vec3 x{1_r, 0_r, 0_r};
    const Real along = dot(rotate(frame, x), rotate(turned.pose(turned.bodies()[0]).rotation, x));
    return along > 0.99_r ? "" : "a hinge stays turned over";
}

/// A crate that may not turn is stopped by a hit off its centre.
std::string locked_crates_stop() {
    WorldDef def = scene::small_def();
    def.gravity = {};
    World world = scene::made(World::create(def));
    scene::add_wall(world, scene::at(0.9, -1, 0), {0.5_r, 1_r, 1_r});
    BodyDef crate_def{.locks = lock_angular_x | lock_angular_y | lock_angular_z};
    crate_def.pose = scene::at(0, 0.5, 0), crate_def.linear_velocity = scene::vec(0, -3, 0);
    const BodyId crate = scene::add(world, crate_def, {.geometry = box(0.5_r, 0.5_r, 0.5_r)});
    world.tick();
    return abs(world.linear_velocity(crate).y) < 0.05_r ? "" : "a crate goes on";
}

} // namespace

Checks world_checks() {
    Checks list;
    for (const char* name :
         {"repeats", "rolls back", "saves everything", "moves", "forgets", "reads no leftovers",
          "sends differences", "shuffles", "every mode agrees", "every bit counts"})
        list.emplace_back(name, proof_check(name));
    list.insert(list.end(), {{"golden table", golden_table},
                             {"rounding modes", rounding_modes},
                             {"damaged snapshots are refused", damaged_snapshots},
                             {"both byte orders agree", byte_orders},
                             {"events come in order and in turn", events_in_order},
                             {"contact points can be asked for late", late_points},
                             {"dead ids stay dead", dead_ids},
                             {"crowds agree", crowds_agree},
                             {"what is alike stays apart", alike_shapes},
                             {"bodies rest together", rest_together},
                             {"joints that change are planned anew", joints_planned},
                             {"joints keep bodies apart", joints_part},
                             {"filters are followed", filters_part},
                             {"open points are closed", open_points_close},
                             {"whole figures stay", whole_figures_stay},
                             {"loads come to rest", loads_keep_open},
                             {"rings keep together", rings_spin},
                             {"hinges hold", hinges_hold},
                             {"locked crates stop", locked_crates_stop},
                             {"a state may move", [] { return lockstone::test::moving_state_differs(60); }},
                             {"grows", grows}});
    return list;
}

} // namespace planted
