#include "session/join/spectator.h"

#include "base/assert.h"
#include "base/bytes.h"
#include "base/text.h"

#include <algorithm>

namespace lockstone::session {

namespace {
/// A machine has caught up if it is at most so many ticks behind the newest available one.
constexpr std::uint64_t near_ticks = 8;
constexpr std::uint32_t patience_polls = 300; ///< maximum silence of a host during the transfer of a state
constexpr std::uint32_t word_polls = 180;     ///< maximum waiting time for the hashes of other machines
} // namespace

SpectatorSession::SpectatorSession(const SessionDef& session_def, WatchDef how, Transport& packets)
    : def(session_def), watch(std::move(how)), transport(packets), match(packet_context(session_def).match),
      tick_bytes(tick_bytes_of(session_def)), phase(watch.from_state ? Phase::fetching : Phase::following),
      ticks(tick_bytes), hashes(history_ticks) {
    for (const PeerId peer : watch.hosts) hosts.push_back({peer, {}, {}});
    requests.reserve(watch.ticks_per_frame);
    inputs.reserve((watch.ticks_per_frame + 1) * def.players.size());
}

// ---- packets -----------------------------------------------------------------------------------------------------

void SpectatorSession::poll(std::uint64_t now_ms) {
    begin_poll(now_ms);
    for (std::uint32_t i = 0; i < packets_per_poll_max; ++i) {
        const std::optional<Datagram> datagram = transport.receive();
        if (!datagram) break;
        count(*datagram, take(*datagram));
    }
    speak(0, false);
}

void SpectatorSession::begin_poll(std::uint64_t now_ms) {
    if (counts.packets_sent == 0) counts.first_poll_ms = now_ms;
    counts.last_poll_ms = std::max(counts.last_poll_ms, now_ms);
    for (Host& host : hosts) host.packets_read = 0;
}

void SpectatorSession::count(const Datagram& datagram, std::optional<PacketFault> fault) {
    ++counts.packets_received;
    counts.bytes_received += datagram.bytes.size();
    const auto from = std::ranges::find(hosts, datagram.from, &Host::peer);
    if (!fault && from != hosts.end()) from->heard_ms = counts.last_poll_ms;
    if (!fault) return;
    ++counts.packets_dropped;
    ++counts.dropped[static_cast<std::size_t>(*fault)];
}

std::optional<PacketFault> SpectatorSession::take(const Datagram& datagram) {
    const auto from = std::ranges::find(hosts, datagram.from, &Host::peer);
    if (from == hosts.end()) return PacketFault::stranger;
    if (++from->packets_read > packets_per_peer_max) return PacketFault::flood;
    return take(*from, datagram.bytes);
}

std::optional<PacketFault> SpectatorSession::take(Host& from, std::span<const std::byte> bytes) {
    const bool is_serving = &from == &hosts[serving];
    if (const auto stretch = read_stretch(bytes, match, tick_bytes)) {
        if (!is_serving || phase != Phase::following) return PacketFault::implausible;
        take_stretch(*stretch);
        return std::nullopt;
    }
    if (const auto offer = read_offer(bytes, match)) {
        if (!is_serving || phase != Phase::fetching) return PacketFault::implausible;
        take_offer(*offer);
        return std::nullopt;
    }
    if (const auto chunk = read_chunk(bytes, match)) {
        if (!is_serving || !assembly || !assembly->take(*chunk)) return PacketFault::implausible;
        polls_without_progress = 0;
        return std::nullopt;
    }
    if (const auto word = read_word(bytes, match)) {
        take_word(from, *word);
        return std::nullopt;
    }
    return PacketFault::damaged;
}

void SpectatorSession::take_stretch(const Stretch& stretch) {
    if (stretch.count == 0 && stretch.first > ticks.next()) {
        hosts[serving].log_begin = stretch.first;
        return;
    }
    if (!std::exchange(connected, true))
        notices.emplace_back(std::in_place_type<PeerConnected>, PeerConnected{hosts[serving].peer});
    live_end = has_told_end ? std::max(live_end, stretch.end) : stretch.end;
    has_told_end = true;
    ticks.take(stretch, confirmed);
}

void SpectatorSession::take_offer(const Offer& offer) {
    // An old offer that was under way, or the current one again.
    if (assembly && assembly->offer().tick >= offer.tick) return;
    if (offer.bytes > watch.state_bytes_max)
        return refuse(base::join("its state has ", offer.bytes, " bytes, at most ", watch.state_bytes_max,
                                 " are taken"));
    if (!assembly) polls_without_progress = 0; // a changed offer does not count as progress
    assembly.emplace(offer);
    for (Host& host : hosts) host.state_hash.reset();
    hosts[serving].state_hash = offer.hash;
    polls_with_state = 0;
}

void SpectatorSession::take_word(Host& from, const Word& word) {
    if (phase == Phase::fetching && assembly && word.tick + 1 == assembly->offer().tick &&
        &from != &hosts[serving])
        from.state_hash = word.hash;
    if (phase != Phase::following || word.tick < first || word.tick >= confirmed ||
        word.tick + history_ticks < confirmed)
        return;
    const std::uint64_t ours = hashes[word.tick % history_ticks];
    from.agrees = ours == word.hash;
    if (*from.agrees || std::exchange(from.differs_told, true)) return;
    notices.emplace_back(std::in_place_type<Desync>,
                         Desync{word.tick, static_cast<std::uint32_t>(ours),
                                static_cast<std::uint32_t>(word.hash), from.peer});
}

/// Sends the serving host a request for ticks or for a state, and the others a request for a hash; each
/// contains the ticket.
void SpectatorSession::speak(std::uint32_t ticket, bool wants_seat) {
    judge_state();
    judge_host();
    if (phase == Phase::stopped) return;
    Wish wish;
    wish.ticket = ticket;
    wish.wants_seat = wants_seat;
    if (phase == Phase::fetching) {
        wish.wants_state = true;
        if (assembly) {
            wish.offered = assembly->offer().tick;
            wish.missing = assembly->missing();
            wish.have = assembly->have_after_missing();
        }
    } else if (phase == Phase::following) {
        wish.wants_log = true;
        wish.wanted = ticks.next();
    }
    send_wish(hosts[serving].peer, wish);
    Wish question;
    question.ticket = ticket;
    question.wants_seat = wants_seat;
    if (phase == Phase::fetching && assembly) question.asked = assembly->offer().tick - 1;
    if (phase == Phase::following && confirmed > first) question.asked = confirmed - 1;
    if (question.asked == no_tick && ticket == 0) return;
    for (std::size_t h = 0; h < hosts.size(); ++h)
        if (h != serving) send_wish(hosts[h].peer, question);
}

void SpectatorSession::send_wish(PeerId to, const Wish& wish) {
    const std::span<const std::byte> out = write_wish(packet, match, wish);
    transport.send(to, out);
    ++counts.packets_sent;
    counts.bytes_sent += out.size();
}

// ---- start from a state ------------------------------------------------------------------------------------------

/// Refuses a state that does not arrive in time. Accepts the complete state only if more machines report
/// its hash than another hash. A report of the sender alone is enough only after word_polls polls without a
/// report of another machine, or if there is no other host.
void SpectatorSession::judge_state() {
    if (phase != Phase::fetching) return;
    if (++polls_without_progress > patience_polls) return refuse("it sends no state");
    const std::uint32_t most_polls = polls_for_state(assembly ? assembly->missing() : 0);
    if (!assembly || !assembly->is_complete()) {
        if (++polls_fetching > most_polls) refuse("it sends its state too slowly");
        return;
    }
    ++polls_with_state;
    std::size_t same = 0, other = 0;
    for (const Host& host : hosts)
        if (host.state_hash) ++(*host.state_hash == assembly->offer().hash ? same : other);
    if (other >= same)
        return refuse(
            base::join(other, " of ", same + other, " machines tell another hash than that of its state"));
    const bool is_waiting = polls_with_state < word_polls;
    if (same + other < 2 && hosts.size() > 1 && is_waiting) return;
    phase = Phase::adopting;
}

void SpectatorSession::refuse(std::string reason) {
    notices.emplace_back(std::in_place_type<StateRefused>,
                         StateRefused{hosts[serving].peer, std::move(reason)});
    next_host();
}

bool SpectatorSession::is_heard(PeerId peer, std::uint64_t since_ms) const {
    const auto host = std::ranges::find(hosts, peer, &Host::peer);
    return host != hosts.end() && counts.last_poll_ms - std::max(host->heard_ms, since_ms) <= gone_after_ms;
}

/// The next host that was heard recently. Silent hosts are skipped, so that no time is lost with each of
/// them.
std::optional<std::size_t> SpectatorSession::next_heard() const {
    for (std::size_t i = 1; i < hosts.size(); ++i) {
        const std::size_t next = (serving + i) % hosts.size();
        if (is_heard(hosts[next].peer, 0)) return next;
    }
    return std::nullopt;
}

void SpectatorSession::next_host() {
    phase = Phase::fetching;
    ask((serving + 1) % hosts.size());
    assembly.reset();
    polls_without_progress = polls_fetching = 0;
}

/// Sends further requests to that host, and drops the announced end and the state difference of the
/// previous host.
void SpectatorSession::ask(std::size_t host) {
    serving_since_ms = counts.last_poll_ms;
    polls_without_ticks = polls_starved = 0;
    if (std::exchange(serving, host) == host) return;
    has_told_end = differs = false;
}

/// True if the host has announced more ticks than it sends for too long. The announced end is
/// then ignored.
bool SpectatorSession::is_starved() {
    const bool lacks = current + near_ticks < live_end && ticks.next() <= current + near_ticks;
    polls_starved = lacks && has_told_end ? polls_starved + 1 : 0;
    if (polls_starved <= host_silence_polls) return false;
    polls_starved = 0;
    has_told_end = false;
    return true;
}

/// Changes to the next host if this one sends no new ticks, lacks the next tick, or sends wrong hashes. The
/// requests continue with the same tick.
void SpectatorSession::judge_host() {
    if (phase != Phase::following) return;
    const bool has_told = std::exchange(ticks_seen, ticks.next()) != ticks.next();
    if (has_told) polls_without_log = polls_without_ticks = 0;
    if (is_log_gone()) return begin_anew();
    const std::optional<std::size_t> next = next_heard();
    const bool tells_another = differs && next && !hosts[*next].differs_told;
    const bool is_of_no_use = is_starved() || lacks_log(hosts[serving]) || tells_another;
    if (next && is_of_no_use) return ask(*next);
    if (has_told) return;
    const bool is_too_long = ++polls_without_ticks > silence_polls;
    if (!is_too_long && (is_heard(hosts[serving].peer, serving_since_ms) || !next)) return;
    ask(next.value_or((serving + 1) % hosts.size()));
}

/// True if all hosts report that they no longer hold the next tick, or if one does and the others send
/// nothing for too long.
bool SpectatorSession::is_log_gone() {
    const auto lacking = std::ranges::count_if(hosts, [&](const Host& host) { return lacks_log(host); });
    if (lacking == 0) return false;
    const std::uint64_t most_polls = std::uint64_t{hosts.size()} * (silence_polls + 1);
    return static_cast<std::size_t>(lacking) == hosts.size() || ++polls_without_log > most_polls;
}

/// Handles the loss of the next tick on all hosts. A spectator that begins at a state, and has run no tick
/// yet, requests another state; otherwise it stops, because no host can continue its ticks.
void SpectatorSession::begin_anew() {
    polls_without_log = 0;
    for (Host& host : hosts) host.log_begin = 0;
    if (watch.from_state && confirmed == first && last_end == never) return next_host();
    phase = Phase::stopped;
    notices.emplace_back(std::in_place_type<MatchStopped>,
                         MatchStopped{base::join("no host has tick ", ticks.next(), " any more")});
}

void SpectatorSession::report_adopted(const Status& taken, std::uint64_t hash) {
    LOCKSTONE_ASSERT(phase == Phase::adopting, "no state was to be adopted");
    const Offer offer = assembly->offer();
    if (!taken) return refuse(taken.error().message);
    if (hash != offer.hash)
        return refuse(base::join("its state has another hash than it says, at tick ", offer.tick));
    first = current = confirmed = agreed = offer.tick;
    ticks.begin_at(offer.tick);
    has_told_end = false;
    live_end = first;
    assembly.reset();
    serving_since_ms = counts.last_poll_ms;
    phase = Phase::following;
}

bool SpectatorSession::is_level() const {
    if (phase != Phase::following || !has_told_end || current + near_ticks < live_end) return false;
    std::size_t same = 1, other = 0; // the serving host sends a hash with each tick
    for (std::size_t h = 0; h < hosts.size(); ++h)
        if (h != serving && hosts[h].agrees) ++(*hosts[h].agrees ? same : other);
    return !differs && same > other && (!watch.from_state || confirmed > first);
}

// ---- running -----------------------------------------------------------------------------------------------------

void SpectatorSession::show(std::uint64_t tick) {
    const std::span<const std::byte> at = told(tick);
    const std::uint32_t left = base::load_little_endian<std::uint16_t>(at.data() + 4);
    for (std::uint32_t p = 0; p < def.players.size(); ++p)
        inputs.push_back({at.subspan(6 + std::size_t{p} * def.input_size, def.input_size),
                          (left >> p & 1u) != 0 ? InputStatus::disconnected : InputStatus::confirmed});
}

Step SpectatorSession::advance() {
    LOCKSTONE_ASSERT(confirmed == current, "take confirmed ticks first: ", confirmed, " of ", current);
    requests.clear();
    inputs.clear();
    if (phase == Phase::adopting) {
        requests.push_back(Adopt{assembly->offer().tick, assembly->image()});
        return {Stall::connecting, requests, 0};
    }
    if (phase == Phase::stopped) return {Stall::stopped, requests, 0};
    // Near the newest tick, one tick in a frame: this smooths an uneven arrival of ticks.
    const std::uint64_t wanted = current + near_ticks < live_end ? watch.ticks_per_frame : 1;
    const std::uint64_t end = std::min({ticks.next(), current + wanted, last_end});
    for (; current < end; ++current) {
        const std::size_t first_input = inputs.size();
        show(current);
        requests.push_back(Advance{current, std::span(inputs).subspan(first_input), false});
        ++counts.ticks;
    }
    counts.stalls += requests.empty() ? 1u : 0u;
    const Stall stall = !requests.empty() ? Stall::none
                        : connected       ? Stall::inputs_missing
                                          : Stall::connecting;
    return {stall, requests, 0};
}

Step SpectatorSession::settle() {
    requests.clear();
    inputs.clear();
    return {Stall::none, requests, 0};
}

HashCheck SpectatorSession::report_hash(std::uint64_t tick, std::uint64_t hash) {
    LOCKSTONE_ASSERT(tick >= confirmed && tick < current, "tick ", tick, " of [", confirmed, ", ", current,
                     ")");
    hashes[tick % history_ticks] = hash;
    const auto told_hash = base::load_little_endian<std::uint32_t>(told(tick).data());
    ++counts.hashes_compared;
    if (told_hash == static_cast<std::uint32_t>(hash)) {
        if (!differs) agreed = tick + 1;
    } else if (!std::exchange(differs, true) && !std::exchange(hosts[serving].differs_told, true)) {
        notices.emplace_back(std::in_place_type<Desync>,
                             Desync{tick, static_cast<std::uint32_t>(hash), told_hash, hosts[serving].peer});
    }
    return HashCheck::accepted;
}

std::optional<ConfirmedTick> SpectatorSession::next_confirmed() {
    if (confirmed == current) return std::nullopt;
    inputs.clear();
    show(confirmed);
    const ConfirmedTick tick{confirmed, inputs, hashes[confirmed % history_ticks]};
    ++confirmed;
    return tick;
}

std::optional<Notice> SpectatorSession::next_notice() {
    if (notices.empty()) return std::nullopt;
    const Notice first_one = notices.front();
    notices.erase(notices.begin());
    return first_one;
}

Status SpectatorSession::drop_peer(PeerId) {
    return Error{"drop_peer: a spectator cannot remove a machine from the match"};
}

PeerQuality SpectatorSession::quality(PeerId peer) const {
    if (std::ranges::find(hosts, peer, &Host::peer) == hosts.end()) return {};
    return {
        connected, 0,
        static_cast<std::int32_t>(static_cast<std::int64_t>(current) - static_cast<std::int64_t>(live_end)),
        agreed};
}

} // namespace lockstone::session

