// The command `lockstone broadcast`.
#include "cli/commands.h"
#include "cli/interrupt.h"
#include "cli/match/key_file.h"
#include "cli/match/serve_relay.h"
#include "lockstone/session/spectator_relay.h"
#include "meet/match_card.h"
#include "meet/meeting.h"

#include <algorithm>
#include <cstdio>
#include <thread>

namespace lockstone::cli {
namespace {

constexpr std::uint64_t card_patience_ms = 20'000, silence_max_ms = 60'000, open_after_end_ms = 10'000;
constexpr std::uint64_t door_open_ms = 24ull * 3600 * 1000;
constexpr std::uint64_t polls_between_cards = 30;
constexpr std::uint32_t log_ticks_least = 1024, watchers_most = 4096;

struct Args {
    std::vector<std::string> invitations;
    std::string key_file, address = "0.0.0.0";
    std::uint32_t port = 7701, watchers = 1024, seconds = 0;
    bool new_key = false;
};

void describe(CLI::App& command, Args& args) {
    add_texts(command, "INVITATION", args.invitations,
              "CODE@ADDRESS:PORT#KEY that the host prints for watchers; further ones name other machines of "
              "the same match, which are used when the first is lost")
        .required();
    add_number(command, "--port", args.port, "UDP port to listen at; 0: any free port", 0, 65535)
        .show_default();
    add_text(command, "--address", args.address, "address to listen at; 0.0.0.0: every address, also of IPv6")
        .show_default();
    add_text(command, "--key", args.key_file, "file with the secret key: 64 hexadecimal digits").required();
    add_flag(command, "--new-key", args.new_key, "create the key file first; it must not exist");
    add_number(command, "--watchers", args.watchers, "largest number of watchers at one time", 1,
               watchers_most)
        .show_default();
    add_number(command, "--seconds", args.seconds,
               "time after which the broadcast ends [s]; 0: it ends after the match or at a signal")
        .show_default();
}

/// The machines that show the match. This transport numbers them as peers 0, 1 and so on.
class Hosts final : public Transport {
  public:
    Status add(const std::string& word, std::uint64_t now_ms) {
        const Result<Invitation> invitation = parse_invitation(word);
        if (!invitation) return invitation.error();
        if (invitation->code.empty()) return Error{"broadcast needs the code too: CODE@" + word};
        Result<Meeting> meeting = Meeting::begin(*invitation, 2, now_ms);
        if (!meeting) return meeting.error();
        hosts.push_back({std::move(*meeting), {}, {}, 0});
        return {};
    }
    /// Polls the meetings and reads the match cards that arrive. Returns true once every host has sent its card.
    Result<bool> meet(std::uint64_t now_ms) {
        for (Host& host : hosts) {
            if (host.wire) continue;
            if (const Status status = host.meeting.poll(now_ms); !status) return status.error();
            if (!host.meeting.token()) continue;
            Result<UdpTransport> opened = UdpTransport::open(*host.meeting.token(), {}, {}, now_ms);
            if (!opened) return opened.error();
            host.wire = std::move(*opened), host.met_ms = now_ms;
        }
        poll(now_ms);
        while (receive()) {} // drops other packets: their senders repeat them
        for (const Host& host : hosts)
            if (host.wire && !host.card && now_ms - host.met_ms > card_patience_ms)
                return Error{"the machine with the code " + host.meeting.invitation().code +
                             " does not send the match"};
        return std::ranges::all_of(hosts, [](const Host& host) { return host.card.has_value(); });
    }
    /// The match that all hosts play; an error if two cards differ.
    Result<MatchCard> card() const {
        for (const Host& host : hosts)
            if (to_bytes(*host.card) != to_bytes(*hosts.front().card))
                return Error{"the machine with the code " + host.meeting.invitation().code +
                             " plays a different match than the first machine"};
        return *hosts.front().card;
    }
    std::vector<PeerId> peers() const {
        std::vector<PeerId> all;
        for (PeerId peer = 0; peer < hosts.size(); ++peer) all.push_back(peer);
        return all;
    }
    void poll(std::uint64_t now_ms) {
        for (Host& host : hosts)
            if (host.wire) host.wire->poll(now_ms);
        next = 0;
    }
    void send(PeerId to, std::span<const std::byte> bytes) override {
        if (to < hosts.size() && hosts[to].wire) hosts[to].wire->send(0, bytes);
    }
    std::optional<Datagram> receive() override {
        for (; next < hosts.size(); ++next) {
            Host& host = hosts[next];
            while (const auto packet = host.wire ? host.wire->receive() : std::nullopt) {
                const auto card = card_of(packet->bytes);
                if (!card) return Datagram{static_cast<PeerId>(next), packet->bytes};
                if (!host.card) host.card = card;
            }
        }
        return {};
    }
    bool authenticated() const override { return true; }

  private:
    struct Host {
        Meeting meeting;
        std::optional<UdpTransport> wire;
        std::optional<MatchCard> card;
        std::uint64_t met_ms;
    };
    std::vector<Host> hosts;
    std::size_t next = 0; ///< index of the host whose packets are read next
};

Result<std::unique_ptr<SpectatorRelay>> relay_of(const MatchCard& card, const Hosts& hosts,
                                                 std::uint32_t watchers, Transport& up, Transport& down) {
    const Result<std::unique_ptr<Game>> game = game_of(card, "");
    if (!game) return game.error();
    std::vector<PeerId> homes;
    for (PeerId p = 0; p < (*game)->player_count(); ++p) homes.push_back(p % card.machines);
    SpectatorRelayDef def{.hosts = hosts.peers(), .watchers_max = watchers};
    // The relay keeps every tick, so each watcher starts at tick 0 and needs no state.
    def.log_ticks_max = std::max(log_ticks_least, static_cast<std::uint32_t>(card.ticks));
    def.state_polls = 0;
    return make_spectator_relay(session_def(**game, 0, homes), def, up, down);
}

/// Limits a loop to 60 turns a second.
class Pace {
  public:
    void wait() {
        next += std::chrono::microseconds(1'000'000 / 60);
        next = std::max(next,
                        std::chrono::steady_clock::now() -
                            std::chrono::seconds(1)); // catches up at most one second
        std::this_thread::sleep_until(next);
    }

