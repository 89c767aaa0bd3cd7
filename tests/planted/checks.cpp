// The checks that planted faults have to be caught by, in one program that holds all faults and has one of them switched on.
//
//   planted_checks FAULT [CHECK]      FAULT: a number of faults.py's list, from 1; 0: none. CHECK: this one only
//   planted_checks --list
//
// Prints for each check its name as it begins, then "ok" or "FAILED" and where. Exit status 1 when one failed. A check
// that ends the program has caught something too.
#include "../matrix/host.h"
#include "collide/narrow_phase.h"
#include "lockstone/prove.h"
#include "planted.h"
#include "replay/replay.h"
#include "session/join/join_scenes.h"
#include "session/join/relayed_scenes.h"
#include "session/run_ahead.h"
#include "state/canonical.h"
#include "support/contact_points.h"
#include "support/sim_replay.h"
#include "support/task_worlds.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <random>
#include <sstream>

namespace planted {

int fault = 0;

std::uint64_t noise() {
    static std::random_device device;
    return device();
}
bool clock_is_odd() { return std::chrono::steady_clock::now().time_since_epoch().count() / 64 % 2 != 0; }
std::uint64_t address() {
    static std::vector<std::unique_ptr<char[]>> blocks;
    blocks.push_back(std::make_unique<char[]>(40));
    return reinterpret_cast<std::uintptr_t>(blocks.back().get()) / 16;
}
std::int32_t through_float(std::int32_t value) {
    volatile float wide = static_cast<float>(value) * 1.37f;
    return static_cast<std::int32_t>(std::lrint(wide / 1.37f));
}
std::uint32_t ticket(std::uint32_t count) {
    static std::uint32_t taken = 0, of = 0;
    if (of != count) of = count, taken = 0;
    return taken++ % count;
}

} // namespace planted

using namespace lockstone;
using namespace lockstone::test;