// ---- hosts and factory functions ---------------------------------------------------------------------------------

namespace lockstone {

struct SpectatorHost::Impl {
    Transport& transport;
    ConfirmedSink* next;
    std::uint32_t match;
    session::TimelineHost timeline;
    StateInspector* states = nullptr;
};

SpectatorHost::SpectatorHost(const SessionDef& def, Transport& transport, SpectatorHostDef host,
                             ConfirmedSink* next)
    : impl(new Impl{transport, next, session::packet_context(def).match,
                    session::TimelineHost(def, {.log_ticks_max = session::no_tick,
                                                .delay_ticks = host.delay_ticks,
                                                .listeners_max = host.watchers_max,
                                                .silence_polls = host.silence_polls,
                                                .keeps_unheard = true}),
                    nullptr}) {}
SpectatorHost::~SpectatorHost() = default;

void SpectatorHost::on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs,
                                 std::uint64_t hash) {
    impl->timeline.add(tick, inputs, hash);
    if (impl->next != nullptr) impl->next->on_confirmed(tick, inputs, hash);
}

void SpectatorHost::set_states(StateInspector* states) { impl->states = states; }

void SpectatorHost::poll() {
    for (std::uint32_t i = 0; i < packets_per_poll_max; ++i) {
        const std::optional<Datagram> datagram = impl->transport.receive();
        if (!datagram) break;
        if (const auto wish = session::read_wish(datagram->bytes, impl->match))
            impl->timeline.hear(datagram->from, *wish);
    }
    impl->timeline.serve(impl->transport, impl->states);
}