  private:
    std::chrono::steady_clock::time_point next = std::chrono::steady_clock::now();
};

void say_how_to_watch(const Args& args, const NetKey& secret, UdpWatchDoor& door, const std::string& code) {
    const std::uint16_t port = door.socket().local_address().port;
    const bool is_any = args.address == "0.0.0.0";
    const std::string key = to_string(public_key_of(secret)),
                      at = is_any ? "127.0.0.1:" + std::to_string(port)
                                  : to_string(door.socket().local_address());
    std::printf("port %u, key %s, code %s\nto watch: lockstone-demo --watch %s@%s#%s\n", port, key.c_str(),
                code.c_str(), code.c_str(), at.c_str(), key.c_str());
    if (is_any) std::printf("from another machine: replace 127.0.0.1 with the address of this machine\n");
    std::fflush(stdout);
}

/// Runs the relay until the match is over and no watcher has been connected for open_after_end_ms, until no new tick
/// has come for silence_max_ms, or until --seconds have passed.
Exit serve(const Args& args, const MatchCard& card, Hosts& hosts, UdpWatchDoor& door, SpectatorRelay& relay,
           const Interrupt& interrupt, std::uint64_t begun_ms) {
    Pace pace;
    std::uint64_t polls = 0, told_ms = unix_ms(), watched_ms = told_ms, told = 0;
    std::uint32_t watchers_ever = 0;
    std::uint64_t host_changes = 0; // counted up to the last new tick
    const auto is_over = [&](std::uint64_t now_ms) {
        if (args.seconds != 0 && now_ms - begun_ms > std::uint64_t{args.seconds} * 1000) return true;
        return told >= card.ticks ? now_ms - watched_ms > open_after_end_ms
                                  : now_ms - told_ms > silence_max_ms;
    };
    std::uint64_t now_ms = told_ms;
    for (; !interrupt.came() && !is_over(now_ms); pace.wait()) {
        now_ms = unix_ms();
        hosts.poll(now_ms);
        door.poll(now_ms);
        relay.poll();
        if (++polls % polls_between_cards == 0)
            for (PeerId place = 0; place < args.watchers; ++place) door.send(place, to_bytes(card));
        const SpectatorRelay::Counters counters = relay.counters();
        if (counters.next_tick != told || told < card.ticks) watched_ms = now_ms;
        if (counters.next_tick != told)
            told = counters.next_tick, told_ms = now_ms, host_changes = counters.host_changes;
        if (counters.watchers != 0) watched_ms = now_ms;
        watchers_ever = std::max(watchers_ever, counters.watchers);
    }
    const SpectatorRelay::Counters counters = relay.counters();
    std::printf("showed %llu of %llu ticks to at most %u at one time, %llu bytes; changed the source machine "
                "%llu times\n",
                static_cast<unsigned long long>(told), static_cast<unsigned long long>(card.ticks),
                watchers_ever, static_cast<unsigned long long>(counters.bytes_to_watchers),
                static_cast<unsigned long long>(host_changes));
    return told >= card.ticks || now_ms - told_ms <= silence_max_ms ? Exit::good : Exit::check_failed;
}

Result<Exit> broadcast(const Args& args) {
    const std::uint64_t begun_ms = unix_ms();
    const Result<NetKey> key = key_of(args.key_file, args.new_key);
    if (!key) return key.error();
    const auto local = parse_address(args.address + ":" + std::to_string(args.port));
    if (!local) return local.error();
    Hosts hosts;
    for (const std::string& word : args.invitations)
        if (Status s = hosts.add(word, begun_ms); !s) return s.error();
    const Interrupt interrupt;
    for (Pace pace; !interrupt.came(); pace.wait()) {
        const Result<bool> met = hosts.meet(unix_ms());
        if (!met) return met.error();
        if (*met) break;
    }
    if (interrupt.came()) return Exit::good;
    const Result<MatchCard> card = hosts.card();
    if (!card) return card.error();
    // A watcher's place becomes free when the watcher has sent no packet for this time.
    constexpr std::uint32_t idle_ms = 10'000;
    Result<UdpWatchDoor> door = UdpWatchDoor::open(
        {.expires_ms = begun_ms + door_open_ms, .watchers_max = args.watchers, .idle_ms = idle_ms}, *local,
        unix_ms());
    if (!door) return door.error();
    const Result<std::unique_ptr<SpectatorRelay>> relay = relay_of(*card, hosts, args.watchers, hosts, *door);
    if (!relay) return relay.error();
    say_how_to_watch(args, *key, *door, door->open_lobby(*key, unix_ms()));
    return serve(args, *card, hosts, *door, **relay, interrupt, begun_ms);
}

} // namespace

void add_broadcast(CLI::App& app, Work& work) {
    add_command<Args>(app, work, "broadcast",
                      "Show a match over UDP to hundreds of watchers; they use one code, and the players "
                      "send the match once.",
                      describe, broadcast);
}

} // namespace lockstone::cli
