// Relays whose host leaves or lies, and spectators that leave or are many, each with the expected outcome. For the
// tests and for the planted faults.
#pragma once

#include "session/hostile_scenes.h"
#include "session/join/relayed.h"

namespace lockstone::test {

namespace relays {

/// The relay turns to the next host, and all spectators keep watching. A spectator that comes later begins with a state
/// of that host.
inline std::string host_leaves() {
    RelayedMatch net(9, {.hosts = {0, 1}, .state_polls = 300});
    for (int i = 0; i < 8; ++i) net.watch(i % 2 == 1);
    net.run(400);
    if (net.relay->counters().host != 0) return "the relay has not asked the first one";
    net.lose(0);
    net.run(600);
    if (net.relay->counters().host != 1 || net.relay->counters().host_changes == 0)
        return "the relay has not asked the next one";
    if (net.furthest_behind() > RelayedMatch::near) return "who watches lost the match with its host";
    if (net.match.machine(2).timeline.ticks.back().statuses[0] != InputStatus::disconnected ||
        !net.match.agree(1, 2))
        return "the match did not go on without it";
    RelayedMatch::Watcher& late = net.watch(true);
    net.run(400);
    return net.behind(late) <= RelayedMatch::near ? "" : "who comes late does not see the match";
}

inline std::string watched_host_leaves() {
    JoinNet net(3);
    JoinNet::Guest& guest = net.watch({.hosts = {0, 1}});
    net.run(300);
    if (net.behind(guest) > 60) return "who watches is behind";
    net.network.unplug(0);
    net.run(600);
    if (!guest.notices_of<Desync>().empty()) return "a desync";
    return net.behind(guest) <= 60 ? "" : "who watches lost the match with its host";
}

/// A host sends a state of its own making, complete and well-formed.
inline std::string false_state() {
    RelayedMatch net(2, {.hosts = {0, 1}, .state_polls = 120});
    for (const auto& host : net.hosts) host->set_states(nullptr); // the false state is the only one
    std::vector<std::byte> buffer;
    const std::uint32_t match = session::packet_context(net.def).match;
    const std::vector<std::byte> image(500, std::byte{7});
    for (int frame = 0; frame < 400; ++frame) {
        net.run(1);
        const std::uint64_t next = net.relay->counters().next_tick;
        if (next < 2) continue;
        const session::Snapshot snapshot(next - 1, 12345, image);
        session::Chunk chunk;
        snapshot.chunk(0, chunk);
        Transport& host = net.upper.endpoint(0);
        host.send(RelayedMatch::relay_up, session::write_offer(buffer, match, snapshot.offer()));
        host.send(RelayedMatch::relay_up, session::write_chunk(buffer, match, chunk));
        if (net.relay->counters().state_tick != 0)
            return "a state was taken whose hash is not that of its tick";
    }
    return net.relay->counters().states_refused > 0 ? "" : "no false state was refused";
}

inline std::string silent_watchers() {
    RelayedMatch net(12, {.hosts = {0, 1}, .state_polls = 300});
    for (int i = 0; i < 12; ++i) net.watch(false);
    net.run(200);
    for (const auto& w : net.watchers) w->reads = false;
    net.run(70); // drains the packets under way
    const std::uint64_t before = net.relay->counters().bytes_to_watchers;
    net.run(300);
    return net.relay->counters().bytes_to_watchers == before ? "" : "who reads no more is sent on";
}

/// Returns the bytes that two hosts send while `count` spectators arrive in turn, every second one from a state.
inline std::uint64_t bytes_of_hosts(std::uint32_t count, RelayedMatch& net) {
    constexpr std::uint32_t frames = 1200, coming = 600;
    for (std::uint32_t frame = 0; frame < frames; ++frame) {
        while (net.watchers.size() < count && net.watchers.size() * coming <= std::uint64_t{frame} * count)
            net.watch(net.watchers.size() % 2 == 1);
        net.run(1);
    }
    return net.hosts[0]->bytes_sent() + net.hosts[1]->bytes_sent();
}
/// The most bytes that a player sends with many spectators, relative to one spectator [%].
inline constexpr std::uint64_t many_to_one_percent = 105;

inline std::string many_watchers(std::uint32_t count) {
    const SpectatorRelayDef def{.hosts = {0, 1}, .state_polls = 300};
    RelayedMatch one(1, def), many(count, def);
    const std::uint64_t for_one = bytes_of_hosts(1, one), for_many = bytes_of_hosts(count, many);
    if (std::max(one.furthest_behind(), many.furthest_behind()) > RelayedMatch::near)
        return "who watches is behind";
    if (many.relay->counters().watchers != count) return "not all watch";
    for (const auto& w : many.watchers)
        for (const Notice& notice : w->notices)
            if (!std::holds_alternative<PeerConnected>(notice))
                return "who watches is told more than of a connection";
    return for_many * 100 <= for_one * many_to_one_percent
               ? ""
               : "a player sends " + std::to_string(for_many) + " bytes for many who watch, " +
                     std::to_string(for_one) + " for one";
}

/// The log drops old ticks: a machine that joins then begins with a state, or sees no tick.
inline std::string long_match() {
    RelayedMatch net(3, {.hosts = {0, 1}, .log_ticks_max = 1024, .state_polls = 240});
    net.watch(false);
    for (int i = 0; i < 30; ++i) {
        net.run(100);
        if (net.relay->counters().log_bytes > 1024 * (6 + 3 * sizeof(Pad))) return "the log has no end";
    }
    if (net.relay->counters().first_tick <= 1000) return "old ticks are kept";
    RelayedMatch::Watcher &late = net.watch(true), &too_late = net.watch(false);
    net.run(400);
    if (late.timeline.first <= 2000 || !too_late.timeline.ticks.empty())
        return "who comes late begins elsewhere than with a state";
    return std::max(net.behind(*net.watchers[0]), net.behind(late)) <= RelayedMatch::near
               ? ""
               : "who watches is behind";
}

} // namespace relays

inline std::vector<HostileScene> relay_scenes() {
    return {
        {"a relay's host leaves", relays::host_leaves},
        {"a host that is watched leaves", relays::watched_host_leaves},
        {"a relay is sent a false state", relays::false_state},
        {"all who watch stop reading", relays::silent_watchers},
        {"thirty watch through a relay", [] { return relays::many_watchers(30); }},
        {"a match is longer than a relay's log", relays::long_match},
    };
}

} // namespace lockstone::test
