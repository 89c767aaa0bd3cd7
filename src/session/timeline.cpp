#include "session/timeline.h"

#include "base/assert.h"
#include "base/bytes.h"

#include <algorithm>

namespace lockstone::session {

// ---- packets -----------------------------------------------------------------------------------------------------

namespace {

constexpr std::uint8_t wish_kind = 0x57, stretch_kind = 0x54, offer_kind = 0x4f, chunk_kind = 0x43,
                       word_kind = 0x48, admission_kind = 0x52; // "W", "T", "O", "C", "H", "R"
constexpr std::uint32_t flag_log = 1, flag_state = 2, flag_seat = 4;
constexpr std::size_t proof_max = 20; ///< above the depth of a tree over state_bytes_limit bytes

base::ByteWriter begin(std::vector<std::byte>& buffer, std::uint8_t kind, std::uint32_t match) {
    buffer.clear();
    buffer.reserve(packet_bytes_max);
    base::ByteWriter out(buffer);
    out.u8(kind);
    out.u32(match);
    return out;
}
bool is_of(base::ByteReader& in, std::uint8_t kind, std::uint32_t match) {
    return in.u8("kind") == kind && in.u32("match") == match;
}
std::uint8_t kind_of(std::span<const std::byte> packet) {
    return packet.empty() ? std::uint8_t{0} : std::to_integer<std::uint8_t>(packet[0]);
}

} // namespace

bool is_wish(std::span<const std::byte> packet) { return kind_of(packet) == wish_kind; }
bool is_answer_to_wish(std::span<const std::byte> packet) {
    const std::uint8_t kind = kind_of(packet);
    return kind == stretch_kind || kind == offer_kind || kind == chunk_kind || kind == word_kind ||
           kind == admission_kind;
}

std::span<const std::byte> write_wish(std::vector<std::byte>& buffer, std::uint32_t match, const Wish& wish) {
    base::ByteWriter out = begin(buffer, wish_kind, match);
    out.u8(static_cast<std::uint8_t>((wish.wants_log ? flag_log : 0u) | (wish.wants_state ? flag_state : 0u) |
                                     (wish.wants_seat ? flag_seat : 0u)));
    out.u32(wish.ticket);
    out.u32(static_cast<std::uint32_t>(wish.wanted));
    out.u32(static_cast<std::uint32_t>(wish.asked));
    out.u32(static_cast<std::uint32_t>(wish.offered));
    out.u32(wish.missing);
    out.u64(wish.have);
    return add_checksum(buffer);
}
std::optional<Wish> read_wish(std::span<const std::byte> packet, std::uint32_t match) {
    base::ByteReader in(checked_body(packet), "wish");
    const bool is_ours = is_of(in, wish_kind, match);
    const std::uint32_t flags = in.u8("flags");
    Wish wish;
    wish.wants_log = (flags & flag_log) != 0;
    wish.wants_state = (flags & flag_state) != 0;
    wish.wants_seat = (flags & flag_seat) != 0;
    wish.ticket = in.u32("ticket");
    wish.wanted = in.u32("wanted");
    wish.asked = in.u32("asked");
    wish.offered = in.u32("offered");
    wish.missing = in.u32("missing");
    wish.have = in.u64("have");
    if (flags > (flag_log | flag_state | flag_seat)) in.fail("flags out of range");
    in.expect_end();
    return is_ours && in.ok() ? std::optional(wish) : std::nullopt;
}

std::span<const std::byte> write_stretch(std::vector<std::byte>& buffer, std::uint32_t match,
                                         const Stretch& stretch) {
    base::ByteWriter out = begin(buffer, stretch_kind, match);
    out.u32(static_cast<std::uint32_t>(stretch.first));
    out.u32(static_cast<std::uint32_t>(stretch.end));
    out.u8(static_cast<std::uint8_t>(stretch.count));
    out.bytes(stretch.bytes);
    return add_checksum(buffer);
}
std::optional<Stretch> read_stretch(std::span<const std::byte> packet, std::uint32_t match,
                                    std::size_t tick_bytes) {
    base::ByteReader in(checked_body(packet), "stretch");
    const bool is_ours = is_of(in, stretch_kind, match);
    Stretch stretch;
    stretch.first = in.u32("first tick");
    stretch.end = in.u32("end");
    stretch.count = in.u8("count");
    stretch.bytes = in.bytes(stretch.count * tick_bytes, "ticks");
    in.expect_end();
    return is_ours && in.ok() ? std::optional(stretch) : std::nullopt;
}

std::span<const std::byte> write_offer(std::vector<std::byte>& buffer, std::uint32_t match,
                                       const Offer& offer) {
    base::ByteWriter out = begin(buffer, offer_kind, match);
    out.u32(static_cast<std::uint32_t>(offer.tick));
    out.u64(offer.hash);
    out.u32(offer.bytes);
    out.u64(offer.root);
    return add_checksum(buffer);
}
std::optional<Offer> read_offer(std::span<const std::byte> packet, std::uint32_t match) {
    base::ByteReader in(checked_body(packet), "offer");
    const bool is_ours = is_of(in, offer_kind, match);
    Offer offer;
    offer.tick = in.u32("tick");
    offer.hash = in.u64("hash");
    offer.bytes = in.u32("bytes");
    offer.root = in.u64("root");
    if (offer.tick == 0 || offer.tick >= no_tick) in.fail("tick out of range");
    if (offer.bytes == 0 || offer.bytes > state_bytes_limit) in.fail("bytes out of range");
    in.expect_end();
    return is_ours && in.ok() ? std::optional(offer) : std::nullopt;
}

std::span<const std::byte> write_chunk(std::vector<std::byte>& buffer, std::uint32_t match,
                                       const Chunk& chunk) {
    base::ByteWriter out = begin(buffer, chunk_kind, match);
    out.u32(static_cast<std::uint32_t>(chunk.tick));
    out.u32(chunk.index);
    out.u8(static_cast<std::uint8_t>(chunk.proof.size()));
    for (const std::uint64_t hash : chunk.proof) out.u64(hash);
    out.bytes(chunk.bytes);
    return add_checksum(buffer);
}
std::optional<Chunk> read_chunk(std::span<const std::byte> packet, std::uint32_t match) {
    base::ByteReader in(checked_body(packet), "chunk");
    const bool is_ours = is_of(in, chunk_kind, match);
    Chunk chunk;
    chunk.tick = in.u32("tick");
    chunk.index = in.u32("index");
    const std::uint32_t proof = in.u8("proof size");
    if (proof > proof_max) in.fail("proof out of range");
    for (std::uint32_t i = 0; i < proof && in.ok(); ++i) chunk.proof.push_back(in.u64("proof"));
    if (!is_ours || !in.ok()) return std::nullopt;
    chunk.bytes = in.bytes(in.remaining(), "bytes");
    if (chunk.bytes.empty() || chunk.bytes.size() > chunk_bytes) return std::nullopt;
    return chunk;
}

std::span<const std::byte> write_word(std::vector<std::byte>& buffer, std::uint32_t match, const Word& word) {
    base::ByteWriter out = begin(buffer, word_kind, match);
    out.u32(static_cast<std::uint32_t>(word.tick));
    out.u64(word.hash);
    return add_checksum(buffer);
}
std::optional<Word> read_word(std::span<const std::byte> packet, std::uint32_t match) {
    base::ByteReader in(checked_body(packet), "word");
    const bool is_ours = is_of(in, word_kind, match);
    Word word;
    word.tick = in.u32("tick");
    word.hash = in.u64("hash");
    in.expect_end();
    return is_ours && in.ok() ? std::optional(word) : std::nullopt;
}

std::span<const std::byte> write_admission(std::vector<std::byte>& buffer, std::uint32_t match,
                                           std::uint32_t players, const Admission& admission) {
    base::ByteWriter out = begin(buffer, admission_kind, match);
    out.u32(admission.ticket);
    out.u32(static_cast<std::uint32_t>(admission.tick));
    for (std::uint32_t p = 0; p < players; ++p) out.u32(static_cast<std::uint32_t>(admission.since[p]));
    return add_checksum(buffer);
}
std::optional<Admission> read_admission(std::span<const std::byte> packet, std::uint32_t match,
                                        std::uint32_t players) {
    base::ByteReader in(checked_body(packet), "admission");
    const bool is_ours = is_of(in, admission_kind, match);
    Admission admission;
    admission.ticket = in.u32("ticket");
    admission.tick = in.u32("tick");
    for (std::uint32_t p = 0; p < players; ++p) admission.since[p] = in.u32("since");
    in.expect_end();
    return is_ours && in.ok() ? std::optional(admission) : std::nullopt;
}

// ---- hosting -----------------------------------------------------------------------------------------------------

namespace {
constexpr std::uint64_t listener_resend_polls = 20, ticks_ahead_max = 256;
constexpr std::uint64_t snapshot_polls = 120; ///< minimum distance between two states
/// Minimum time for which a state is kept while a listener collects it.
constexpr std::uint64_t snapshot_polls_max = 7200;
constexpr std::uint64_t quiet_polls = 60;   ///< a listener that is silent for longer receives no ticks
constexpr std::uint64_t kept_unheard = 256; ///< minimum length of the log without listeners [ticks]
/// Maximum length of a log with listeners, as a multiple of log_ticks_max.
constexpr std::uint64_t held_times = 8;
constexpr std::uint32_t chunks_per_wish = 2, chunk_times = 8;

/// Returns how long a state is kept for its listeners [polls]: eight times the transfer time without loss,
/// but at least snapshot_polls_max.
std::uint64_t polls_of(const Offer& offer) {
    return std::max<std::uint64_t>(snapshot_polls_max,
                                   std::uint64_t{chunk_times} * offer.chunks() / chunks_per_wish);
}
} // namespace

TimelineHost::TimelineHost(const SessionDef& session_def, TimelineDef how)
    : def(how), match(packet_context(session_def).match), tick_bytes(tick_bytes_of(session_def)),
      hashes(history_ticks) {
    if (!def.keeps_unheard) log.reserve(2 * kept_unheard * tick_bytes);
}

void TimelineHost::add(std::uint64_t tick, std::span<const PlayerInput> inputs, std::uint64_t hash) {
    if (!std::exchange(has_begun, true)) first = log_first = tick;
    LOCKSTONE_ASSERT(tick == log_end(), "confirmed ticks are added in order: tick ", tick, " after ",
                     log_end());
    hashes[tick % history_ticks] = hash;
    make_room();
    base::ByteWriter out(log);
    out.u32(static_cast<std::uint32_t>(hash));
    std::uint32_t left = 0;
    for (std::size_t p = 0; p < inputs.size(); ++p)
        left |= inputs[p].status == InputStatus::disconnected ? 1u << p : 0u;
    out.u16(static_cast<std::uint16_t>(left));
    for (const PlayerInput& input : inputs) out.bytes(input.bytes);
}

void TimelineHost::add_told(std::uint64_t tick, std::span<const std::byte> told) {
    if (!std::exchange(has_begun, true)) first = log_first = tick;
    LOCKSTONE_ASSERT(tick == log_end() && told.size() == tick_bytes, "tick ", tick, " after ", log_end());
    is_told = true;
    make_room();
    base::ByteWriter(log).bytes(told);
}

/// Called before a tick is added. The log keeps the newest ticks even without listeners: a machine that
/// received a state from another host may request the ticks after that state here.
void TimelineHost::make_room() {
    const std::uint64_t ticks = log.size() / tick_bytes;
    const bool is_unheard = !def.keeps_unheard && all.empty();
    const std::uint64_t most = is_unheard ? 2 * kept_unheard : def.log_ticks_max;
    if (ticks < most) return;
    std::uint64_t old = ticks - ticks / 2;
    if (!def.keeps_unheard && ticks / held_times < most) old = std::min(old, first_awaited() - log_first);
    if (old < most / 4) return; // moving the rest costs time, so ticks are not dropped a few at a time
    log.erase(log.begin(), log.begin() + static_cast<std::ptrdiff_t>(old * tick_bytes));
    log_first += old;
}

/// The first tick of the log that a listener reads now, or after the state that it receives.
std::uint64_t TimelineHost::first_awaited() const {
    std::uint64_t tick = is_snapshot_taken() ? std::max(snapshot->offer().tick, log_first) : log_end();
    for (const Listener& listener : all)
        if (listener.wish.wants_log && listener.wanted >= log_first && listener.silent_polls < quiet_polls)
            tick = std::min(tick, listener.wanted);
    return tick;
}

std::optional<std::uint32_t> TimelineHost::told_hash(std::uint64_t tick) const {
    if (tick < log_first || tick >= log_end()) return std::nullopt;
    return base::load_little_endian<std::uint32_t>(log.data() + (tick - log_first) * tick_bytes);
}

void TimelineHost::set_snapshot(const Offer& offer, std::span<const std::byte> image) {
    snapshot.emplace(offer.tick, offer.hash, std::vector<std::byte>(image.begin(), image.end()));
    snapshot_at_poll = polls;
    ++made;
}

std::uint64_t TimelineHost::shown_end() const {
    return log_end() - std::min<std::uint64_t>(log_end() - log_first, def.delay_ticks);
}

void TimelineHost::hear(PeerId peer, const Wish& wish) {
    if (wish.wants_log && wish.wanted > shown_end()) return;
    auto found = std::ranges::lower_bound(all, peer, {}, &Listener::peer);
    if (found == all.end() || found->peer != peer) {
        if (all.size() >= def.listeners_max) return;
        found = all.insert(found, {peer, {}, false, wish.wanted, wish.wanted});
    }
    found->wish = wish;
    found->was_heard = true;
    found->silent_polls = 0;
    const bool begins_anew = wish.wanted == 0;
    if (wish.wanted > found->wanted || begins_anew) found->polls_without_progress = 0;
    found->wanted = begins_anew ? 0 : std::max(found->wanted, wish.wanted);
    found->sent = begins_anew ? 0 : std::max(found->sent, found->wanted);
}

void TimelineHost::serve(Transport& transport, StateInspector* states) {
    ++polls;
    std::erase_if(all, [&](Listener& listener) { return ++listener.silent_polls > def.silence_polls; });
    for (Listener& listener : all) {
        const bool was_heard = std::exchange(listener.was_heard, false);
        if (was_heard) serve_word(listener, transport);
        if (was_heard && listener.wish.wants_state && make_snapshot(states)) serve_state(listener, transport);
        if (listener.wish.wants_log && listener.silent_polls <= quiet_polls) serve_log(listener, transport);
    }
}

void TimelineHost::send(Transport& transport, PeerId to, std::span<const std::byte> out) {
    transport.send(to, out);
    ++packets;
    bytes += out.size();
}

void TimelineHost::serve_word(Listener& listener, Transport& transport) {
    const std::uint64_t tick = listener.wish.asked, end = shown_end();
    if (is_told) { // other ticks: only the low half of the hash is known
        if (tick < end && snapshot && tick + 1 == snapshot->offer().tick)
            send(transport, listener.peer, write_word(packet, match, {tick, snapshot->offer().hash}));
        return;
    }
    if (tick < first || tick >= end || tick + history_ticks < log_end()) return;
    send(transport, listener.peer, write_word(packet, match, {tick, hashes[tick % history_ticks]}));
}

bool TimelineHost::is_snapshot_taken() const {
    return snapshot && polls - snapshot_at_poll < polls_of(snapshot->offer()) &&
           std::ranges::any_of(all, [&](const Listener& l) {
               return l.wish.wants_state && l.wish.offered == snapshot->offer().tick;
           });
}

/// Makes a state on request, at most one in snapshot_polls polls, and not while a listener collects the
/// stored one. Returns true if a stored state can be sent.
bool TimelineHost::make_snapshot(StateInspector* states) {
    const std::uint64_t age = polls - snapshot_at_poll;
    const bool is_kept = snapshot && snapshot->offer().tick >= log_first &&
                         (age < snapshot_polls || is_told || is_snapshot_taken());
    if (!is_kept && (made == 0 || age >= snapshot_polls) && states != nullptr && has_begun &&
        log_end() > first) {
        const std::uint64_t last = log_end() - 1;
        const State* state = states->state_after(last);
        snapshot_at_poll = polls;
        ++made;
        snapshot.reset();
        if (state == nullptr || state->hash() != hashes[last % history_ticks]) return false;
        std::vector<std::byte> image = state->save_portable();
        if (image.size() <= state_bytes_limit) snapshot.emplace(last + 1, state->hash(), std::move(image));
    }
    return snapshot && snapshot->offer().tick >= log_first && snapshot->offer().tick <= shown_end();
}

/// Sends the offer of a state, or its next chunks. Each chunk is sent once. After 20 requests without
/// progress, the host sends again from the first missing chunk on.
void TimelineHost::serve_state(Listener& listener, Transport& transport) {
    const Wish& wish = listener.wish;
    const Offer& offer = snapshot->offer();
    if (wish.offered != offer.tick) return send(transport, listener.peer, write_offer(packet, match, offer));
    if (wish.missing >= offer.chunks()) return;
    if (std::exchange(listener.chunks_of, offer.tick) != offer.tick)
        listener.chunk_next = listener.chunk_missing = 0,
        listener.chunks_sent = listener.wishes_without_chunk = 0;
    if (wish.missing > listener.chunk_missing) listener.wishes_without_chunk = 0;
    listener.chunk_missing = wish.missing;
    listener.chunk_next = std::max(listener.chunk_next, wish.missing);
    if (listener.chunk_next > wish.missing && ++listener.wishes_without_chunk >= listener_resend_polls) {
        listener.chunk_next = wish.missing;
        listener.wishes_without_chunk = 0;
    }
    const std::uint64_t budget = chunk_times * std::uint64_t{offer.chunks()} + 256;
    const std::uint32_t end = std::min(offer.chunks(), wish.missing + chunks_ahead);
    for (std::uint32_t n = 0; n < chunks_per_wish && listener.chunk_next < end; ++listener.chunk_next) {
        const std::uint32_t after = listener.chunk_next - wish.missing;
        if (after > 0 && (wish.have >> (after - 1) & 1u) != 0) continue;
        if (++listener.chunks_sent > budget) return;
        snapshot->chunk(listener.chunk_next, chunk);
        send(transport, listener.peer, write_chunk(packet, match, chunk));
        ++n;
    }
}

/// For a listener that lacks ticks which the log no longer holds: sends it the first tick of the log, every
/// 20 polls.
void TimelineHost::tell_begin(Listener& listener, Transport& transport) {
    if (++listener.polls_without_progress < listener_resend_polls) return;
    listener.polls_without_progress = 0;
    send(transport, listener.peer, write_stretch(packet, match, {log_first, 0, shown_end(), {}}));
}

/// Sends the next ticks. Each tick is sent once; after 20 polls without progress the host sends again from
/// the first missing tick on. The match waits for a machine that joins, so this machine gets the first
/// ticks that it may lack in every second poll, and the next ones in the other polls, independent of the
/// round trip.
void TimelineHost::serve_log(Listener& listener, Transport& transport) {
    if (listener.wanted < log_first) return tell_begin(listener, transport);
    if (listener.sent > listener.wanted && ++listener.polls_without_progress >= listener_resend_polls) {
        listener.sent = listener.wanted;
        listener.polls_without_progress = 0;
    }
    const bool is_awaited = listener.wish.ticket != 0 && polls % 2 == 0;
    const std::uint64_t first_sent = is_awaited ? listener.wanted : listener.sent;
    const std::uint64_t last = std::min(shown_end(), listener.wanted + ticks_ahead_max);
    const std::uint64_t fits = std::min<std::uint64_t>(stretch_bytes_max / tick_bytes, 255);
    const std::uint64_t count = std::min(fits, last - std::min(last, first_sent));
    if (count == 0) return;
    const std::size_t from = (first_sent - log_first) * tick_bytes;
    send(transport, listener.peer,
         write_stretch(packet, match,
                       {first_sent, static_cast<std::uint32_t>(count), shown_end(),
                        std::span(log).subspan(from, count * tick_bytes)}));
    listener.sent = std::max(listener.sent, first_sent + count);
}

} // namespace lockstone::session
