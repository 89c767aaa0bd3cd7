#include "solve/contacts/contact_order.h"

#include "base/poison.h"
#include "base/room.h"
#include "solve/contacts/contact.h"

#include <algorithm>

namespace lockstone::solve {

namespace {

/// Points farther apart than this carry no load soon [m].
constexpr std::int32_t touching = decimal<Separation>("0.0005").raw;

std::uint32_t kind_of(const Contact& contact) {
    std::int32_t least = Separation::max().raw, carried = 0;
    for (std::uint32_t k = 0; k < contact.count; ++k) {
        least = std::min(least, contact.points[k].separation.raw);
        carried |= contact.points[k].impulse.raw;
    }
    const auto bit = [](bool is, ContactOrder::Kind kind) { return is ? unsigned{kind} : 0u; };
    return bit(carried != 0, ContactOrder::carried) | bit(contact.count > 1, ContactOrder::several) |
           bit(least < touching, ContactOrder::touches) |
           bit(contact.restitution > Unit{}, ContactOrder::bounces) |
           bit(contact.rolling > Unit{}, ContactOrder::rolls);
}

/// Replaces counts[k], the number of items with key k, by the index at which the items with key k begin.
void sum_up(std::span<std::uint32_t> counts) {
    std::uint32_t sum = 0;
    for (std::uint32_t& count : counts) {
        const std::uint32_t own = count;
        count = sum;
        sum += own;
    }
}

} // namespace

ContactHead head_of(const Contact& contact) { return {contact.body_a, contact.body_b, kind_of(contact)}; }

/// Reserves for the largest need of this many contacts, so that a tick in which more of them touch does not allocate.
void ContactOrder::reserve(std::size_t contacts, std::size_t bodies) {
    for (auto* list : {&levels, &first, &queue}) list->reserve(bodies + 2);
    for (auto* list : {&down, &down_before, &place}) list->reserve(contacts + 2);
    for (Given* given : {&now, &before})
        given->links.reserve(contacts), given->kinds.reserve(contacts), given->movable.reserve(bodies + 2);
    neighbours.reserve(2 * contacts);
    counts.reserve(2 * bodies + 4);
}

/// Reads links and kinds, and counts the neighbours of bodies. Returns true if the bodies touch and can move as in the
/// last tick.
bool ContactOrder::read(std::span<const ContactHead> contacts, const SolverBodies& bodies) {
    std::swap(now, before);
    const std::size_t count = bodies.body.size();
    now.movable.resize(count);
    bool any_driven = false;
    const auto is_driven = [](const BodyStep& step) { return step.moves && !step.movable; };
    for (std::size_t b = 0; b < count; ++b) {
        now.movable[b] = bodies.step[b].movable ? 1 : 0;
        any_driven |= is_driven(bodies.step[b]);
    }
    first.assign(count + 1, 0);
    now.links.resize(contacts.size()), now.kinds.resize(contacts.size());
    bool is_same = now.movable == before.movable && before.links.size() == contacts.size();
    all_kinds = 0;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        const ContactHead& c = contacts[i];
        now.links[i] = {c.body_a, c.body_b};
        now.kinds[i] = static_cast<std::uint8_t>(c.kind);
        if (any_driven && (is_driven(bodies.step[c.body_a]) || is_driven(bodies.step[c.body_b])))
            now.kinds[i] |= driven;
        all_kinds |= now.kinds[i];
        const std::uint32_t one = (now.kinds[i] & touches) != 0 ? 1 : 0;
        first[c.body_a] += one, first[c.body_b] += one;
        is_same =
            is_same && now.links[i] == before.links[i] && ((now.kinds[i] ^ before.kinds[i]) & touches) == 0;
    }
    return is_same;
}

/// Breadth-first search over the contacts that touch, from the bodies that impulses do not move.
void ContactOrder::find_levels() {
    const std::size_t count = now.movable.size();
    sum_up(first);
    neighbours.resize(first[count]);
    queue.assign(first.begin(), first.end() - 1); // the index where the next neighbour of each body goes
    for (std::size_t i = 0; i < now.links.size(); ++i) {
        if ((now.kinds[i] & touches) == 0) continue;
        const Link& link = now.links[i];
        neighbours[queue[link.a]++] = link.b;
        neighbours[queue[link.b]++] = link.a;
    }
    levels.assign(count, no_level);
    queue.clear();
    for (std::uint32_t b = 0; b < count; ++b)
        if (now.movable[b] == 0 && first[b] != first[b + 1]) {
            levels[b] = 0;
            queue.push_back(b);
        }
    level_max = 0;
    for (std::size_t i = 0; i < queue.size(); ++i) { // each body enters once, so the reserved size is enough
        const std::uint32_t b = queue[i];
        level_max = levels[b];
        for (std::uint32_t n = first[b]; n < first[b + 1]; ++n) {
            if (levels[neighbours[n]] != no_level) continue;
            levels[neighbours[n]] = levels[b] + 1;
            queue.push_back(neighbours[n]);
        }
    }
}

/// Sorts contacts by the sum of their bodies' levels, the highest first; contacts of bodies without a level come first.
void ContactOrder::sort_down() {
    const std::uint32_t above = level_max + 1;
    const auto key = [&](const Link& link) {
        return 2 * above - std::min(levels[link.a], above) - std::min(levels[link.b], above);
    };
    counts.assign(std::size_t{2} * above + 1, 0);
    place.resize(now.links.size());
    for (std::size_t i = 0; i < now.links.size(); ++i) ++counts[place[i] = key(now.links[i])];
    sum_up(counts);
    down.resize(now.links.size());
    for (std::uint32_t i = 0; i < now.links.size(); ++i) down[counts[place[i]]++] = i;
}

void ContactOrder::find(std::span<const ContactHead> contacts, const SolverBodies& bodies) {
    if (down.capacity() < contacts.size() + 2 || levels.capacity() < bodies.body.size() + 2)
        reserve(base::room_for(contacts.size()), base::room_for(bodies.body.size()));
    if (contacts.empty()) {
        levels.assign(bodies.body.size(), no_level);
        down.clear(), now.links.clear();
        all_kinds = 0, ++versions;
        return;
    }
    const bool is_kept = read(contacts, bodies) && is_known;
    paths.take(is_kept, base::Path::order_found, base::Path::order_kept);
    if (is_kept) return;
    const bool has_same_links = is_known && now.links == before.links && now.movable == before.movable;
    is_known = true;
    std::swap(down, down_before);
    find_levels();
    sort_down();
    if (!has_same_links || down != down_before) ++versions;
}

CheckVector<std::uint32_t> ContactOrder::ranks() const {
    CheckVector<std::uint32_t> rank_of(down.size());
    for (std::uint32_t rank = 0; rank < down.size(); ++rank) rank_of[down[rank]] = rank;
    return rank_of;
}

void ContactOrder::poison(std::byte with) {
    base::poison(with, now.links, now.kinds, now.movable, all_kinds, levels, first, neighbours, queue, down,
                 place, counts);
    is_known = false;
}

} // namespace lockstone::solve
