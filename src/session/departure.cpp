// Departures: which machine leaves the match, and at which tick.
//
// One machine alone cannot remove another from a match of three or more. A machine votes for a peer to
// leave if the peer is silent, delays the match, or has dropped this machine. The peer has left when more
// than half of the machines that are still heard vote so; between two machines one vote is enough. From
// then on its inputs are ignored. No other machine may send them in its place, so they end at the cut: the
// smallest number of its inputs that a remaining machine has. No machine has confirmed a tick beyond the
// cut, because a tick is confirmed only when all others have acknowledged its inputs. All remaining
// machines announce their cut, the lowest is valid, and when all announce the same one the player is
// disconnected. If they cannot agree the match stops. A machine that joined after the cut has no vote on
// it. A machine that is about to join before the cut has one, so the cut is not settled until that join is.
#include "session/peer_session.h"

#include "base/text.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace lockstone::session {

void PeerSession::judge_peers() {
    if (is_dropped()) return stop("the other machines count this one as gone");
    find_silent_peers();
    find_late_peer();
    drop_unwanted_peers();
    if (has_come_in_vain()) return stop("the machines that let this one in count it as gone, or are gone");
    for (std::uint32_t p = 0; p < queues.size() && !stopped; ++p)
        if (is_gone(p)) agree_on_cut(p);
}

// ---- observations of this machine --------------------------------------------------------------------------------

bool PeerSession::has_dropped_us(const PeerLink& link) const {
    return link.state == PeerLink::State::connected && (link.says_gone & players_of(def.self)) != 0;
}

/// True if more than half of the heard machines have dropped this one. Never between two: each plays on
/// alone.
bool PeerSession::is_dropped() const {
    std::uint32_t others = 0, heard = 0, dropped_by = 0;
    for (const PeerLink& link : links) {
        if (link.state != PeerLink::State::gone) ++others;
        if (has_dropped_us(link)) ++dropped_by;
        if (has_dropped_us(link) || (link.state == PeerLink::State::connected && !link.unwanted)) ++heard;
    }
    return others > 1 && 2 * dropped_by > heard;
}

/// True if this machine joined, has confirmed no tick with the others yet, and all of them have left. To
/// play on would start a second match beside theirs, so the session stops; the machine may join again.
bool PeerSession::has_come_in_vain() const {
    return entry_tick > 0 && settled_end == entry_tick && !links.empty() &&
           std::ranges::all_of(links,
                               [](const PeerLink& link) { return link.state == PeerLink::State::gone; });
}

void PeerSession::find_silent_peers() {
    for (PeerLink& link : links) {
        if (link.state == PeerLink::State::gone) continue;
        const bool is_silent = link.state == PeerLink::State::connecting
                                   ? now - counts.first_poll_ms > def.connect_ms
                                   : now - link.heard_ms > def.disconnect_ms;
        if (is_silent || has_dropped_us(link)) find_fault_with(link);
    }
}

/// Votes for the peer to leave. The waiting times of the other peers start again from 0: they may have
/// waited for the same peer, and need time to detect that.
void PeerSession::find_fault_with(PeerLink& link) {
    if (std::exchange(link.unwanted, true)) return;
    for (PeerLink& other : links) other.waited_ms = 0;
}

/// Votes against a peer that has delayed the match for too long: of several, the one with the most votes
/// against it, then the one with the greatest id, so that all machines choose the same.
void PeerSession::find_late_peer() {
    PeerLink* late = nullptr;
    for (PeerLink& link : links) {
        if (link.state != PeerLink::State::connected || link.unwanted || link.waited_ms <= def.disconnect_ms)
            continue;
        if (late == nullptr || count_votes(link).against >= count_votes(*late).against) late = &link;
    }
    if (late != nullptr) find_fault_with(*late);
}

