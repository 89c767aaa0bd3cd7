// Machines that come back and states that lie, each with the expected outcome. The tests and the planted faults use
// this list.
#pragma once

#include "session/hostile_scenes.h"
#include "session/join/join_net.h"

namespace lockstone::test {

namespace joins {

/// One machine loses its state, and comes back while the others wait for it or after that. Returns an error sentence or
/// an empty string.
inline std::string comes_back(std::uint32_t machines, std::uint64_t seed, std::uint64_t frames_away) {
    MatchDef def{.machines = machines,
                 .disconnect_ms = 1000,
                 .link = {.latency_ms = 60, .jitter_ms = 30, .loss_permille = 100},
                 .seed = seed};
    Match match(def);
    match.run(300);
    match.crash(1);
    match.run(frames_away);
    match.join(1);
    match.run(900);
    for (PeerId a = 0; a < machines; ++a) {
        for (PeerId b = 0; b < machines; ++b)
            if (!match.agree(a, b)) return "the machines parted";
        if (!match.notices<Desync>(a).empty()) return "a desync";
        if (match.notices<PlayerJoined>(a).size() != 1) return "it did not come back once";
        if (!match.machine(a).events.holds(match.machine(a).timeline.end()))
            return "an event has no end, or two";
        if (match.machine(a).timeline.end() < match.machine(0).timeline.end() - 60)
            return "a machine is behind";
    }
    if (match.machine(0).timeline.ticks.back().statuses[1] != InputStatus::confirmed)
        return "its inputs do not count";
    return match.machine(0).timeline.end() > 900 ? "" : "the match was held up";
}

/// All machines send machine 0 their requests first. It crashes so many frames after the last machine has begun to join
/// late (before, where the number is negative), and joins again at the end. No other machine stops, and both joins
/// succeed.
inline std::string first_goes(std::uint32_t machines, int frames_after) {
    MatchDef def{.machines = machines,
                 .disconnect_ms = 1000,
                 .link = {.latency_ms = 60, .jitter_ms = 30, .loss_permille = 100},
                 .absent = 1u << (machines - 1),
                 .seed = machines + static_cast<std::uint64_t>(frames_after + 1000)};
    const PeerId late = machines - 1;
    Match match(def);
    match.run(300);
    if (frames_after < 0) match.crash(0), match.run(static_cast<std::uint64_t>(-frames_after));
    match.join(late);
    if (frames_after >= 0) match.run(static_cast<std::uint64_t>(frames_after)), match.crash(0);
    match.run(900);
    if (!match.notices<MatchStopped>(late).empty()) { // machine 0 admitted it and crashed: it joins again
        match.crash(late), match.join(late, 2);
        match.run(900);
    }
    const std::uint64_t before = match.machine(1).timeline.end();
    if (before < 600) return "the match was held up";
    if (match.notices<PlayerJoined>(late).size() != 1) return "who comes late is not in";
    if (match.machine(1).timeline.ticks.back().statuses[late] != InputStatus::confirmed)
        return "the inputs of who came late do not count";
    if (match.machine(1).timeline.ticks.back().statuses[0] != InputStatus::disconnected)
        return "who has gone still has a say";
    match.join(0);
    match.run(900);
    for (PeerId a = 0; a < machines; ++a) {
        for (PeerId b = 0; b < machines; ++b)
            if (!match.agree(a, b)) return "the machines parted";
        if (!match.notices<Desync>(a).empty()) return "a desync";
        if (!match.notices<MatchStopped>(a).empty()) return "a match has stopped";
        if (match.machine(a).timeline.end() + 60 < match.machine(1).timeline.end())
            return "a machine is behind";
        for (const InputStatus status : match.machine(a).timeline.ticks.back().statuses)
            if (status != InputStatus::confirmed) return "somebody's inputs do not count";
    }
    return match.machine(1).timeline.end() > before + 600 ? "" : "the match was held up when it came back";
}

/// Machine 2 of four crashes before it has heard of machine 3, which joins late. One of machines 0 and 1 misses machine
/// 2 first and admits machine 3 before the departure is settled; the second machine admits it after that. Machine 3
/// gets its seat from machine 1. If machine 1 is the second one, the seat says that machine 2 has left.
inline std::string another_goes(PeerId misses_it_first) {
    MatchDef def{.machines = 4, .disconnect_ms = 1000, .link = {.latency_ms = 30}, .absent = 1u << 3};
    Match match(def);
    match.network.set_link(misses_it_first, 3, {.latency_ms = 200});
    match.run(300);
    match.join(3);
    match.run(10);
    match.network.set_link(2, misses_it_first, {.loss_permille = 1000});
    match.run(6);
    match.crash(2);
    match.run(600);
    for (const PeerId a : {0u, 1u, 3u}) {
        if (!match.agree(a, 0) || !match.agree(a, 1)) return "the machines parted";
        if (!match.notices<MatchStopped>(a).empty()) return "a match has stopped";
        if (match.notices<PlayerJoined>(a).size() != 1) return "who comes late is not in";
        if (match.machine(a).timeline.end() < 700) return "the match was held up";
        const std::vector<InputStatus>& last = match.machine(a).timeline.ticks.back().statuses;
        if (last[2] != InputStatus::disconnected) return "who has gone still has a say";
        if (last[3] != InputStatus::confirmed) return "the inputs of who came late do not count";
    }
    return "";
}

/// Machine 3 of four joins late and receives nothing from machine 2 from then on. The others advance with its first 30
/// inputs up to the limit of predictions. When they drop machine 2, its inputs end at the tick where machine 3 joined:
/// exactly those ticks run again.
inline std::string leaves_unheard() {
    MatchDef def{.machines = 4, .disconnect_ms = 1000, .link = {.latency_ms = 20}, .absent = 1u << 3};
    const std::uint64_t bound = 2 * def.prediction_max + 8;
    Match match(def);
    match.run(300);
    match.join(3);
    for (int i = 0; i < 600 && match.notices<PlayerJoined>(2).empty(); ++i) match.frame();
    if (match.notices<PlayerJoined>(2).empty()) return "it is not let in";
    const std::uint64_t tick = match.notices<PlayerJoined>(2)[0].tick;
    while (match.machine(2).session->current_tick() + def.input_delay + 1 < tick) match.frame();
    match.network.set_link(2, 3, {.loss_permille = 1000});
    match.run(2 * bound);
    for (const PeerId a : {0u, 1u})
        if (!match.machine(a).session->drop_peer(2)) return "machine 2 is unknown";
    match.run(600);
    for (const PeerId a : {0u, 1u, 3u}) {
        if (!match.agree(a, 0) || !match.agree(a, 1)) return "the machines parted";
        if (!match.notices<MatchStopped>(a).empty()) return "a match has stopped";
        const std::uint64_t depth = match.machine(a).session->stats().depth_max;
        if (a != 3 && depth != bound) return "a session went back by " + std::to_string(depth) + " ticks";
    }
    return match.machine(0).timeline.end() > 700 ? "" : "the match was held up";
}

/// The last of so many machines joins late. When machine `gone` has settled the seat, the machines before it crash:
/// they have sent that they are ready, but not that they settled the seat. From then on the others wait for the joined
/// machine as long as for the crashed ones. The join nevertheless succeeds at once and permanently.
inline std::string goes_when_settled(std::uint32_t machines, std::uint32_t gone) {
    MatchDef def{.machines = machines,
                 .disconnect_ms = 1000,
                 .link = {.latency_ms = 20},
                 .absent = 1u << (machines - 1)};
    const PeerId late = machines - 1;
    Match match(def);
    for (PeerId id = 0; id < gone; ++id) // these machines are the last to hear that the others are ready
        for (PeerId from = gone; from < late; ++from) match.network.set_link(from, id, {.latency_ms = 60});
    match.run(300);
    match.join(late);
    for (int i = 0; i < 600 && match.notices<PlayerJoined>(gone).empty(); ++i) match.frame();
    for (PeerId id = 0; id < gone; ++id) {
        if (!match.notices<PlayerJoined>(id).empty()) return "it goes too late";
        match.crash(id);
    }
    match.run(600);
    for (PeerId id = gone; id < machines; ++id) {
        if (!match.agree(id, gone) || !match.agree(id, late)) return "the machines parted";
        if (!match.notices<MatchStopped>(id).empty()) return "a match has stopped";
        if (match.notices<PlayerJoined>(id).size() != 1) return "who comes late is not in, or twice";
        if (match.notices<PlayerDisconnected>(id).size() != gone) return "somebody is thrown out";
        if (match.machine(id).timeline.end() < 700) return "the match was held up";
    }
    return match.machine(gone).timeline.ticks.back().statuses[late] == InputStatus::confirmed
               ? ""
               : "the inputs of who came late do not count";
}

/// Both others crash after they have admitted machine 2, before a tick was confirmed with it. Machine 2 does not
/// continue alone.
inline std::string all_go() {
    Match match({.machines = 3, .disconnect_ms = 1000, .link = {.latency_ms = 20}, .absent = 1u << 2});
    match.run(300);
    match.join(2);
    for (int i = 0; i < 600 && match.notices<PlayerJoined>(2).empty(); ++i) match.frame();
    if (match.notices<PlayerJoined>(2).empty()) return "it is not let in";
    match.crash(0), match.crash(1);
    match.run(300);
    return match.notices<MatchStopped>(2).size() == 1 ? "" : "it goes on alone";
}

/// Machine 2 crashes when its inputs reach beyond the tick where machine 3 joins. Machine 1 could not send machine 0
/// that it is ready for that tick, for `unheard` frames, so predictions reach far. Machine 3 has none of those inputs,
/// and the other two have them.
inline std::string goes_beyond_an_entry(std::uint64_t unheard) {
    MatchDef def{.machines = 4, .prediction_max = 40, .link = {.latency_ms = 20}, .absent = 1u << 3};
    Match match(def);
    match.run(300);
    if (!match.machine(1).session->drop_peer(2))
        return "machine 2 is unknown"; // only one of two machines drops it, so it stays
    match.run(10);
    match.join(3);
    match.run(2);
    match.network.set_link(1, 0, {.loss_permille = 1000});
    match.run(unheard);
    if (!match.machine(0).session->drop_peer(2)) return "machine 2 is unknown";
    match.crash(2);
    match.run(6);
    match.network.set_link(1, 0, {.latency_ms = 20});
    match.run(600);
    for (const PeerId a : {0u, 1u, 3u}) {
        if (!match.notices<MatchStopped>(a).empty()) return "a match has stopped";
        if (!match.agree(a, 0) || !match.agree(a, 3)) return "the machines parted";
        if (match.machine(a).timeline.end() < 700) return "the match was held up";
    }
    return match.machine(0).timeline.ticks.back().statuses[3] == InputStatus::confirmed
               ? ""
               : "the inputs of who came late do not count";
}

/// Machine 0 of three crashes, and the others have not received its newest inputs. Ticks that it has confirmed, shown
/// and recorded remain valid.
inline std::string goes_unheard(bool lockstep) {
    Match match({.machines = 3,
                 .lockstep = lockstep,
                 .input_delay = lockstep ? 8u : 2u,
                 .disconnect_ms = 1000,
                 .link = {.latency_ms = 20}});
    match.run(300);
    for (const PeerId to : {1u, 2u}) match.network.set_link(0, to, {.loss_permille = 1000});
    match.run(20);
    match.crash(0);
    match.run(300);
    if (match.machine(1).timeline.end() < 400) return "the match was held up";
    return match.agree(0, 1) && match.agree(0, 2) ? "" : "it has confirmed a tick that did not stay";
}

/// Machine 0 of three has left, but still sends hashes to machine 2, which joins late. Machine 2 reads them and does
/// not count them.
inline std::string has_left_and_talks() {
    MatchDef def{.machines = 3, .disconnect_ms = 1000, .link = {.latency_ms = 20}, .absent = 1u << 2};
    Match match(def);
    match.run(300);
    match.crash(0);
    match.run(150);
    match.join(2);
    std::vector<std::byte> packet;
    const std::uint32_t id = session::packet_context(match.session_def_of(2)).match;
    for (int i = 0; i < 900; ++i) {
        const Timeline& played = match.machine(1).timeline;
        const std::uint64_t tick = played.end() - 20;
        match.network.endpoint(0).send(2, session::write_word(packet, id, {tick, played.ticks[tick].hash}));
        match.frame();
    }
    if (match.notices<PlayerJoined>(2).size() != 1) return "who comes late is not in";
    return match.agree(1, 2) && match.notices<MatchStopped>(2).empty() ? "" : "it did not stay in";
}

/// A machine comes back, receives nothing for a while, then everything at once. It has run up to the limit of
/// predictions, and continues at once.
inline std::string hears_all_at_once(std::uint32_t machines, std::uint32_t inspected_ticks) {
    MatchDef def{.machines = machines, .disconnect_ms = 1000, .link = {.latency_ms = 20}};
    Match match(def);
    match.run(200);
    match.crash(1);
    match.run(150);
    match.def.inspected_ticks = inspected_ticks;
    match.join(1);
    const auto plays = [&] {
        const auto joined = match.notices<PlayerJoined>(1);
        return !joined.empty() && match.machine(1).session->current_tick() > joined[0].tick;
    };
    for (int i = 0; i < 1200 && !plays(); ++i) match.frame();
    if (!plays()) return "it did not come back";
    for (const std::uint32_t lost : {1000u, 0u}) {
        for (PeerId from = 0; from < machines; ++from)
            if (from != 1) match.network.set_link(from, 1, {.latency_ms = 20, .loss_permille = lost});
        match.run(lost != 0 ? 20 : 300); // the others have its first 30 inputs, so they continue
    }
    for (PeerId id = 0; id < machines; ++id) {
        if (!match.agree(0, id) || !match.notices<Desync>(id).empty()) return "the machines parted";
        if (!match.machine(id).events.holds(match.machine(id).timeline.end()))
            return "an event has no end, or two";
    }
    return match.machine(1).timeline.end() + 30 > match.machine(0).timeline.end() ? "" : "it is behind";
}

/// Every link has this latency, less than 3/16 of the timeout. The last of so many machines joins late, joins once and
/// stays.
inline std::string comes_from_afar(std::uint32_t machines, std::uint32_t way_ms) {
    MatchDef def{.machines = machines,
                 .prediction_max = 64,
                 .link = {.latency_ms = way_ms},
                 .absent = 1u << (machines - 1)};
    Match match(def);
    match.run(300);
    match.join(machines - 1);
    match.run(1500);
    for (PeerId id = 0; id < machines; ++id) {
        if (!match.agree(id, 0)) return "the machines parted";
        if (!match.notices<PlayerDisconnected>(id).empty()) return "somebody was thrown out";
        if (match.notices<PlayerJoined>(id).size() != 1) return "who comes late is not in, or twice";
    }
    return match.machine(0).timeline.ticks.back().statuses[machines - 1] == InputStatus::confirmed
               ? ""
               : "the inputs of who came late do not count";
}

/// A transport of machine 0 that changes one packet of the log to machine 2, or all of them: the packet names an end of
/// the match far beyond the true one.
struct FarEnd final : Transport {
    Transport* real = nullptr;
    bool always = false, has_lied = false;
    std::vector<std::byte> packet;
    void send(PeerId to, std::span<const std::byte> bytes) override {
        packet.assign(bytes.begin(), bytes.end());
        constexpr std::size_t end_at = 9; // after kind, match and first tick
        if (to == 2 && bytes[0] == std::byte{0x54} && (always || !std::exchange(has_lied, true))) {
            for (std::size_t i = 0; i < 4; ++i) packet[end_at + i] = std::byte{0xff};
            packet.resize(packet.size() - 4);
            session::add_checksum(packet);
        }
        real->send(to, packet);
    }
    std::optional<Datagram> receive() override { return real->receive(); }
};

/// Machine 0 hosts machine 2, which joins. It names a far end of the match, once before it leaves or in every packet.
inline std::string far_end(bool always) {
    FarEnd liar;
    liar.always = always;
    MatchDef def{.machines = 3, .disconnect_ms = 1000, .link = {.latency_ms = 20}, .absent = 1u << 2};
    def.through = [&liar](PeerId id, Transport& wire) -> Transport& {
        if (id != 0) return wire;
        liar.real = &wire;
        return liar;
    };
    Match match(def);
    match.run(200);
    match.join(2);
    for (int i = 0; i < 300 && !always && !liar.has_lied; ++i) match.frame();
    match.run(5);
    if (!always) match.crash(0);
    match.run(900);
    if (match.notices<PlayerJoined>(2).size() != 1) return "who comes late is not in";
    if (match.machine(1).timeline.end() < 900) return "the match was held up";
    return match.agree(1, 2) ? "" : "the machines parted";
}

/// Machine 0 of three, which the guest requests first, offers a changed state.
inline std::string lying_host() {
    JoinNet net(3);
    net.lie = [](PeerId from, Arena& shown) {
        if (from == 0) shown.state().edit_row(arena_columns().agent, 2).speed ^= 1;
    };
    net.run(300);
    JoinNet::Guest& guest = net.watch({.hosts = {0, 1, 2}, .from_state = true});
    net.run(600);
    if (guest.notices_of<StateRefused>().size() != 1) return "a false state was not refused";
    return net.behind(guest) <= 60 ? "" : "it did not see the match";
}

inline std::string damaged_chunk() {
    const session::Snapshot snapshot(77, 5, std::vector<std::byte>(7000));
    session::Assembly assembly(snapshot.offer());
    session::Chunk chunk;
    snapshot.chunk(3, chunk);
    std::vector<std::byte> bytes(chunk.bytes.begin(), chunk.bytes.end());
    bytes[500] = std::byte{1};
    chunk.bytes = bytes;
    return assembly.take(chunk) ? "a chunk was taken that is not what the root says" : "";
}

} // namespace joins

inline std::vector<HostileScene> join_scenes() {
    return {
        {"a damaged chunk is not taken", joins::damaged_chunk},
        {"a machine comes back among two", [] { return joins::comes_back(2, 2, 30); }},
        {"a machine comes back among three", [] { return joins::comes_back(3, 5, 300); }},
        {"one of two comes back and hears all at once", [] { return joins::hears_all_at_once(2, 64); }},
        {"it keeps no states for inquiries", [] { return joins::hears_all_at_once(2, 0); }},
        {"one of three comes back and hears all at once", [] { return joins::hears_all_at_once(3, 64); }},
        {"the first goes before the last comes late", [] { return joins::first_goes(3, -300); }},
        {"it goes while it gives its state", [] { return joins::first_goes(3, 20); }},
        {"it goes when it has given its state", [] { return joins::first_goes(3, 22); }},
        {"it goes while the last comes", [] { return joins::first_goes(4, 40); }},
        {"it goes when it has let another one in", [] { return joins::first_goes(3, 54); }},
        {"it goes while others wait for it", [] { return joins::first_goes(4, -20); }},
        {"another one goes, and has left for who comes", [] { return joins::another_goes(0); }},
        {"another one goes, and is there for who comes", [] { return joins::another_goes(1); }},
        {"the first goes when another one has settled the seat",
         [] { return joins::goes_when_settled(3, 1); }},
        {"twelve go when the others have", [] { return joins::goes_when_settled(16, 12); }},
        {"all go when they have let one in", joins::all_go},
        {"one goes whose inputs reach beyond an entry", [] { return joins::goes_beyond_an_entry(90); }},
        {"one goes whose newest inputs nobody has", [] { return joins::goes_unheard(false); }},
        {"one of lockstep goes whose newest inputs nobody has", [] { return joins::goes_unheard(true); }},
        {"one that has left talks on to who comes", joins::has_left_and_talks},
        {"one leaves whom who came in has not heard", joins::leaves_unheard},
        {"a host that lies is found out", joins::lying_host},
        {"one comes late from afar", [] { return joins::comes_from_afar(3, 600); }},
        {"a host tells a far end once, and goes", [] { return joins::far_end(false); }},
        {"a host tells a far end all the time", [] { return joins::far_end(true); }},
    };
}

} // namespace lockstone::test
