// The relay forwards encrypted packets between players, which do not learn each other's addresses. The lobby starts
// matches by a code.
#include "net/wire.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

const NetKey relay_secret = random_key();
const NetAddress relay_at = address(1, 9999);

MatchPlan relayed(std::uint32_t players) {
    MatchPlan plan = plan_of(players);
    plan.relay = relay_at, plan.relay_secret = relay_secret;
    plan.relay_expires_ms = start_ms + 120'000;
    return plan;
}

struct Relayed : Players {
    Relay relay;
    explicit Relayed(std::uint32_t players = 2, const RelayDef& def = {})
        : Players(relayed(players)), relay(relay_secret, def, start_ms) {
        wire.keeps = true;
        wire.attach(relay_at, relay);
    }
    std::uint64_t refused_there(NetFault fault) const {
        return relay.stats().refused[static_cast<std::size_t>(fault)];
    }
    /// The first datagram of a kind that a player sent to the relay.
    Packet of_kind(int kind, std::uint8_t host = 10) const {
        for (const OnTheWay& d : wire.sent)
            if (d.from == address(host) && std::to_integer<std::uint8_t>(d.bytes[0]) >> 4 == kind)
                return d.bytes;
        FAIL("nothing of this kind was sent");
        return {};
    }
};

} // namespace

TEST_CASE("net: players connect through a relay and send no datagram between their own addresses") {
    Relayed players(4);
    REQUIRE(players.connect());
    players.send(3, 1, 50);
    players.wire.run(200);
    const auto taken = players.taken(1);
    REQUIRE(taken.size() == 1);
    CHECK(taken[0].first == 3);
    CHECK(taken[0].second.size() == 50);
    for (const OnTheWay& d : players.wire.sent) CHECK((d.from == relay_at || d.to == relay_at));
    CHECK(players.relay.counters().players == 4);
    CHECK(players.relay.counters().matches == 1);
}

TEST_CASE("net: an endpoint rejects a packet whose bytes or sender a relay changes") {
    Relayed players(3);
    REQUIRE(players.connect());
    players.send(0, 1);
    Packet packet;
    while (const auto out = players[0].next_outgoing()) packet = packet_of(out->bytes);
    Packet renamed = packet;
    renamed[0] = std::byte{0x82}, renamed[2] = std::byte{1}; // as if from player 2, with a new number
    players[1].receive(relay_at, renamed, players.wire.now_ms);
    packet[0] = std::byte{0x80}, packet[12] ^= std::byte{1};
    players[1].receive(relay_at, packet, players.wire.now_ms);
    CHECK(refused(players[1], NetFault::unauthenticated) == 2);
    CHECK(players.taken(1).empty());
    packet[12] ^= std::byte{1};
    players[1].receive(address(10), packet, players.wire.now_ms); // not through the relay
    CHECK(refused(players[1], NetFault::stranger) == 1);
    players[1].receive(relay_at, packet, players.wire.now_ms);
    CHECK(players.taken(1).size() == 1);
}

TEST_CASE("net: a relay forwards only packets of admitted players within the match and within the rate") {
    Relayed players(2, {.packets_per_second = 300});
    REQUIRE(players.connect());
    const std::uint64_t before = players.relay.counters().forwarded;
    Packet packet(30, std::byte{0x81});
    players.relay.receive(address(66), packet, players.wire.now_ms);
    CHECK(players.refused_there(NetFault::stranger) == 1);
    packet[0] = std::byte{0x80}; // to itself
    players.relay.receive(address(10), packet, players.wire.now_ms);
    packet[0] = std::byte{0x85}; // to no player
    players.relay.receive(address(10), packet, players.wire.now_ms);
    CHECK(players.refused_there(NetFault::malformed) == 2);
    CHECK(players.relay.counters().forwarded == before);
    packet[0] = std::byte{0x81};
    for (int i = 0; i < 1000; ++i) players.relay.receive(address(10), packet, players.wire.now_ms);
    CHECK(players.relay.counters().forwarded - before <= 300);
    CHECK(players.refused_there(NetFault::over_rate) >= 700);
}

