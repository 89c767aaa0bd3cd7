#include "solve/bodies/solving_order.h"

#include "base/text.h"

#include <algorithm>

namespace lockstone::solve {

namespace {

constexpr std::uint32_t nowhere = 0xffffffffu;

/// The position of an item in a plan.
struct Place {
    std::uint32_t strand = nowhere, piece = 0, item = 0;
};

/// By piece: the number of pieces of each strand that are certainly done before it begins, of its own round and of the
/// round before.
class Clocks {
  public:
    explicit Clocks(const base::StrandPlan& of)
        : plan(of), first(of.strands + 1, 0), computed(of.strands, 0) {
        for (std::uint32_t k = 0; k < plan.strands; ++k) first[k + 1] = first[k] + plan.count(k);
        now.assign(std::size_t{first.back()} * plan.strands, 0), before = now;
        for (bool any = true; any;) {
            any = false;
            for (std::uint32_t k = 0; k < plan.strands; ++k)
                for (; computed[k] < plan.count(k) && can_compute(k); ++computed[k]) compute(k), any = true;
        }
        if (!fault().empty()) return;
        for (const Place& place : in_order) compute_before(place);
    }
    /// Pieces that wait for each other, in a sentence; empty if there are none.
    std::string fault() const {
        for (std::uint32_t k = 0; k < plan.strands; ++k)
            if (computed[k] != plan.count(k))
                return base::join("piece ", computed[k], " of strand ", k, " waits for ever");
        return {};
    }
    /// True if item x is done before item y begins: by the order within their strand, or by the clock of the piece of
    /// y.
    bool comes_before(const Place& x, const Place& y) const {
        if (x.strand == y.strand) return x.item < y.item;
        return at(now, y)[x.strand] > x.piece;
    }
    /// True if the piece of x is done in a round before y begins in the next round.
    bool comes_before_next(const Place& x, const Place& y) const {
        return x.strand == y.strand || at(before, y)[x.strand] > x.piece;
    }

  private:
    using Numbers = CheckVector<std::uint32_t>;

    std::span<std::uint32_t> at(Numbers& of, const Place& p) const {
        return std::span(of).subspan(std::size_t{first[p.strand] + p.piece} * plan.strands, plan.strands);
    }
    std::span<const std::uint32_t> at(const Numbers& of, const Place& p) const {
        return std::span(of).subspan(std::size_t{first[p.strand] + p.piece} * plan.strands, plan.strands);
    }
    std::span<const base::PieceWait> waits_of(const Place& p) const {
        const base::Piece& piece = plan.pieces[p.strand][p.piece];
        return std::span(plan.waits).subspan(piece.first_wait, piece.last_wait - piece.first_wait);
    }
    bool can_compute(std::uint32_t strand) const {
        return std::ranges::all_of(waits_of({strand, computed[strand]}), [&](const base::PieceWait& wait) {
            return wait.of_last_round || wait.pieces <= computed[wait.strand];
        });
    }
    static void take(std::span<std::uint32_t> to, std::span<const std::uint32_t> from) {
        for (std::size_t k = 0; k < to.size(); ++k) to[k] = std::max(to[k], from[k]);
    }
    static void take(std::span<std::uint32_t> to, std::uint32_t strand, std::uint32_t pieces) {
        to[strand] = std::max(to[strand], pieces);
    }
    void compute(std::uint32_t strand) {
        const Place p{strand, computed[strand]};
        const auto own = at(now, p);
        if (p.piece != 0) take(own, at(now, {strand, p.piece - 1}));
        own[strand] = p.piece;
        for (const base::PieceWait& wait : waits_of(p)) {
            if (wait.of_last_round || wait.pieces == 0) continue;
            take(own, at(now, {wait.strand, wait.pieces - 1})), take(own, wait.strand, wait.pieces);
        }
        in_order.push_back(p);
    }
    void compute_before(const Place& p) {
        const auto own = at(before, p);
        if (p.piece != 0) take(own, at(before, {p.strand, p.piece - 1}));
        take(own, p.strand, plan.count(p.strand));
        for (const base::PieceWait& wait : waits_of(p)) {
            if (wait.pieces == 0) continue;
            const Place other{wait.strand, wait.pieces - 1};
            take(own, at(wait.of_last_round ? now : before, other));
            take(own, wait.strand, wait.of_last_round ? wait.pieces : plan.count(wait.strand));
        }
    }

