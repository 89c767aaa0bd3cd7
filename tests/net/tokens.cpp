// Tokens and passes: sealed ones open, and others are refused with a reason.
#include "net/wire.h"

#include <doctest/doctest.h>

using namespace lockstone;
using namespace lockstone::test;

namespace {

const NetKey key = random_key();

std::string trouble(const Packet& bytes, const NetKey& with = key, std::uint64_t now_ms = start_ms) {
    const auto token = open_token(bytes, with, now_ms);
    return token ? "" : token.error().message;
}

} // namespace

TEST_CASE("net: a sealed token opens with unchanged fields") {
    MatchPlan plan = plan_of(5);
    plan.addresses[2] = parse_address("[2001:db8::7]:80").value();
    const auto tokens = make_tokens(plan).value();
    for (const ConnectToken& token : tokens) {
        const ConnectToken opened = open_token(seal_token(token, key), key, start_ms).value();
        CHECK(opened.match_id == token.match_id);
        CHECK(opened.expires_ms == token.expires_ms);
        CHECK(opened.slot == token.slot);
        CHECK(opened.players == 5);
        CHECK(opened.secret == token.secret);
        CHECK(opened.public_keys == token.public_keys);
        CHECK(opened.addresses == token.addresses);
    }
}

TEST_CASE("net: a complete unchanged token opens with its key before its end, otherwise open_token() returns "
          "why not") {
    const ConnectToken token = make_tokens(plan_of(2)).value()[0];
    const Packet sealed = seal_token(token, key);
    CHECK(trouble(sealed) == "");
    CHECK(trouble(sealed, random_key()) ==
          "the connect token was not sealed with this key, or was changed since");
    CHECK(trouble(sealed, key, start_ms + 60'000) == "the connect token has expired, 0 seconds ago");
    CHECK(trouble(sealed, key, start_ms + 59'999) == "");
    for (std::size_t size = 0; size < sealed.size(); ++size)
        CHECK(trouble({sealed.begin(), sealed.begin() + static_cast<std::ptrdiff_t>(size)}) != "");
    for (std::size_t at = 0; at < sealed.size(); ++at) {
        Packet changed = sealed;
        changed[at] ^= std::byte{4};
        const std::string said = trouble(changed);
        CHECK(said == (at < 4    ? "this is no connect token"
                       : at == 4 ? "the connect token is of version 6, this program reads 2"
                                 : "the connect token was not sealed with this key, or was changed since"));
    }
    Packet longer = sealed;
    longer.push_back(std::byte{0});
    CHECK(trouble(longer) == "the connect token was not sealed with this key, or was changed since");
}

TEST_CASE("net: a token names two relays with a key and a pass for each and contains no player's address") {
    MatchPlan plan = plan_of(16);
    plan.relay = address(1), plan.relay_secret = random_key(), plan.relay_expires_ms = start_ms + 60'000;
    plan.second_relay = address(2), plan.second_relay_secret = random_key();
    MatchPlan timeless = plan;
    timeless.relay_expires_ms = 0;
    REQUIRE_FALSE(make_tokens(timeless));
    CHECK(make_tokens(timeless).error().message ==
          "relay_expires_ms is 0: the relay would reject every player");
    const ConnectToken token = make_tokens(plan).value()[3];
    const Packet sealed = seal_token(token, key);
    CHECK(sealed.size() <= 1138); // the space in a lobby's answer
    const ConnectToken opened = open_token(sealed, key, start_ms).value();
    CHECK(opened.relay == plan.relay);
    CHECK(opened.pass == token.pass);
    CHECK(opened.second_relay.address == plan.second_relay);
    CHECK(opened.second_relay.key == token.second_relay.key);
    CHECK(opened.second_relay.pass == token.second_relay.pass);
    CHECK(opened.addresses == std::array<NetAddress, net_players_max>{});
    CHECK(open_pass(opened.second_relay.pass, plan.second_relay_secret, start_ms));
    CHECK_FALSE(open_pass(opened.second_relay.pass, plan.relay_secret, start_ms));
    CHECK_FALSE(open_pass(opened.pass, plan.second_relay_secret, start_ms));
}

TEST_CASE("net: open_token() rejects an authentic token with a field out of range") {
    ConnectToken token = make_tokens(plan_of(2)).value()[0];
    token.slot = 2;
    CHECK(trouble(seal_token(token, key)).find("slot 2 of 2") != std::string::npos);
    token.slot = 0, token.players = 17;
    CHECK(trouble(seal_token(token, key)).find("17 players, must be 2..16") != std::string::npos);
    token.players = 2, token.pass.resize(300);
    CHECK(trouble(seal_token(token, key)).find("a pass of 300 bytes") != std::string::npos);
}

TEST_CASE("net: an endpoint rejects an invalid token and reports the field") {
    const ConnectToken good = make_tokens(plan_of(2)).value()[0];
    const auto complaint = [](ConnectToken token) {
        const auto made = Endpoint::create(token, {}, start_ms);
        return made ? std::string() : made.error().message;
    };
    CHECK(complaint(good) == "");
    ConnectToken token = good;
    token.players = 40;
    CHECK(complaint(token) == "ConnectToken::players is 40, must be 2..16");
    token = good, token.slot = 1;
    CHECK(complaint(token) == "ConnectToken::secret does not belong to this slot's public key");
    token = good, token.slot = 7;
    CHECK(complaint(token) == "ConnectToken::slot is 7 of 2 players");
    token = good, token.public_keys[1] = {};
    CHECK(complaint(token) == "the public key of slot 1 is one that no secret belongs to");
    token = good, token.relay = address(1);
    CHECK(complaint(token) == "ConnectToken::pass has 0 bytes, a pass has 95");
    token.pass.resize(95), token.second_relay.address = address(2);
    CHECK(complaint(token) == "ConnectToken::second_relay has a pass of 0 bytes, a pass has 95");
    token.second_relay.address = token.relay;
    CHECK(complaint(token) == "ConnectToken::second_relay needs a first one, at another address");
}

TEST_CASE("net: make_tokens() rejects invalid match plans") {
    CHECK_FALSE(make_tokens(plan_of(1)));
    CHECK_FALSE(make_tokens(plan_of(17)));
    MatchPlan plan = plan_of(2);
    plan.addresses[1].port = 0;
    CHECK_FALSE(make_tokens(plan));
    plan.relay = address(1), plan.relay_expires_ms = start_ms + 60'000;
    CHECK(make_tokens(plan).value()[0].addresses[0].port == 0); // no player learns another one's address
    plan.second_relay = plan.relay;
    CHECK_FALSE(make_tokens(plan));
    plan.relay = {}, plan.addresses[1] = address(11);
    CHECK_FALSE(make_tokens(plan));
}

TEST_CASE("net: addresses and keys convert to text and back") {
    for (const char* text : {"192.0.2.7:7777", "[2001:db8::7]:1", "0.0.0.0:0", "[::]:65535"})
        CHECK(to_string(parse_address(text).value()) == text);
    for (const char* text : {"", "192.0.2.7", "192.0.2.7:", "192.0.2.7:65536", "192.0.2:1", "host:1",
                             "[::1:1", "[]:1", "::1:x", "1.2.3.4:-1"})
        CHECK_FALSE(parse_address(text));
    const NetKey made = random_key();
    CHECK(parse_key(to_string(made)).value() == made);
    CHECK_FALSE(parse_key("12"));
    CHECK_FALSE(parse_key(std::string(64, 'g')));
}
