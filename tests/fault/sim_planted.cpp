// Planted faults for the checker of the contract: it must name each column that a restore loses.
#include "lockstone/testing.h"
#include "support/sim_replay.h"

#include <doctest/doctest.h>

#include <cstring>

using namespace lockstone;
using namespace lockstone::test::scene;

namespace {

constexpr std::size_t restored_at = 40;

const Run& the_run() {
    static const Run run = run_of(script_story(Scenery::pile, 60));
    return run;
}

/// The checker's result for a world restored at tick 40 after `sabotage` of its state.
template <class Sabotage> std::string verdict(Sabotage&& sabotage) {
    World w = start_script(Scenery::pile);
    w.restore(the_run().images[restored_at]);
    sabotage(testing::state_of(w));
    return departs(the_run(), w, restored_at, 20);
}

const ColumnInfo& column(const State& s, const char* name) {
    const ColumnInfo* info = s.layout().find_column(name);
    REQUIRE(info != nullptr);
    return *info;
}
std::uint32_t index_of(const State& s, const ColumnInfo& info) {
    return static_cast<std::uint32_t>(&info - s.layout().columns().data());
}
void zero(State& s, const char* name) {
    const std::span<std::byte> bytes = s.edit_bytes(index_of(s, column(s, name)));
    std::memset(bytes.data(), 0, bytes.size());
}
bool names(const std::string& verdict, const std::string& what) {
    return verdict.find(what) != std::string::npos;
}

} // namespace

TEST_CASE("the checker finds no fault in a correct restore") {
    CHECK(verdict([](State&) {}) == "");
}

TEST_CASE("planted fault: the checker finds and names any column that a restore leaves out") {
    World w = start_script(Scenery::pile);
    w.restore(the_run().images[restored_at]);
    for (const ColumnInfo& info : w.state().layout().columns()) {
        const std::span<const std::byte> bytes = w.state().bytes(index_of(w.state(), info));
        if (std::ranges::all_of(bytes, [](std::byte b) { return b == std::byte{}; }))
            continue; // no data to lose
        INFO(info.name);
        CHECK(names(verdict([&](State& s) { zero(s, info.name.c_str()); }), "column " + info.name));
    }
}

TEST_CASE("planted fault: the checker finds a generation that is not restored") {
    const std::string v = verdict([](State& s) {
        const ColumnInfo& info = column(s, "body.slot");
        s.edit_bytes(index_of(s, info))[3 * info.row_size + 4] ^= std::byte{1};
    });
    CHECK(names(v, "column body.slot, row 3, generation"));
}

TEST_CASE("planted fault: the checker finds one flipped bit of one velocity with its row and field") {
    const std::string v = verdict([](State& s) {
        const ColumnInfo& info = column(s, "body.velocity");
        s.edit_bytes(index_of(s, info))[7 * info.row_size + 4] ^= std::byte{1};
    });
    CHECK(names(v, "column body.velocity, row 7, linear.y"));
}

TEST_CASE("planted fault: the checker finds an extra body") {
    World w = start_script(Scenery::pile);
    w.restore(the_run().images[restored_at]);
    made(w.create_body({}));
    CHECK(names(departs(the_run(), w, restored_at, 20), "count"));
}

TEST_CASE("planted fault: a replay of the journal finds a missing command at its tick") {
    World w = start_script(Scenery::pile), fresh = start_script(Scenery::pile);
    Tape tape;
    w.set_journal(&tape);
    for (int t = 0; t < 40; ++t) step_script(w);
    std::size_t left_out = 0;
    while (!std::holds_alternative<AddImpulse>(tape.commands[left_out].command)) ++left_out;
    std::uint64_t first_wrong = 1000;
    std::size_t next = 0;
    for (std::uint64_t t = 0; t < tape.hashes.size() && first_wrong == 1000; ++t) {
        for (; next < tape.commands.size() && tape.commands[next].tick == t; ++next)
            if (next != left_out) REQUIRE(fresh.apply(tape.commands[next].command).ok());
        fresh.tick();
        if (fresh.hash() != tape.hashes[t]) first_wrong = t;
    }
    CHECK(first_wrong == tape.commands[left_out].tick);
}
