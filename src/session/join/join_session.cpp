#include "session/join/join_session.h"

#include "base/assert.h"
#include "base/bytes.h"
#include "base/text.h"

#include <algorithm>

namespace lockstone::session {

namespace {

/// Time after which a request gets a new ticket. It doubles after every 32 tickets, so the tickets of a
/// life last for 4.5 hours.
constexpr std::uint64_t ask_again_ms = 2000;
constexpr std::uint32_t tickets_alike = 32;
std::uint64_t patience_with(std::uint32_t ticket) {
    return ask_again_ms << (ticket % tickets_of_a_life / tickets_alike);
}
bool is_last_of_its_life(std::uint32_t ticket) { return life_of(ticket + 1) != life_of(ticket); }

/// Returns the required number of saved states. During catch-up a frame begins with all ticks that may
/// still change, and runs several ticks before one of them is confirmed.
std::uint32_t images_of(const Session& watching, const Session& playing) {
    return std::max(watching.images_max(), playing.images_max() + catch_up_ticks - 1);
}

/// The silence T after which another machine no longer counts in agreed_admission(). With D = disconnect_ms
/// and w = the longest time that a message takes one way, losses and resends included, T must satisfy
///
///   w < T < D - 4 w
///
/// With a smaller T, a present machine could count as gone. With a larger T, the others could drop the
/// joining machine for silence. The worst case is a machine A that leaves after another machine B has
/// settled the seat with A's answer, at time s, while A's admission has not arrived here. A has B's answer
/// at s + w and would answer the next request. So if no admission of A arrives, A has left before s + 2 w.
/// Its last packet arrives here before s + 3 w, and A no longer counts from s + 3 w + T on. The first
/// packet of this machine as a player arrives w later, before s + D. D / 4 satisfies both conditions for
/// all w below 3/16 D.
std::uint64_t gone_after_ms(const SessionDef& def) { return def.disconnect_ms / 4; }

WatchDef watch_of(const SessionDef& def, const JoinDef& join) {
    WatchDef watch;
    for (const PeerId peer : def.players)
        if (peer != def.self && std::ranges::find(watch.hosts, peer) == watch.hosts.end())
            watch.hosts.push_back(peer);
    std::ranges::sort(watch.hosts);
    watch.ticks_per_frame = join.ticks_per_frame;
    watch.from_state = true;
    watch.state_bytes_max = join.state_bytes_max;
    return watch;
}

} // namespace

std::optional<Datagram> Inbox::receive() {
    if (waiting.empty()) return std::nullopt;
    held = std::move(waiting.front());
    waiting.pop_front();
    return Datagram{held.from, held.bytes};
}

void Inbox::put(const Datagram& datagram) {
    if (waiting.size() < packets_per_poll_max)
        waiting.push_back({datagram.from, {datagram.bytes.begin(), datagram.bytes.end()}});
}

JoinSession::JoinSession(const SessionDef& session_def, const JoinDef& how, Transport& packets)
    : def(session_def), join(how), transport(packets), match(packet_context(session_def).match),
      watch(session_def, watch_of(session_def, how), packets), inbox(packets),
      ticket(how.life * tickets_of_a_life), images(images_of(watch, PeerSession(session_def, packets))) {
    // A host that sends packets but no new ticks is replaced after half the time in which the others drop a
    // silent machine.
    constexpr std::uint64_t polls_a_second = 60, most_ms = host_silence_polls * 1000 / polls_a_second;
    const std::uint64_t half_ms = std::min(session_def.disconnect_ms / 2, most_ms);
    watch.ask_next_after(static_cast<std::uint32_t>(half_ms * polls_a_second / 1000),
                         gone_after_ms(session_def));
}

const Session& JoinSession::driving() const {
    return is_playing() ? static_cast<const Session&>(*play) : static_cast<const Session&>(watch);
}
Session& JoinSession::now_driving() {
    return is_playing() ? static_cast<Session&>(*play) : static_cast<Session&>(watch);
}

// ---- packets -----------------------------------------------------------------------------------------------------

void JoinSession::poll(std::uint64_t now_ms) {
    now = std::max(now, now_ms);
    if (!is_playing()) watch.begin_poll(now);
    receive_all();
    come_in();
    if (play) play->poll(now);
    if (is_playing() || watch.is_stopped()) return;
    if (watch.is_level() && !std::exchange(asks, true)) asked_ms = ticket_ms = now;
    if (asks && !play && now - ticket_ms > patience_with(ticket)) ask_anew();
    watch.speak(ticket, asks);
}

/// The others may still be settling an earlier ticket. They then send the admission for that one, which is
/// valid as well.
void JoinSession::ask_anew() {
    if (!is_last_of_its_life(ticket)) ++ticket;
    ticket_ms = now;
    if (told.empty()) asked_ms = now;
}

void JoinSession::receive_all() {
    for (std::uint32_t i = 0; i < packets_per_poll_max; ++i) {
        const std::optional<Datagram> datagram = transport.receive();
        if (!datagram) return;
        if (!is_answer_to_wish(datagram->bytes)) {
            if (play)
                inbox.put(*datagram);
            else
                watch.count(*datagram, PacketFault::stranger);
        } else if (!is_playing()) {
            hear_admission(*datagram);
        }
    }
}

void JoinSession::hear_admission(const Datagram& datagram) {
    const std::uint32_t players = static_cast<std::uint32_t>(def.players.size());
    const auto heard = read_admission(datagram.bytes, match, players);
    if (!heard) return watch.count(datagram, watch.take(datagram));
    const bool is_of_this_life = heard->ticket <= ticket && life_of(heard->ticket) == life_of(ticket);
    const bool is_good =
        asks && is_of_this_life && players_at(def, datagram.from) != 0 && datagram.from != def.self;
    watch.count(datagram, is_good ? std::nullopt : std::optional(PacketFault::implausible));
    if (!is_good) return;
    const auto known = std::ranges::find(told, datagram.from, &std::pair<PeerId, Admission>::first);
    if (known == told.end())
        told.emplace_back(datagram.from, *heard);
    else if (heard->ticket >= known->second.ticket)
        known->second = *heard;
}

/// Returns the admission, for a tick still ahead, that more than half of the counted machines sent; empty:
/// none. Counted are machines with players in the match that have sent an admission or were heard recently.
/// `left`: bit p, player p has left.
std::optional<Admission> JoinSession::agreed_admission(std::uint32_t left) const {
    const auto others = std::ranges::count_if(watch_of(def, join).hosts, [&](PeerId host) {
        const bool has_told = std::ranges::count(told, host, &std::pair<PeerId, Admission>::first) != 0;
        return (players_at(def, host) & ~left) != 0 && (has_told || watch.is_heard(host, asked_ms));
    });
    for (const auto& [peer, one] : told) {
        const auto same = std::ranges::count(told, one, &std::pair<PeerId, Admission>::second);
        if (2 * same > others && one.tick >= watch.here_through()) return one;
    }
    return std::nullopt;
}

/// Begins to receive as a player as soon as the admission is known.
void JoinSession::come_in() {
    if (!play && !told.empty() && watch.here_through() > 0) {
        const auto left =
            base::load_little_endian<std::uint16_t>(watch.told(watch.here_through() - 1).data() + 4);
        if (const std::optional<Admission> one = agreed_admission(left)) begin_to_play(*one, left);
    }
    if (!play || knows_before || watch.here_through() < admission.tick) return;
    const std::span<const std::byte> tick = watch.told(admission.tick - 1).subspan(6);
    std::vector<PlayerInput> before;
    for (std::uint32_t p = 0; p < def.players.size(); ++p)
        before.push_back({tick.subspan(std::size_t{p} * def.input_size, def.input_size)});
    play->set_inputs_before(before);
    knows_before = true;
}

void JoinSession::begin_to_play(const Admission& agreed, std::uint32_t left) {
    admission = agreed;
    Entry entry{agreed.tick, agreed.since, left & ~players_at(def, def.self)};
    // A player that joins between the newest tick here and that tick is present.
    for (std::uint32_t p = 0; p < def.players.size(); ++p)
        if (agreed.since[p] >= watch.here_through()) entry.left &= ~(1u << p);
    SessionDef as_player = def;
    if (join.lockstep) as_player.prediction_max = 0;
    play = std::make_unique<PeerSession>(as_player, inbox, entry);
    if (inspector != nullptr) play->set_inspector(inspector);
    watch.end_at(agreed.tick);
    for (std::uint32_t p = 0; p < def.players.size(); ++p)
        if (def.players[p] == def.self)
            notices.emplace_back(std::in_place_type<PlayerJoined>, PlayerJoined{p, def.self, agreed.tick});
}

// ---- driving -----------------------------------------------------------------------------------------------------

void JoinSession::add_local_input(std::uint32_t player, std::span<const std::byte> input) {
    if (is_playing()) play->add_local_input(player, input);
}

Step JoinSession::advance() { return now_driving().advance(); }
Step JoinSession::settle() { return now_driving().settle(); }

std::optional<Notice> JoinSession::next_notice() {
    if (auto notice = watch.next_notice()) return notice;
    if (!notices.empty()) {
        const Notice first = notices.front();
        notices.erase(notices.begin());
        return first;
    }
    return play ? play->next_notice() : std::nullopt;
}

Status JoinSession::drop_peer(PeerId peer) { return now_driving().drop_peer(peer); }

bool JoinSession::set_inspector(StateInspector* whom) {
    inspector = whom;
    if (play) play->set_inspector(whom);
    return true;
}
void JoinSession::drop_inspector(const StateInspector& whom) {
    if (inspector == &whom) inspector = nullptr;
    if (play) play->drop_inspector(whom);
}

void JoinSession::set_input_delay(std::uint32_t ticks) {
    LOCKSTONE_ASSERT(ticks <= input_delay_limit && (!join.lockstep || ticks > 0), "an input delay of ", ticks,
                     " ticks");
    def.input_delay = ticks;
    if (play) play->set_input_delay(ticks);
}

} // namespace lockstone::session