void PeerSession::count_waits(std::uint64_t passed_ms) {
    // The time in which this machine did not poll is not the peer's delay.
    constexpr std::uint64_t passed_max_ms = 250;
    const std::uint64_t passed = std::min(passed_ms, passed_max_ms);
    for (PeerLink& link : links) {
        if (owes_word(link))
            // The maximum factor: see README.md, Leaving.
            link.waited_ms += links.size() > 1 ? 2 * passed : passed;
        else if (is_awaited(link))
            link.waited_ms += passed;
    }
}

void PeerSession::make_up_for_waits() {
    const std::uint64_t made_up_ms = std::max<std::uint64_t>(100, def.disconnect_ms / 60);
    for (PeerLink& link : links) link.waited_ms -= std::min(link.waited_ms, made_up_ms);
}

/// True if the next tick waits for inputs of this peer, or for its announcement about a departure or a
/// join.
bool PeerSession::is_awaited(const PeerLink& link) const {
    if (link.state != PeerLink::State::connected || is_connecting()) return false;
    if (has_not_judged(link) || owes_join_word(link)) return true;
    const std::uint64_t settled = settled_through();
    return std::ranges::any_of(queues, [&](const InputQueue& queue) {
        const std::uint32_t p = queue.player();
        const bool tells_cut = link.cut[p] != never && link.cut[p] <= cuts[p];
        if (is_gone(p)) return !queue.disconnected() && !tells_cut && has_say_in_cut(link, p);
        return def.players[p] == link.peer && queue.next() == settled &&
               current >= settled + def.prediction_max;
    });
}

/// True if only this machine waits for the peer: for its hashes and acknowledgements. The others see only
/// that this machine does not advance. Therefore, among three or more machines, this waiting time counts
/// twice; after the vote this machine no longer needs the peer's hashes and acknowledgements.
bool PeerSession::owes_word(const PeerLink& link) const {
    if (link.state != PeerLink::State::connected || link.unwanted || is_connecting()) return false;
    if (link.hashes.exchanged_through() + history_confirmed_max <= confirmed) return true;
    const std::uint64_t fixed = fixed_through();
    // A tick without all inputs waits for the inputs only: no peer can acknowledge an input that has not
    // arrived here.
    const bool lacks_inputs = current >= settled_through() + def.prediction_max;
    const bool is_held = !lacks_inputs && current >= fixed + change_max;
    return std::ranges::any_of(queues, [&](const InputQueue& queue) {
        const std::uint32_t p = queue.player();
        if (is_gone(p) || def.players[p] == link.peer) return false;
        if (is_local(p) && queue.room() == 0 && link.next_input[p] <= queue.oldest()) return true;
        const bool is_needed = is_local(p) ? links.size() > 1 : is_heard(def.players[p]);
        return is_held && is_needed && link.next_input[p] <= fixed;
    });
}

/// True if the machine was heard recently, so that the other machines should have its inputs too. If it is
/// silent here it may be silent for all of them.
bool PeerSession::is_heard(PeerId peer) const {
    const auto link = std::ranges::find(links, peer, &PeerLink::peer);
    return link != links.end() && !link->unwanted && now - link->heard_ms <= def.disconnect_ms / 4;
}

/// True if this machine votes for another one to leave and the peer has not announced the same vote.
bool PeerSession::has_not_judged(const PeerLink& link) const {
    return std::ranges::any_of(links, [&](const PeerLink& other) {
        return &other != &link && other.unwanted && other.state != PeerLink::State::gone &&
               (link.says_unwanted & players_of(other.peer)) == 0;
    });
}

// ---- votes -------------------------------------------------------------------------------------------------------

/// Votes of this machine, and of the peers that it hears and does not vote against itself.
PeerSession::Votes PeerSession::count_votes(const PeerLink& accused) const {
    Votes votes{1, accused.unwanted ? 1u : 0u};
    for (const PeerLink& link : links) {
        if (&link == &accused || link.state != PeerLink::State::connected || link.unwanted) continue;
        ++votes.of;
        if ((link.says_unwanted & players_of(accused.peer)) != 0) ++votes.against;
    }
    return votes;
}

