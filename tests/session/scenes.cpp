// The scenes with vehicles, characters and joints under rollback: every tick runs again from a saved state, through the
// session and its event ledger.
#include "scenes/scenes.h"
#include "cli/match/event_law.h"
#include "lockstone/session.h"
#include "lockstone/session/forgetful.h"
#include "support/effort.h"

#include <doctest/doctest.h>

#include <string>
#include <vector>

using namespace lockstone;

namespace {

/// Two scripted players of a scene.
struct Played {
    std::string fault;          ///< the error of a run that rolls back at every tick; empty without one
    std::uint64_t landings = 0; ///< confirmed landings of characters
};

Played play(const char* scene, std::uint32_t size, std::uint32_t depth, int ticks,
            std::string column_left_out = "") {
    const auto game = make_scene(scene, {.size = size, .seed = 1, .players = 2}).value();
    World world = game->start().value();
    WorldSimulation whole(world, *game);
    testing::ForgetfulSimulation simulation(whole, std::move(column_left_out));
    SessionDef def;
    def.input_size = game->input_size();
    def.players = {0, 0};
    const auto session = make_sync_test_session(def, depth).value();
    SessionRunner runner(*session, simulation);
    std::vector<std::byte> input(game->input_size());
    cli::EventLaw events;
    Played out;
    const auto count = static_cast<std::uint64_t>(ticks);
    for (std::uint64_t i = 0; i < count; ++i) {
        for (std::uint32_t p = 0; p < 2; ++p) {
            scripted_input(*game, 1, session->current_tick(), p, input);
            session->add_local_input(p, input);
        }
        if (runner.frame(i).stall != Stall::none) return {"it stalls"};
        for (const SessionEvent& e : runner.events()) {
            events.see(e);
            out.landings += e.event.kind == EventKind::character_landed && e.status == EventStatus::confirmed;
        }
        if (const SyncTestFailure* failure = runner.sync_failure()) return {to_string(*failure)};
    }
    if (session->stats().hashes_compared + depth < count) out.fault = "too little was compared";
    if (!events.holds(session->current_tick() - depth - 1)) out.fault = "an event has no end, or two";
    return out;
}

struct Row {
    const char* scene;
    std::uint32_t size, depth;
    int ticks;
    const char* column; ///< planted fault: the column that the snapshots leave out
};

constexpr Row rows[] = {{"ragdolls", 4, 4, 120, "game.players"},
                        {"joint-grid", 0, 4, 160, "game.players"},
                        {"bridge", 24, 4, 160, "game.players"},
                        {"wrecking-ball", 12, 4, 160, "game.players"},
                        {"cars", 0, 4, 120, nullptr},
                        {"character", 0, 4, 120, nullptr},
                        {"character", 0, 1, 460, nullptr},
                        {"character", 0, 6, 240, "character.row"}};

} // namespace

TEST_CASE("players who drive, walk, roll, jump and push among joints survive rollback at every tick") {
    for (const Row& row : rows) {
        INFO(row.scene, ", depth ", row.depth);
        const Played played = play(row.scene, row.size, row.depth, test::tries(row.ticks));
        CHECK(played.fault == "");
        if (row.ticks >= 240 && !test::is_too_long_here()) CHECK(played.landings > 0);
    }
}

TEST_CASE("planted: every scene detects a rollback that does not restore a column of rules or characters") {
    for (const Row& row : rows)
        if (row.column != nullptr) {
            INFO(row.scene);
            CHECK(play(row.scene, row.size, row.depth, std::max(row.ticks, 160), row.column).fault != "");
        }
}
