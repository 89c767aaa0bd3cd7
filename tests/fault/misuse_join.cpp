// Wrong arguments to sessions that join a match, and to sessions that accept states.
#include "lockstone/session/join.h"
#include "lockstone/session/spectator.h"
#include "session/arena.h"
#include "support/stops.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

TEST_CASE("misuse: sessions that join reject wrong definitions and a simulation rejects invalid states") {
    SimulatedNetwork network(2, {}, 1);
    SessionDef def;
    def.input_size = 1;
    def.players = {0, 1};
    CHECK_FALSE(make_join_session(def, {.life = 0}, network.endpoint(0)));
    CHECK_FALSE(make_join_session(def, {.ticks_per_frame = 0}, network.endpoint(0)));
    CHECK_FALSE(make_join_session(def, {.state_bytes_max = 0}, network.endpoint(0)));
    SessionDef alone = def;
    alone.players = {0};
    CHECK_FALSE(make_join_session(alone, {}, network.endpoint(0)));
    SessionDef absent = def;
    absent.absent = 1;
    CHECK_FALSE(make_rollback_session(absent, network.endpoint(0)));
    absent.absent = 4;
    CHECK_FALSE(make_rollback_session(absent, network.endpoint(0)));

    const auto session = make_join_session(def, {}, network.endpoint(0)).value();
    CHECK(last_words([&] { session->report_adopted({}, 0); }).starts_with("lockstone: broken rule: "));
    make_rollback_session(def, network.endpoint(0))
        .value()
        ->report_adopted({}, 0); // it requested no state, and ignores the report

    Arena arena(2);
    const std::uint64_t before = arena.hash();
    CHECK_FALSE(arena.adopt({}));
    CHECK_FALSE(arena.adopt_at(~std::uint64_t{0}, {}));
    std::vector<std::byte> damaged = arena.state().save_portable();
    damaged[damaged.size() / 2] ^= std::byte{1};
    CHECK_FALSE(arena.adopt(damaged));
    CHECK(arena.hash() == before);
}