void PeerSession::drop_unwanted_peers() {
    for (bool again = true; std::exchange(again, false);) {
        for (PeerLink& link : links) {
            const Votes votes = count_votes(link);
            if (link.state == PeerLink::State::gone || 2 * votes.against <= votes.of) continue;
            link.state = PeerLink::State::gone;
            // A machine that joins and is silent delays the others until the timeout, so it must not do so
            // often.
            if (link.seat.entered_ms != 0 && now - link.seat.entered_ms < 12 * def.disconnect_ms)
                link.seat.not_before_ms = now + 12 * def.disconnect_ms;
            gone |= players_of(link.peer);
            send(link); // informs the peer without delay
            again = true;
        }
    }
}

Status PeerSession::drop_peer(PeerId peer) {
    PeerLink* link = find_link(peer);
    if (link == nullptr)
        return Error{base::join("drop_peer: machine ", peer, " is not a peer of this match")};
    find_fault_with(*link);
    return {};
}

// ---- the tick of a departure -------------------------------------------------------------------------------------

bool PeerSession::is_somebody_leaving() const {
    return std::ranges::any_of(
        queues, [&](const InputQueue& queue) { return is_gone(queue.player()) && !queue.disconnected(); });
}

/// True if the cut needs this peer's announcement. A machine that joined after the cut announces none: it
/// has no earlier inputs, and may know from the log that the player has left.
bool PeerSession::has_say_in_cut(const PeerLink& link, std::uint32_t player) const {
    const int first_player = std::countr_zero(players_of(link.peer));
    return since[static_cast<std::size_t>(first_player)] <= cuts[player];
}

void PeerSession::agree_on_cut(std::uint32_t player) {
    InputQueue& queue = queues[player];
    const auto remains = [](const PeerLink& link) { return link.state == PeerLink::State::connected; };
    if (queue.disconnected()) { // an honest machine no longer lowers the cut
        for (const PeerLink& link : links)
            if (remains(link) && cuts[player] != never && link.cut[player] < cuts[player])
                return stop_without_cut(player, link, cuts[player]);
        return;
    }
    // After a player has left, a machine accepts no more inputs of it, so the number of inputs that it has
    // is final.
    if (cuts[player] == never) {
        std::uint64_t fewest = queue.next();
        for (const PeerLink& link : links) {
            if (!remains(link)) continue;
            if ((link.says_gone >> player & 1u) == 0) return;
            fewest = std::min(fewest, link.next_input[player]);
        }
        cuts[player] = fewest;
    }
    bool all_tell_it = true;
    for (const PeerLink& link : links) {
        if (!remains(link)) continue;
        if (link.cut[player] < settled_end) return stop_without_cut(player, link, settled_end);
        cuts[player] = std::min(cuts[player], link.cut[player]);
    }
    for (const PeerLink& link : links)
        if (remains(link) && has_say_in_cut(link, player))
            all_tell_it = all_tell_it && link.cut[player] == cuts[player];
    if (!all_tell_it || is_entry_open(cuts[player])) return;
    queue.disconnect_at(cuts[player]);
    notices.emplace_back(std::in_place_type<PlayerDisconnected>,
                         PlayerDisconnected{player, def.players[player], cuts[player]});
}

void PeerSession::stop_without_cut(std::uint32_t player, const PeerLink& link, std::uint64_t here) {
    stop(base::join("machine ", link.peer + 1, " says that player ", player + 1, " left at tick ",
                    link.cut[player], ", but this machine has confirmed it up to tick ", here));
}

void PeerSession::stop(std::string reason) {
    stopped = true;
    notices.emplace_back(std::in_place_type<MatchStopped>, MatchStopped{std::move(reason)});
}

} // namespace lockstone::session
