// Fifty machines watch over sockets of 127.0.0.1, each with keys of its own, through one relay: the player sends the
// match once. They come with tokens, or all with one code.
#include "lockstone/session/spectator_relay.h"
#include "net/net_player.h"
#include "net/wire.h"

#include <doctest/doctest.h>

#include <algorithm>

using namespace lockstone;
using namespace lockstone::test;

namespace {

constexpr std::uint64_t match_ticks = 600; // ten seconds at 60 Hz
// a player's bytes for fifty spectators, relative to those for one
constexpr std::uint64_t bytes_bound_percent = 105;
const NetAddress any_port = parse_address("127.0.0.1:0").value();

struct NetWatcher final : ConfirmedSink {
    UdpTransport transport;
    World world;
    WorldSimulation simulation;
    std::unique_ptr<Session> session;
    std::unique_ptr<SessionRunner> runner;
    std::uint64_t first = 0;
    std::vector<std::uint64_t> hashes;
    bool differs = false;

    NetWatcher(const Game& game, const ConnectToken& token, bool from_state, std::uint64_t now_ms)
        : transport(UdpTransport::open(token, {.packets_per_second = 1000}, any_port, now_ms).value()),
          world(game.start().value()), simulation(world, game) {
        session = make_spectator_session(session_def(game, 0, {0, 1}),
                                         WatchDef{.hosts = {0}, .from_state = from_state}, transport)
                      .value();
        runner = std::make_unique<SessionRunner>(*session, simulation, RunnerDef{this});
    }
    void on_confirmed(std::uint64_t tick, std::span<const PlayerInput>, std::uint64_t hash) override {
        if (hashes.empty()) first = tick;
        hashes.push_back(hash);
    }
    void frame(std::uint64_t now_ms) {
        transport.poll(now_ms);
        runner->frame(now_ms);
        while (const auto notice = session->next_notice())
            differs = differs || std::holds_alternative<Desync>(*notice);
    }
    std::uint64_t end() const { return first + hashes.size(); }
};

/// Two machines play and `count` watch. Returns the bytes that the player's machine sent to the relay [bytes above
/// UDP].
std::uint64_t bytes_sent_with(std::uint32_t count) {
    const auto game = make_scene("rollback-arena", {.size = 0, .seed = 1, .players = 2}).value();
    SimulatedNetwork network(2, {.latency_ms = 30}, 1); // between the two players
    MatchPlan plan = plan_of(2);                        // of a player's machine and the relay
    plan.expires_ms = start_ms + 3'600'000;
    std::vector<UdpSocket> free;
    for (NetAddress& address : plan.addresses) {
        free.push_back(UdpSocket::open(any_port).value());
        address = free.back().local_address();
    }
    free.clear();
    const auto tokens = make_tokens(plan).value();
    UdpTransport shown = UdpTransport::open(tokens[0], {}, plan.addresses[0], start_ms).value(),
                 seen = UdpTransport::open(tokens[1], {}, plan.addresses[1], start_ms).value();
    UdpWatchDoor door = UdpWatchDoor::open({.expires_ms = start_ms + 3'600'000}, any_port, start_ms).value();
    const auto relay =
        make_spectator_relay(session_def(*game, 0, {0, 1}), {.hosts = {0}, .state_polls = 120}, seen, door)
            .value();
    NetPlayer a(*game, 0, 2, network.endpoint(0), &shown), b(*game, 1, 2, network.endpoint(1));
    std::vector<std::unique_ptr<NetWatcher>> watchers;
    for (std::uint64_t frame = 0; frame < 2 * match_ticks; ++frame) {
        const std::uint64_t now_ms = start_ms + frame * 1000 / 60;
        network.advance_to(frame * 1000 / 60);
        shown.poll(now_ms), seen.poll(now_ms);
        for (NetPlayer* player : {&a, &b}) player->frame(now_ms, match_ticks);
        // They come one at a time in the first half of the match, every second one from a state.
        while (watchers.size() < count && watchers.size() * match_ticks / 2 <= frame * count)
            watchers.push_back(std::make_unique<NetWatcher>(*game, door.door().let_in(now_ms).value(),
                                                            watchers.size() % 2 == 1, now_ms));
        door.poll(now_ms);
        relay->poll();
        for (const auto& watcher : watchers) watcher->frame(now_ms);
    }
    CHECK(a.hashes.size() == match_ticks);
    CHECK(door.door().counters().connected == count);
    CHECK(relay->counters().watchers == count);
    std::uint64_t late = 0;
    for (const auto& watcher : watchers) {
        CHECK_FALSE(watcher->differs);
        REQUIRE(watcher->end() == match_ticks);
        CHECK(std::ranges::equal(watcher->hashes, std::span(a.hashes).subspan(watcher->first)));
        late += watcher->first > 0 ? 1u : 0u;
    }
    MESSAGE(count, " watch, ", late, " of them from a state; the player sent ",
            shown.endpoint().stats().bytes_sent, " bytes, the relay ", relay->counters().bytes_to_watchers);
    return shown.endpoint().stats().bytes_sent;
}

} // namespace

