// Sending and receiving packets. A packet is decoded, then checked as a whole against what its sender can
// know, and only then applied: a dropped packet changes nothing. No lost packet is resent; instead, each
// packet carries the inputs that its receiver has not acknowledged.
#include "session/peer_session.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace lockstone::session {

void PeerSession::poll(std::uint64_t now_ms) {
    if (!std::exchange(polled, true)) {
        counts.first_poll_ms = now = now_ms;
        for (PeerLink& link : links) link.heard_ms = now_ms;
    }
    const std::uint64_t passed_ms = std::max(now, now_ms) - now;
    now += passed_ms;
    counts.last_poll_ms = now;
    ++polls;
    receive_all();
    if (stopped) return send_to_all();
    if (has_run) count_waits(passed_ms);
    judge_peers();
    admit();
    forget_old_inputs();
    for (PeerLink& link : links)
        if (link.state != PeerLink::State::gone) compare_hashes(link);
    send_to_all();
}

// ---- receiving ---------------------------------------------------------------------------------------------------

void PeerSession::receive_all() {
    for (PeerLink& link : links) link.packets_read = 0;
    for (std::uint32_t i = 0; i < packets_per_poll_max; ++i) {
        const std::optional<Datagram> datagram = transport.receive();
        if (!datagram) return;
        ++counts.packets_received;
        counts.bytes_received += datagram->bytes.size();
        if (const std::optional<PacketFault> fault = receive(*datagram)) {
            ++counts.packets_dropped;
            ++counts.dropped[static_cast<std::size_t>(*fault)];
        }
    }
}

std::optional<PacketFault> PeerSession::receive(const Datagram& datagram) {
    PeerLink* link = find_link(datagram.from);
    if (link == nullptr) return PacketFault::stranger;
    if (++link->packets_read > packets_per_peer_max) return PacketFault::flood;
    if (is_wish(datagram.bytes)) return receive_wish(*link, datagram.bytes);
    if (link->state == PeerLink::State::gone) return PacketFault::stranger;
    if (is_inspection(datagram.bytes)) return receive_inspection(*link, datagram.bytes);
    const Sender sender{players_of(link->peer), transport.authenticated(), link->sequence_heard, link->tick};
    if (const std::optional<PacketFault> fault = decode(datagram.bytes, link->context, sender, incoming)) {
        const bool incompatible = *fault == PacketFault::version || *fault == PacketFault::match;
        // Possibly from before one of the two joined.
        const bool may_be_old = link->context.match != context.match;
        if (incompatible && !may_be_old && !link->told_incompatible) {
            link->told_incompatible = true;
            notices.emplace_back(std::in_place_type<PeerIncompatible>,
                                 PeerIncompatible{link->peer, name_of(*fault)});
        }
        return fault;
    }
    if (!plausible(*link)) return PacketFault::implausible;
    apply(*link);
    return std::nullopt;
}

bool PeerSession::plausible(const PeerLink& link) const {
    if (!incoming.greeting && link.state == PeerLink::State::connecting)
        return false;                // the first packet must be a greeting
    std::uint64_t local_end = never; // no peer can have confirmed a tick without all local inputs
    for (const InputQueue& queue : queues) {
        const std::uint64_t next = incoming.next_input[queue.player()];
        if (is_local(queue.player())) {
            if (next > std::max(queue.next(), link.next_input[queue.player()])) return false;
            local_end = std::min(local_end, queue.next());
        } else if (!is_gone(queue.player()) && next > queue.oldest() + history_ticks) {
            return false;
        }
    }
    if (incoming.hash_first + incoming.hash_count > local_end) return false;
    if (incoming.next_hash > std::max(confirmed, link.hashes.acknowledged())) return false;
    for (const JoinWord& word : incoming.join_words())
        if (word.stand != JoinStand::no && word.tick > current + join_ahead_max) return false;
    return std::ranges::all_of(incoming.input_blocks(), [&](const InputBlock& block) {
        return block.first <= queues[block.player].next() + history_confirmed_max; // no sender stores more
    });
}

