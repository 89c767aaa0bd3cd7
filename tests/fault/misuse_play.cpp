// Wrong arguments to sessions, recorders, players and asset libraries.
#include "fault/misuse.h"
#include "support/small_recording.h"

#include "lockstone/asset.h"
#include "lockstone/play/ragdoll.h"
#include "lockstone/session.h"
#include "lockstone/session/join.h"

#include <doctest/doctest.h>

#include <functional>

using namespace lockstone;
using namespace lockstone::test;

namespace {

struct NobodysInspector final : StateInspector {
    const State* state_after(std::uint64_t) override { return nullptr; }
    Rerun run_again(std::uint64_t, std::span<const PlayerInput>) override { return {}; }
};

} // namespace

TEST_CASE("misuse: wrong arguments of a session give an error or end the program") {
    SimulatedNetwork network(2, {}, 1);
    SessionDef def;
    def.input_size = 1;
    def.players = {0, 1};
    for (const std::uint64_t never : {std::uint64_t{0}}) {
        SessionDef hasty = def;
        hasty.disconnect_ms = never;
        refused("patience", status_of(make_rollback_session(hasty, network.endpoint(0))), "disconnect_ms");
        hasty.disconnect_ms = disconnect_ms_limit; // negative control
        CHECK(make_rollback_session(hasty, network.endpoint(0)));
        ++hasty.disconnect_ms;
        refused("endless patience", status_of(make_rollback_session(hasty, network.endpoint(0))),
                "at most 120000");
        hasty = def;
        hasty.connect_ms = never;
        refused("patience", status_of(make_lockstep_session(hasty, network.endpoint(0))), "connect_ms");
    }
    const auto late = make_join_session(def, {.lockstep = true}, network.endpoint(0)).value();
    stops("a delay before it plays", [&] { late->set_input_delay(33); });
    stops("no delay before it plays", [&] { late->set_input_delay(0); });
    for (const bool lockstep : {false, true}) {
        const auto session = (lockstep ? make_lockstep_session(def, network.endpoint(0))
                                       : make_rollback_session(def, network.endpoint(0)))
                                 .value();
        const std::array<std::byte, 2> input{};
        stops("another machine's player", [&] { session->add_local_input(1, std::span(input).first(1)); });
        stops("no player", [&] { session->add_local_input(~0u, std::span(input).first(1)); });
        stops("a long input", [&] { session->add_local_input(0, input); });
        stops("no input", [&] { session->add_local_input(0, {}); });
        stops("delay", [&] { session->set_input_delay(33); });
        stops("a tick that never ran", [&] { session->report_hash(0, 1); });
        stops("a tick far off", [&] { session->report_hash(~std::uint64_t{0}, 1); });
        refused("oneself", session->drop_peer(0), "machine 0");
        refused("nobody", session->drop_peer(~0u), "not a peer");
        CHECK_FALSE(session->quality(~0u).connected);
        CHECK(session->set_inspector(nullptr));
        session->drop_inspector(NobodysInspector()); // was never set
        CHECK(session->look_ahead(0).empty());       // run_ahead is 0
        CHECK(session->look_ahead(~0u).empty());
        session->poll(1000);
        session->poll(10); // time must not decrease
        CHECK(session->stats().last_poll_ms == 1000);
        CHECK(session->advance().stall == Stall::connecting);
        CHECK(session->current_tick() == 0);
    }
    const auto lockstep = make_lockstep_session(def, network.endpoint(0)).value();
    stops("no delay", [&] { lockstep->set_input_delay(0); });
    stops("an endpoint that is not there", [&] { (void)network.endpoint(2); });
    stops("time that goes back", [&] { network.advance_to(5), network.advance_to(4); });
    def.players = {0, 0};
    const auto sync = make_sync_test_session(def, 2).value();
    CHECK_FALSE(sync->set_inspector(nullptr));
    CHECK(log_text(DesyncReport{}) != "");
    refused("a sync test has no peers", sync->drop_peer(0), "no peers");
    stops("sync test, no player", [&] { sync->add_local_input(2, {}); });
}

TEST_CASE("misuse: ragdoll functions reject rotations that are zero quaternions") {
    World world = must(World::create({}));
    const auto zero = [](RagdollPart part) {
        RagdollPose pose = ragdoll_standing();
        pose[static_cast<std::size_t>(part)] = Quat{};
        return pose;
    };
    RagdollDef def;
    def.place.rotation = Quat{};
    refused("place", status_of(make_ragdoll(world, def)), "place.rotation is no rotation");
    def = {};
    def.pose = zero(RagdollPart::head);
    refused("pose", status_of(make_ragdoll(world, def)), "pose of head is no rotation");
    CHECK(world.body_count() == 0);
    const Ragdoll ragdoll = must(make_ragdoll(world, {}));
    const std::uint64_t before = world.hash();
    refused("drive", set_ragdoll_drive(world, ragdoll, zero(RagdollPart::foot_right), {.frequency = 5_r}),
            "pose of foot_right is no rotation");
    CHECK(world.hash() == before);
    CHECK(set_ragdoll_drive(world, ragdoll, zero(RagdollPart::pelvis), {.frequency = 5_r})
              .ok()); // that part is ignored
}

TEST_CASE("misuse: a desync report marks half a hash as a half and prints all its digits") {
    DesyncReport report;
    report.log.push_back({7, 0x04e3e231, 0x1, {}});
    CHECK(log_text(report).find("tick 7: lower half of the hash 04e3e231 against 00000001,") !=
          std::string::npos);
}

