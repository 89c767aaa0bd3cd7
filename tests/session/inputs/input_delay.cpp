// The tuned input delay follows the latency between the machines, and rollbacks stay as short as the definition sets.
//
// Bounds: a latency of 150 ms is 9 ticks at 60 Hz. 4 of them may be predicted, so the delay is 5, and one or two more
// because frames quantize the measured round trip (a packet waits for the next frame on each side, as does its answer).
// Rollbacks: 6 ticks, which are the 4 and those two.
#include "lockstone/session/input_delay.h"
#include "session/match.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

PeerQuality peer(std::uint32_t ping_ms, bool connected = true) {
    return {.connected = connected, .ping_ms = ping_ms};
}

/// The delay after a minute.
std::uint32_t settled(InputDelayDef def, std::vector<PeerQuality> peers) {
    InputDelayTuner tuner(def);
    for (std::uint32_t i = 0; i < 60 * def.tick_rate; ++i) tuner.update(peers);
    return tuner.delay();
}

/// A match whose machines tune their delay if `tunes` is true. Stores the rollback depth of each frame of machine 1.
struct Tuned {
    explicit Tuned(bool tunes) : is_on(tunes), match({.input_delay = 1, .prediction_max = 16}) {}
    void run(int frames, std::uint32_t way_ms) {
        for (const PeerId from : {0u, 1u}) match.network.set_link(from, 1 - from, {.latency_ms = way_ms});
        depths.clear();
        for (int i = 0; i < frames; ++i) {
            for (const PeerId id : {0u, 1u}) {
                const PeerQuality other[] = {match.machine(id).session->quality(1 - id)};
                const std::uint32_t delay = tuners[id].update(other);
                if (is_on) match.machine(id).session->set_input_delay(delay);
            }
            const std::uint64_t before = match.machine(1).session->stats().resimulated;
            match.frame();
            depths.push_back(match.machine(1).session->stats().resimulated - before);
        }
    }
    /// The 90th percentile of the rollback depths after the first 20 s [ticks].
    std::uint64_t depth() const {
        std::vector<std::uint64_t> late(depths.begin() + 1200, depths.end());
        std::ranges::sort(late);
        return late[late.size() * 9 / 10];
    }
    bool is_on;
    Match match;
    std::array<InputDelayTuner, 2> tuners{InputDelayTuner({}), InputDelayTuner({})};
    std::vector<std::uint64_t> depths;
};

} // namespace

TEST_CASE("the tuned input delay is the latency minus the allowed rollback within its limits") {
    CHECK(settled({}, {peer(0)}) == 1);
    CHECK(settled({}, {peer(100)}) == 1);
    CHECK(settled({}, {peer(200)}) == 2);                    // 6 ticks
    CHECK(settled({}, {peer(201)}) == 3);                    // rounded up
    CHECK(settled({}, {peer(20), peer(300), peer(5)}) == 5); // the slowest peer's
    CHECK(settled({}, {peer(20), peer(300, false)}) == 1);   // that peer is absent
    CHECK(settled({}, {peer(100'000)}) == 8);
    CHECK(settled({.rollback_ticks = 0}, {peer(100)}) == 3);
    CHECK(settled({.tick_rate = 120}, {peer(100)}) == 2); // 6 ticks at this rate
    CHECK(settled({.least = 0}, {peer(0)}) == 0);
    CHECK(settled({}, {}) == 1);
    CHECK(settled({.least = 99, .most = 77}, {peer(0)}) == input_delay_limit); // clamped to the range
    CHECK(InputDelayTuner({.tick_rate = 0}).update({}) == 1);
}

TEST_CASE("the tuned input delay stays constant while the latency only jitters") {
    InputDelayTuner tuner({});
    std::uint32_t changes = 0, before = tuner.delay();
    for (std::uint32_t i = 0; i < 36'000; ++i) {
        const PeerQuality trembling[] = {peer(i % 3 == 0 ? 400u : 120u)};
        changes += tuner.update(trembling) != before ? 1u : 0u;
        before = tuner.delay();
    }
    CHECK(changes == 0);
    for (std::uint32_t i = 0; i < 660;
         ++i) { // longer in two of three updates: a tick more in 90 frames, seven in 630
        const PeerQuality mostly[] = {peer(i % 3 == 0 ? 120u : 400u)};
        tuner.update(mostly);
    }
    CHECK(tuner.delay() == 8);
}

TEST_CASE("machines with tuned input delay roll back no further than the requested depth and agree") {
    Tuned tuned(true);
    tuned.run(2400, 150);
    MESSAGE("150 ms: delay ", tuned.tuners[0].delay(), ", rollbacks of ", tuned.depth(), " ticks");
    CHECK(tuned.tuners[0].delay() >= 5);
    CHECK(tuned.tuners[0].delay() <= 7);
    CHECK(tuned.depth() <= 6);
    tuned.run(3600, 15);
    MESSAGE("15 ms: delay ", tuned.tuners[0].delay(), ", rollbacks of ", tuned.depth(), " ticks");
    CHECK(tuned.tuners[0].delay() == 1);
    tuned.run(2400, 150);
    CHECK(tuned.depth() <= 6);
    CHECK(tuned.match.agree(0, 1));
    CHECK(tuned.match.notices<Desync>(0).empty());
    CHECK(tuned.match.machine(0).timeline.end() > 8000);
}

TEST_CASE("machines without tuned input delay roll back further than the requested depth") {
    Tuned planted(false);
    planted.run(2400, 150);
    CHECK(planted.depth() > 6);
}