void PeerSession::apply(PeerLink& link) {
    // A packet that was overtaken on the way, or that another machine sent again, may carry data but does
    // not end the peer's silence.
    const bool is_new = incoming.sequence > link.sequence_heard;
    if (is_new) {
        link.sequence_heard = incoming.sequence;
        link.heard_ms = now;
    }
    if (is_new && link.state == PeerLink::State::connecting) {
        link.state = PeerLink::State::connected;
        notices.emplace_back(std::in_place_type<PeerConnected>, PeerConnected{link.peer});
    }
    link.has_heard_us = link.has_heard_us || incoming.heard;
    apply_departures(link);
    if (is_new) apply_joins(link);
    for (std::uint32_t p = 0; p < queues.size(); ++p)
        link.next_input[p] = std::max(link.next_input[p], incoming.next_input[p]);
    for (const InputBlock& block : incoming.input_blocks()) apply_inputs(block);
    link.hashes.acknowledge(incoming.next_hash);
    for (std::uint32_t i = 0; i < incoming.hash_count; ++i)
        link.hashes.receive(incoming.hash_first + i, incoming.hashes[i]);
    if (!is_new) return; // the rest of an older packet is outdated
    link.tick = std::max(link.tick, incoming.tick);
    if (incoming.quality) apply_quality(link, *incoming.quality);
}

/// Inputs after a gap are ignored: the sender repeats them from the gap on.
void PeerSession::apply_inputs(const InputBlock& block) {
    InputQueue& queue = queues[block.player];
    const auto before = queue.before(block.first);
    if (!before) return;
    for_each_input(block, *before, [&](std::uint64_t tick, std::span<const std::byte> input) {
        if (tick == queue.next() && queue.room() > 0 && !queue.disconnected()) queue.confirm(input);
    });
}

void PeerSession::apply_departures(PeerLink& link) {
    for (std::uint32_t p = 0; p < queues.size(); ++p) {
        const std::uint32_t bit = 1u << p;
        if (((incoming.unwanted | incoming.gone) & bit) == 0) continue;
        if (incoming.since[p] != since[p]) continue; // from before a later join of the player
        link.says_unwanted |= bit;
        link.says_gone |= incoming.gone & bit;
        if ((incoming.has_cut & bit) == 0) continue;
        // From this tick on both machines are in the match.
        const std::uint64_t earliest = std::max(since[p], entry_tick);
        link.cut[p] = std::min(link.cut[p], std::max(incoming.cut[p], earliest));
    }
}

void PeerSession::apply_quality(PeerLink& link, const QualityReport& report) {
    constexpr std::int32_t ahead_max = 1000;      // the bound prevents an overflow of sums
    constexpr std::uint16_t ping_max_ms = 60'000; // a longer ping is no echo of this machine's clock
    link.remote_ahead = std::clamp(report.ticks_ahead, -ahead_max, ahead_max);
    link.has_echo = true;
    link.echo_ms = report.sent_ms;
    link.echo_received_ms = now;
    const auto ping = static_cast<std::uint16_t>(now - report.echo_ms - report.echo_held_ms);
    if (report.has_echo && ping <= ping_max_ms) link.ping_ms = ping;
}

void PeerSession::compare_hashes(PeerLink& link) {
    if (link.unwanted && link.hashes.exchanged_through() + history_confirmed_max < confirmed)
        link.hashes_are_lost = true;
    if (link.hashes_are_lost) return;
    const std::uint64_t before = link.hashes.compared_through();
    const auto local = [this](std::uint64_t tick) { return static_cast<std::uint32_t>(local_hash(tick)); };
    if (const std::optional<std::uint64_t> tick = link.hashes.compare(confirmed, local)) {
        const Desync desync{*tick, local(*tick), link.hashes.remote_hash(*tick), link.peer};
        notices.emplace_back(std::in_place_type<Desync>, desync);
        begin_inspection(link, desync);
    }
    counts.hashes_compared += link.hashes.compared_through() - before;
}

// ---- sending -----------------------------------------------------------------------------------------------------

void PeerSession::send_to_all() {
    for (PeerLink& link : links)
        if (link.state != PeerLink::State::gone) send(link);
    for (PeerLink& link : links) go_on_inspecting(link);
    serve_those_who_come(); // last, because it is not urgent
}

