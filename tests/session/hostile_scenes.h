// Attacks of one hostile machine of three or four, each with its expected outcome. The tests and the planted faults use
// this list.
#pragma once

#include "session/hostile.h"
#include "session/timeline.h"

namespace lockstone::test {

struct HostileScene {
    const char* name;
    std::function<std::string()> run; ///< returns an error sentence, or an empty string
};

namespace hostile {

using session::Message;

/// Runs ten more seconds, with the lies. Returns an error sentence unless the `honest` machines went on and treated the
/// liar as `liar` says: it stays, leaves, or either.
enum class Liar { stays, leaves, either };
inline std::string endured(HostileMatch& h, const std::vector<PeerId>& honest, Liar liar,
                           std::uint64_t ticks_least = 550) {
    h.match.run(600);
    if (std::string wrong = h.trouble(honest, ticks_least); !wrong.empty()) return wrong;
    for (const PeerId id : honest) {
        if (liar == Liar::leaves && !h.has_left(id, h.hostile)) return "the liar is still there";
        if (liar == Liar::stays && h.has_left(id, h.hostile)) return "the liar was thrown out";
    }
    return {};
}

inline void says_gone(Message& m, std::uint32_t players) {
    m.unwanted |= players;
    m.gone |= players;
    m.has_cut |= players;
    for (std::uint32_t p = 0; p < players_max; ++p) m.cut[p] = 5;
}

inline std::string word_against_one(std::uint32_t machines, bool to_all) {
    HostileMatch h(machines);
    h.match.run(120);
    h.liar.lie = [&](PeerId to, Message& m) {
        if (to == 0) says_gone(m, 1u << 1);
        if (to == 1 && to_all) says_gone(m, 1u << 0);
        return true;
    };
    std::vector<PeerId> honest;
    for (PeerId id = 0; id + 1 < machines; ++id) honest.push_back(id);
    return endured(h, honest, Liar::either);
}

inline std::string word_against_all() {
    HostileMatch h(3);
    h.match.run(120);
    h.liar.lie = [&](PeerId, Message& m) {
        says_gone(m, 3);
        return true;
    };
    return endured(h, {0, 1}, Liar::leaves);
}

/// The format cannot carry inputs of another machine's player. A lie can only claim to have more of them.
inline std::string claimed_inputs_of_the_gone() {
    HostileMatch h(4);
    h.match.run(120);
    int packets = 0;
    h.liar.lie = [&](PeerId, Message& m) {
        if ((m.unwanted >> 2 & 1u) == 0) return true;
        // The liar leaves these out for 40 packets: until all have dropped the machine, its inputs may grow.
        if (++packets < 40) m.gone = m.has_cut = 0;
        m.next_input[2] += 100;
        return true;
    };
    h.match.network.unplug(2);
    return endured(h, {0, 1}, Liar::either, 450);
}

inline std::string keep_alives_without(void (*what)(Message&), std::uint32_t machines,
                                       bool only_to_0 = false) {
    HostileMatch h(machines);
    h.match.run(120);
    Message frozen{};
    bool is_frozen = false;
    h.liar.lie = [&](PeerId to, Message& m) {
        if (to == 1 && only_to_0) return true;
        if (!is_frozen) frozen = m, is_frozen = true;
        m.next_input = what == nullptr ? frozen.next_input : m.next_input;
        if (what != nullptr) what(m);
        return true;
    };
    std::vector<PeerId> honest;
    for (PeerId id = 0; id + 1 < machines; ++id) honest.push_back(id);
    return endured(h, honest, only_to_0 ? Liar::either : Liar::leaves, 400);
}

/// Sends one input now and then, so it is never silent.
inline std::string dripped_inputs() {
    HostileMatch h(3);
    h.match.run(120);
    std::uint64_t allowed = 0, next_at = 0;
    h.liar.lie = [&](PeerId, Message& m) {
        if (h.match.now_ms >= next_at) ++allowed, next_at = h.match.now_ms + 900;
        for (std::uint32_t b = 0; b < m.block_count; ++b) m.blocks[b].count = std::min(m.blocks[b].count, 1u);
        if (h.match.now_ms + 30 < next_at && next_at - h.match.now_ms < 870) m.block_count = 0;
        return true;
    };
    return endured(h, {0, 1}, Liar::leaves, 250);
}

inline std::string far_behind() {
    HostileMatch h(3);
    h.match.run(120);
    h.liar.lie = [&](PeerId, Message& m) {
        if (m.quality) m.quality->ticks_ahead = -2'000'000'000;
        return true;
    };
    return endured(h, {0, 1}, Liar::stays, 580); // the others wait at most 8 of 68 frames
}

inline std::string flood() {
    HostileMatch h(3);
    h.match.run(120);
    std::vector<std::vector<std::byte>> packets;
    bool floods = true;
    h.liar.lie = [&](PeerId, Message& m) {
        if (!std::exchange(floods, false)) return true;
        const auto bytes = h.liar.written(m);
        const std::vector<std::byte> copy(bytes.begin(), bytes.end());
        for (int i = 0; i < 20'000; ++i) h.liar.real->send(0, copy);
        return true;
    };
    h.match.run(1);
    const SessionStats before = h.match.machine(0).session->stats();
    for (int i = 0; i < 30; ++i) {
        const SessionStats& stats = h.match.machine(0).session->stats();
        const std::uint64_t received = stats.packets_received;
        const std::uint64_t unread = stats.dropped[static_cast<std::size_t>(PacketFault::flood)];
        h.match.run(1);
        const std::uint64_t now_received = stats.packets_received - received;
        const std::uint64_t now_read =
            now_received - (stats.dropped[static_cast<std::size_t>(PacketFault::flood)] - unread);
        if (now_received > packets_per_poll_max) return "one poll took more packets than it may";
        if (now_read > 2 * packets_per_peer_max) return "one poll read more packets of a peer than it may";
    }
    if (h.match.machine(0).session->stats().packets_received - before.packets_received < 10'000)
        return "the flood did not arrive";
    return endured(h, {0, 1}, Liar::stays);
}

/// A machine between the peers replays old packets of a machine that is gone. In a pause the peers miss no inputs, so
/// only the silence of that machine can show that it is gone.
inline std::string replayed_packets(bool in_a_pause) {
    HostileMatch h(3);
    std::vector<std::pair<PeerId, std::vector<std::byte>>> old;
    h.liar.lie = [&](PeerId to, Message& m) {
        const auto bytes = h.liar.written(m);
        if (old.size() < 240) old.emplace_back(to, std::vector<std::byte>(bytes.begin(), bytes.end()));
        return true;
    };
    h.match.run(200);
    h.liar.lie = [](PeerId, Message&) { return false; };
    for (int i = 0; i < 600; ++i) {
        const auto& [to, bytes] = old[static_cast<std::size_t>(i) % old.size()];
        h.liar.real->send(to, bytes);
        if (in_a_pause && i < 240)
            h.match.pause();
        else
            h.match.run(1);
        if (in_a_pause && i == 240 && !h.has_left(0, 2)) return "old packets kept it alive through the pause";
    }
    if (std::string wrong = h.trouble({0, 1}, in_a_pause ? 450 : 600); !wrong.empty()) return wrong;
    return h.has_left(0, 2) && h.has_left(1, 2) ? "" : "old packets kept it alive";
}

inline std::string never_appears() {
    HostileMatch h(3, {.connect_ms = 2000});
    h.liar.lie = [](PeerId, Message&) { return false; };
    return endured(h, {0, 1}, Liar::leaves, 400);
}

/// Machine 2 fails, and the liar sends all others wrong facts about that departure.
inline std::string about_a_departure(const LyingTransport::Lie& lie, bool may_stop,
                                     std::uint64_t ticks_least = 400) {
    HostileMatch h(4);
    h.match.run(120);
    h.liar.lie = lie;
    h.match.network.unplug(2);
    h.match.run(600);
    const bool stopped =
        !h.match.notices<MatchStopped>(0).empty() || !h.match.notices<MatchStopped>(1).empty();
    if (!h.match.agree(0, 1)) return "the honest machines parted";
    if (stopped) return may_stop ? "" : "the match stopped";
    return h.trouble({0, 1}, ticks_least);
}

/// No machine lies. Two machines fail, and the remaining ones have received different numbers of their inputs.
inline std::string two_fail() {
    for (std::uint64_t seed = 1; seed <= 6; ++seed) {
        const bool lockstep = seed % 3 == 0;
        HostileMatch h(4, {.lockstep = lockstep,
                           .input_delay = lockstep ? 12u : 2u,
                           .link = {.latency_ms = 60, .jitter_ms = 30, .loss_permille = 100},
                           .seed = seed});
        h.match.run(200);
        h.match.network.set_link(3, 0, {.loss_permille = 1000});
        h.match.run(5);
        h.match.network.unplug(3);
        h.match.run(seed * 8);
        h.match.network.set_link(2, 1, {.loss_permille = 1000});
        h.match.run(4);
        h.match.network.unplug(2);
        h.match.run(600);
        if (std::string wrong = h.trouble({0, 1}, 450); !wrong.empty()) return wrong;
        if (!h.has_left(0, 2) || !h.has_left(1, 3)) return "who failed is still there";
    }
    return {};
}

/// The liar sends packets to machine 0 only.
inline std::string silent_to_one() {
    HostileMatch h(4);
    h.match.run(120);
    h.liar.lie = [](PeerId to, Message&) { return to == 0; };
    return endured(h, {0, 1, 2}, Liar::leaves, 450);
}

inline std::vector<HostileScene> hostile_to_all() {
    const auto no_inputs = [](Message& m) { m.block_count = 0; };
    const auto no_hashes = [](Message& m) { m.hash_count = 0; };
    const auto no_hash_acks = [](Message& m) { m.next_hash = 0; };
    const auto claims_most = [](Message& m) {
        m.block_count = 0;
        for (std::uint64_t& next : m.next_input) next += 100;
        m.next_input[0] = m.next_input[1] = 0;
    };
    return {
        {"tells one of three that another is gone", [] { return word_against_one(3, false); }},
        {"tells each of three that the other is gone", [] { return word_against_one(3, true); }},
        {"tells two of four that the other is gone", [] { return word_against_one(4, true); }},
        {"tells all that they are gone", word_against_all},
        {"claims inputs of a machine that is gone", claimed_inputs_of_the_gone},
        {"sends no inputs", [=] { return keep_alives_without(no_inputs, 3); }},
        {"sends no inputs, among four", [=] { return keep_alives_without(no_inputs, 4); }},
        {"sends no hashes", [=] { return keep_alives_without(no_hashes, 3); }},
        {"acknowledges no hashes", [=] { return keep_alives_without(no_hash_acks, 3); }},
        {"acknowledges no inputs", [] { return keep_alives_without(nullptr, 3); }},
        {"sends one of two no hashes", [=] { return keep_alives_without(no_hashes, 3, true); }},
        {"acknowledges no hashes of one of two", [=] { return keep_alives_without(no_hash_acks, 3, true); }},
        {"acknowledges no inputs to one of two", [] { return keep_alives_without(nullptr, 3, true); }},
        {"claims inputs and sends none", [=] { return keep_alives_without(claims_most, 3); }},
        {"drips inputs", dripped_inputs},
        {"says that it is far behind", far_behind},
        {"floods", flood},
        {"is replayed", [] { return replayed_packets(false); }},
        {"is replayed while the game is paused", [] { return replayed_packets(true); }},
        {"never appears", never_appears},
        {"is silent to two of three", silent_to_one},
    };
}

/// Attacks while another machine fails.
inline std::vector<HostileScene> hostile_at_departures() {
    return {
        {"does nothing while two machines fail", two_fail},
        {"does not see that a machine is gone",
         [] {
             return about_a_departure(
                 [](PeerId, Message& m) {
                     m.unwanted = m.gone = m.has_cut = 0;
                     return true;
                 },
                 false);
         }},
        {"claims fewer inputs of the one that is gone",
         [] {
             return about_a_departure(
                 [](PeerId to, Message& m) {
                     if (to == 1) m.next_input[2] -= 6;
                     return true;
                 },
                 true);
         }},
        {"tells each another cut",
         [] {
             return about_a_departure(
                 [](PeerId to, Message& m) {
                     if (m.has_cut != 0) m.cut[2] -= to;
                     return true;
                 },
                 true);
         }},
        {"tells a cut that is too late",
         [] {
             return about_a_departure(
                 [](PeerId, Message& m) {
                     if (m.has_cut != 0) m.cut[2] += 5;
                     m.unwanted &= 1u << 2, m.gone &= 1u << 2,
                         m.has_cut &= 1u << 2; // as if the liar need not wait
                     return true;
                 },
                 false, 500);
         }},
    };
}

/// No machine lies. The link from machine 3 to machine 1 is the slowest, so the others wait until machine 1
/// acknowledges those inputs. Then machine 2 receives nothing from machine 1 for less than half of the timeout, from
/// each moment of that wait on. Machine 2 stops, so the others lack its inputs; and it lacks machine 1's inputs from
/// the same tick on, so it has acknowledged none. That is one fault, not two.
inline std::string unheard_for_a_while(bool lockstep) {
    for (std::uint64_t moment = 0; moment < 13; ++moment) {
        Match match({.machines = 4,
                     .lockstep = lockstep,
                     .input_delay = lockstep ? 8u : 2u,
                     .disconnect_ms = 2000,
                     .link = {.latency_ms = 20}});
        match.network.set_link(3, 1, {.latency_ms = 200});
        match.run(120 + moment);
        match.network.set_link(1, 2, {.loss_permille = 1000});
        match.run(50);
        match.network.set_link(1, 2, {.latency_ms = 20});
        match.run(180);
        for (PeerId id = 0; id < 4; ++id) {
            if (!match.notices<PlayerDisconnected>(id).empty()) return "a machine was thrown out";
            if (!match.agree(id, 0)) return "the machines parted";
            if (match.machine(id).timeline.end() < 150) return "the match was held up";
        }
    }
    return {};
}

/// No machine lies. Machine 0 stops advancing, but its packets arrive. The others drop machine 0 and no other machine,
/// because none of the others is late.
inline std::string stands_still(bool lockstep) {
    Match match({.machines = 4,
                 .lockstep = lockstep,
                 .input_delay = lockstep ? 8u : 2u,
                 .disconnect_ms = 1000,
                 .link = {.latency_ms = 20}});
    match.run(120);
    for (int i = 0; i < 200; ++i) {
        match.machine(0).frames_to_wait = 1;
        match.run(1);
    }
    for (PeerId id = 1; id < 4; ++id) {
        const auto left = match.notices<PlayerDisconnected>(id);
        if (left.size() != 1 || left[0].peer != 0) return "another one was thrown out, or nobody";
        if (!match.agree(id, 1)) return "the machines parted";
    }
    return match.machine(1).timeline.end() > 220 ? "" : "the match was held up";
}

inline std::vector<HostileScene> honest_and_late() {
    return {
        {"one of lockstep does not hear another for a while", [] { return unheard_for_a_while(true); }},
        {"one does not hear another for a while", [] { return unheard_for_a_while(false); }},
        {"one of lockstep stands still", [] { return stands_still(true); }},
        {"one stands still", [] { return stands_still(false); }},
    };
}

/// Machine 1 of four loses its state and joins again, and the liar sends wrong facts about that join.
inline std::string about_a_join(const LyingTransport::Lie& lie, bool may_fail) {
    HostileMatch h(4);
    h.match.run(120);
    h.match.crash(1);
    h.match.run(150);
    h.liar.lie = lie;
    h.match.join(1);
    h.match.run(900);
    for (const PeerId a : {0u, 1u, 2u})
        for (const PeerId b : {0u, 1u, 2u})
            if (!h.match.agree(a, b)) return "the honest machines parted";
    if (may_fail) return {};
    if (h.match.notices<PlayerJoined>(0).size() != 1 || h.match.notices<PlayerJoined>(1).size() != 1)
        return "the machine did not come back";
    return h.match.machine(0).timeline.end() > 900 ? "" : "the match was held up";
}

/// The liar's vote arrives after the tick that the others proposed; they have waited at that tick.
inline std::string late_word() {
    const auto first = std::make_shared<std::uint64_t>(0);
    return about_a_join(
        [first](PeerId, Message& m) {
            if (m.join_count == 0) return true;
            if (*first == 0) *first = m.tick;
            if (m.joins[0].tick > 0 && ++*first < m.joins[0].tick + 100) m.join_count = 0;
            return true;
        },
        false);
}

/// The liar votes "ready" to one machine. To machine 2 it votes "yes", and then "no" after that machine is ready.
inline std::string no_to_who_is_ready() {
    const auto told = std::make_shared<int>(0);
    return about_a_join(
        [told](PeerId to, Message& m) {
            if (m.join_count == 0 || to != 2 || m.joins[0].stand != session::JoinStand::ready) return true;
            m.joins[0].stand = ++*told < 30 ? session::JoinStand::yes : session::JoinStand::no;
            return true;
        },
        true);
}

/// The liar votes for a join that no machine has requested.
inline std::string join_out_of_nothing(bool of_one_that_plays) {
    HostileMatch h(4);
    h.match.run(120);
    if (!of_one_that_plays) h.match.crash(1);
    h.match.run(200);
    h.liar.lie = [](PeerId, Message& m) {
        m.join_count = 1;
        m.joins[0] = {1, 300, session::JoinStand::ready, m.tick + 20};
        return true;
    };
    h.match.run(600);
    if (!h.match.notices<PlayerJoined>(0).empty()) return "a machine came in that did not ask";
    std::vector<PeerId> honest{0, 2};
    if (of_one_that_plays) honest.push_back(1);
    return h.trouble(honest, 700);
}

/// The liar names a ticket that no machine has sent, above the greatest valid one, and leaves. Then a machine joins
/// again.
inline std::string ticket_out_of_nothing() {
    HostileMatch h(4);
    h.match.run(120);
    h.match.crash(1);
    h.match.run(150);
    h.liar.lie = [](PeerId, Message& m) {
        m.join_count = 1;
        m.joins[0] = {1, 0xffff'ffff, session::JoinStand::yes, m.tick + 60};
        return true;
    };
    h.match.run(120); // the others have voted "no"
    h.match.crash(3);
    h.match.run(150);
    h.match.join(1);
    h.match.run(600);
    if (h.match.notices<PlayerJoined>(0).size() != 1 || h.match.notices<PlayerJoined>(1).size() != 1)
        return "the machine did not come back";
    return h.match.agree(0, 2) && h.match.agree(0, 1) ? "" : "the honest machines parted";
}

/// A dropped machine requests everything, with a new ticket in each frame and more packets than a poll reads.
inline std::string wishes_without_end() {
    HostileMatch h(3);
    h.match.run(120);
    h.match.crash(2);
    h.match.run(120);
    std::vector<std::byte> packet;
    const std::uint64_t before = h.match.machine(0).timeline.end();
    const std::uint64_t sent = h.match.network.counters().sent;
    std::uint64_t wishes = 0;
    for (std::uint32_t frame = 0; frame < 600; ++frame) {
        for (std::uint32_t n = 0; n < 100; ++n, ++wishes)
            h.match.network.endpoint(2).send(
                0, session::write_wish(packet, h.liar.context.match,
                                       {.wants_log = true,
                                        .wants_state = true,
                                        .wants_seat = n % 2 == 0,
                                        .ticket = 256 + frame,
                                        .wanted = frame % 3,
                                        .asked = before,
                                        .offered = n % 2 == 0 ? before : 0xffff'ffff}));
        h.match.run(1);
    }
    const std::uint64_t answers = h.match.network.counters().sent - sent - wishes - 2 * 600;
    if (answers > 5 * 600) return "more than five packets a poll were answered";
    if (h.match.machine(0).timeline.end() < before + 500) return "the match was held up";
    return h.match.agree(0, 1) ? "" : "the honest machines parted";
}

/// A machine joins, is silent, is dropped, and joins again. The others wait for it each time.
inline std::string comes_and_is_silent() {
    HostileMatch h(3);
    h.match.run(120);
    for (std::uint32_t life = 1; life <= 8; ++life) {
        h.match.crash(2);
        h.match.run(75);
        h.match.join(2, life);
        h.match.run(150);
    }
    if (h.match.notices<PlayerJoined>(0).size() > 2) return "it came in again and again";
    if (h.match.machine(0).timeline.end() < 1500) return "the match was held up";
    return h.match.agree(0, 1) ? "" : "the honest machines parted";
}

inline std::vector<HostileScene> hostile_at_joins() {
    const auto change_words = [](auto change) {
        return [change](PeerId to, Message& m) {
            for (std::uint32_t i = 0; i < m.join_count; ++i) change(to, m.joins[i]);
            return true;
        };
    };
    using session::JoinStand, session::JoinWord;
    return {
        {"tells each another join tick",
         [=] {
             return about_a_join(change_words([](PeerId to, JoinWord& word) { word.tick += to * 20; }), true);
         }},
        {"is ready before the others",
         [=] {
             return about_a_join(change_words([](PeerId, JoinWord& word) { word.stand = JoinStand::ready; }),
                                 true);
         }},
        {"is ready at another tick for each",
         [=] {
             return about_a_join(change_words([](PeerId to, JoinWord& word) {
                                     word.stand = JoinStand::ready, word.tick += to * 20;
                                 }),
                                 true);
         }},
        {"says no to some",
         [=] {
             return about_a_join(change_words([](PeerId to, JoinWord& word) {
                                     if (to == 2) word.stand = JoinStand::no;
                                 }),
                                 true);
         }},
        {"says no to who is ready", no_to_who_is_ready},
        {"tells its word late", late_word},
        {"lets one in that has not asked", [] { return join_out_of_nothing(false); }},
        {"lets one in that plays", [] { return join_out_of_nothing(true); }},
        {"tells of a ticket that nobody asked with", ticket_out_of_nothing},
        {"wishes without end", wishes_without_end},
        {"comes in and is silent", comes_and_is_silent},
        {"does nothing while one comes back",
         [] { return about_a_join([](PeerId, Message&) { return true; }, false); }},
    };
}

} // namespace hostile

inline std::vector<HostileScene> hostile_scenes() {
    std::vector<HostileScene> all = hostile::hostile_to_all();
    for (HostileScene& scene : hostile::hostile_at_joins()) all.push_back(std::move(scene));
    for (HostileScene& scene : hostile::hostile_at_departures()) all.push_back(std::move(scene));
    for (HostileScene& scene : hostile::honest_and_late()) all.push_back(std::move(scene));
    return all;
}

} // namespace lockstone::test
