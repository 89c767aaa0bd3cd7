// Tokens and passes: creation, encryption, decryption. For the formats see README.md.
#include "net/crypto.h"

#include "base/bytes.h"

#include <algorithm>

namespace lockstone {
namespace {

using net::Bytes;

constexpr std::size_t pass_bytes_max = 256; // of a sealed pass in a token

/// The head before the sealed part, authenticated with it: magic and version.
std::uint8_t version_of(std::string_view magic) { return magic == "LSTK" ? token_version : net_version; }
std::vector<std::byte> head(std::string_view magic) {
    std::vector<std::byte> bytes;
    base::ByteWriter to(bytes);
    to.bytes(std::as_bytes(std::span(magic)));
    to.u8(version_of(magic));
    return bytes;
}

Result<std::vector<std::byte>> opened(std::string_view what, std::string_view magic, Bytes bytes,
                                      const NetKey& key) {
    const std::vector<std::byte> header = head(magic);
    base::ByteReader from(bytes, what);
    const Bytes found = from.bytes(magic.size(), "magic");
    const std::uint8_t version = from.u8("version");
    if (!from.ok()) return from.error();
    if (!std::ranges::equal(found, std::as_bytes(std::span(magic))))
        return Error{base::join("this is no ", what)};
    if (version != version_of(magic))
        return Error{
            base::join("the ", what, " is of version ", version, ", this program reads ", version_of(magic))};
    if (bytes.size() < header.size() + net::sealed_extra_bytes)
        return Error{base::join("the ", what, " is cut")};
    std::vector<std::byte> plain(bytes.size() - header.size() - net::sealed_extra_bytes);
    if (!net::open_with_nonce(plain, bytes.subspan(header.size()), header, key))
        return Error{base::join("the ", what, " was not sealed with this key, or was changed since")};
    return plain;
}

void write(base::ByteWriter& to, const NetAddress& address) {
    to.bytes(std::as_bytes(std::span(address.ip)));
    to.u16(address.port);
}

NetAddress read_address(base::ByteReader& from, std::string_view what) {
    NetAddress address;
    const Bytes ip = from.bytes(address.ip.size(), what);
    if (!ip.empty()) std::memcpy(address.ip.data(), ip.data(), ip.size());
    address.port = from.u16(what);
    return address;
}

NetKey read_key(base::ByteReader& from, std::string_view what) {
    NetKey key;
    const Bytes bytes = from.bytes(key.bytes.size(), what);
    if (!bytes.empty()) std::memcpy(key.bytes.data(), bytes.data(), bytes.size());
    return key;
}

/// Derives the key of passes. The relay's secret is an X25519 key, and a key should have one use only.
NetKey pass_key(const NetKey& relay_secret) {
    return net::derived(relay_secret, std::as_bytes(std::span("lockstone relay pass")));
}

Status in_time(std::string_view what, std::uint64_t expires_ms, std::uint64_t now_ms) {
    if (now_ms >= expires_ms)
        return Error{
            base::join("the ", what, " has expired, ", (now_ms - expires_ms) / 1000, " seconds ago")};
    return {};
}

void write_relay(base::ByteWriter& to, const NetAddress& address, const NetKey& key, Bytes pass) {
    write(to, address);
    to.bytes(key.bytes);
    to.u16(static_cast<std::uint16_t>(pass.size()));
    to.bytes(pass);
}
RelaySeat read_relay(base::ByteReader& from) {
    RelaySeat seat;
    seat.address = read_address(from, "relay");
    seat.key = read_key(from, "relay key");
    const std::uint16_t pass_bytes = from.u16("pass length");
    if (pass_bytes > pass_bytes_max)
        from.fail(base::join("a pass of ", pass_bytes, " bytes, at most ", pass_bytes_max));
    const Bytes pass = from.bytes(pass_bytes, "pass");
    seat.pass.assign(pass.begin(), pass.end());
    return seat;
}

/// A token of a lobby has a pass, but not yet the relay's address, which the client adds.
std::uint8_t relays_of(const ConnectToken& token) {
    if (token.relay.port == 0 && token.pass.empty()) return 0;
    return token.second_relay.address.port == 0 ? 1 : 2;
}

/// The common first fields of tokens and passes: match, expiry, seat.
template <class T> void write_seat(base::ByteWriter& to, const T& t) {
    to.u64(t.match_id);
    to.u64(t.expires_ms);
    to.u8(static_cast<std::uint8_t>(t.slot));
    to.u8(static_cast<std::uint8_t>(t.players));
}
template <class T> void read_seat(base::ByteReader& from, T& t) {
    t.match_id = from.u64("match");
    t.expires_ms = from.u64("end");
    t.slot = from.u8("slot");
    t.players = from.u8("players");
    if (t.players < 2 || t.players > net_players_max)
        from.fail(base::join(t.players, " players, must be 2..", net_players_max));
    if (t.slot >= t.players) from.fail(base::join("slot ", t.slot, " of ", t.players));
}

} // namespace

std::vector<std::byte> net::sealed_file(std::string_view magic, Bytes plain, const NetKey& key) {
    std::vector<std::byte> bytes = head(magic);
    const std::vector<std::byte> header = bytes;
    bytes.resize(header.size() + plain.size() + net::sealed_extra_bytes);
    net::seal_with_nonce(std::span(bytes).subspan(header.size()), plain, header, key);
    return bytes;
}

std::vector<std::byte> seal_token(const ConnectToken& token, const NetKey& key) {
    std::vector<std::byte> plain;
    base::ByteWriter to(plain);
    const std::uint8_t relays = relays_of(token);
    write_seat(to, token);
    to.u8(relays);
    to.bytes(token.secret.bytes);
    for (std::uint32_t slot = 0; slot < token.players && slot < net_players_max; ++slot) {
        to.bytes(token.public_keys[slot].bytes);
        if (relays == 0) write(to, token.addresses[slot]);
    }
    if (relays > 0) write_relay(to, token.relay, token.relay_key, token.pass);
    if (relays > 1)
        write_relay(to, token.second_relay.address, token.second_relay.key, token.second_relay.pass);
    return net::sealed_file("LSTK", plain, key);
}

Result<ConnectToken> open_token(std::span<const std::byte> bytes, const NetKey& key, std::uint64_t now_ms) {
    const auto plain = opened("connect token", "LSTK", bytes, key);
    if (!plain) return plain.error();
    base::ByteReader from(*plain, "connect token");
    ConnectToken token;
    read_seat(from, token);
    const std::uint8_t relays = from.u8("relays");
    if (relays > 2) from.fail(base::join(relays, " relays, at most 2"));
    token.secret = read_key(from, "secret key");
    for (std::uint32_t slot = 0; from.ok() && slot < token.players; ++slot) {
        token.public_keys[slot] = read_key(from, "public key");
        if (relays == 0) token.addresses[slot] = read_address(from, "address");
    }
    if (from.ok() && relays > 0) {
        RelaySeat first = read_relay(from);
        if (first.pass.empty()) from.fail("a relay without a pass");
        token.relay = first.address, token.relay_key = first.key, token.pass = std::move(first.pass);
    }
    if (from.ok() && relays > 1) {
        token.second_relay = read_relay(from);
        if (token.second_relay.address.port == 0 || token.second_relay.pass.empty())
            from.fail("a second relay without a port, or without a pass");
    }
    from.expect_end();
    if (!from.ok()) return from.error();
    if (Status s = in_time("connect token", token.expires_ms, now_ms); !s) return s.error();
    return token;
}

std::vector<std::byte> seal_pass(const RelayPass& pass, const NetKey& relay_secret) {
    std::vector<std::byte> plain;
    base::ByteWriter to(plain);
    write_seat(to, pass);
    to.bytes(pass.key.bytes);
    return net::sealed_file("LSRP", plain, pass_key(relay_secret));
}

Result<RelayPass> open_pass(std::span<const std::byte> bytes, const NetKey& relay_secret,
                            std::uint64_t now_ms) {
    const auto plain = opened("relay pass", "LSRP", bytes, pass_key(relay_secret));
    if (!plain) return plain.error();
    base::ByteReader from(*plain, "relay pass");
    RelayPass pass;
    read_seat(from, pass);
    pass.key = read_key(from, "key");
    from.expect_end();
    if (!from.ok()) return from.error();
    if (Status s = in_time("relay pass", pass.expires_ms, now_ms); !s) return s.error();
    return pass;
}

Result<std::vector<ConnectToken>> make_tokens(const MatchPlan& plan) {
    const std::size_t players = plan.addresses.size();
    if (players < 2 || players > net_players_max)
        return Error{base::join("a match has 2..", net_players_max, " players, not ", players)};
    for (const NetAddress& address : plan.addresses)
        if (address.port == 0 && plan.relay.port == 0)
            return Error{"a player has no address, and there is no relay"};
    if (plan.second_relay.port != 0 && (plan.relay.port == 0 || plan.second_relay == plan.relay))
        return Error{"a second relay needs a first one, at another address"};
    if (plan.relay.port != 0 && plan.relay_expires_ms == 0)
        return Error{"relay_expires_ms is 0: the relay would reject every player"};
    ConnectToken all;
    all.match_id = plan.match_id, all.expires_ms = plan.expires_ms;
    all.players = static_cast<std::uint32_t>(players), all.relay = plan.relay;
    std::vector<ConnectToken> tokens(players, all);
    for (PeerId slot = 0; slot < players; ++slot) {
        ConnectToken& own = tokens[slot];
        own.slot = slot, own.secret = random_key(), own.relay_key = random_key();
        const NetKey public_key = public_key_of(own.secret);
        // In a match with a relay, no player learns the address of another.
        const NetAddress address = plan.relay.port == 0 ? plan.addresses[slot] : NetAddress{};
        for (ConnectToken& token : tokens)
            token.public_keys[slot] = public_key, token.addresses[slot] = address;
        if (plan.relay.port != 0)
            own.pass = seal_pass({plan.match_id, plan.relay_expires_ms, slot, own.players, own.relay_key},
                                 plan.relay_secret);
        if (plan.second_relay.port == 0) continue;
        own.second_relay.address = plan.second_relay, own.second_relay.key = random_key();
        own.second_relay.pass =
            seal_pass({plan.match_id, plan.relay_expires_ms, slot, own.players, own.second_relay.key},
                      plan.second_relay_secret);
    }
    return tokens;
}

} // namespace lockstone
