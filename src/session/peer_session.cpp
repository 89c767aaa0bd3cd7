#include "session/peer_session.h"

#include "base/assert.h"
#include "base/text.h"

#include <algorithm>

namespace lockstone::session {

namespace {
/// After a join, the first inputs of a machine are zero for so many ticks: the time until its inputs reach
/// the others.
constexpr std::uint64_t neutral_ticks = 30;
constexpr std::uint64_t seat_silence_polls = 600, seat_log_ticks = 7200;
} // namespace

PeerSession::PeerSession(const SessionDef& session_def, Transport& packets, const Entry& entry)
    : def(session_def), transport(packets), context(packet_context(session_def)), has_run(entry.tick == 0),
      since(entry.since), entry_tick(entry.tick),
      catch_up_end(entry.tick == 0 ? 0 : entry.tick + neutral_ticks),
      timeline(session_def, {.log_ticks_max = seat_log_ticks,
                             .delay_ticks = 0,
                             .listeners_max = players_max,
                             .silence_polls = seat_silence_polls,
                             .keeps_unheard = false}),
      current(entry.tick), settled_end(entry.tick), confirmed(entry.tick), hashes(history_ticks) {
    cuts.fill(never);
    gone = entry.tick == 0 ? def.absent : entry.left;
    for (std::uint32_t p = 0; p < def.players.size(); ++p) {
        InputQueue& queue = queues.emplace_back(p, def.input_size);
        queue.begin_at(entry.tick);
        if (is_gone(p)) queue.disconnect_at(entry.tick);
        if (!is_local(p)) continue;
        ++counts.local_players;
        const std::array<std::byte, input_bytes_max> nothing{};
        queue.set_before_begin(std::span(nothing).first(def.input_size));
        while (queue.next() < catch_up_end) queue.confirm(std::span(nothing).first(def.input_size));
    }
    std::vector<PeerId> peers = def.players;
    std::ranges::sort(peers);
    peers.erase(std::unique(peers.begin(), peers.end()), peers.end());
    for (const PeerId peer : peers) {
        if (peer == def.self) continue;
        PeerLink& link = links.emplace_back(peer, context_with(peer), entry.tick);
        // The admission proves that this peer is in the match.
        if (entry.tick > 0) link.state = PeerLink::State::connected;
        if ((gone & players_of(peer)) != 0) link.state = PeerLink::State::gone, link.unwanted = true;
    }
    // Among three or more machines a departure may revoke true inputs until all machines have acknowledged
    // them. The acknowledgement takes a round trip, a prediction waits for one way only, so the bound
    // is larger. Lockstep revokes nothing and waits instead.
    constexpr std::uint64_t polls_between = 8;
    const bool predicts = def.prediction_max > 0;
    change_max = links.size() > 1 && predicts ? 2 * def.prediction_max + polls_between : def.prediction_max;
    requests.reserve(2 * (change_max + 2 + catch_up_ticks));
    inputs.reserve((change_max + 3 + catch_up_ticks) * def.players.size());
    foreseen_bytes.reserve(def.players.size() * def.input_size);
    foreseen.reserve(def.players.size());
    notices.reserve(links.size() * 3 + def.players.size());
}

// ---- inputs ------------------------------------------------------------------------------------------------------

void PeerSession::add_local_input(std::uint32_t player, std::span<const std::byte> input) {
    LOCKSTONE_ASSERT(player < queues.size() && is_local(player), "player ", player, " does not play here");
    InputQueue& queue = queues[player];
    const std::uint64_t target = current + def.input_delay;
    // The delay has increased, or the match begins. The ticks between repeat the last input, zeros at the
    // start of a match.
    std::array<std::byte, input_bytes_max> before{};
    if (queue.next() > 0) std::ranges::copy(queue.confirmed(queue.next() - 1), before.begin());
    while (queue.next() < target && queue.room() > 1) queue.confirm(std::span(before).first(def.input_size));
    if (queue.next() == target && queue.room() > 0) queue.confirm(input);
}

void PeerSession::set_inputs_before(std::span<const PlayerInput> before) {
    for (InputQueue& queue : queues)
        if (!is_local(queue.player())) queue.set_before_begin(before[queue.player()].bytes);
}

void PeerSession::set_input_delay(std::uint32_t ticks) {
    LOCKSTONE_ASSERT(ticks <= input_delay_limit && (ticks > 0 || def.prediction_max > 0), ticks, " ticks");
    def.input_delay = ticks;
}

std::span<const PlayerInput> PeerSession::look_ahead(std::uint32_t offset) {
    if (offset >= def.run_ahead || stopped || is_connecting()) return {};
    foreseen_bytes.resize(def.players.size() * def.input_size);
    foreseen.clear();
    for (const InputQueue& queue : queues) {
        const auto to = std::span(foreseen_bytes).subspan(queue.player() * def.input_size, def.input_size);
        const InputStatus status =
            queue.foresee(current + offset, *def.predictor, is_local(queue.player()), to);
        foreseen.push_back({to, status});
    }
    return foreseen;
}

std::uint64_t PeerSession::settled_through() const {
    std::uint64_t end = never;
    for (const InputQueue& queue : queues) end = std::min(end, queue.settled_through());
    return end;
}

/// The own inputs count as well. If this machine leaves, its inputs end where the others have them, but
/// ticks that it has confirmed until then are already displayed, recorded and sent to machines that join.
/// Two machines do not wait for that, because it would take a round trip.
std::uint64_t PeerSession::agreed_through() const {
    const bool are_two = links.size() == 1;
    std::uint64_t end = never;
    for (const PeerLink& link : links) {
        if (link.state != PeerLink::State::connected || link.unwanted) continue;
        for (const InputQueue& queue : queues) {
            const std::uint32_t p = queue.player();
            if ((is_local(p) && are_two) || is_gone(p) || def.players[p] == link.peer) continue;
            end = std::min(end, link.next_input[p]);
        }
    }
    return end;
}

/// During a departure no further tick is fixed: the inputs of the player may end at any tick from here on.
std::uint64_t PeerSession::fixed_through() const {
    if (is_somebody_leaving()) return settled_end;
    return std::min(std::min(settled_through(), agreed_through()), join_bound());
}

bool PeerSession::is_connecting() const {
    return std::ranges::any_of(
        links, [](const PeerLink& link) { return link.state == PeerLink::State::connecting; });
}

std::uint64_t PeerSession::take_first_wrong() {
    std::uint64_t wrong = never;
    for (InputQueue& queue : queues) wrong = std::min(wrong, queue.take_first_wrong());
    return wrong;
}

/// An input is kept until its tick is confirmed here. An input of a local player is also kept until every
/// peer has it; for a peer that this machine votes against, only as long as there is space.
void PeerSession::forget_old_inputs() {
    for (InputQueue& queue : queues) {
        std::uint64_t needed_from = confirmed;
        for (const PeerLink& link : links) {
            if (link.state == PeerLink::State::gone || !is_local(queue.player())) continue;
            const std::uint64_t lacks_from = link.next_input[queue.player()];
            const std::uint64_t newest_kept =
                queue.next() - std::min(queue.next(), history_confirmed_max - 1);
            needed_from =
                std::min(needed_from, link.unwanted ? std::max(lacks_from, newest_kept) : lacks_from);
        }
        queue.forget_before(needed_from);
    }
}

// ---- confirmed ticks and their hashes ----------------------------------------------------------------------------

HashCheck PeerSession::report_hash(std::uint64_t tick, std::uint64_t hash) {
    LOCKSTONE_ASSERT(tick >= confirmed && tick < current, "tick ", tick, " of [", confirmed, ", ", current,
                     ")");
    hashes[tick % history_ticks] = hash;
    return HashCheck::accepted;
}

std::optional<ConfirmedTick> PeerSession::next_confirmed() {
    if (confirmed == settled_end) return std::nullopt;
    inputs.clear();
    for (const InputQueue& queue : queues) inputs.push_back(queue.settled(confirmed));
    const ConfirmedTick tick{confirmed, inputs, local_hash(confirmed)};
    timeline.add(tick.tick, tick.inputs, tick.hash);
    ++confirmed;
    return tick;
}

// ---- notices -----------------------------------------------------------------------------------------------------

std::optional<Notice> PeerSession::next_notice() {
    if (notices_taken == notices.size()) {
        notices.clear();
        notices_taken = 0;
        return std::nullopt;
    }
    return notices[notices_taken++];
}

PeerLink* PeerSession::find_link(PeerId peer) {
    const auto found = std::ranges::find(links, peer, &PeerLink::peer);
    return found == links.end() ? nullptr : &*found;
}

PeerQuality PeerSession::quality(PeerId peer) const {
    const auto link = std::ranges::find(links, peer, &PeerLink::peer);
    if (link == links.end()) return {};
    return {link->state == PeerLink::State::connected, link->ping_ms, link->time_sync.ticks_ahead(),
            link->hashes.agreed_through()};
}

/// Returns the lead over the slowest peer [ticks], at most once in 60 ticks, because a wait takes time to
/// show in the measured lead. A true lead never exceeds the number of ticks that the session runs ahead, so
/// the result is limited to it: a greater value is a false report of a peer.
std::uint32_t PeerSession::wait_recommended() {
    constexpr std::uint64_t ticks_between = 60;
    constexpr std::int32_t worth_waiting = 2;
    if (current < next_wait_at) return 0;
    std::int32_t lead = 0;
    for (const PeerLink& link : links) {
        if (link.state == PeerLink::State::connected) lead = std::max(lead, link.time_sync.ticks_ahead());
    }
    const std::uint32_t lead_max = def.prediction_max > 0 ? def.prediction_max : def.input_delay;
    lead = std::min(lead, static_cast<std::int32_t>(lead_max));
    if (lead < worth_waiting) return 0;
    next_wait_at = current + ticks_between;
    return static_cast<std::uint32_t>(lead);
}

} // namespace lockstone::session

namespace lockstone {

namespace {

class RepeatLastInput final : public InputPredictor {
  public:
    void predict(std::uint32_t, std::span<const std::byte> last, std::uint64_t,
                 std::span<std::byte> out) const override {
        std::ranges::copy(last, out.begin());
    }
};

} // namespace

const InputPredictor& repeat_last_input() {
    static const RepeatLastInput repeat_last;
    return repeat_last;
}

} // namespace lockstone
