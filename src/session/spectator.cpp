#include "session/spectator.h"

#include "base/assert.h"
#include "base/bytes.h"
#include "base/hash.h"
#include "base/text.h"

#include <algorithm>

namespace lockstone::session {

namespace {

constexpr std::uint8_t wish_kind = 0x57, stretch_kind = 0x54; // "W", "T"

std::size_t tick_bytes_of(const SessionDef& def) { return 6 + def.players.size() * def.input_size; }

std::span<const std::byte> sealed(std::vector<std::byte>& buffer) {
    base::ByteWriter(buffer).u32(static_cast<std::uint32_t>(base::xxh3(buffer)));
    return buffer;
}
/// Without the checksum, which is right; empty where it is not.
std::span<const std::byte> opened(std::span<const std::byte> packet) {
    if (packet.size() <= checksum_bytes || packet.size() > packet_bytes_max) return {};
    const std::span<const std::byte> body = packet.first(packet.size() - checksum_bytes);
    const auto sum = base::load_little_endian<std::uint32_t>(packet.data() + body.size());
    return sum == static_cast<std::uint32_t>(base::xxh3(body)) ? body : std::span<const std::byte>();
}

} // namespace

// ---- packets -----------------------------------------------------------------------------------------------------

std::span<const std::byte> write_wish(std::vector<std::byte>& buffer, std::uint32_t match,
                                      std::uint64_t wanted) {
    buffer.clear();
    base::ByteWriter out(buffer);
    out.u8(wish_kind);
    out.u32(match);
    out.u32(static_cast<std::uint32_t>(wanted));
    return sealed(buffer);
}

std::span<const std::byte> write_stretch(std::vector<std::byte>& buffer, std::uint32_t match,
                                         const Stretch& stretch) {
    buffer.clear();
    base::ByteWriter out(buffer);
    out.u8(stretch_kind);
    out.u32(match);
    out.u32(static_cast<std::uint32_t>(stretch.first));
    out.u32(static_cast<std::uint32_t>(stretch.end));
    out.u8(static_cast<std::uint8_t>(stretch.count));
    out.bytes(stretch.bytes);
    return sealed(buffer);
}

std::optional<std::uint64_t> read_wish(std::span<const std::byte> packet, std::uint32_t match) {
    base::ByteReader in(opened(packet), "wish");
    const bool is_ours = in.u8("kind") == wish_kind && in.u32("match") == match;
    const std::uint64_t wanted = in.u32("wanted");
    in.expect_end();
    return is_ours && in.ok() ? std::optional(wanted) : std::nullopt;
}

std::optional<Stretch> read_stretch(std::span<const std::byte> packet, std::uint32_t match,
                                    std::size_t tick_bytes) {
    base::ByteReader in(opened(packet), "stretch");
    const bool is_ours = in.u8("kind") == stretch_kind && in.u32("match") == match;
    Stretch stretch;
    stretch.first = in.u32("first tick");
    stretch.end = in.u32("end");
    stretch.count = in.u8("count");
    stretch.bytes = in.bytes(stretch.count * tick_bytes, "ticks");
    in.expect_end();
    return is_ours && in.ok() ? std::optional(stretch) : std::nullopt;
}

// ---- watching ----------------------------------------------------------------------------------------------------

SpectatorSession::SpectatorSession(const SessionDef& session_def, PeerId from, Transport& packets,
                                   std::uint32_t per_frame)
    : def(session_def), host(from), transport(packets), match(packet_context(session_def).match),
      ticks_per_frame(per_frame), tick_bytes(tick_bytes_of(session_def)), ring(history_ticks * tick_bytes),
      hashes(history_ticks) {
    requests.reserve(per_frame);
    inputs.reserve((per_frame + 1) * def.players.size());
}

/// Ticks come in order; what lies after a gap comes again.
void SpectatorSession::poll(std::uint64_t now_ms) {
    if (counts.packets_sent == 0) counts.first_poll_ms = now_ms;
    counts.last_poll_ms = std::max(counts.last_poll_ms, now_ms);
    for (std::uint32_t i = 0; i < packets_per_peer_max; ++i) {
        const std::optional<Datagram> datagram = transport.receive();
        if (!datagram) break;
        ++counts.packets_received;
        counts.bytes_received += datagram->bytes.size();
        const auto stretch =
            datagram->from == host ? read_stretch(datagram->bytes, match, tick_bytes) : std::nullopt;
        if (!stretch) {
            ++counts.packets_dropped;
            ++counts.dropped[static_cast<std::size_t>(datagram->from == host ? PacketFault::damaged
                                                                             : PacketFault::stranger)];
            continue;
        }
        if (!std::exchange(connected, true))
            notices.emplace_back(std::in_place_type<PeerConnected>, PeerConnected{host});
        live_end = std::max(live_end, stretch->end);
        for (std::uint32_t t = 0; t < stretch->count; ++t)
            if (stretch->first + t == next && next < confirmed + history_ticks)
                std::ranges::copy(stretch->bytes.subspan(t * tick_bytes, tick_bytes), slot(next++).begin());
    }
    const std::span<const std::byte> wish = write_wish(packet, match, next);
    transport.send(host, wish);
    ++counts.packets_sent;
    counts.bytes_sent += wish.size();
}

void SpectatorSession::show(std::uint64_t tick) {
    const std::span<const std::byte> at = slot(tick);
    const std::uint32_t left = base::load_little_endian<std::uint16_t>(at.data() + 4);
    for (std::uint32_t p = 0; p < def.players.size(); ++p)
        inputs.push_back({at.subspan(6 + std::size_t{p} * def.input_size, def.input_size),
                          (left >> p & 1u) != 0 ? InputStatus::disconnected : InputStatus::confirmed});
}

Step SpectatorSession::advance() {
    LOCKSTONE_ASSERT(confirmed == current, "take confirmed ticks first: ", confirmed, " of ", current);
    requests.clear();
    inputs.clear();
    // Near the live edge one tick a frame: what comes unevenly is shown evenly.
    constexpr std::uint64_t near_ticks = 8;
    const std::uint64_t wanted = current + near_ticks < live_end ? ticks_per_frame : 1;
    const std::uint64_t end = std::min(next, current + wanted);
    for (; current < end; ++current) {
        const std::size_t first = inputs.size();
        show(current);
        requests.push_back(Advance{current, std::span(inputs).subspan(first), false});
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
    const auto told = base::load_little_endian<std::uint32_t>(slot(tick).data());
    ++counts.hashes_compared;
    if (told == static_cast<std::uint32_t>(hash)) {
        if (!differs) agreed = tick + 1;
    } else if (!std::exchange(differs, true)) {
        notices.emplace_back(std::in_place_type<Desync>,
                             Desync{tick, static_cast<std::uint32_t>(hash), told, host});
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
    const Notice first = notices.front();
    notices.erase(notices.begin());
    return first;
}

Status SpectatorSession::drop_peer(PeerId) { return Error{"drop_peer: who watches has no say in who plays"}; }

PeerQuality SpectatorSession::quality(PeerId peer) const {
    if (peer != host) return {};
    return {
        connected, 0,
        static_cast<std::int32_t>(static_cast<std::int64_t>(current) - static_cast<std::int64_t>(live_end)),
        agreed};
}

} // namespace lockstone::session

// ---- hosting -----------------------------------------------------------------------------------------------------

namespace lockstone {

struct SpectatorHost::Impl {
    struct Watcher {
        PeerId peer;
        std::uint64_t wanted = 0, sent = 0; ///< ticks
        std::uint64_t silent_polls = 0, polls_without_progress = 0;
    };
    Transport& transport;
    SpectatorHostDef def;
    ConfirmedSink* next;
    std::uint32_t match;
    std::size_t tick_bytes;
    std::vector<std::byte> log; ///< from tick 0, as session::Stretch tells
    std::vector<Watcher> watchers;
    std::vector<std::byte> packet;
    std::uint64_t bytes_sent = 0;

    std::uint64_t end() const {
        const std::uint64_t ticks = log.size() / tick_bytes;
        return ticks - std::min<std::uint64_t>(ticks, def.delay_ticks);
    }

    /// A word of a watcher. Whoever claims to have what it was not sent yet has its word ignored.
    void hear(PeerId peer, std::uint64_t wanted) {
        auto found = std::ranges::find(watchers, peer, &Watcher::peer);
        if (found == watchers.end()) {
            if (watchers.size() >= def.watchers_max || wanted > end()) return;
            watchers.push_back({peer, wanted, wanted, 0, 0});
            return;
        }
        found->silent_polls = 0;
        if (wanted > end()) return;
        if (wanted > found->wanted || wanted == 0) found->polls_without_progress = 0;
        found->wanted =
            wanted < found->wanted && wanted != 0 ? found->wanted : wanted; // 0: it has begun anew
        found->sent = wanted == 0 ? 0 : std::max(found->sent, found->wanted);
    }

    /// What comes next, once; again from the first that it lacks after 20 polls without progress.
    void serve(Watcher& watcher) {
        constexpr std::uint64_t resend_polls = 20, ticks_ahead_max = 256;
        if (watcher.sent > watcher.wanted && ++watcher.polls_without_progress >= resend_polls) {
            watcher.sent = watcher.wanted;
            watcher.polls_without_progress = 0;
        }
        const std::uint64_t last = std::min(end(), watcher.wanted + ticks_ahead_max);
        const std::uint64_t fits = std::min<std::uint64_t>(session::stretch_bytes_max / tick_bytes, 255);
        const std::uint64_t count = std::min(fits, last - std::min(last, watcher.sent));
        if (count == 0) return;
        const std::size_t from = watcher.sent * tick_bytes;
        const auto bytes = session::write_stretch(packet, match,
                                                  {watcher.sent, static_cast<std::uint32_t>(count), end(),
                                                   std::span(log).subspan(from, count * tick_bytes)});
        transport.send(watcher.peer, bytes);
        bytes_sent += bytes.size();
        watcher.sent += count;
    }
};

SpectatorHost::SpectatorHost(const SessionDef& def, Transport& transport, SpectatorHostDef host,
                             ConfirmedSink* next)
    : impl(new Impl{transport,
                    host,
                    next,
                    session::packet_context(def).match,
                    session::tick_bytes_of(def),
                    {},
                    {},
                    {},
                    0}) {}
SpectatorHost::~SpectatorHost() = default;

void SpectatorHost::on_confirmed(std::uint64_t tick, std::span<const PlayerInput> inputs,
                                 std::uint64_t hash) {
    LOCKSTONE_ASSERT(tick * impl->tick_bytes == impl->log.size(),
                     "a spectator host is told of every tick from 0 on: tick ", tick, " after ",
                     impl->log.size() / impl->tick_bytes);
    base::ByteWriter out(impl->log);
    out.u32(static_cast<std::uint32_t>(hash));
    std::uint32_t left = 0;
    for (std::size_t p = 0; p < inputs.size(); ++p)
        left |= inputs[p].status == InputStatus::disconnected ? 1u << p : 0u;
    out.u16(static_cast<std::uint16_t>(left));
    for (const PlayerInput& input : inputs) out.bytes(input.bytes);
    if (impl->next != nullptr) impl->next->on_confirmed(tick, inputs, hash);
}

void SpectatorHost::poll() {
    for (std::uint32_t i = 0; i < packets_per_poll_max; ++i) {
        const std::optional<Datagram> datagram = impl->transport.receive();
        if (!datagram) break;
        if (const auto wanted = session::read_wish(datagram->bytes, impl->match))
            impl->hear(datagram->from, *wanted);
    }
    std::erase_if(impl->watchers,
                  [&](Impl::Watcher& w) { return ++w.silent_polls > impl->def.silence_polls; });
    for (Impl::Watcher& watcher : impl->watchers) impl->serve(watcher);
}

std::uint32_t SpectatorHost::watchers() const { return static_cast<std::uint32_t>(impl->watchers.size()); }
std::uint64_t SpectatorHost::bytes_sent() const { return impl->bytes_sent; }

Result<std::unique_ptr<Session>> make_spectator_session(const SessionDef& def, PeerId host,
                                                        Transport& transport, std::uint32_t ticks_per_frame) {
    if (ticks_per_frame == 0 || ticks_per_frame > 64)
        return Error{base::join("spectator: ticks_per_frame is ", ticks_per_frame, ", expected 1 to 64")};
    if (def.players.empty() || def.players.size() > players_max || def.input_size > input_bytes_max)
        return Error{base::join("spectator: ", def.players.size(), " players with inputs of ", def.input_size,
                                " bytes")};
    return std::unique_ptr<Session>(
        std::make_unique<session::SpectatorSession>(def, host, transport, ticks_per_frame));
}

} // namespace lockstone
