// States on the wire: chunks with proofs, spectators that begin with them, and states that every spectator refuses.
#include "session/join/snapshot.h"
#include "session/join/join_net.h"
#include "support/small_game.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

std::vector<std::byte> some_bytes(std::size_t count) {
    std::vector<std::byte> bytes(count);
    test::SplitMix random(count);
    for (std::byte& b : bytes) b = static_cast<std::byte>(random.next());
    return bytes;
}

session::Chunk chunk_of(const session::Snapshot& snapshot, std::uint32_t index) {
    session::Chunk chunk;
    snapshot.chunk(index, chunk);
    return chunk;
}

} // namespace

TEST_CASE("a state of any size arrives complete in any order of its chunks") {
    for (const std::size_t size : {1u, 959u, 960u, 961u, 1920u, 5000u, 20'000u, 65'000u}) {
        CAPTURE(size);
        const std::vector<std::byte> bytes = some_bytes(size);
        const session::Snapshot snapshot(77, 5, bytes);
        session::Assembly assembly(snapshot.offer());
        test::SplitMix random(size);
        for (std::uint64_t tries = 0; !assembly.is_complete(); ++tries) {
            const session::Chunk chunk = chunk_of(snapshot, random.below(snapshot.offer().chunks()));
            const std::uint32_t before = assembly.missing();
            const std::uint64_t here = assembly.have_after_missing(); // bit i: chunk before + 1 + i
            const bool is_near = chunk.index <= before + 64;
            const bool is_here = chunk.index < before || (is_near && chunk.index > before &&
                                                          (here >> (chunk.index - before - 1) & 1u) != 0);
            const bool taken = assembly.take(chunk);
            if (is_near) CHECK(taken == !is_here);
            CHECK_FALSE(assembly.take(chunk)); // the chunk is stored already
            REQUIRE(tries < 100'000);
        }
        CHECK(std::ranges::equal(assembly.image(), bytes));
    }
}

TEST_CASE("an assembly rejects every kind of chunk that does not match the root of the offer") {
    const session::Snapshot snapshot(77, 5, some_bytes(7000));
    session::Assembly assembly(snapshot.offer());
    const auto refused = [&](auto&& change) {
        session::Chunk chunk = chunk_of(snapshot, 3);
        std::vector<std::byte> bytes(chunk.bytes.begin(), chunk.bytes.end());
        change(chunk, bytes);
        chunk.bytes = bytes;
        return !assembly.take(chunk) && assembly.missing() == 0 && assembly.have_after_missing() == 0;
    };
    CHECK(refused([](auto&, auto& bytes) { bytes[500] ^= std::byte{1}; }));
    CHECK(refused([](auto&, auto& bytes) { bytes.pop_back(); }));
    CHECK(refused([](auto&, auto& bytes) { bytes.push_back(std::byte{0}); }));
    CHECK(refused([](auto& chunk, auto&) { chunk.index = 2; }));
    CHECK(refused([](auto& chunk, auto&) { chunk.index = 8; }));
    CHECK(refused([](auto& chunk, auto&) { chunk.index = 0xffff'ffff; }));
    CHECK(refused([](auto& chunk, auto&) { chunk.tick = 76; }));
    CHECK(refused([](auto& chunk, auto&) { chunk.proof[1] ^= 1; }));
    CHECK(refused([](auto& chunk, auto&) { chunk.proof.pop_back(); }));
    CHECK(refused([](auto& chunk, auto&) { chunk.proof.push_back(0); }));
    CHECK_FALSE(refused([](auto&, auto&) {})); // the control: an unchanged chunk

    for (std::uint32_t field = 0; field < 4; ++field) { // the root covers this tick, hash and size only
        session::Offer other = snapshot.offer();
        if (field == 0) other.tick ^= 1;
        if (field == 1) other.hash ^= 1;
        if (field == 2) other.bytes -= 1;
        if (field == 3) other.root ^= 1;
        session::Assembly wrong(other);
        session::Chunk chunk = chunk_of(snapshot, 1);
        chunk.tick = other.tick;
        CHECK_FALSE(wrong.take(chunk));
    }
}

TEST_CASE("a spectator begins at a recent state and sees the rest of the match") {
    JoinNet net(2);
    net.run(600);
    JoinNet::Guest& guest = net.watch({.hosts = {0}, .from_state = true});
    net.run(240);
    REQUIRE(guest.timeline.first > 500);
    CHECK(net.behind(guest) <= 60);
    CHECK(guest.notices_of<StateRefused>().empty());
    net.run(300);
    CHECK(net.behind(guest) <= 60);
    CHECK(guest.session->quality(0).hashes_agreed == guest.timeline.end());
    CHECK(guest.events.holds(guest.timeline.end()));
}

TEST_CASE("a spectator rejects a state that two of three machines contradict and begins with one of theirs") {
    for (const bool is_first : {true, false}) { // the guest requests the liar's state first, or only its hash
        JoinNet net(3);
        net.lie = [](PeerId from, Arena& shown) {
            if (from == 0) shown.state().edit_row(arena_columns().agent, 2).speed ^= 1;
        };
        net.run(300);
        JoinNet::Guest& guest =
            net.watch({.hosts = is_first ? std::vector<PeerId>{0, 1, 2} : std::vector<PeerId>{1, 0, 2},
                       .from_state = true});
        net.run(600);
        CHECK(guest.notices_of<StateRefused>().size() == (is_first ? 1 : 0));
        CHECK(net.behind(guest) <= 60);
        CHECK(guest.timeline.first > 250);
    }
}

TEST_CASE("a spectator accepts no state when two machines report different ones") {
    JoinNet net(2);
    net.lie = [](PeerId from, Arena& shown) {
        if (from == 0) shown.state().edit_row(arena_columns().agent, 2).speed ^= 1;
    };
    net.run(300);
    JoinNet::Guest& guest = net.watch({.hosts = {0, 1}, .from_state = true});
    net.run(400);
    const auto refused = guest.notices_of<StateRefused>();
    REQUIRE(refused.size() > 1);
    CHECK(refused[0].reason == "1 of 2 machines tell another hash than that of its state");
    CHECK(guest.timeline.ticks.empty());
}

TEST_CASE("a spectator rejects a state above its size limit with a sentence") {
    JoinNet net(2);
    net.run(100);
    JoinNet::Guest& guest = net.watch({.hosts = {0}, .from_state = true, .state_bytes_max = 100});
    net.run(100);
    const auto refused = guest.notices_of<StateRefused>();
    REQUIRE_FALSE(refused.empty());
    CHECK(refused[0].reason.find("bytes, at most 100 are taken") != std::string::npos);
    CHECK(guest.timeline.ticks.empty());
}

TEST_CASE("adopt_at() rejects a state of another tick than its host reports and leaves the world unchanged") {
    const SmallGame game;
    World theirs = game.start().value(), ours = game.start().value();
    for (int t = 0; t < 5; ++t) theirs.tick();
    WorldSimulation simulation(ours, game);
    const std::uint64_t before = ours.hash();
    for (const std::uint64_t tick : {0u, 4u, 6u}) {
        const Status taken = simulation.adopt_at(tick, theirs.save_portable());
        REQUIRE_FALSE(taken);
        CHECK(taken.error().message.find("the state is of tick 5") != std::string::npos);
        CHECK(ours.hash() == before);
    }
    CHECK(simulation.adopt_at(5, theirs.save_portable()));
    CHECK(ours.hash() == theirs.hash());
}
