// Leaving: who must go, and from which tick on.
//
// Nobody leaves on one machine's word. A machine wants a peer to leave when it has seen for itself that the peer is silent,
// keeps the match waiting, or has dropped it. The peer has left when most of those who are still heard want so; between
// two machines that is one. From then on its inputs are refused. No other machine's word stands for them, so where they
// end, the cut, is where the machine that remains and has the fewest of them ends. Nobody has confirmed a tick beyond
// it, because a tick is confirmed only when all others are known to have its inputs. All who remain tell their cut, the
// lowest holds, and when all tell the same the player is disconnected. Where they cannot agree the match stops. Who came
// in after the cut has no say in it; who is about to come in before it has one, so it is not settled until that is.
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

// ---- what this machine has seen for itself -----------------------------------------------------------------------

bool PeerSession::has_dropped_us(const PeerLink& link) const {
    return link.state == PeerLink::State::connected && (link.says_gone & players_of(def.self)) != 0;
}

/// Whether more than half of the machines that are heard have dropped this one. Between two never: each goes on alone.
bool PeerSession::is_dropped() const {
    std::uint32_t others = 0, heard = 0, dropped_by = 0;
    for (const PeerLink& link : links) {
        if (link.state != PeerLink::State::gone) ++others;
        if (has_dropped_us(link)) ++dropped_by;
        if (has_dropped_us(link) || (link.state == PeerLink::State::connected && !link.unwanted)) ++heard;
    }
    return others > 1 && 2 * dropped_by > heard;
}

/// This machine came in, has confirmed no tick with the others yet, and all of them are gone for it. If it went on it would play a match of
/// its own beside theirs. So it stops, and may come again.
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

/// From now on this machine wants the peer to leave. It begins to count anew how long it waits for the others: they may have waited for the
/// same peer, and need time to find that out.
void PeerSession::find_fault_with(PeerLink& link) {
    if (std::exchange(link.unwanted, true)) return;
    for (PeerLink& other : links) other.waited_ms = 0;
}

/// Finds fault with a peer that has kept the match waiting for too long. Among several it is the one that most others want to leave, then the
/// last by id, so that all machines choose the same.
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
    constexpr std::uint64_t passed_max_ms = 250; // nobody keeps a machine waiting that does not poll
    const std::uint64_t passed = std::min(passed_ms, passed_max_ms);
    for (PeerLink& link : links) {
        if (owes_word(link))
            link.waited_ms += links.size() > 1 ? 2 * passed : passed; // at most that: README.md, Leaving
        else if (is_awaited(link))
            link.waited_ms += passed;
    }
}

void PeerSession::make_up_for_waits() {
    const std::uint64_t made_up_ms = std::max<std::uint64_t>(100, def.disconnect_ms / 60);
    for (PeerLink& link : links) link.waited_ms -= std::min(link.waited_ms, made_up_ms);
}

/// Whether the next tick waits for this peer's inputs or for its word on a departure.
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

/// Whether the match waits here for what this peer owes to this machine alone: hashes and acknowledgements. The others see only that
/// this machine stands still. So where there are others, patience is half as long, and then this machine goes on without hashes and
/// acknowledgements of that peer.
bool PeerSession::owes_word(const PeerLink& link) const {
    if (link.state != PeerLink::State::connected || link.unwanted || is_connecting()) return false;
    if (link.hashes.exchanged_through() + history_confirmed_max <= confirmed) return true;
    const std::uint64_t fixed = fixed_through();
    // A tick that lacks inputs waits for these. Nobody owes an acknowledgement of an input that is not here.
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

/// Whether that machine is heard, so that others should have its inputs too. A machine that falls silent here may be silent to all of them.
bool PeerSession::is_heard(PeerId peer) const {
    const auto link = std::ranges::find(links, peer, &PeerLink::peer);
    return link != links.end() && !link->unwanted && now - link->heard_ms <= def.disconnect_ms / 4;
}

/// This machine wants another one to leave, and the peer has not said that it wants so too.
bool PeerSession::has_not_judged(const PeerLink& link) const {
    return std::ranges::any_of(links, [&](const PeerLink& other) {
        return &other != &link && other.unwanted && other.state != PeerLink::State::gone &&
               (link.says_unwanted & players_of(other.peer)) == 0;
    });
}

// ---- what most have seen -----------------------------------------------------------------------------------------

/// This machine votes, and so do the peers that it hears and does not want to leave itself.
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
            // Whoever comes in and is silent makes the others wait for as long as their patience lasts. It may not do so often.
            if (link.seat.entered_ms != 0 && now - link.seat.entered_ms < 12 * def.disconnect_ms)
                link.seat.not_before_ms = now + 12 * def.disconnect_ms;
            gone |= players_of(link.peer);
            send(link); // where it hears this, it knows at once
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

// ---- from which tick on ------------------------------------------------------------------------------------------

bool PeerSession::is_somebody_leaving() const {
    return std::ranges::any_of(
        queues, [&](const InputQueue& queue) { return is_gone(queue.player()) && !queue.disconnected(); });
}

/// Whether the cut waits for this peer's word. Who came in after the cut tells none: it has no input from before, and may know from the log
/// that the player has left.
bool PeerSession::has_say_in_cut(const PeerLink& link, std::uint32_t player) const {
    const int first_player = std::countr_zero(players_of(link.peer));
    return since[static_cast<std::size_t>(first_player)] <= cuts[player];
}

void PeerSession::agree_on_cut(std::uint32_t player) {
    InputQueue& queue = queues[player];
    const auto remains = [](const PeerLink& link) { return link.state == PeerLink::State::connected; };
    if (queue.disconnected()) { // nobody who is honest lowers it any more
        for (const PeerLink& link : links)
            if (remains(link) && cuts[player] != never && link.cut[player] < cuts[player])
                return stop_without_cut(player, link, cuts[player]);
        return;
    }
    // Once a player is gone for a machine it takes none of its inputs any more: how many it has is final.
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
                    link.cut[player], ", this machine has run it up to tick ", here, " for good"));
}

void PeerSession::stop(std::string reason) {
    stopped = true;
    notices.emplace_back(std::in_place_type<MatchStopped>, MatchStopped{std::move(reason)});
}

} // namespace lockstone::session
