// Watchers: whoever joins, whenever, sees the match that was played, and notices when it does not.
#include "session/join/spectator.h"
#include "session/match.h"
#include "session/seal.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

/// A match whose machine 0 shows it to others, over a network of their own.
struct Watched {
    struct Watcher {
        Arena arena{2};
        Timeline timeline;
        std::unique_ptr<Session> session;
        std::unique_ptr<SessionRunner> runner;
        std::vector<Notice> notices;
        bool is_there = true;
    };
    Match match;
    SimulatedNetwork network;
    SessionDef def;
    SpectatorHost host;
    std::size_t shown = 0;
    std::vector<std::unique_ptr<Watcher>> watchers;

    explicit Watched(SpectatorHostDef host_def = {})
        : match({.link = {.latency_ms = 60, .jitter_ms = 30, .loss_permille = 100}}),
          network(8,
                  {.latency_ms = 80,
                   .jitter_ms = 40,
                   .loss_permille = 100,
                   .duplicate_permille = 20,
                   .reorder_permille = 20,
                   .damage_permille = 10},
                  3),
          def(as_players()), host(def, network.endpoint(0), host_def) {}

    static SessionDef as_players() {
        SessionDef d;
        d.content_id = 7;
        d.input_size = input_size_of<Pad>;
        d.players = {0, 1};
        return d;
    }
    Watcher& join() {
        Watcher& w = *watchers.emplace_back(std::make_unique<Watcher>());
        const PeerId id = static_cast<PeerId>(watchers.size());
        w.session = make_spectator_session(def, 0, network.endpoint(id), 4).value();
        w.runner = std::make_unique<SessionRunner>(*w.session, w.arena, RunnerDef{&w.timeline});
        return w;
    }
    void run(int frames) {
        for (int i = 0; i < frames; ++i) {
            match.frame();
            network.advance_to(match.now_ms);
            const std::vector<Timeline::Tick>& ticks = match.machine(0).timeline.ticks;
            for (; shown < ticks.size(); ++shown) {
                std::vector<PlayerInput> inputs;
                for (std::size_t p = 0; p < 2; ++p)
                    inputs.push_back({std::span(ticks[shown].inputs).subspan(p * sizeof(Pad), sizeof(Pad)),
                                      ticks[shown].statuses[p]});
                host.on_confirmed(shown, inputs, ticks[shown].hash);
            }
            host.poll();
            for (const auto& w : watchers) {
                if (!w->is_there) continue;
                w->runner->frame(match.now_ms);
                while (const auto notice = w->session->next_notice()) w->notices.push_back(*notice);
            }
        }
    }
    /// How many ticks the watcher is behind; `never` where it has seen another match.
    std::uint64_t behind(const Watcher& w) const {
        const std::vector<Timeline::Tick>& played = match.machines[0]->timeline.ticks;
        if (!w.timeline.in_order || w.timeline.ticks.size() > played.size()) return session::never;
        for (std::size_t t = 0; t < w.timeline.ticks.size(); ++t)
            if (w.timeline.ticks[t] != played[t]) return session::never;
        return played.size() - w.timeline.ticks.size();
    }
};

} // namespace

TEST_CASE("whoever watches, from the start or from later on, sees the match as it was played, soon live") {
    Watched watched;
    Watched::Watcher& first = watched.join();
    watched.run(1200);
    CHECK(watched.behind(first) <= 60);
    Watched::Watcher& late = watched.join();
    watched.run(700); // 1200 ticks at four a frame, while 500 more are played
    CHECK(watched.behind(late) <= 60);
    CHECK(watched.behind(first) <= 60);
    CHECK(late.session->quality(0).hashes_agreed == late.timeline.ticks.size());
    MESSAGE("behind: ", watched.behind(first), " and ", watched.behind(late), " ticks; sent ",
            watched.host.bytes_sent(), " bytes");
    CHECK(watched.match.agree(0, 1));
}

