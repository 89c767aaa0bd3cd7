// A relay and its lobby under attack. Hostile addresses of a few networks open rooms, leave them, try codes, take seats
// and send changed and copied datagrams. Newcomers from other networks must still meet and play.
//
// Forbidden: a crash; a newcomer that is refused or not connected in time; more rooms or matches than RelayDef allows;
// more bytes out than in; rooms or matches that outlast their limits of silence.
//
// Planted: "many" attacks from more addresses than the reserve for newcomers has places; "stays" continues the attack
// while the tables must become empty.
#include "attack/attack.h"
#include "net/wire.h"
#include "support/split_mix.h"

using namespace lockstone;
using namespace lockstone::test;

namespace {

constexpr std::uint64_t step_ms = 20;

NetAddress address_in(std::uint32_t network, std::uint32_t host, std::uint32_t port) {
    NetAddress made = address(static_cast<std::uint8_t>(1 + host), static_cast<std::uint16_t>(port));
    made.ip[13] = static_cast<std::uint8_t>(network >> 8), made.ip[14] = static_cast<std::uint8_t>(network);
    return made;
}

/// A machine that sends requests to the lobby, and then plays with its token.
struct Machine {
    NetAddress at;
    std::unique_ptr<LobbyClient> client;
    std::unique_ptr<Endpoint> endpoint; ///< null: no token yet
    bool enters = false;                ///< enters a room of the previous machine
};

class Siege {
  public:
    Siege(std::uint64_t seed, bool has_too_many);
    /// Returns an error sentence or an empty string.
    std::string run(bool stays, attack::Figures& figures);

  private:
    void run_for(std::uint64_t ms);
    void attack_once();
    void open_or_leave(Machine& attacker);
    void forge();
    void take_token(Machine& machine);
    NetAddress attacker_address();
    std::string admit_newcomers(attack::Figures& figures);
    std::string over_limits() const;

