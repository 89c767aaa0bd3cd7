#include "solve/contacts/contact_packs.h"

#include "base/poison.h"
#include "base/room.h"
#include "base/text.h"
#include "solve/contacts/contact_order.h"

#include <algorithm>
#include <tuple>
#include <utility>

namespace lockstone::solve {

namespace {

/// The smallest number of packs for which a strand is worth a worker.
constexpr std::size_t strand_packs_least = 16;
/// Packs of the last order stay valid while at most one contact in this many has another sort than when they were made.
constexpr std::size_t other_sort_share = 16;

/// The sort of a contact, in the order in which packs are filled: several points before one point, and in each group
/// contacts that carried an impulse in the last tick before those that did not.
std::uint32_t sort_of(const ContactOrder& order, std::uint32_t contact) {
    return ~order.kind(contact) & (ContactOrder::carried | ContactOrder::several);
}

/// The bytes of a strand's packs that stay in a processor's own cache from pass to pass.
constexpr std::size_t strand_bytes = std::size_t{1} << 19;
/// The packs of a strand after which steps between passes are done, where passes are one run: soon, while the bodies
/// are in the nearest cache.
constexpr std::uint32_t packs_between(std::uint32_t packs) { return std::clamp(packs / 8, 4u, 32u); }

} // namespace

void ContactPacks::reserve(std::size_t contacts, std::size_t body_count) {
    nodes.reserve(contacts), strands[0].round_of_pack.reserve(contacts);
    packed.reserve(2 * contacts), strands[0].packed.reserve(2 * contacts);
    cut.reserve(contacts, body_count);
    last.reserve(body_count + 2), bodies.reserve(body_count + 1);
}

/// `longest`: the length of the longest chain of contacts that follow each other.
void ContactPacks::share_out(const ContactOrder& order, const Wanted& wanted, std::uint32_t longest,
                             std::span<const Transform> poses) {
    const std::size_t packs = nodes.size() / wanted.lanes;
    const std::size_t workers =
        std::clamp<std::size_t>(packs / strand_packs_least, 1, std::min(wanted.workers, base::strands_max));
    strand_count = static_cast<std::uint32_t>(workers);
    runs_all = by_island = false;
    if (wanted.may_run_all) {
        // In a large world of islands, strands are so small that they stay in a cache for all passes.
        const std::size_t fit = packs * wanted.pack_bytes / strand_bytes,
                          most = std::min<std::size_t>(fit, base::strands_max) / workers * workers;
        if (most > 2 * workers && cut.cut_by_island(order, static_cast<std::uint32_t>(most))) {
            strand_count = static_cast<std::uint32_t>(most);
            runs_all = by_island = true;
            return;
        }
        // In a deep pile, parts of a pass have little to do at once, but several passes have. In a flat pile this would
        // move each body from worker to worker.
        if (workers > 1 && 4 * std::size_t{longest} > packs) {
            runs_all = true;
            return cut.cut_by_order(order, strand_count);
        }
    }
    // Borders between shares make the longest chain a third longer, and strands are worth their cost when they save a
    // quarter.
    if (workers > 1 && 16 * std::size_t{longest} <= 9 * packs)
        return cut.cut_by_place(order, poses, strand_count);
    strand_count = 1;
    cut.make_one(order);
}

// ---- predecessors and successors ---

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

/// Finds the direct predecessors and successors of each contact. Returns the length of the longest chain of contacts
/// that follow each other.
std::uint32_t ContactPacks::find_nodes(const ContactOrder& order) {
    last.assign(order.body_count(), 0);
    std::uint32_t longest = 0;
    for (const std::uint32_t i : order.down_from_the_top()) {
        const ContactOrder::Link link = order.link(i);
        Node& node = nodes[i];
        std::uint32_t earlier = 0; // length of the longest chain that ends before it
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

/// Notes that a pack of `strand` took a predecessor of this contact in this round.
void ContactPacks::let_follow(std::uint32_t contact, std::uint32_t strand, std::uint32_t round) {
    if (contact == no_contact) return;
    Node& node = nodes[contact];
    const bool is_own = node.strand == strand;
    node.round = std::max(node.round, round + 1 + (is_own ? 0 : grace));
    if (--node.waits != 0) return;
    Strand& to = strands[node.strand];
    if (node.waits_between && round < to.held_until)
        add(to.held, contact);
    else
        add(is_own && node.round == round + 1 ? to.ready[node.sort] : to.late, contact);
}

/// Notes that a pack has a contact that follows `before`. If `before` is in another strand, the pack waits for its
/// pack.
void ContactPacks::wait_for(std::uint32_t before, std::uint32_t strand, std::uint32_t pack) {
    if (before == no_contact) return;
    const Node& node = nodes[before];
    std::uint32_t& seen = strands[strand].seen[node.strand];
    if (node.strand == strand || node.pack < seen) return;
    seen = node.pack + 1;
    waits.push_back({strand, pack, node.strand, seen, false});
}

/// Makes the next pack of a strand. Returns false if none of its contacts is ready. It takes contacts of the first sort
/// that fills the pack, or else of the first sort that has any. Then it adds contacts of sorts with no property (several
/// points, an impulse) that the first sort lacks: these do not raise the cost of the pack.
bool ContactPacks::fill_pack(Strand& own, std::uint32_t lanes, std::uint32_t round) {
    while (own.late.count != 0 && nodes[own.late.front].round <= round) {
        const std::uint32_t contact = take_front(own.late);
        add(own.ready[nodes[contact].sort], contact);
    }
    if (round >= own.held_until)
        while (own.held.count != 0) {
            const std::uint32_t contact = take_front(own.held);
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

/// Finds the contacts that in a pass are the first to move a body whose steps between passes another strand does.
void ContactPacks::find_waits_between_passes(const ContactOrder& order, std::uint32_t lanes) {
    for (std::uint32_t k = 0; k < strand_count; ++k) {
        std::uint32_t seen[base::strands_max] = {};
        const Strand& own = strands[k];
        for (std::uint32_t at = 0; at < own.packed.size(); ++at) {
            if (own.packed[at] == no_contact) continue;
            const Node& node = nodes[own.packed[at]];
            if (!node.waits_between) continue;
            const ContactOrder::Link link = order.link(own.packed[at]);
            const auto look = [&](std::uint32_t before, std::uint32_t body) {
                if (!waits_between(body, before, k)) return;
                const Node& end = nodes[last[body] - 1];
                const std::uint32_t packs = strands[end.strand].packs(), step = packs_between(packs),
                                    done = std::min((end.pack / step + 1) * step, packs);
                if (done <= seen[end.strand]) return;
                seen[end.strand] = done;
                waits.push_back({k, at / lanes, end.strand, done, true});
            };
            look(node.before_a, link.a), look(node.before_b, link.b);
        }
    }
}

void ContactPacks::cut_pieces() {
    std::uint32_t first_pack = 0;
    pieces.strands = strand_count;
    for (Strand& strand : std::span(strands).first(strand_count)) {
        strand.pieces_to.assign(strand.packs() + 1, 0);
        strand.pieces_to.back() = 1;
        if (!runs_all || by_island) continue;
        const std::uint32_t step = packs_between(strand.packs());
        for (std::uint32_t at = step; at < strand.packs(); at += step) strand.pieces_to[at] = 1;
    }
    for (const Wait& w : waits) strands[w.strand].pieces_to[w.pack] = strands[w.other].pieces_to[w.packs] = 1;
    for (std::uint32_t k = 0; k < strand_count; ++k) {
        Strand& own = strands[k];
        own.pieces_to[0] = 0;
        base::Piece piece;
        piece.last = first_pack;
        for (std::uint32_t packs = 1; packs <= own.packs(); ++packs) {
            const bool ends = own.pieces_to[packs] != 0;
            own.pieces_to[packs] = own.pieces_to[packs - 1] + (ends ? 1u : 0u);
            if (!ends) continue;
            piece.first = piece.last, piece.last = first_pack + packs;
            piece.order = own.round_of_pack[piece.first - first_pack];
            pieces.pieces[k].push_back(piece);
        }
        first_pack += own.packs();
    }
    add_waits();
}

/// Adds the waits to the plan, piece by piece.
void ContactPacks::add_waits() {
    const auto key = [](const Wait& w) {
        return std::tuple(w.strand, w.pack, w.is_between, w.other, w.packs);
    };
    std::sort(waits.begin(), waits.end(), [&](const Wait& a, const Wait& b) { return key(a) < key(b); });
    for (auto now = waits.begin(); now != waits.end();) {
        base::Piece& piece = pieces.pieces[now->strand][strands[now->strand].pieces_to[now->pack]];
        piece.first_wait = static_cast<std::uint32_t>(pieces.waits.size());
        const std::uint32_t strand = now->strand, pack = now->pack;
        for (; now != waits.end() && now->strand == strand && now->pack == pack; ++now)
            pieces.waits.push_back({now->other, strands[now->other].pieces_to[now->packs], now->is_between});
        piece.last_wait = static_cast<std::uint32_t>(pieces.waits.size());
    }
}

/// The strand of a body's last contact does its steps between passes. A body without contacts is in the last piece of a
/// strand. A body that impulses do not move is in no list, since all strands read it.
void ContactPacks::list_bodies(const ContactOrder& order) {
    const std::uint32_t count = static_cast<std::uint32_t>(last.size()) - 1;
    const auto entry_of = [&](std::uint32_t body) -> std::uint32_t& {
        if (last[body] != 0) {
            const Node& end = nodes[last[body] - 1];
            return strands[end.strand].first_body[strands[end.strand].pieces_to[end.pack]];
        }
        const std::uint64_t share = std::uint64_t{body} * strand_count / count;
        std::vector<std::uint32_t>& of = strands[strands[share].packs() != 0 ? share : 0].first_body;
        return of[of.size() - 2];
    };
    const auto for_moved = [&](const auto& visit) {
        for (std::uint32_t body = 0; body < count; ++body)
            if (order.moves(body)) visit(body);
    };
    for (std::uint32_t k = 0; k < strand_count; ++k) strands[k].first_body.assign(pieces.count(k) + 1, 0);
    for_moved([&](std::uint32_t body) { ++entry_of(body); });
    std::uint32_t sum = 0;
    for (std::uint32_t k = 0; k < strand_count; ++k)
        for (std::uint32_t& first : strands[k].first_body) sum += std::exchange(first, sum);
    bodies.resize(sum);
    for_moved([&](std::uint32_t body) { bodies[entry_of(body)++] = body; });
    // Each entry is now where the next one begins.
    sum = 0;
    for (std::uint32_t k = 0; k < strand_count; ++k)
        for (std::uint32_t& first : strands[k].first_body) sum = std::exchange(first, sum);
}

// ---- all ---

/// `before`: the predecessor of a contact at `body`, or no_contact. True if this contact is the first in a pass to move
/// the body, and another strand than `strand` does the body's steps between passes.
bool ContactPacks::waits_between(std::uint32_t body, std::uint32_t before, std::uint32_t strand) const {
    return before == no_contact && last[body] != 0 && nodes[last[body] - 1].strand != strand;
}

void ContactPacks::pack_all(const ContactOrder& order, std::uint32_t lanes) {
    waits.clear(), packed.clear(), pieces.clear();
    for (Strand& strand : std::span(strands).first(strand_count)) {
        for (Queue& queue : strand.ready) queue = {};
        strand.late = strand.held = {};
        strand.held_until = static_cast<std::uint32_t>(nodes.size() / (2 * lanes * strand_count));
        strand.seen.assign(strand_count, 0);
        strand.packed.clear(), strand.round_of_pack.clear();
        base::make_room(strand.packed, (nodes.size() + nodes.size() / 4) / strand_count + lanes);
    }
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
        nodes[i].round = 0;
        nodes[i].strand = static_cast<std::uint8_t>(cut.of(i));
    }
    for (const std::uint32_t i : order.down_from_the_top()) {
        Node& node = nodes[i];
        const ContactOrder::Link link = order.link(i);
        node.waits_between = runs_all && strand_count > 1 &&
                             (waits_between(link.a, node.before_a, node.strand) ||
                              waits_between(link.b, node.before_b, node.strand));
        Strand& own = strands[node.strand];
        if (node.waits == 0) add(node.waits_between ? own.held : own.ready[node.sort], i);
    }
    bool any = true;
    for (std::uint32_t round = 0; any; ++round) {
        any = false;
        for (std::uint32_t k = 0; k < strand_count; ++k)
            any |= fill_pack(strands[k], lanes, round) || strands[k].late.count != 0 ||
                   strands[k].held.count != 0;
    }
}

/// True if the packs are still valid: the order is the same. A few contacts may have another sort than their pack was
/// made for.
bool ContactPacks::serve(const ContactOrder& order, const Wanted& wanted) const {
    if (made_of != order.version() || made != wanted) return false;
    std::size_t others = 0;
    for (std::uint32_t i = 0; i < nodes.size(); ++i) others += sort_of(order, i) != nodes[i].sort ? 1u : 0u;
    return others <= nodes.size() / other_sort_share;
}

void ContactPacks::note_strands() const {
    using base::Path;
    paths.take(strand_count > 1, Path::contacts_one_strand, Path::contacts_many_strands);
    paths.take(grace != 0, Path::packs_without_grace, Path::packs_with_grace);
    if (by_island)
        paths.take(Path::strands_by_island);
    else if (strand_count > 1)
        paths.take(runs_all, Path::strands_by_place, Path::strands_by_order);
}

void ContactPacks::make(const ContactOrder& order, const Wanted& wanted, std::span<const Transform> poses) {
    const bool are_kept = serve(order, wanted);
    paths.take(are_kept, base::Path::packs_made, base::Path::packs_kept);
    if (are_kept) return note_strands();
    made_of = order.version(), made = wanted;
    nodes.resize(order.down_from_the_top().size());
    const std::uint32_t longest = find_nodes(order);
    // A contact that follows a contact of another strand is packed a round later than it could be, so that no strand
    // waits for a pack that has only begun. Where most contacts follow each other there are too few packs for that.
    grace = std::size_t{longest} * wanted.lanes < nodes.size() / 4 ? 1 : 0;
    share_out(order, wanted, longest, poses);
    note_strands();
    pack_all(order, wanted.lanes);
    if (runs_all && !by_island) find_waits_between_passes(order, wanted.lanes);
    if (strand_count > 1) cut_pieces();
    if (runs_all) list_bodies(order);
    if (strand_count == 1)
        packed.swap(strands[0].packed);
    else
        for (std::uint32_t k = 0; k < strand_count; ++k)
            packed.insert(packed.end(), strands[k].packed.begin(), strands[k].packed.end());
    if constexpr (checks_order) {
        const std::string fault = order_fault(order);
        LOCKSTONE_ASSERT(fault.empty(), fault);
    }
}

// ---- the check ---

CheckVector<Solved> solved_in_packs(const ContactOrder& order, std::span<const std::uint32_t> contact_of_lane,
                                    std::uint32_t lanes) {
    const CheckVector<std::uint32_t> rank_of = order.ranks();
    CheckVector<Solved> solved;
    for (std::uint32_t i = 0; i < contact_of_lane.size(); ++i) {
        const std::uint32_t contact = contact_of_lane[i];
        if (contact == ContactPacks::no_contact) continue;
        const ContactOrder::Link link = order.link(contact);
        solved.push_back({i / lanes,
                          rank_of[contact],
                          {order.moves(link.a) ? link.a : no_body, order.moves(link.b) ? link.b : no_body}});
    }
    return solved;
}

std::string ContactPacks::order_fault(const ContactOrder& order) const {
    const CheckVector<Solved> solved = solved_in_packs(order, packed, made.lanes);
    CheckVector<std::uint32_t> ranks;
    for (const Solved& s : solved) ranks.push_back(s.rank);
    std::ranges::sort(ranks);
    for (std::uint32_t rank = 0; rank < order.down_from_the_top().size(); ++rank)
        if (rank >= ranks.size() || ranks[rank] != rank)
            return base::join("rank ", rank, " is not in one pack");
    if (!runs_all) return solve::order_fault(pieces, solved);
    if (by_island && !pieces.waits.empty()) return "islands wait for one another";
    CheckVector<BetweenPasses> followed;
    for (std::uint32_t k = 0; k < pieces.strands; ++k)
        for (std::uint32_t i = 0; i < pieces.count(k); ++i)
            for (const std::uint32_t body : bodies_after({k, i, 0})) followed.push_back({body, k, i});
    return solve::order_fault(pieces, solved, followed);
}

void ContactPacks::poison(std::byte with) {
    base::poison(with, nodes, last, waits, packed, bodies);
    for (Strand& strand : strands)
        base::poison(with, strand.seen, strand.packed, strand.round_of_pack, strand.pieces_to,
                     strand.first_body);
    cut.poison(with);
    pieces.clear();
    made_of = ~std::uint64_t{0};
}

} // namespace lockstone::solve