std::uint32_t SpectatorHost::watchers() const { return impl->timeline.listeners(); }
std::uint64_t SpectatorHost::bytes_sent() const { return impl->timeline.bytes_sent(); }

namespace session {
Status check_watch(const SessionDef& def, const WatchDef& watch) {
    if (watch.ticks_per_frame == 0 || watch.ticks_per_frame > 64)
        return Error{
            base::join("spectator: ticks_per_frame is ", watch.ticks_per_frame, ", expected 1 to 64")};
    if (def.players.empty() || def.players.size() > players_max || def.input_size > input_bytes_max)
        return Error{base::join("spectator: ", def.players.size(), " players with inputs of ", def.input_size,
                                " bytes")};
    if (watch.hosts.empty()) return Error{"spectator: hosts is empty"};
    if (watch.state_bytes_max == 0 || watch.state_bytes_max > state_bytes_limit)
        return Error{base::join("spectator: state_bytes_max is ", watch.state_bytes_max, ", expected 1 to ",
                                state_bytes_limit)};
    return {};
}
} // namespace session

Result<std::unique_ptr<Session>> make_spectator_session(const SessionDef& def, WatchDef watch,
                                                        Transport& transport) {
    if (const Status status = session::check_watch(def, watch); !status) return status.error();
    return std::unique_ptr<Session>(
        std::make_unique<session::SpectatorSession>(def, std::move(watch), transport));
}

Result<std::unique_ptr<Session>> make_spectator_session(const SessionDef& def, PeerId host,
                                                        Transport& transport, std::uint32_t ticks_per_frame) {
    return make_spectator_session(def, WatchDef{.hosts = {host}, .ticks_per_frame = ticks_per_frame},
                                  transport);
}

} // namespace lockstone