    const base::StrandPlan& plan;
    /// by strand: the index of its first piece among all pieces; the number of its computed clocks
    Numbers first, computed;
    Numbers now, before; ///< [piece][strand]
    CheckVector<Place> in_order;
};

/// The positions of the items of a plan, by item.
CheckVector<Place> places_of(const base::StrandPlan& plan, std::span<const Solved> solved) {
    std::uint32_t end = 0;
    for (const Solved& s : solved) end = std::max(end, s.item + 1);
    CheckVector<Place> places(end);
    for (std::uint32_t item = 0; item < end && plan.strands == 0; ++item) places[item] = {0, 0, item};
    for (std::uint32_t k = 0; k < plan.strands; ++k) {
        std::uint32_t number = 0;
        for (std::uint32_t i = 0; i < plan.count(k); ++i)
            for (std::uint32_t item = plan.pieces[k][i].first; item < plan.pieces[k][i].last; ++item)
                if (item < end) places[item] = {k, i, number++};
    }
    return places;
}

/// The first and the last constraint of a body so far, by rank.
struct Seen {
    const Solved *first = nullptr, *last = nullptr;
};

/// Compares constraints of a body that have adjacent ranks. Sets `seen` for each body.
std::string pass_fault(const Clocks& clocks, std::span<const Place> places, std::span<const Solved> by_rank,
                       CheckVector<Seen>& seen) {
    for (const Solved& s : by_rank) {
        if (places[s.item].strand == nowhere) return base::join("item ", s.item, " is in no piece");
        for (const std::uint32_t body : s.moved) {
            if (body == no_body) continue;
            if (body >= seen.size()) seen.resize(body + 1);
            Seen& of = seen[body];
            if (of.last != nullptr && of.last->rank == s.rank)
                return base::join("body ", body, ": rank ", s.rank, " is solved twice");
            if (of.last != nullptr && !clocks.comes_before(places[of.last->item], places[s.item]))
                return base::join("body ", body, ": rank ", s.rank, " in item ", s.item,
                                  " does not come after rank ", of.last->rank, " in item ", of.last->item);
            of.last = &s;
            if (of.first == nullptr) of.first = &s;
        }
    }
    return {};
}

/// Compares the steps of bodies between passes with their constraints.
std::string follow_fault(const Clocks& clocks, std::span<const Place> places,
                         std::span<const BetweenPasses> followed, const CheckVector<Seen>& seen) {
    CheckVector<std::uint8_t> is_followed(seen.size(), 0);
    for (const BetweenPasses& f : followed) {
        if (f.body >= seen.size() || seen[f.body].last == nullptr) continue;
        if (is_followed[f.body]++ != 0) return base::join("body ", f.body, " is followed twice");
        const Place at{f.strand, f.piece, 0}, last = places[seen[f.body].last->item];
        const bool is_done = last.strand == f.strand ? last.piece <= f.piece : clocks.comes_before(last, at);
        if (!is_done)
            return base::join("body ", f.body, " is followed before its rank ", seen[f.body].last->rank);
        if (!clocks.comes_before_next(at, places[seen[f.body].first->item]))
            return base::join("body ", f.body, " is followed after rank ", seen[f.body].first->rank,
                              " of the next pass");
    }
    for (std::uint32_t body = 0; body < seen.size(); ++body)
        if (seen[body].last != nullptr && is_followed[body] == 0)
            return base::join("body ", body, " is not followed");
    return {};
}

CheckVector<Solved> sorted(std::span<const Solved> solved) {
    CheckVector<Solved> by_rank(solved.begin(), solved.end());
    std::ranges::sort(by_rank, {}, &Solved::rank);
    return by_rank;
}

} // namespace

std::string order_fault(const base::StrandPlan& plan, std::span<const Solved> solved) {
    const Clocks clocks(plan);
    if (std::string fault = clocks.fault(); !fault.empty()) return fault;
    CheckVector<Seen> seen;
    const CheckVector<Solved> by_rank = sorted(solved);
    return pass_fault(clocks, places_of(plan, solved), by_rank, seen);
}

std::string order_fault(const base::StrandPlan& plan, std::span<const Solved> solved,
                        std::span<const BetweenPasses> followed) {
    const Clocks clocks(plan);
    if (std::string fault = clocks.fault(); !fault.empty()) return fault;
    CheckVector<Seen> seen;
    const CheckVector<Solved> by_rank = sorted(solved);
    const CheckVector<Place> places = places_of(plan, solved);
    if (std::string fault = pass_fault(clocks, places, by_rank, seen); !fault.empty()) return fault;
    return follow_fault(clocks, places, followed, seen);
}

} // namespace lockstone::solve