TEST_CASE("net: a pass lets in a player with its key from a proven address until the pass expires") {
    Relayed players;
    REQUIRE(players.connect());
    const Packet request = players.of_kind(14);
    const auto refuses = [&](const NetAddress& from, const Packet& packet, NetFault fault) {
        const std::uint64_t before = players.refused_there(fault),
                            in_all = players.relay.stats().refused_in_all();
        players.relay.receive(from, packet, players.wire.now_ms);
        CHECK(players.refused_there(fault) == before + 1);
        CHECK(players.relay.stats().refused_in_all() == in_all + 1);
        CHECK_FALSE(players.relay.next_outgoing());
        CHECK(players.relay.counters().players == 2);
    };
    refuses(address(66), request, NetFault::cookie);
    Packet changed = request;
    changed[60] ^= std::byte{1}; // in the pass
    refuses(address(10), changed, NetFault::unauthenticated);
    // in the authenticator, which a thief of the pass cannot compute
    changed = request, changed.back() ^= std::byte{1};
    refuses(address(10), changed, NetFault::unauthenticated);
    changed = request, changed[1] = std::byte{9};
    refuses(address(10), changed, NetFault::version);
    changed = request, changed.pop_back();
    refuses(address(10), changed, NetFault::truncated);

    MatchPlan old = relayed(2);
    old.relay_expires_ms = start_ms; // the token is valid, the pass is not
    const ConnectToken token = make_tokens(old).value()[0];
    Endpoint late = Endpoint::create(token, {}, players.wire.now_ms).value();
    players.wire.attach(address(30), late);
    players.wire.run(1000);
    CHECK_FALSE(late.is_relayed());
    CHECK(players.refused_there(NetFault::expired) > 0);
}

TEST_CASE("net: a relay admits a player again after its address changes and the match continues") {
    Relayed players;
    REQUIRE(players.connect());
    players.wire.move(address(10), address(40));
    players.wire.run(8000);
    players.send(0, 1), players.send(1, 0);
    players.wire.run(200);
    CHECK(players.taken(0).size() == 1);
    CHECK(players.taken(1).size() == 1);
    CHECK(players.relay.counters().players == 2);
}