TEST_CASE("a departure is seen by who watches as it was by who played") {
    Watched watched;
    Watched::Watcher& watcher = watched.join();
    watched.run(300);
    REQUIRE(watched.match.machine(0).session->drop_peer(1).ok());
    watched.run(300);
    CHECK(watched.behind(watcher) <= 60);
    CHECK(watcher.timeline.ticks.back().statuses[1] == InputStatus::disconnected);
}

TEST_CASE("the delay holds: nothing is shown sooner than so many ticks after it was played") {
    Watched watched({.delay_ticks = 120});
    Watched::Watcher& watcher = watched.join();
    for (int i = 0; i < 30; ++i) {
        watched.run(20);
        CHECK(watched.match.machine(0).timeline.ticks.size() - watcher.timeline.ticks.size() >=
              std::min<std::size_t>(120, watched.match.machine(0).timeline.ticks.size()));
    }
    CHECK(watched.behind(watcher) <= 180);
}

TEST_CASE("a watcher with another world is told at the first tick that differs, and nobody else notices") {
    Watched watched;
    Watched::Watcher &right = watched.join(), &wrong = watched.join();
    watched.run(200);
    const std::uint64_t tick = wrong.session->current_tick();
    wrong.arena.state().edit_row(arena_columns().agent, 3).speed ^= 1;
    watched.run(200);
    std::vector<Desync> told;
    for (const Notice& notice : wrong.notices)
        if (const Desync* desync = std::get_if<Desync>(&notice)) told.push_back(*desync);
    REQUIRE(told.size() == 1);
    CHECK(told[0].tick == tick);
    CHECK(wrong.session->quality(0).hashes_agreed == tick);
    CHECK(watched.behind(right) <= 60);
    CHECK(right.notices.size() == 1); // connected
}

TEST_CASE("who leaves frees its place, who comes beyond the last place is not answered, and the match goes "
          "on as without") {
    Watched watched({.watchers_max = 1, .silence_polls = 60}), alone;
    Watched::Watcher& first = watched.join();
    watched.run(200);
    Watched::Watcher& second = watched.join();
    watched.run(200);
    CHECK(second.timeline.ticks.empty());
    CHECK(second.runner->frame(watched.match.now_ms).stall == Stall::connecting);
    first.is_there = false;
    watched.run(400);
    CHECK(watched.host.watchers() == 1);
    CHECK(watched.behind(second) <= 60);
    alone.run(800);
    CHECK(watched.match.machine(0).timeline.ticks == alone.match.machine(0).timeline.ticks);
}

TEST_CASE("no bytes break a host or a watcher, and what they claim beyond what was sent is ignored") {
    Watched watched({.watchers_max = 4});
    Watched::Watcher& watcher = watched.join();
    test::Random random(3);
    std::vector<std::byte> buffer;
    const std::uint32_t match = session::packet_context(watched.def).match;
    for (int i = 0; i < 400; ++i) {
        watched.run(1);
        for (int more = 0; more < 5; ++more) {
            const bool to_host = random.below(2) == 0;
            const auto bytes =
                to_host ? session::write_wish(
                              buffer, match,
                              {.wants_log = true,
                               .wants_state = random.below(2) == 0,
                               .wanted = random.below(2) == 0 ? random.below(500) : random.next() >> 33,
                               .asked = random.below(500)})
                        : session::write_stretch(buffer, match + random.below(2),
                                                 {random.below(500), 0, random.below(500), {}});
            std::vector<std::byte> packet(bytes.begin(), bytes.end());
            if (random.below(2) == 0)
                packet[random.below(static_cast<std::uint32_t>(packet.size()))] =
                    static_cast<std::byte>(random.next());
            if (random.below(4) != 0) test::seal(packet, 0);
            watched.network.endpoint(to_host ? 5 + random.below(2) : 6)
                .send(to_host ? 0 : 1, packet); // a stranger's
        }
    }
    CHECK(watched.behind(watcher) <= 60);
    CHECK(watcher.session->stats().dropped[static_cast<std::size_t>(PacketFault::stranger)] > 100);
    CHECK_FALSE(make_spectator_session(watched.def, 0, watched.network.endpoint(1), 0));
    CHECK_FALSE(make_spectator_session({}, 0, watched.network.endpoint(1)));
}