TEST_CASE("misuse: a tick run aside from a state that was never saved ends the program") {
    const SmallGame game;
    World world = must(game.start());
    WorldSimulation simulation(world, game);
    stops("nothing saved", [&] { (void)simulation.run_aside(Image{}, {}); });
}

TEST_CASE("misuse: a recorder returns errors that name the expected value for wrong arguments") {
    const SmallGame game;
    replay::MemorySink sink, spare;
    World world = must(game.start());
    auto recorder = must(replay::InputRecorder::begin(sink, game, world));
    const SmallInputs inputs(SmallGame::script(0));
    refused("a tick too far", recorder.on_tick(1, inputs.list, 1), "tick 0 comes next");
    refused("no tick yet", recorder.after_tick(world, inputs.list), "tick 0");
    must(game.advance(world, inputs.list));
    auto other = must(replay::InputRecorder::begin(spare, game, must(game.start())));
    refused("a keyframe of another time", other.keyframe(world), "the world stands at 1");
    refused("too few inputs", other.on_tick(0, {}, world.hash()), "");
    must(recorder.after_tick(world, inputs.list));
    refused("the same tick again", recorder.after_tick(world, inputs.list), "tick 1 comes next");
    World lighter = world.clone();
    must(lighter.set_gravity({}));
    refused("a keyframe of another world", recorder.keyframe(lighter), "the world's hash is");
    must(recorder.close());
    refused("a tick after the end", recorder.on_tick(1, inputs.list, 0), "");
    CHECK(must(read(sink.bytes)).tick_count() == 1); // and the recording is valid

    replay::MemorySink tape;
    const auto commands = must(replay::CommandRecorder::begin(tape, world, "small"));
    Image image;
    world.save(image);
    CHECK(commands->status().ok());
    world.restore(image);
    refused("restored while recorded", commands->status(), "the world was restored to tick 1");
    must(game.advance(world, inputs.list));
    refused("and closed", commands->close(), "restored");

    std::optional<World> gone = must(game.start());
    const auto widow = must(replay::CommandRecorder::begin(tape, *gone, "small"));
    World moved = std::move(*gone);
    stops("its world was moved", [&] { (void)widow->close(); });
    *gone = std::move(moved);
    stops("its world is destroyed", [&] {
        gone.reset();
        (void)widow->close();
    });
}

TEST_CASE("misuse: a player returns errors for wrong arguments and stays at its tick") {
    const SmallGame game;
    const replay::Recording recording = must(read(record_inputs(30)));
    refused("no game", status_of(replay::Player::open(recording, nullptr)), "needs the game");
    auto player = must(replay::Player::open(recording, game));
    REQUIRE(player.seek(7).ok());
    const std::uint64_t before = player.world().hash();
    refused("beyond the end", player.seek(31), "lies outside");
    refused("far beyond", player.seek(~std::uint64_t{0}), "lies outside");
    refused("no such keyframe", player.seek_keyframe(99), "no keyframe 99");
    CHECK(player.time() == 7);
    CHECK(player.world().hash() == before);
    REQUIRE(player.seek(30).ok());
    refused("a step beyond the end", player.step(), "ends at tick 30");
}

TEST_CASE("misuse: an asset library returns errors for wrong arguments and adds no asset") {
    AssetLibrary library;
    const AssetId nobody{0x1234};
    refused("no bytes", status_of(library.add(std::span<const std::byte>{})), "");
    refused("any bytes", status_of(library.add(AssetBytes(100, std::byte{7}))), "");
    const AssetBytes broken[] = {AssetBytes(100, std::byte{7}), AssetBytes{}};
    refused("a set of any bytes", status_of(library.add(encode_assets(broken))),
            "asset set: asset 0 of 2: asset:");
    refused("what did not bake", status_of(library.add(bake_hull({}))), "");
    refused("geometry of nobody", status_of(library.geometry(nobody)), "0x1234");
    refused("a copy of nobody", status_of(bake_scaled(library, nobody, {2_r, 2_r, 2_r})), "0x1234");
    refused("a file that is not there", status_of(load_assets("/no/such/file.lsa", library)),
            "/no/such/file.lsa: cannot read: ");
    refused("a folder", status_of(load_assets("/", library)), "/: is a directory, not an asset");
    refused("a file without a name", status_of(load_assets("", library)), ": cannot read: ");
    CHECK_FALSE(library.contains(nobody));
    CHECK(library.bytes(nobody).empty());
    CHECK(library.find(nobody) == nullptr);
    CHECK(library.ids().empty());
    refused("an empty mesh", status_of(bake_mesh({})), "");
    refused("an empty height field", status_of(bake_height_field({})), "");
    refused("an empty compound", status_of(bake_compound({})), "");
    const std::array<std::uint32_t, 3> far[] = {{0, 1, 9}};
    const Vec3 corners[] = {{}, {1_r, 0_r, 0_r}, {0_r, 0_r, 1_r}};
    refused("a corner that is not there", status_of(bake_mesh({.vertices = corners, .triangles = far})), "");
    const std::uint16_t materials[] = {1, 2};
    const std::array<std::uint32_t, 3> one[] = {{0, 1, 2}};
    refused("materials of others",
            status_of(bake_mesh({.vertices = corners, .triangles = one, .materials = materials})), "");
}