TEST_CASE("net: a relay removes silent players and admits no more matches than its limit") {
    Relayed players(2, {.matches_max = 1});
    REQUIRE(players.connect());
    MatchPlan other = relayed(2);
    other.match_id = 78;
    const ConnectToken token = make_tokens(other).value()[0];
    Endpoint waiting = Endpoint::create(token, {}, players.wire.now_ms).value();
    players.wire.attach(address(30), waiting);
    players.wire.run(1000);
    CHECK_FALSE(waiting.is_relayed());
    CHECK(players.relay.counters().matches == 1);
    players.relay.poll(players.wire.now_ms + 100'000);
    players.relay.poll(players.wire.now_ms + 102'000);
    CHECK(players.relay.counters().matches == 0);
    CHECK(players.relay.counters().players == 0);
}

TEST_CASE(
    "net: a relay limits the matches that one address begins and other addresses can still begin theirs") {
    Wire wire;
    Relay relay(relay_secret, {.matches_per_source = 2}, start_ms);
    wire.attach(relay_at, relay);
    std::vector<std::unique_ptr<Endpoint>> players;
    const auto sits = [&](const NetAddress& from) {
        MatchPlan plan = relayed(2);
        plan.match_id = 100 + players.size();
        players.push_back(std::make_unique<Endpoint>(
            Endpoint::create(make_tokens(plan).value()[0], {}, wire.now_ms).value()));
        wire.attach(from, *players.back());
        wire.run(1000);
        return players.back()->is_relayed();
    };
    CHECK(sits(address(30, 4000)));
    CHECK(sits(address(30, 4001)));
    CHECK_FALSE(sits(address(30, 4002)));
    CHECK(sits(address(31)));
    CHECK(relay.counters().matches == 3);
}

TEST_CASE("net: a relay limits its answers per second to a flood of hellos") {
    Relay relay(relay_secret, {}, start_ms);
    Packet hello(24, std::byte{0});
    hello[0] = std::byte{0xc0}, hello[1] = std::byte{1};
    std::size_t answers = 0;
    for (std::uint32_t i = 0; i < 100'000; ++i) {
        NetAddress from = address(9);
        from.ip[12] = static_cast<std::uint8_t>(i), from.ip[13] = static_cast<std::uint8_t>(i >> 8);
        relay.receive(from, hello, start_ms);
        while (const auto out = relay.next_outgoing()) {
            ++answers;
            CHECK(out->bytes.size() <= hello.size());
        }
    }
    CHECK(answers <= RelayDef{}.hellos_per_second);
    CHECK(relay.counters().players == 0);
}

namespace {

struct Lobby {
    Wire wire;
    Relay relay{relay_secret, {}, start_ms};
    std::vector<std::unique_ptr<LobbyClient>> clients;

    Lobby() {
        wire.keeps = true;
        wire.attach(relay_at, relay);
    }
    LobbyClient& ask(std::string_view code, std::uint32_t players,
                     const NetKey& key = public_key_of(relay_secret)) {
        return ask_from(address(static_cast<std::uint8_t>(50 + clients.size())), code, players, key);
    }
    LobbyClient& ask_from(const NetAddress& from, std::string_view code, std::uint32_t players,
                          const NetKey& key = public_key_of(relay_secret)) {
        clients.push_back(std::make_unique<LobbyClient>(relay_at, key, code, players));
        wire.attach(from, *clients.back());
        wire.run(2000);
        return *clients.back();
    }
};

} // namespace

TEST_CASE(
    "net: three players with the same code receive tokens from the lobby and connect through the relay") {
    Lobby lobby;
    LobbyClient& host = lobby.ask("", 3);
    REQUIRE(host.code().size() == 8);
    CHECK_FALSE(host.token());
    CHECK(lobby.wire.now_ms - host.answered_ms() < 1000);
    lobby.ask(host.code(), 0), lobby.ask(host.code(), 0);
    lobby.wire.run(1000);
    std::vector<std::unique_ptr<Endpoint>> players;
    for (std::size_t slot = 0; slot < 3; ++slot) {
        REQUIRE(lobby.clients[slot]->token());
        const ConnectToken& token = *lobby.clients[slot]->token();
        CHECK(token.slot == slot);
        players.push_back(std::make_unique<Endpoint>(Endpoint::create(token, {}, lobby.wire.now_ms).value()));
        lobby.wire.attach(address(static_cast<std::uint8_t>(50 + slot)), *players.back());
    }
    lobby.wire.run(2000);
    for (PeerId a = 0; a < 3; ++a)
        for (PeerId b = 0; b < 3; ++b) CHECK(players[a]->is_connected(b) == (a != b));
}

TEST_CASE(
    "net: a player from the lobby can return with its token as long as the match may last and not later") {
    constexpr std::uint64_t minute_ms = 60'000;
    for (const std::uint64_t minutes : {11u, 25u}) {
        Lobby lobby;
        lobby.wire.keeps = false;
        lobby.relay = Relay(relay_secret, {.match_ms = 20 * minute_ms}, start_ms);
        const std::string code = lobby.ask("", 2).code();
        lobby.ask(code, 0);
        lobby.wire.run(1000);
        std::array<std::unique_ptr<Endpoint>, 2> players;
        const auto begin = [&](std::size_t slot) {
            auto made = Endpoint::create(lobby.clients[slot]->token().value(), {}, lobby.wire.now_ms);
            if (!made) return false;
            players[slot] = std::make_unique<Endpoint>(std::move(*made));
            lobby.wire.attach(address(static_cast<std::uint8_t>(50 + slot)), *players[slot]);
            return true;
        };
        REQUIRE(begin(0));
        REQUIRE(begin(1));
        lobby.wire.run(2000);
        CHECK(players[1]->is_connected(0));
        lobby.wire.detach(address(50)); // the machine that opened the room
        for (std::uint64_t second = 0; second < 60 * minutes; ++second) lobby.wire.advance(1000);
        const bool is_in_time = minutes < 20;
        CHECK(begin(0) == is_in_time); // as a new process with the kept token does
        if (!is_in_time) continue;
        lobby.wire.run(3000);
        CHECK(players[0]->is_connected(1));
    }
}

TEST_CASE("net: the lobby reports why it rejects a request and ignores clients without its key") {
    Lobby lobby;
    CHECK(lobby.ask("ABCDEFGH", 0).refusal() == "the lobby knows no such code, or it has expired");
    CHECK(lobby.ask("ABC", 0).refusal() == "a code has 8 letters");
    CHECK(lobby.ask("", 17).refusal() == "the lobby takes 2 to 16 players");
    LobbyClient& host = lobby.ask("", 2);
    lobby.ask(host.code(), 0);
    CHECK(lobby.ask(host.code(), 0).refusal() == "all players of this code are there already");
    LobbyClient& mistaken = lobby.ask("", 2, public_key_of(random_key()));
    CHECK(mistaken.code().empty());
    CHECK(lobby.relay.stats().refused[static_cast<std::size_t>(NetFault::unauthenticated)] > 0);
    CHECK(lobby.relay.counters().rooms == 1);
    lobby.relay.poll(lobby.wire.now_ms + 400'000);
    CHECK(lobby.relay.counters().rooms == 0);
}

TEST_CASE(
    "net: the lobby limits the rooms that one address opens at any ports and others can still open theirs") {
    Lobby lobby;
    const auto from_one = [&](std::uint32_t port, std::string_view code) -> LobbyClient& {
        const NetAddress from = address(99, static_cast<std::uint16_t>(port));
        LobbyClient& client = lobby.ask_from(from, code, 2);
        lobby.wire.detach(from); // requests of one address have a rate limit
        return client;
    };
    lobby.relay = Relay(relay_secret, {.room_idle_ms = RelayDef{}.room_ms}, start_ms);
    const std::uint32_t most = RelayDef{}.rooms_per_source;
    for (std::uint32_t room = 0; room < most; ++room) {
        CAPTURE(room);
        REQUIRE(from_one(4000 + room, "").code().size() == 8);
    }
    CHECK(from_one(5000, "").refusal() == "the lobby has no room for another match");
    CHECK(lobby.relay.counters().rooms == most);
    LobbyClient& other = lobby.ask_from(address(98), "", 2);
    REQUIRE(other.code().size() == 8);
    CHECK(from_one(5001, other.code()).refusal().empty()); // it may enter
    lobby.relay.poll(lobby.wire.now_ms + 400'000);         // its rooms have closed
    CHECK(lobby.relay.counters().rooms == 0);
}

TEST_CASE("net: the lobby limits the rooms that one network opens and others can still open theirs") {
    Lobby lobby;
    lobby.relay = Relay(relay_secret, {.rooms_per_source = 2, .rooms_per_network = 4}, start_ms);
    const auto opens = [&](const NetAddress& from) { return !lobby.ask_from(from, "", 2).code().empty(); };
    for (const std::uint32_t port : {1u, 2u})
        for (const std::uint8_t host : {std::uint8_t{20}, std::uint8_t{21}})
            CHECK(opens(address(host, static_cast<std::uint16_t>(port))));
    CHECK_FALSE(opens(address(22)));
    NetAddress other = address(22);
    other.ip[14] = 3;
    CHECK(opens(other));
    // An IPv6 network is a /48.
    NetAddress wide{.ip = {0x20, 1, 0xd, 0xb8}, .port = 7777};
    for (std::uint8_t i = 0; i < 6; ++i) {
        wide.ip[7] = i; // another /64
        CHECK(opens(wide) == (i < 4));
    }
    wide.ip[5] = 1;
    CHECK(opens(wide));
}

TEST_CASE("net: the lobby reserves the last quarter of its rooms for newcomers") {
    Lobby lobby;
    lobby.relay = Relay(relay_secret, {.rooms_max = 8, .rooms_per_source = 8}, start_ms);
    std::uint32_t opened = 0;
    for (std::uint16_t port = 1; port <= 8; ++port)
        opened += lobby.ask_from(address(20, port), "", 2).code().empty() ? 0u : 1u;
    CHECK(opened == 6);
    for (const std::uint8_t host : {std::uint8_t{21}, std::uint8_t{22}})
        CHECK(lobby.ask_from(address(host), "", 2).code().size() == 8);
    CHECK(lobby.ask_from(address(23), "", 2).refusal() == "the lobby has no room for another match");
}

TEST_CASE("net: a room closes when its players have gone and stays open while they wait") {
    Lobby lobby;
    const std::string left = lobby.ask("", 2).code();
    lobby.wire.detach(address(50));
    LobbyClient& waiting = lobby.ask("", 2);
    lobby.wire.run(40'000);
    CHECK(lobby.relay.counters().rooms == 1);
    CHECK(lobby.ask(left, 0).refusal() == "the lobby knows no such code, or it has expired");
    CHECK(lobby.ask(waiting.code(), 0).token());
}

TEST_CASE("net: the lobby sends no more bytes than it receives and rooms are bounded") {
    Lobby lobby;
    lobby.relay = Relay(relay_secret, {.rooms_max = 2}, start_ms);
    lobby.ask("", 2), lobby.ask("", 2);
    CHECK(lobby.ask("", 2).refusal() == "the lobby has no room for another match");
    std::size_t in = 0, out = 0;
    for (const OnTheWay& d : lobby.wire.sent) (d.from == relay_at ? out : in) += d.bytes.size();
    CHECK(out <= in);
}