TEST_CASE("net: fifty spectators see every tick through a relay on 127.0.0.1 and the player sends no more "
          "than for one") {
    const std::uint64_t for_one = bytes_sent_with(1), for_fifty = bytes_sent_with(50);
    CHECK(for_fifty * 100 <= for_one * bytes_bound_percent);
}

namespace {

/// A machine that sends a code to the lobby of a door, then watches.
struct Guest {
    UdpSocket socket = UdpSocket::open(any_port).value();
    LobbyClient lobby;
    std::optional<UdpTransport> transport;

    bool doubles = true; ///< each packet to the lobby is sent twice: the machine still gets one place

    Guest(const NetAddress& at, const NetKey& key, const std::string& code, bool doubled = true)
        : lobby(at, key, code, 2), doubles(doubled) {}
    void poll(std::uint64_t now_ms) {
        while (const auto arrived = socket.receive()) lobby.receive(arrived->from, arrived->bytes, now_ms);
        lobby.poll(now_ms);
        while (const auto out = lobby.next_outgoing()) {
            socket.send(out->to, out->bytes);
            if (doubles) socket.send(out->to, out->bytes);
        }
        if (!transport && lobby.token())
            transport = UdpTransport::open(*lobby.token(), {}, any_port, now_ms).value();
        if (transport) transport->poll(now_ms);
    }
};

} // namespace

TEST_CASE("net: a door admits one spectator to each of its places by one code and none by another code") {
    constexpr std::uint32_t places = 6;
    const NetKey secret = random_key();
    UdpWatchDoor opened =
        UdpWatchDoor::open({.expires_ms = start_ms + 3'600'000, .watchers_max = places}, any_port, start_ms)
            .value();
    const std::string code = opened.open_lobby(secret, start_ms);
    UdpWatchDoor door = std::move(opened); // the lobby still knows the door's address
    const NetAddress at = door.socket().local_address();
    std::vector<std::unique_ptr<Guest>> guests;
    const auto run = [&](std::uint64_t from_ms) {
        for (std::uint64_t now_ms = from_ms; now_ms < from_ms + 4000; now_ms += 20) {
            door.poll(now_ms);
            for (const auto& guest : guests) guest->poll(now_ms);
        }
    };
    const auto come = [&](const std::string& word, const NetKey& key) {
        guests.push_back(std::make_unique<Guest>(at, key, word));
    };
    const NetKey key = public_key_of(secret);
    come(code == "AAAAAAAA" ? "BBBBBBBB" : "AAAAAAAA", key), come("", key),
        come(code, public_key_of(random_key()));
    run(start_ms);
    CHECK(guests[0]->lobby.refusal() == "the lobby knows no such code, or it has expired");
    CHECK(guests[1]->lobby.refusal() == "the lobby has no room for another match");
    CHECK_FALSE(guests[2]->lobby.token()); // wrong key: no answer
    CHECK(door.door().counters().let_in == 0);
    for (std::uint32_t i = 0; i < places; ++i) come(code, key);
    run(start_ms + 5000);
    CHECK(door.door().counters().let_in == places);
    CHECK(door.door().counters().connected == places);
    come(code, key);
    run(start_ms + 10'000);
    CHECK(guests.back()->lobby.refusal() == "all places for those who watch are taken");
    std::vector<std::uint64_t> matches;
    for (std::uint32_t i = 3; i < 3 + places; ++i) {
        REQUIRE(guests[i]->lobby.token());
        CHECK(guests[i]->lobby.token()->addresses[0] == at);
        matches.push_back(guests[i]->lobby.token()->match_id);
        guests[i]->transport->send(0, Packet(30, static_cast<std::byte>(i)));
    }
    std::ranges::sort(matches);
    CHECK(std::ranges::adjacent_find(matches) == matches.end());
    door.poll(start_ms + 15'000);
    std::uint32_t taken = 0;
    for (; const auto packet = door.receive(); ++taken) CHECK(packet->bytes.size() == 30);
    CHECK(taken == places);
}

TEST_CASE("net: three hundred spectators behind one address enter by one code before any of them times out") {
    constexpr std::uint32_t count = 300;
    constexpr std::uint64_t patience_ms = 5000; // the demo's timeout for a relay that does not answer
    const NetKey secret = random_key();
    UdpWatchDoor door = UdpWatchDoor::open({.expires_ms = start_ms + 3'600'000}, any_port, start_ms).value();
    const std::string code = door.open_lobby(secret, start_ms);
    std::vector<std::unique_ptr<Guest>> guests;
    for (std::uint32_t i = 0; i < count; ++i)
        guests.push_back(
            std::make_unique<Guest>(door.socket().local_address(), public_key_of(secret), code, false));
    for (std::uint64_t now_ms = start_ms; now_ms < start_ms + patience_ms; now_ms += 20) {
        door.poll(now_ms);
        for (const auto& guest : guests) guest->poll(now_ms);
    }
    CHECK(std::ranges::count_if(guests, [](const auto& g) { return g->lobby.token().has_value(); }) == count);
    CHECK(door.door().counters().let_in == count);
}
