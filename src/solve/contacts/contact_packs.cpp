#include "solve/contacts/contact_packs.h"

#include "base/poison.h"
#include "base/room.h"
#include "solve/bodies/sides.h"
#include "solve/contacts/contact_order.h"

#include <algorithm>
#include <array>

namespace lockstone::solve {

namespace {

/// A strand is worth a worker from so many packs on.
constexpr std::size_t strand_packs_least = 16;
/// Packs of the last order serve while fewer than one contact in so many is of another sort than it was.
constexpr std::size_t other_sort_share = 16;

/// What packs are made of: contacts of several points before single ones, of either those that carried something in the last tick before
/// those that did not.
std::uint32_t sort_of(const ContactOrder& order, std::uint32_t contact) {
    return ~order.kind(contact) & (ContactOrder::carried | ContactOrder::several);
}

/// For so many full packs, of which `longest` follow one another whatever is done: as many as there is work for. Borders make the row of
/// those a third longer, and strands are worth their while when they save a quarter.
std::uint32_t strands_for(std::size_t packs, std::uint32_t longest, std::uint32_t most) {
    if (16 * std::size_t{longest} > 9 * packs) return 1;
    return static_cast<std::uint32_t>(std::clamp<std::size_t>(packs / strand_packs_least, 1, most));
}

} // namespace

void ContactPacks::reserve(std::size_t contacts, std::size_t bodies) {
    nodes.reserve(contacts), strands[0].round_of_pack.reserve(contacts);
    packed.reserve(2 * contacts), strands[0].packed.reserve(2 * contacts);
    last.reserve(bodies + 2);
}

void ContactPacks::share_out(const ContactOrder& order, std::span<const Transform> poses) {
    const auto place_of = [&](std::uint32_t contact) { // contacts that move nothing are nowhere
        const std::uint32_t body = order.moved_body(contact);
        return body < poses.size() ? poses[body].position : Vec3{};
    };
    std::array<Vec3, Sides::samples_max> sample;
    std::size_t samples = 0;
    const std::span<const std::uint32_t> down = order.down_from_the_top();
    for (std::size_t i = 0; i < down.size(); i += Sides::stride_of(down.size()))
        sample[samples++] = place_of(down[i]);
    const Sides sides{std::span<const Vec3>(sample).first(samples), strand_count};
    for (std::uint32_t i = 0; i < nodes.size(); ++i)
        nodes[i].strand = static_cast<std::uint8_t>(sides.side_of(place_of(i)));
}

// ---- what follows what ---

void ContactPacks::add(Queue& queue, std::uint32_t contact) {
    (queue.count != 0 ? nodes[queue.back].next : queue.front) = contact;
    queue.back = contact;
    ++queue.count;
}

std::uint32_t ContactPacks::take_front(Queue& queue) {
    const std::uint32_t contact = queue.front;
    queue.front = nodes[contact].next;
    --queue.count;
    return contact;
}

/// What each contact waits for. Returns how many contacts follow one another at most.
std::uint32_t ContactPacks::find_nodes(const ContactOrder& order) {
    last.assign(order.body_count(), 0);
    std::uint32_t longest = 0;
    for (const std::uint32_t i : order.down_from_the_top()) {
        const ContactOrder::Link link = order.link(i);
        Node& node = nodes[i];
        std::uint32_t earlier = 0; // contacts before it, one after the other
        const auto follow = [&](std::uint32_t body, std::uint32_t& before) -> unsigned {
            const std::uint32_t latest = last[body];
            last[body] = order.moves(body) ? i + 1 : 0;
            before = latest - 1;
            if (latest == 0) return 0;
            Node& leader = nodes[before];
            earlier = std::max(earlier, leader.round);
            (order.link(before).a == body ? leader.after_a : leader.after_b) = i;
            return 1;
        };
        node.after_a = node.after_b = no_contact;
        node.waits = static_cast<std::uint8_t>(follow(link.a, node.before_a) + follow(link.b, node.before_b));
        node.sort = static_cast<std::uint8_t>(sort_of(order, i));
        node.round = earlier + 1;
        longest = std::max(longest, node.round);
    }
    return longest;
}

/// One contact less stands before this one, as a pack of `strand` has it in this round.
void ContactPacks::let_follow(std::uint32_t contact, std::uint32_t strand, std::uint32_t round) {
    if (contact == no_contact) return;
    Node& node = nodes[contact];
    const bool is_own = node.strand == strand;
    node.round = std::max(node.round, round + 1 + (is_own ? 0 : grace));
    if (--node.waits != 0) return;
    Strand& to = strands[node.strand];
    add(is_own && node.round == round + 1 ? to.ready[node.sort] : to.late, contact);
}

/// A pack has a contact that follows `before`, which may be in another strand.
void ContactPacks::wait_for(std::uint32_t before, std::uint32_t strand, std::uint32_t pack) {
    if (before == no_contact) return;
    const Node& node = nodes[before];
    std::uint32_t& seen = strands[strand].seen[node.strand];
    if (node.strand == strand || node.pack < seen) return;
    seen = node.pack + 1;
    waits.push_back({strand, pack, node.strand, seen});
}

/// The next pack of a strand, if any contact of it is ready. Of the first sort that fills it, or the first that there is; then of any sort that
/// costs such a pack no more by what its contacts lack.
bool ContactPacks::fill_pack(Strand& own, std::uint32_t lanes, std::uint32_t round) {
    while (own.late.count != 0 && nodes[own.late.front].round <= round) {
        const std::uint32_t contact = take_front(own.late);
        add(own.ready[nodes[contact].sort], contact);
    }
    std::uint32_t sort = sorts;
    for (std::uint32_t k = 0; k < sorts; ++k) {
        if (own.ready[k].count >= lanes) {
            sort = k;
            break;
        }
        if (own.ready[k].count != 0 && sort == sorts) sort = k;
    }
    if (sort == sorts) return false;
    const std::size_t at = own.packed.size();
    own.packed.resize(at + lanes, no_contact);
    std::uint32_t* to = &own.packed[at];
    std::uint32_t taken = 0;
    for (std::uint32_t from = sort; from < sorts; ++from) {
        if ((sort & ~from) != 0) continue;
        while (own.ready[from].count != 0 && taken < lanes) to[taken++] = take_front(own.ready[from]);
    }
    own.round_of_pack.push_back(round);
    const std::uint32_t strand = static_cast<std::uint32_t>(&own - strands),
                        pack = static_cast<std::uint32_t>(at) / lanes;
    for (std::uint32_t i = 0; i < taken; ++i) {
        Node& node = nodes[to[i]];
        node.pack = pack;
        if (strand_count > 1) wait_for(node.before_a, strand, pack), wait_for(node.before_b, strand, pack);
        let_follow(node.after_a, strand, round), let_follow(node.after_b, strand, round);
    }
    return true;
}

// ---- pieces ---

/// Pieces by the round of their first packs: whatever one waits for comes before it.
void ContactPacks::cut_pieces() {
    std::uint32_t first_pack[base::strands_max] = {}, at[base::strands_max] = {},
                  after[base::strands_max][base::strands_max] = {};
    const auto packs_of = [&](std::uint32_t k) {
        return static_cast<std::uint32_t>(strands[k].round_of_pack.size());
    };
    for (std::uint32_t k = 0, sum = 0; k < strand_count; sum += packs_of(k++)) {
        first_pack[k] = sum;
        strands[k].piece_end.assign(packs_of(k) + 1, 0);
        strands[k].piece_end.back() = 1;
    }
    for (const Wait& w : waits) strands[w.strand].piece_end[w.pack] = strands[w.other].piece_end[w.packs] = 1;
    pieces.strands = strand_count;
    for (std::uint32_t k = 0; k < strand_count; ++k) {
        std::uint32_t sum = 0;
        for (std::uint32_t packs = 1; packs <= packs_of(k); ++packs) {
            std::uint32_t& end = strands[k].piece_end[packs];
            sum += end;
            end = end != 0 ? sum : 0;
        }
        pieces.piece_count[k] = 0;
    }
    for (auto wait = waits.begin();;) {
        std::uint32_t next = strand_count;
        for (std::uint32_t k = 0; k < strand_count; ++k)
            if (at[k] < packs_of(k) && (next == strand_count || strands[k].round_of_pack[at[k]] <
                                                                    strands[next].round_of_pack[at[next]]))
                next = k;
        if (next == strand_count) break;
        const std::uint32_t first = at[next], round = strands[next].round_of_pack[first];
        while (strands[next].piece_end[++at[next]] == 0) {}
        for (; wait != waits.end(); ++wait) {
            const std::uint32_t its_round = strands[wait->strand].round_of_pack[wait->pack];
            if (its_round > round || (its_round == round && wait->strand > next)) break;
            after[wait->strand][wait->other] = strands[wait->other].piece_end[wait->packs];
        }
        base::Piece& piece = pieces.pieces.emplace_back();
        piece.strand = next, piece.index = pieces.piece_count[next]++;
        piece.first = first_pack[next] + first, piece.last = first_pack[next] + at[next];
        std::copy_n(after[next], base::strands_max, piece.after);
    }
}

// ---- all ---

void ContactPacks::pack_all(const ContactOrder& order, std::uint32_t lanes) {
    waits.clear(), packed.clear(), pieces.clear();
    for (Strand& strand : std::span(strands).first(strand_count)) {
        for (Queue& queue : strand.ready) queue = {};
        strand.late = {};
        std::ranges::fill(strand.seen, 0u);
        strand.packed.clear(), strand.round_of_pack.clear();
        base::make_room(strand.packed, (nodes.size() + nodes.size() / 4) / strand_count + lanes);
    }
    for (const std::uint32_t i : order.down_from_the_top()) {
        Node& node = nodes[i];
        node.round = 0;
        if (node.waits == 0) add(strands[node.strand].ready[node.sort], i);
    }
    bool any = true;
    for (std::uint32_t round = 0; any; ++round) {
        any = false;
        for (std::uint32_t k = 0; k < strand_count; ++k)
            any |= fill_pack(strands[k], lanes, round) || strands[k].late.count != 0;
    }
}

/// They do where the order is the same, though a few contacts may not be of the sort any more that their pack is made for.
bool ContactPacks::serve(const ContactOrder& order, std::uint32_t lanes, std::uint32_t strands_most) const {
    if (made != Made{order.version(), lanes, strands_most}) return false;
    std::size_t others = 0;
    for (std::uint32_t i = 0; i < nodes.size(); ++i) others += sort_of(order, i) != nodes[i].sort ? 1u : 0u;
    return others <= nodes.size() / other_sort_share;
}

void ContactPacks::make(const ContactOrder& order, std::uint32_t lanes, std::uint32_t strands_most,
                        std::span<const Transform> poses) {
    if (serve(order, lanes, strands_most)) return;
    made = {order.version(), lanes, strands_most};
    nodes.resize(order.down_from_the_top().size());
    const std::uint32_t longest = find_nodes(order);
    // What another strand lets follow is packed a round later than it could be, so that nobody waits for a pack that is only just begun. Where most
    // follow one another there is no time for that.
    grace = std::size_t{longest} * lanes < nodes.size() / 4 ? 1 : 0;
    strand_count = strands_for(nodes.size() / lanes, longest, std::min(strands_most, base::strands_max));
    if (strand_count > 1)
        share_out(order, poses);
    else
        for (Node& node : nodes) node.strand = 0;
    pack_all(order, lanes);
    if (strand_count == 1) {
        packed.swap(strands[0].packed);
        return;
    }
    for (std::uint32_t k = 0; k < strand_count; ++k)
        packed.insert(packed.end(), strands[k].packed.begin(), strands[k].packed.end());
    cut_pieces();
}

void ContactPacks::poison(std::byte with) {
    base::poison(with, nodes, last, waits, packed);
    for (Strand& strand : strands) base::poison(with, strand.packed, strand.round_of_pack, strand.piece_end);
    pieces.clear();
    made = {};
}

} // namespace lockstone::solve
