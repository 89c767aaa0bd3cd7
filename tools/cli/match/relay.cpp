// The command `lockstone relay`.
#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/match/key_file.h"
#include "cli/match/serve_relay.h"

#include <cstdio>

namespace lockstone::cli {
namespace {

struct Args {
    std::string key_file, address = "0.0.0.0";
    std::string second, second_key_file;
    std::uint32_t port = 7700, matches = RelayDef{}.matches_max, seconds = 0;
    bool new_key = false;
};

void describe(CLI::App& command, Args& args) {
    add_number(command, "--port", args.port, "UDP port to listen at; 0: any free port", 0, 65535)
        .show_default();
    add_text(command, "--address", args.address, "address to listen at; 0.0.0.0: every address, also of IPv6")
        .show_default();
    add_text(command, "--key", args.key_file, "file with the relay's secret key: 64 hexadecimal digits")
        .required();
    add_flag(command, "--new-key", args.new_key, "create the key file first; it must not exist");
    add_text(command, "--second", args.second,
             "ADDRESS:PORT of a second relay; players continue there when this one is lost; the lobby sends "
             "them the address");
    add_text(command, "--second-key", args.second_key_file,
             "file with the secret key of the second relay, for the players' tokens there");
    add_number(command, "--matches", args.matches, "largest number of matches at one time, 1 to 65536", 1,
               65536)
        .show_default();
    add_number(command, "--seconds", args.seconds,
               "time after which the relay ends [s]; 0: it ends at a signal")
        .show_default();
}

/// Stores the second relay in `def`, if the arguments name one.
Status name_second(const Args& args, RelayDef& def) {
    if (args.second.empty() != args.second_key_file.empty())
        return Error{"--second and --second-key: give both, or neither"};
    if (args.second.empty()) return {};
    const auto at = parse_address(args.second);
    if (!at) return Error{"--second " + args.second + ": " + at.error().message};
    if (at->port == 0) return Error{"--second " + args.second + ": has no port; write ADDRESS:PORT"};
    const Result<NetKey> key = key_in(args.second_key_file);
    if (!key) return key.error();
    def.second = *at, def.second_secret = *key;
    return {};
}

void report(const Relay& relay) {
    const Relay::Counters counters = relay.counters();
    const NetStats& stats = relay.stats();
    std::printf("received %llu datagrams, forwarded %llu, refused %llu\n",
                static_cast<unsigned long long>(stats.received),
                static_cast<unsigned long long>(counters.forwarded),
                static_cast<unsigned long long>(stats.refused_in_all()));
    for (std::uint32_t f = 0; f < net_fault_count; ++f)
        if (stats.refused[f] > 0)
            std::printf("  %s %llu\n", name_of(static_cast<NetFault>(f)),
                        static_cast<unsigned long long>(stats.refused[f]));
}

Result<Exit> relay(const Args& args) {
    const Result<NetKey> key = key_of(args.key_file, args.new_key);
    if (!key) return key.error();
    const auto local = parse_address(args.address + ":" + std::to_string(args.port));
    if (!local) return local.error();
    Result<UdpSocket> socket = UdpSocket::open(*local);
    if (!socket) return socket.error();
    const std::uint64_t begun_ms = unix_ms();
    RelayDef def{.matches_max = args.matches};
    if (Status s = name_second(args, def); !s) return s.error();
    Relay relay(*key, def, begun_ms);
    std::printf("port %u, key %s\n", socket->local_address().port, to_string(public_key_of(*key)).c_str());
    std::fflush(stdout);
    const Interrupt interrupt;
    while (!interrupt.came() &&
           (args.seconds == 0 || unix_ms() - begun_ms < std::uint64_t{args.seconds} * 1000))
        serve_relay(relay, *socket, 100);
    report(relay);
    return Exit::good;
}

} // namespace

void add_relay(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "relay",
                      "Forward encrypted packets between players; players find each other by a code.",
                      describe, relay);
}

} // namespace lockstone::cli
