// net_peer: one machine of a match as a process, in real time.
//
//   net_peer --relay ADDRESS:PORT --key HEX [--code CODE] --ticks N
//       plays through a relay: opens a room for two and prints its code, or enters the room of a code
//   net_peer --tokens A:PORT B:PORT --slot N --seed HEX --ticks N
//       plays directly: both peers make equal tokens from a common seed
//   ... --leak BYTES
//       planted: leaks these bytes in every frame
//
// Prints "playing" after a second of confirmed ticks, and "confirmed TICKS hash HASH" at the end: the hash of all
// confirmed hashes. Exit status 0: all ticks were confirmed.
#include "base/hash.h"
#include "cli/match/clock.h"
#include "net/net_player.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <thread>

using namespace lockstone;
using cli::unix_ms;

namespace {

struct Args {
    std::vector<std::string> words;
    std::string after(std::string_view name, std::size_t which = 1) const {
        const auto found = std::ranges::find(words, name);
        const auto at = static_cast<std::size_t>(found - words.begin()) + which;
        return found != words.end() && at < words.size() ? words[at] : std::string();
    }
    std::uint64_t number(std::string_view name, std::uint64_t otherwise) const {
        const std::string text = after(name);
        return text.empty() ? otherwise : std::stoull(text);
    }
    bool has(std::string_view name) const { return std::ranges::find(words, name) != words.end(); }
};

ConnectToken token_of_lobby(const Args& args) {
    const NetAddress relay = parse_address(args.after("--relay")).value();
    UdpSocket socket = UdpSocket::open(parse_address("0.0.0.0:0").value()).value();
    LobbyClient client(relay, parse_key(args.after("--key")).value(), args.after("--code"), 2);
    bool told = args.has("--code");
    for (const std::uint64_t end = unix_ms() + 20'000; unix_ms() < end && !client.token();) {
        socket.wait(20);
        while (const auto arrived = socket.receive())
            client.receive(arrived->from, arrived->bytes, unix_ms());
        client.poll(unix_ms());
        while (const auto out = client.next_outgoing()) socket.send(out->to, out->bytes);
        if (!client.refusal().empty())
            std::fprintf(stderr, "net_peer: %s\n", client.refusal().c_str()), std::exit(2);
        if (!told && !client.code().empty())
            std::printf("code %s\n", client.code().c_str()), std::fflush(stdout), told = true;
    }
    if (!client.token()) std::fprintf(stderr, "net_peer: the others have not come\n"), std::exit(2);
    return *client.token();
}

/// For tests only: the seed determines all secrets.
ConnectToken token_of_seed(const Args& args) {
    const NetKey seed = parse_key(args.after("--seed")).value();
    ConnectToken token;
    token.match_id = 1, token.expires_ms = unix_ms() + 600'000, token.players = 2;
    token.slot = static_cast<PeerId>(args.number("--slot", 0));
    for (PeerId slot = 0; slot < 2; ++slot) {
        NetKey secret = seed;
        secret.bytes[0] ^= static_cast<std::byte>(slot + 1);
        token.public_keys[slot] = public_key_of(secret);
        token.addresses[slot] = parse_address(args.after("--tokens", slot + 1)).value();
        if (slot == token.slot) token.secret = secret;
    }
    return token;
}

int play(const Args& args, const ConnectToken& token) {
    const std::uint64_t ticks = args.number("--ticks", 600);
    NetAddress local = parse_address("0.0.0.0:0").value();
    local.port = static_cast<std::uint16_t>(
        args.number("--port", token.relay.port == 0 ? token.addresses[token.slot].port : 0));
    UdpTransport transport = UdpTransport::open(token, {}, local, unix_ms()).value();
    const auto game = make_scene("rollback-arena", {.size = 0, .seed = 1, .players = 2}).value();
    test::NetPlayer player(*game, token.slot, 2, transport);
    const auto begun = std::chrono::steady_clock::now();
    std::uint64_t after = 0;
    bool playing = false;
    std::vector<std::vector<std::byte>> leaked;
    for (std::uint64_t frame = 0; frame < 3 * ticks + args.number("--patience", 1200) && after < 60;
         ++frame) {
        if (const std::uint64_t leak = args.number("--leak", 0); leak != 0)
            leaked.emplace_back(leak, std::byte{1});
        transport.poll(unix_ms());
        player.frame(unix_ms(), ticks);
        if (!playing && player.hashes.size() >= 60)
            std::printf("playing\n"), std::fflush(stdout), playing = true;
        if (player.hashes.size() >= ticks) ++after; // the other peer needs our last packets
        std::this_thread::sleep_until(begun + std::chrono::microseconds(frame * 1'000'000 / 60));
    }
    const NetStats& wire = transport.endpoint().stats();
    const SessionStats& stats = player.stats();
    std::printf("rollbacks %llu depth %llu stalls %llu sent %llu bytes %llu refused %llu\n",
                static_cast<unsigned long long>(stats.rollbacks),
                static_cast<unsigned long long>(stats.depth_max),
                static_cast<unsigned long long>(stats.stalls), static_cast<unsigned long long>(wire.sent),
                static_cast<unsigned long long>(wire.bytes_sent),
                static_cast<unsigned long long>(wire.refused_in_all()));
    std::printf("confirmed %zu hash %016llx%s%s\n", player.hashes.size(),
                static_cast<unsigned long long>(base::xxh3(std::as_bytes(std::span(player.hashes)))),
                player.desynced ? " DESYNC" : "", player.lost ? " LOST" : "");
    return player.hashes.size() >= ticks && !player.desynced && !player.lost ? 0 : 1;
}

} // namespace

int main(int argc, char** argv) {
    const Args args{{argv + 1, argv + argc}};
    return play(args, args.has("--relay") ? token_of_lobby(args) : token_of_seed(args));
}
