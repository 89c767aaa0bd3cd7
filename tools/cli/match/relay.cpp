// lockstone relay
#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/match/serve_relay.h"
#include "cli/text.h"

#include <cstdio>
#include <filesystem>

#include <sys/stat.h>

namespace lockstone::cli {
namespace {

struct Args {
    std::string key_file, address = "0.0.0.0";
    std::uint32_t port = 7700, matches = RelayDef{}.matches_max, seconds = 0;
    bool new_key = false;
};

void describe(CLI::App& command, Args& args) {
    add_number(command, "--port", args.port, "the UDP port to listen at; 0: any that is free", 0, 65535)
        .show_default();
    add_text(command, "--address", args.address, "the address to listen at; 0.0.0.0: every one, of IPv6 too")
        .show_default();
    add_text(command, "--key", args.key_file, "the file of the relay's secret: 64 hexadecimal digits")
        .required();
    add_flag(command, "--new-key", args.new_key, "make that file first; it must not be there");
    add_number(command, "--matches", args.matches, "matches at one time", 1, 65536).show_default();
    add_number(command, "--seconds", args.seconds, "end after so long; 0: at a signal").show_default();
}

Result<NetKey> key_of(const Args& args) {
    if (args.new_key) {
        if (std::filesystem::exists(args.key_file)) return Error{args.key_file + ": is there already"};
        ::umask(077); // the secret is its owner's to read
        if (Status s = write_file(args.key_file, to_string(random_key()) + "\n"); !s) return s.error();
    }
    Result<std::string> text = read_file(args.key_file);
    if (!text) return text.error();
    while (!text->empty() && text->back() == '\n') text->pop_back();
    Result<NetKey> key = parse_key(*text);
    if (!key) return Error{args.key_file + ": " + key.error().message};
    return key;
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
    const Result<NetKey> key = key_of(args);
    if (!key) return key.error();
    const auto local = parse_address(args.address + ":" + std::to_string(args.port));
    if (!local) return local.error();
    Result<UdpSocket> socket = UdpSocket::open(*local);
    if (!socket) return socket.error();
    const std::uint64_t begun_ms = unix_ms();
    Relay relay(*key, {.matches_max = args.matches}, begun_ms);
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
                      "Forward sealed packets between players, and bring them together by a code.", describe,
                      relay);
}

} // namespace lockstone::cli
