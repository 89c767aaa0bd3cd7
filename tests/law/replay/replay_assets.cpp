// A recording of commands contains its assets, so it plays without the game's code.
#include "replay/replay.h"
#include "support/sim_shapes.h"
#include "support/small_game.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::replay;
using namespace lockstone::test::scene;

namespace {

/// Twenty ticks with every kind of shape; one shape is made during the recording.
std::vector<std::byte> recorded(const Zoo& zoo) {
    World w = zoo_world(zoo, 1);
    MemorySink sink;
    const auto recorder = made(CommandRecorder::begin(sink, w, "zoo"));
    for (int t = 0; t < 20; ++t) {
        if (t == 5) add(w, {.pose = at(0, 6, 0)}, {.geometry = instance(ShapeKind::compound, zoo.table)});
        w.tick();
    }
    done(recorder->close());
    return sink.bytes;
}

} // namespace

TEST_CASE("a recording of commands contains its assets and plays from the file alone") {
    const Zoo zoo = make_zoo();
    const Recording recording = made(Recording::from_bytes(recorded(zoo), "zoo"));
    CHECK(recording.assets()->ids() == zoo.library->ids());
    Player player = made(Player::open(recording));
    while (!player.at_end()) {
        done(player.step());
        REQUIRE(player.agrees());
    }
    CHECK(player.time() == 20);
}

TEST_CASE("the reader rejects a recording with one damaged asset") {
    const Zoo zoo = make_zoo();
    std::vector<std::byte> bytes = recorded(zoo);
    const std::span<const std::byte> hull = zoo.library->bytes(zoo.hull);
    const auto at = std::search(bytes.begin(), bytes.end(), hull.begin(), hull.end());
    REQUIRE(at != bytes.end());
    at[static_cast<std::ptrdiff_t>(hull.size() / 2)] ^= std::byte{1};
    const Result<Recording> damaged = Recording::from_bytes(bytes, "zoo");
    REQUIRE_FALSE(damaged);
    CHECK(damaged.error().message.find("chunk ASET at byte") != std::string::npos);
}