void PeerSession::send(PeerLink& link) {
    fill_status(link);
    writer.begin(link.context, {players_of(def.self), transport.authenticated()}, outgoing);
    send_inputs(link);
    const std::span<const std::byte> packet = writer.finish();
    transport.send(link.peer, packet);
    ++counts.packets_sent;
    counts.bytes_sent += packet.size();
}

void PeerSession::fill_status(PeerLink& link) {
    constexpr std::uint32_t packets_between_quality = 6;
    outgoing.greeting = !link.has_heard_us;
    outgoing.heard = link.state != PeerLink::State::connecting;
    outgoing.sequence = ++link.sequence_sent;
    outgoing.tick = current;
    fill_departures();
    for (const InputQueue& queue : queues) outgoing.next_input[queue.player()] = queue.next();
    outgoing.next_hash = link.hashes.next_wanted();
    const HashLedger::Range range =
        link.hashes_are_lost ? HashLedger::Range{0, 0} : link.hashes.to_send(confirmed);
    outgoing.hash_first = range.first;
    outgoing.hash_count = range.count;
    for (std::uint32_t i = 0; i < range.count; ++i)
        outgoing.hashes[i] = static_cast<std::uint32_t>(local_hash(range.first + i));

    const std::int64_t ahead = static_cast<std::int64_t>(current) - static_cast<std::int64_t>(link.tick);
    const std::int32_t local_ahead = static_cast<std::int32_t>(std::clamp<std::int64_t>(ahead, -1000, 1000));
    if (link.state == PeerLink::State::connected) link.time_sync.sample(local_ahead, link.remote_ahead);
    outgoing.quality.reset();
    if (link.packets_until_quality-- > 0) return;
    link.packets_until_quality = packets_between_quality;
    const std::uint64_t held = now - link.echo_received_ms;
    const bool has_echo = link.has_echo && held < 30'000;
    outgoing.quality = {local_ahead, static_cast<std::uint16_t>(now), has_echo, link.echo_ms,
                        static_cast<std::uint16_t>(has_echo ? held : 0)};
}

/// A stopped machine announces all others as gone, so that they need not wait for the timeout.
void PeerSession::fill_departures() {
    outgoing.gone = gone;
    outgoing.unwanted = gone;
    outgoing.has_cut = 0;
    outgoing.since = since;
    outgoing.join_count = 0;
    for (std::uint32_t p = 0; p < queues.size(); ++p)
        for (const PeerLink& seat : links)
            if (seat.seat.stand && seat.seat.stand->player == p)
                outgoing.joins[outgoing.join_count++] = *seat.seat.stand;
    for (const PeerLink& link : links) {
        if (link.unwanted) outgoing.unwanted |= players_of(link.peer);
        if (stopped) outgoing.gone |= players_of(link.peer);
    }
    for (std::uint32_t p = 0; p < queues.size(); ++p) {
        if (cuts[p] == never) continue;
        outgoing.has_cut |= 1u << p;
        outgoing.cut[p] = cuts[p];
    }
}

/// A block begins at the first input that the peer lacks according to its last packet. If the peer lacks
/// more inputs than a usual round trip holds, or than the packet can hold, three packets of four begin
/// later, so that they end with the newest input. This avoids sending again and again inputs that the peer
/// already has. Lost inputs arrive with the fourth packet.
void PeerSession::send_inputs(const PeerLink& link) {
    constexpr std::uint64_t usual_ticks = 16, newest_ticks = 12;
    std::uint32_t left = static_cast<std::uint32_t>(std::popcount(players_of(def.self)));
    for (const InputQueue& queue : queues) {
        if (!is_local(queue.player())) continue;
        --left;
        std::uint64_t first = std::max(link.next_input[queue.player()], queue.oldest());
        const std::uint64_t lacks = queue.next() - std::min(queue.next(), first);
        if (lacks == 0) {
            writer.add_no_inputs();
            continue;
        }
        const std::uint64_t fit = std::max(writer.inputs_that_fit(left), 1u);
        if (lacks > std::min(usual_ticks, fit) && link.sequence_sent % 4 != 0)
            first = queue.next() - std::min(newest_ticks, fit);
        writer.add_inputs(first, queue.next() - first, left, *queue.before(first),
                          [&](std::uint64_t tick) { return queue.confirmed(tick); });
    }
}

} // namespace lockstone::session