namespace {

/// The scripted pile of the tests: bodies come and go, commands of all kinds, game columns, events that are counted.
class ScriptGame final : public Game {
  public:
    std::string name() const override { return "script"; }
    std::uint64_t content_id() const override { return 1; }
    std::uint32_t player_count() const override { return 0; }
    std::uint32_t input_size() const override { return 0; }
    Result<World> start() const override {
        World world = scene::start_script(scene::Scenery::pile);
        for (int i = 0; i < 30; ++i) scene::step_script(world);
        return world;
    }
    Status advance(World& world, std::span<const PlayerInput>) const override {
        scene::step_script(world);
        return {};
    }
};

/// Balls that are pushed as far as they are apart: what is asked before a tick decides it. So seldom that a rollback meets the
/// tick at which it was asked last without asking before.
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

/// The first thing that is wrong; empty: nothing.
using Check = std::function<std::string()>;

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

/// Hashes of a game against the table.
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

/// Rows as a host of the other byte order has them: each leaf reversed. Both have to give one hash, and one image.
std::string byte_orders() {
    World world = scene::start_script(scene::Scenery::pile);
    for (int i = 0; i < 20; ++i) scene::step_script(world);
    constexpr std::size_t least = 20'000; // a column's bytes: some buffers full, which are of 4096
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

/// So many balls in one place that not all pairs are looked at, or even listed; later they part.
std::string crowds_agree() {
    WorldDef def = scene::small_def();
    def.bodies_max = def.shapes_max = 400;
    def.contacts_max = 100; // so 1,224 pairs are looked at, and 9,792 may be listed
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

/// A table that grows moves the pages of the one behind it; what was known of them goes along.
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
        Pair pair{State(std::make_shared<const StateLayout>(std::move(layout))), first, second, behind};
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

/// A world that takes memory as bodies come, and one that had it before; and back over what grew.
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
        for (int k = 0; k < 8; ++k) // in the end several pages of each column
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

std::string peers_agree() {
    for (std::uint64_t seed = 1; seed <= 3; ++seed) {
        MatchDef def;
        def.link = {.latency_ms = 90, .jitter_ms = 30, .loss_permille = 80};
        def.seed = seed;
        def.inspected_ticks =
            0; // images that are kept for reports would stand in for those that were not asked for
        Match match(def);
        match.run(500);
        if (!match.agree(0, 1) || match.machine(0).timeline.ticks.size() < 200)
            return "the peers' timelines part";
        for (PeerId id : {PeerId{0}, PeerId{1}}) {
            if (!match.notices<Desync>(id).empty()) return "a desync is told of";
            if (!match.machine(id).events.holds(match.machine(id).timeline.ticks.size()) ||
                match.machine(id).events.count(EventStatus::predicted) == 0)
                return "an event is told twice, or never to its end";
            Arena straight(2);
            if (run_straight(match.machine(id).timeline, 2, straight) !=
                match.machine(id).timeline.ticks.back().hash)
                return "the inputs, run straight, give another hash";
        }
    }
    return {};
}

std::string machines_come_back() {
    for (const HostileScene& scene : join_scenes())
        if (const std::string wrong = scene.run(); !wrong.empty())
            return std::string(scene.name) + ": " + wrong;
    return {};
}

std::string relays_serve() {
    for (const HostileScene& scene : relay_scenes())
        if (const std::string wrong = scene.run(); !wrong.empty())
            return std::string(scene.name) + ": " + wrong;
    return {};
}

std::string shows_ahead() {
    for (const HostileScene& scene : run_ahead_scenes())
        if (const std::string wrong = scene.run(); !wrong.empty())
            return std::string(scene.name) + ": " + wrong;
    return {};
}

std::string hostile_peers() {
    for (const HostileScene& scene : hostile_scenes())
        if (const std::string wrong = scene.run(); !wrong.empty())
            return std::string(scene.name) + ": " + wrong;
    return {};
}

using Bytes = std::vector<std::byte>;

Bytes record(bool commands) {
    const ScriptGame game;
    replay::MemorySink sink;
    World world = game.start().value();
    replay::RecorderOptions options;
    options.keyframe_ticks = 8, options.block_ticks = 8;
    if (commands) {
        const auto recorder = scene::made(replay::CommandRecorder::begin(sink, world, "script", options));
        for (int t = 0; t < 40; ++t) scene::done(game.advance(world, {}));
        scene::done(recorder->close());
        return sink.bytes;
    }
    auto recorder = scene::made(replay::InputRecorder::begin(sink, game, world, options));
    for (int t = 0; t < 40; ++t) {
        scene::done(game.advance(world, {}));
        scene::done(recorder.after_tick(world, {}));
    }
    scene::done(recorder.close());
    return sink.bytes;
}

std::string recordings_verify() {
    const ScriptGame game;
    for (const bool commands : {false, true}) {
        const auto recording = replay::Recording::from_bytes(record(commands), "script");
        if (!recording) return recording.error().message;
        replay::VerifyOptions options;
        options.from_keyframes = true;
        const replay::VerifyReport report = verify(*recording, commands ? nullptr : &game, options);
        if (!report.good() || report.keyframes_compared < 3)
            return report.sentence + ", keyframes " + std::to_string(report.keyframes_compared);
    }
    return {};
}

std::string damaged_recordings() {
    const Bytes bytes = record(true);
    for (std::size_t at = 100; at < bytes.size(); at += bytes.size() / 60) {
        Bytes damaged = bytes;
        damaged[at] ^= std::byte{4};
        const auto recording = replay::Recording::from_bytes(damaged, "script");
        if (recording.ok()) return "byte " + std::to_string(at) + " was taken";
        if (recording.error().message.find("checksum") == std::string::npos &&
            recording.error().message.find("damaged") == std::string::npos)
            return "byte " + std::to_string(at) + ": " + recording.error().message;
    }
    return {};
}

/// Records a run whose hashes are told wrongly from tick 20 on.
std::string wrong_hash_found() {
    const ScriptGame game;
    replay::MemorySink sink;
    World world = game.start().value();
    auto recorder = scene::made(replay::InputRecorder::begin(sink, game, world, {}));
    for (std::uint64_t t = 0; t < 40; ++t) {
        const std::uint64_t tick = world.tick_count();
        scene::done(game.advance(world, {}));
        scene::done(recorder.on_tick(tick, {}, world.hash() ^ (t == 20 ? 1u : 0u)));
    }
    scene::done(recorder.close());
    const auto recording = scene::made(replay::Recording::from_bytes(sink.bytes, "script"));
    return verify(recording, &game).verdict == replay::Verdict::diverged ? "" : "it verifies";
}

std::string late_points() {
    for (const scene::Scenery scenery : {scene::Scenery::stack, scene::Scenery::pile})
        if (std::string found = scene::late_points_difference(scenery, 400); !found.empty()) return found;
    return scene::points_of_sleepers_difference(400);
}

/// Two shapes that are alike share a row; what is said to one is not said to the other.
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

/// A ball in a box that reaches 1074 m along its diagonal, asked for with that diagonal as what parted them.
std::string hint_of_large_box() {
    const shapes::Solid ball{sphere(1_r)}, cliff{scaled(box(77.5_r, 77.5_r, 77.5_r), 8_r)};
    const Coordinate along = decimal<Coordinate>("57.735");
    const Unit third = decimal<Unit>("0.577350269");
    collide::NarrowScratch scratch;
    collide::Manifolds found;
    collide::collide(cliff, ball, {Rotation::identity(), {along, along, along}}, Length{},
                     {{third, third, third}, {}, 0}, scratch, found);
    return found.count == 1 ? "" : "a ball 100 m from its centre is outside";
}

std::string parts_are_found() {
    AssetLibrary library;
    std::vector<CompoundPart> balls(20, {sphere(0.1_r), Transform::identity()});
    for (std::size_t i = 0; i < balls.size(); ++i) balls[i].local.position.x = Real(static_cast<int>(i));
    const auto& row = *library.find(library.add(bake_compound(balls)).value());
    std::vector<std::uint32_t> found;
    row.compound->find(row.compound->extent, found);
    return found.size() == balls.size() ? "" : "a part of a compound is not found";
}

/// Two cubes that overlap by 1 cm along x and by 2 cm along y, and touched along y in the last tick.
std::string kept_face_is_nearest() {
    std::vector<LengthVec3> corners;
    for (int i = 0; i < 8; ++i) {
        const auto side = [&](int axis) {
            return decimal<Length>("0.5") * Length((i >> axis & 1) != 0 ? 1 : -1);
        };
        corners.push_back({side(0), side(1), side(2)});
    }
    AssetLibrary library;
    const AssetId id = library.add(bake_hull(corners)).value();
    const shapes::Solid cube{library.geometry(id).value(), library.find(id)->hull.get()};
    collide::NarrowScratch scratch;
    collide::Manifolds found;
    collide::collide(
        cube, cube,
        {Rotation::identity(), {decimal<Coordinate>("0.99"), decimal<Coordinate>("0.98"), Coordinate{}}},
        decimal<Length>("0.02"), {{}, {Unit{}, unit_one, Unit{}}, 0}, scratch, found);
    return found.count == 1 && found.items[0].normal.x == unit_one
               ? ""
               : "a face is kept though another is nearer";
}

std::vector<std::pair<std::string, Check>> all_checks() {
    std::vector<std::pair<std::string, Check>> list;
    for (const char* name : {"repeats", "rolls back", "saves everything", "moves", "forgets",
                             "reads no leftovers", "sends differences", "shuffles", "every bit counts"})
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
                             {"a hint does not part from large boxes", hint_of_large_box},
                             {"parts are found", parts_are_found},
                             {"a face that is kept is the nearest", kept_face_is_nearest},
                             {"grows", grows},
                             {"peers agree", peers_agree},
                             {"hostile peers", hostile_peers},
                             {"machines come back", machines_come_back},
                             {"relays serve", relays_serve},
                             {"shows ahead", shows_ahead},
                             {"recordings verify", recordings_verify},
                             {"damaged recordings are refused", damaged_recordings},
                             {"a wrong hash in a recording is found", wrong_hash_found}});
    return list;
}

} // namespace

int main(int argc, char** argv) {
    const std::vector<std::pair<std::string, Check>> checks = all_checks();
    if (argc == 2 && std::strcmp(argv[1], "--list") == 0) {
        for (const auto& [name, check] : checks) std::printf("%s\n", name.c_str());
        return 0;
    }
    if (argc < 2 || argc > 3) {
        std::fprintf(stderr, "planted_checks FAULT [CHECK]\n");
        return 2;
    }
    planted::fault = std::atoi(argv[1]);
    bool good = true;
    for (const auto& [name, check] : checks) {
        if (argc == 3 && name != argv[2]) continue;
        std::printf("%s\t", name.c_str());
        std::fflush(stdout);
        std::string wrong;
        try {
            wrong = check();
        } catch (const std::exception& e) { wrong = e.what(); }
        std::printf("%s\t%s\n", wrong.empty() ? "ok" : "FAILED", wrong.c_str());
        good = good && wrong.empty();
    }
    return good ? 0 : 1;
}
