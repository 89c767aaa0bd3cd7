// One hostile machine among two to four: a whole match of packets with valid checksums, changed field by field or byte
// by byte.
//
// Forbidden: a crash, a hang, honest machines that differ without a notice. Two machines may differ only where one of
// them got a notice of a desync with the other, of the other's departure, or of the end of the match.
//
// Planted: "silent" gives one honest machine a changed world and ignores the notices; "hang" never ends.
#include "attack/attack.h"
#include "session/hostile.h"
#include "session/inputs/input_queue.h"
#include "session/seal.h"

#include <chrono>
#include <cstdio>
#include <thread>

using namespace lockstone;
using namespace lockstone::test;

namespace {

using session::Message;

std::uint64_t any_number(test::SplitMix& random, std::uint64_t near) {
    switch (random.below(6)) {
    case 0:
        return 0;
    case 1:
        return 0xffffffffu;
    case 2:
        return static_cast<std::uint32_t>(random.next());
    case 3:
        return near + random.below(300);
    default:
        return near < 300 ? random.below(300) : near - random.below(300);
    }
}

/// Changes some fields. Inputs stay, because a machine may send any input of its own.
void lie_in_fields(Message& m, std::uint32_t players, test::SplitMix& random) {
    const std::uint32_t all = (1u << players) - 1, p = random.below(players);
    for (std::uint32_t lies = 1 + random.below(3); lies > 0; --lies) {
        switch (random.below(12)) {
        case 0:
            m.tick = any_number(random, m.tick) & 0xffffffffu;
            break;
        case 1:
            m.next_input[p] = any_number(random, m.next_input[p]) & 0xffffffffu;
            break;
        case 2:
            m.next_hash = any_number(random, m.next_hash) & 0xffffffffu;
            break;
        case 3:
            m.hash_first = any_number(random, m.hash_first) & 0xffffffffu;
            break;
        case 4:
            m.hashes[0] = static_cast<std::uint32_t>(random.next());
            break;
        case 5:
            m.unwanted |= random.below(all + 1);
            break;
        case 6:
            m.gone |= 1u << p;
            break;
        case 7:
            m.gone |= 1u << p, m.has_cut |= 1u << p, m.cut[p] = any_number(random, m.tick) & 0xffffffffu;
            break;
        case 8:
            m.block_count = random.below(m.block_count + 1);
            break;
        case 9:
            m.hash_count = random.below(m.hash_count + 1);
            break;
        case 10:
            m.quality = session::QualityReport{
                static_cast<std::int32_t>(random.next()), static_cast<std::uint16_t>(random.next()),
                random.below(2) != 0, static_cast<std::uint16_t>(random.next()),
                static_cast<std::uint16_t>(random.next())};
            break;
        default:
            if (random.below(50) == 0) m.sequence = any_number(random, m.sequence) & 0xffffffffu;
            break;
        }
    }
}

std::vector<std::byte> with_other_bytes(std::span<const std::byte> from, std::uint32_t match,
                                        test::SplitMix& random) {
    std::vector<std::byte> packet(from.begin(), from.end());
    for (std::uint32_t changes = 1 + random.below(3); changes > 0; --changes) {
        const std::uint32_t at = random.below(static_cast<std::uint32_t>(packet.size()));
        if (random.below(8) == 0)
            packet.resize(at);
        else
            packet[at] = static_cast<std::byte>(random.below(3) == 0 ? 0xff : random.below(256));
        if (packet.size() < 10) break;
    }
    seal(packet, match);
    return packet;
}

/// Returns the first tick after which two machines have different states, or `never`. Inputs without an effect may
/// differ.
std::uint64_t parting(const Timeline& a, const Timeline& b) {
    const std::size_t both = std::min(a.ticks.size(), b.ticks.size());
    for (std::size_t t = 0; t < both; ++t)
        if (a.ticks[t].hash != b.ticks[t].hash) return t;
    return session::never;
}

/// Returns whether `a` got a notice that explains its difference from `b`.
bool is_told(const Match& match, PeerId a, PeerId b, std::uint64_t at) {
    for (const Desync& desync : match.notices<Desync>(a))
        if (desync.peer == b && desync.tick <= at) return true;
    for (const PlayerDisconnected& left : match.notices<PlayerDisconnected>(a))
        if (left.peer == b) return true;
    return !match.notices<MatchStopped>(a).empty();
}

/// The notices of a machine, for the report of a finding.
std::string told_to(const Match& match, PeerId id) {
    std::string out = " [" + std::to_string(id) + ": " +
                      std::to_string(match.machines[id]->timeline.ticks.size()) + " ticks";
    for (const Desync& d : match.notices<Desync>(id))
        out += ", desync with " + std::to_string(d.peer) + " at " + std::to_string(d.tick);
    for (const PlayerDisconnected& left : match.notices<PlayerDisconnected>(id))
        out += ", " + std::to_string(left.peer) + " left at " + std::to_string(left.tick);
    for (const MatchStopped& stop : match.notices<MatchStopped>(id)) out += ", stopped: " + stop.reason;
    return out + "]";
}

enum class Fault { none, silent, hang };

/// Returns an error sentence if honest machines differ without a notice.
std::string parted(const HostileMatch& h, Fault fault, bool may_part, attack::Figures& figures) {
    for (PeerId a = 0; a < h.hostile; ++a) {
        const SessionStats& stats = h.match.machines[a]->session->stats();
        figures["dropped"] += stats.packets_dropped;
        figures["ticks"] += stats.ticks;
        figures["stopped"] += h.match.notices<MatchStopped>(a).size();
        for (PeerId b = 0; b < h.hostile; ++b) {
            const std::uint64_t at = parting(h.match.machines[a]->timeline, h.match.machines[b]->timeline);
            if (at == session::never) continue;
            const bool told =
                fault != Fault::silent && (is_told(h.match, a, b, at) || is_told(h.match, b, a, at));
            ++figures[told ? "told" : "silent"];
            if (!told)
                return "machines " + std::to_string(a) + " and " + std::to_string(b) +
                       " part silently at tick " + std::to_string(at) + told_to(h.match, a) +
                       told_to(h.match, b);
            const bool of_desync = h.match.notices<Desync>(a).size() + h.match.notices<Desync>(b).size() > 0;
            if (of_desync && !may_part && h.match.notices<PlayerDisconnected>(a).empty())
                return "a desync out of lies that leave the inputs alone";
        }
    }
    return {};
}

/// Returns an error sentence unless each honest machine advances or has a notice that explains its stop.
std::string stands_still(HostileMatch& h) {
    std::vector<std::size_t> before;
    for (PeerId a = 0; a < h.hostile; ++a) before.push_back(h.match.machine(a).timeline.ticks.size());
    h.match.run(600); // ten times the timeout
    for (PeerId a = 0; a < h.hostile; ++a) {
        const bool knows = !h.match.notices<MatchStopped>(a).empty();
        const bool is_unplugged = h.match.notices<PlayerDisconnected>(a).size() >= h.hostile;
        if (!knows && !is_unplugged && h.match.machine(a).timeline.ticks.size() < before[a] + 20)
            return "machine " + std::to_string(a) + " stands still at tick " + std::to_string(before[a]);
    }
    return {};
}

std::string one_match(std::uint64_t seed, Fault fault, attack::Figures& figures) {
    test::SplitMix random(seed);
    const std::uint32_t machines = 2 + random.below(3);
    const bool lockstep = random.below(4) == 0;
    HostileMatch h(machines, {.lockstep = lockstep,
                              .input_delay = lockstep ? 10u : random.below(4),
                              .prediction_max = lockstep ? 0u : 1 + random.below(12),
                              .link = {.latency_ms = 20 + random.below(60),
                                       .jitter_ms = random.below(30),
                                       .loss_permille = random.below(100),
                                       .duplicate_permille = 20,
                                       .damage_permille = 5},
                              .connect_ms = 2000,
                              .seed = seed});
    const std::uint32_t how = random.below(3), lies_in = 1 + random.below(12);
    bool may_part = false; // bytes may be inputs: then peers may get different ones
    std::uint64_t hostile_packets = 0;
    h.liar.lie = [&](PeerId to, Message& m) {
        const Message truth = m;
        for (std::uint32_t more = random.below(lies_in); more > 0; --more, ++hostile_packets) {
            m = truth;
            if (how != 1) lie_in_fields(m, machines, random);
            const auto bytes = h.liar.written(m);
            std::vector<std::byte> packet(bytes.begin(), bytes.end());
            if (how != 0) packet = with_other_bytes(packet, h.liar.context.match, random), may_part = true;
            h.liar.real->send(to, packet);
        }
        m = truth;
        return how == 2 || random.below(4) != 0;
    };
    h.match.run(60 + random.below(240));
    if (fault == Fault::silent) h.match.machine(0).simulation->state().edit_bytes(0)[0] ^= std::byte{1};
    while (fault == Fault::hang) std::this_thread::sleep_for(std::chrono::seconds(1));
    if (machines == 4 && random.below(2) == 0) h.match.network.unplug(1 + random.below(2));
    h.match.run(300);
    figures["packets"] += hostile_packets;
    if (std::string wrong = parted(h, fault, may_part, figures); !wrong.empty()) return wrong;
    return stands_still(h);
}

} // namespace

int main(int argc, char** argv) {
    const attack::Options options = attack::read_options("peers", argc, argv);
    const Fault fault = options.planted == "silent" ? Fault::silent
                        : options.planted == "hang" ? Fault::hang
                                                    : Fault::none;
    return attack::run(options, [&](std::uint64_t number, attack::Figures& figures) {
        return one_match(options.seed * 1'000'003 + number, fault, figures);
    });
}
