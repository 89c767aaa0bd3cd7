// Admission: which machine joins late or returns, and at which tick.
//
// A machine whose players have left, or were never present, sends all others a request for its seat, with a
// ticket that counts its requests. The request names no seat: it is for the players of the sender. Each
// machine that receives the request itself answers yes with a tick. A machine that has not received it
// within a second after another machine's answer says no, and the ticket has failed. The latest of the
// ticks is valid. A machine that has received the same tick from all others announces ready; then it
// changes neither tick nor answer. If all are ready at the same tick the join is settled. Before that no
// machine confirms this tick or a later one. So two honest machines never settle different ticks, even if a
// third one sends each of them something else: each needs the answer of the other, and no honest machine
// gives two answers.
#include "session/peer_session.h"

#include "base/hash.h"

#include <algorithm>
#include <bit>

namespace lockstone::session {

namespace {
/// From the answer to the tick: time in which the answers reach all machines.
constexpr std::uint64_t join_lead_ticks = 60;
/// A request is valid for so long. After as long without it, a machine refuses a request that it knows only
/// from others.
constexpr std::uint64_t fresh_ms = 1000;
constexpr std::uint64_t told_ms = 10'000; ///< a refusal is announced for so long
} // namespace

PacketContext PeerSession::context_with(PeerId peer) const {
    PacketContext with = context;
    std::uint64_t newest = 0;
    for (std::uint32_t p = 0; p < def.players.size(); ++p)
        if (def.players[p] == peer || def.players[p] == def.self) newest = std::max(newest, since[p]);
    base::HashStream hash;
    hash.add(context.match);
    hash.add(newest);
    if (newest > 0) with.match = static_cast<std::uint32_t>(hash.digest());
    return with;
}

// ---- requests ----------------------------------------------------------------------------------------------------

std::optional<PacketFault> PeerSession::receive_wish(PeerLink& link, std::span<const std::byte> packet) {
    const std::optional<Wish> wish = read_wish(packet, context.match);
    if (!wish) return PacketFault::damaged;
    PeerLink::Seat& seat = link.seat;
    if (wish->ticket == 0 || wish->ticket < std::max(seat.wish, seat.ticket)) return PacketFault::implausible;
    if (link.state != PeerLink::State::gone && life_of(wish->ticket) > life_of(seat.ticket))
        find_fault_with(link); // the request proves that the machine has lost its state
    if (wish->wants_seat) {
        seat.wish = wish->ticket;
        seat.wish_ms = now;
        seat.asks = true;
    }
    timeline.hear(link.peer, *wish);
    return std::nullopt;
}

void PeerSession::serve_those_who_come() {
    std::vector<std::byte> packet;
    for (PeerLink& link : links) {
        const bool asks = std::exchange(link.seat.asks, false);
        if (!asks || !link.seat.is_settled) continue;
        // An admitted machine may send another request before it receives its admission: the answer names the
        // ticket of the admission.
        const std::uint32_t settled = link.seat.admission.ticket;
        const bool is_in = link.state != PeerLink::State::gone && life_of(link.seat.wish) == life_of(settled);
        if (link.seat.wish != settled && !is_in) continue;
        const std::uint32_t players = static_cast<std::uint32_t>(def.players.size());
        transport.send(link.peer, write_admission(packet, context.match, players, link.seat.admission));
    }
    timeline.serve(transport, inspector);
}

// ---- the answer of this machine ----------------------------------------------------------------------------------

/// The answers of the others to a joining machine are stored at their links, indexed by the first player of
/// that machine.
const JoinWord& PeerSession::word_of(const PeerLink& link, const PeerLink& seat) const {
    return link.words[static_cast<std::size_t>(std::countr_zero(players_of(seat.peer)))];
}

void PeerSession::apply_joins(PeerLink& link) {
    for (const JoinWord& word : incoming.join_words()) {
        JoinWord& known = link.words[word.player];
        // The stored answer is final.
        if (word.ticket == known.ticket && known.stand != JoinStand::yes) continue;
        known = word;
    }
}

/// True while a machine is joining: only one joins at a time.
bool PeerSession::is_admitting() const {
    return std::ranges::any_of(links, [&](const PeerLink& link) {
        return link.seat.stand && link.seat.stand->stand != JoinStand::no;
    });
}

bool PeerSession::may_come(const PeerLink& link) const {
    if (link.state != PeerLink::State::gone || is_admitting() || is_connecting() || is_somebody_leaving())
        return false;
    if (link.seat.wish <= link.seat.ticket || link.seat.wish == link.seat.refused ||
        now - link.seat.wish_ms > fresh_ms || now < link.seat.not_before_ms)
        return false;
    return std::ranges::all_of(queues, [&](const InputQueue& queue) { // all its earlier inputs are confirmed
        return def.players[queue.player()] != link.peer || queue.disconnected_at() <= confirmed;
    });
}

/// Not before the cut of a departure: a joining machine has none of the inputs that count until that tick.
std::uint64_t PeerSession::earliest_entry() const {
    std::uint64_t tick = current + join_lead_ticks;
    for (const InputQueue& queue : queues)
        if (is_gone(queue.player())) tick = std::max(tick, queue.disconnected_at());
    return tick;
}

void PeerSession::take_a_stand(PeerLink& link) {
    PeerLink::Seat& seat = link.seat;
    const std::uint32_t player = static_cast<std::uint32_t>(std::countr_zero(players_of(link.peer)));
    if (seat.stand && (seat.stand->stand != JoinStand::no || seat.is_settled)) return;
    if (seat.stand && now - seat.stand_ms > told_ms) seat.stand.reset();
    // The newest ticket that another machine accepts, if it is neither settled nor refused.
    std::uint32_t told = 0;
    for (const PeerLink& other : links) {
        const JoinWord& word = word_of(other, link);
        const bool is_over = word.ticket <= seat.ticket || word.ticket == seat.refused;
        if (&other != &link && other.state == PeerLink::State::connected && word.stand != JoinStand::no &&
            !is_over)
            told = std::max(told, word.ticket);
    }
    if (told == 0) seat.told_ms = now;
    if (may_come(link) && told <= seat.wish) {
        seat.stand = JoinWord{player, seat.wish, JoinStand::yes, earliest_entry()};
        seat.is_settled = false;
        seat.stand_ms = now;
    } else if (told != 0 && now - seat.told_ms > fresh_ms) {
        seat.stand = JoinWord{player, told, JoinStand::no, 0};
        seat.is_settled = false;
        seat.stand_ms = seat.told_ms = now;
        seat.refused = told;
        // A greater ticket is known only from others, who may have invented it.
        if (told <= seat.wish) seat.ticket = told;
    }
}

void PeerSession::admit() {
    for (PeerLink& link : links) {
        if (link.state == PeerLink::State::gone) take_a_stand(link);
        if (!link.seat.stand) continue;
        if (link.seat.is_settled && confirmed > link.seat.admission.tick)
            link.seat.stand.reset(); // the tick is confirmed, so all machines have settled it
        else if (!link.seat.is_settled && link.seat.stand->stand != JoinStand::no)
            agree_on_join(link);
    }
}

// ---- agreement ---------------------------------------------------------------------------------------------------

void PeerSession::agree_on_join(PeerLink& seat) {
    JoinWord& ours = *seat.seat.stand;
    bool all_tell_it = true, all_are_ready = true;
    const auto votes = [&](const PeerLink& link) {
        return &link != &seat && link.state == PeerLink::State::connected;
    };
    for (const PeerLink& link : links) {
        if (!votes(link)) continue;
        const JoinWord& word = word_of(link, seat);
        const bool is_over =
            word.ticket > ours.ticket || (word.ticket == ours.ticket && word.stand == JoinStand::no);
        // The answer ready is final: other machines may have settled the tick because of it.
        if (is_over && ours.stand != JoinStand::ready) {
            seat.seat.ticket = ours.ticket;
            ours = {ours.player, ours.ticket, JoinStand::no, 0};
            return;
        }
        if (word.ticket == ours.ticket && ours.stand == JoinStand::yes)
            ours.tick = std::max(ours.tick, word.tick);
    }
    for (const PeerLink& link : links) {
        if (!votes(link)) continue;
        const JoinWord& word = word_of(link, seat);
        const bool tells_it = word.ticket == ours.ticket && word.tick == ours.tick;
        all_tell_it = all_tell_it && tells_it;
        all_are_ready = all_are_ready && tells_it && word.stand == JoinStand::ready;
    }
    if (all_tell_it) ours.stand = JoinStand::ready;
    if (all_are_ready) settle_join(seat);
}

/// Makes the machine a peer like all others, present from that tick on.
void PeerSession::settle_join(PeerLink& link) {
    const std::uint64_t tick = link.seat.stand->tick;
    const std::uint32_t players = players_of(link.peer);
    gone &= ~players;
    for (PeerLink& other : links) other.says_unwanted &= ~players, other.says_gone &= ~players;
    for (std::uint32_t p = 0; p < queues.size(); ++p) {
        if ((players >> p & 1u) == 0) continue;
        queues[p].return_at(tick);
        since[p] = tick;
        cuts[p] = never;
        for (PeerLink& other : links) other.cut[p] = never, other.next_input[p] = tick;
        notices.emplace_back(std::in_place_type<PlayerJoined>, PlayerJoined{p, link.peer, tick});
    }
    PeerLink::Seat seat = link.seat;
    seat.is_settled = true;
    seat.ticket = seat.stand->ticket;
    seat.admission = {seat.ticket, tick, since};
    seat.entered_ms = std::max<std::uint64_t>(now, 1);
    link = PeerLink(link.peer, context_with(link.peer), tick);
    link.state = PeerLink::State::connected;
    link.heard_ms = now;
    link.seat = seat;
}

/// No tick from here on may be confirmed: inputs of a joining machine may count from it.
std::uint64_t PeerSession::join_bound() const {
    std::uint64_t bound = never;
    for (const PeerLink& link : links)
        if (link.seat.stand && link.seat.stand->stand != JoinStand::no && !link.seat.is_settled)
            bound = std::min(bound, link.seat.stand->tick);
    return bound;
}

/// True if ticks wait for an answer of this peer.
bool PeerSession::owes_join_word(const PeerLink& link) const {
    return std::ranges::any_of(links, [&](const PeerLink& seat) {
        if (&seat == &link || !seat.seat.stand || seat.seat.stand->stand == JoinStand::no ||
            seat.seat.is_settled)
            return false;
        const JoinWord &ours = *seat.seat.stand, &word = word_of(link, seat);
        const bool is_ready =
            word.ticket == ours.ticket && word.tick == ours.tick && word.stand == JoinStand::ready;
        return is_reached(ours.tick) && !is_ready;
    });
}

/// True if a machine may join before that cut. It would lack the inputs of the leaving player, which no
/// machine may send in that player's place.
bool PeerSession::is_entry_open(std::uint64_t cut) const { return join_bound() < cut; }

/// True if the match waits at that tick, or if a departure waits whose cut is after it.
bool PeerSession::is_reached(std::uint64_t tick) const {
    return settled_end >= tick || std::ranges::any_of(queues, [&](const InputQueue& queue) {
               const std::uint64_t cut = cuts[queue.player()];
               return is_gone(queue.player()) && !queue.disconnected() && cut != never && cut > tick;
           });
}

} // namespace lockstone::session