    SplitMix random;
    std::uint32_t networks, hosts; ///< of the attackers; hosts in each network
    std::uint32_t groups;          ///< of newcomers
    NetKey secret = random_key();
    NetAddress relay_at = address_in(999, 0, 9999);
    RelayDef def;
    Wire wire;
    Relay relay;
    std::vector<Machine> attackers;
    std::vector<Packet> seen; ///< datagrams that attackers copy and change
    std::uint32_t next_port = 1024;
};

RelayDef limits(SplitMix& random, std::uint32_t sources, std::uint32_t groups, bool has_too_many) {
    RelayDef def;
    // The reserve is a quarter of a table. Each hostile address may take one place of it, and each group of newcomers
    // needs one.
    const std::uint32_t least = 4 * (sources + groups);
    def.rooms_max = has_too_many ? sources / 2 : least + random.below(16);
    def.matches_max = has_too_many ? sources / 2 : least + random.below(16);
    def.rooms_per_source = 1 + random.below(16), def.rooms_per_network = 4 + random.below(64);
    def.matches_per_source = 1 + random.below(16), def.matches_per_network = 4 + random.below(64);
    return def;
}

Siege::Siege(std::uint64_t seed, bool has_too_many)
    : random(seed), networks(2 + random.below(4)), hosts(4 + random.below(8)), groups(1 + random.below(3)),
      def(limits(random, networks * hosts, groups, has_too_many)), relay(secret, def, start_ms) {
    wire.jitter_ms = random.below(30), wire.loss_permille = random.below(50);
    wire.attach(relay_at, relay);
    attackers.resize(networks * hosts + random.below(networks * hosts));
    // At least one attacker at each address, so that every address uses the reserve if it may.
    for (std::size_t i = 0; i < attackers.size(); ++i)
        attackers[i].at = address_in(static_cast<std::uint32_t>(i) % networks,
                                     static_cast<std::uint32_t>(i) / networks % hosts, next_port++);
}

NetAddress Siege::attacker_address() {
    return address_in(random.below(networks), random.below(hosts), next_port++);
}

void Siege::take_token(Machine& machine) {
    if (machine.client == nullptr || machine.endpoint != nullptr || !machine.client->token()) return;
    auto made = Endpoint::create(*machine.client->token(), {}, wire.now_ms);
    if (!made) return;
    machine.endpoint = std::make_unique<Endpoint>(std::move(*made));
    wire.attach(machine.at, *machine.endpoint);
}

/// Opens a room, enters that of another attacker, or tries a code. A machine that had a room leaves it without a
/// message.
void Siege::open_or_leave(Machine& attacker) {
    if (attacker.client != nullptr) {
        wire.detach(attacker.at);
        attacker.at.port = static_cast<std::uint16_t>(next_port++);
    }
    std::string code;
    const Machine& other = attackers[random.below(static_cast<std::uint32_t>(attackers.size()))];
    if (random.below(3) == 0 && other.client != nullptr) code = other.client->code();
    if (random.below(8) == 0) code = "ABCDEFGH";
    attacker.endpoint.reset();
    const std::uint32_t players = random.below(4) == 0 ? random.below(20) : 2;
    attacker.client = std::make_unique<LobbyClient>(relay_at, public_key_of(secret), code, players);
    wire.attach(attacker.at, *attacker.client);
}

/// Sends a copied datagram, whole or changed, from an address of the attacker's own.
void Siege::forge() {
    if (seen.empty()) return;
    Packet packet = seen[random.below(static_cast<std::uint32_t>(seen.size()))];
    for (std::uint32_t changes = random.below(4); changes > 0 && !packet.empty(); --changes) {
        const std::uint32_t at = random.below(static_cast<std::uint32_t>(packet.size()));
        if (random.below(6) == 0)
            packet.resize(at);
        else
            packet[at] = static_cast<std::byte>(random.below(256));
    }
    const NetAddress from = random.below(2) == 0
                                ? attacker_address()
                                : attackers[random.below(static_cast<std::uint32_t>(attackers.size()))].at;
    wire.put({from, relay_at, std::move(packet), 0});
}

void Siege::attack_once() {
    const auto any = [&]() -> Machine& {
        return attackers[random.below(static_cast<std::uint32_t>(attackers.size()))];
    };
    for (Machine& attacker : attackers)
        if (attacker.client == nullptr || random.below(400) == 0) open_or_leave(attacker);
    for (std::uint32_t forged = random.below(8); forged > 0; --forged) forge();
    for (int i = 0; i < 4; ++i) take_token(any());
    if (seen.size() < 500)
        for (const OnTheWay& datagram : wire.sent)
            if (datagram.to == relay_at) seen.push_back(datagram.bytes);
    wire.sent.clear();
    wire.keeps = seen.size() < 500;
}

void Siege::run_for(std::uint64_t ms) {
    for (const std::uint64_t end = wire.now_ms + ms; wire.now_ms < end;) {
        attack_once();
        wire.advance(step_ms);
    }
}

std::string Siege::over_limits() const {
    const Relay::Counters counters = relay.counters();
    if (counters.rooms > def.rooms_max) return std::to_string(counters.rooms) + " rooms";
    if (counters.matches > def.matches_max) return std::to_string(counters.matches) + " matches";
    const NetStats& stats = relay.stats();
    if (stats.bytes_sent > stats.bytes_received)
        return std::to_string(stats.bytes_sent) + " bytes out of " + std::to_string(stats.bytes_received);
    return {};
}

std::string Siege::admit_newcomers(attack::Figures& figures) {
    for (std::uint32_t group = 0; group < groups; ++group) {
        const std::uint32_t players = 2 + random.below(3);
        std::vector<Machine> machines(players);
        for (std::uint32_t slot = 0; slot < players; ++slot) {
            Machine& machine = machines[slot];
            machine.at = address_in(300 + 16 * group + slot, slot, 7777);
            const std::string code = slot == 0 ? "" : machines[0].client->code();
            machine.client = std::make_unique<LobbyClient>(relay_at, public_key_of(secret), code, players);
            wire.attach(machine.at, *machine.client);
            run_for(3000);
            if (!machine.client->refusal().empty())
                return "a newcomer is refused: " + machine.client->refusal();
            if (machine.client->code().empty()) return "a newcomer is not answered in 3 s";
        }
        run_for(2000);
        for (Machine& machine : machines) {
            take_token(machine);
            if (machine.endpoint == nullptr) return "a newcomer has no token 2 s after all were there";
        }
        run_for(5000);
        for (std::uint32_t slot = 1; slot < players; ++slot)
            if (!machines[0].endpoint->is_connected(slot)) return "newcomers are not connected in 5 s";
        ++figures["matches"];
        for (Machine& machine : machines) wire.detach(machine.at);
    }
    return {};
}

std::string Siege::run(bool stays, attack::Figures& figures) {
    run_for(4000);
    if (std::string wrong = over_limits(); !wrong.empty()) return wrong;
    figures["rooms"] += relay.counters().rooms, figures["hostile matches"] += relay.counters().matches;
    std::string wrong = admit_newcomers(figures);
    if (wrong.empty()) wrong = over_limits();
    if (!wrong.empty())
        return wrong + " (" + std::to_string(relay.counters().rooms) + " of " +
               std::to_string(def.rooms_max) + " rooms, " + std::to_string(relay.counters().matches) +
               " of " + std::to_string(def.matches_max) + " matches)";
    figures["opened"] += relay.stats().opened, figures["datagrams"] += relay.stats().received;
    figures["refused"] += relay.stats().refused_in_all();
    for (const Machine& attacker : attackers) wire.detach(attacker.at);
    const std::uint64_t idle_ms = std::max(def.room_idle_ms, def.idle_ms) + 5000;
    for (std::uint64_t passed = 0; passed < idle_ms; passed += 1000) {
        if (stays) run_for(1000);
        wire.advance(1000);
    }
    const Relay::Counters counters = relay.counters();
    if (counters.rooms + counters.matches + counters.players > 0)
        return std::to_string(counters.rooms) + " rooms and " + std::to_string(counters.matches) +
               " matches are left after " + std::to_string(idle_ms) + " ms of silence";
    return {};
}

} // namespace

int main(int argc, char** argv) {
    const attack::Options options = attack::read_options("lobby", argc, argv);
    return attack::run(options, [&](std::uint64_t number, attack::Figures& figures) {
        Siege siege(options.seed * 1'000'003 + number, options.planted == "many");
        return siege.run(options.planted == "stays", figures);
    });
}
