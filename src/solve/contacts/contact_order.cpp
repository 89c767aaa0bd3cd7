#include "solve/contacts/contact_order.h"

#include "base/poison.h"
#include "base/room.h"
#include "solve/contacts/contact.h"

#include <algorithm>

namespace lockstone::solve {

namespace {

/// Points farther apart carry nothing soon [m].
constexpr std::int32_t touching = decimal<Separation>("0.0005").raw;

std::int32_t least_separation(const Contact& contact) {
    std::int32_t least = Separation::max().raw;
    for (std::uint32_t k = 0; k < contact.count; ++k)
        least = std::min(least, contact.points[k].separation.raw);
    return least;
}

/// counts[k] items of key k become where the items of key k begin.
void sum_up(std::span<std::uint32_t> counts) {
    std::uint32_t sum = 0;
    for (std::uint32_t& count : counts) {
        const std::uint32_t own = count;
        count = sum;
        sum += own;
    }
}

} // namespace

/// For the most that these contacts could need, so that a tick in which more of them touch does not allocate.
void ContactOrder::reserve(std::size_t contacts, std::size_t bodies) {
    for (auto* list : {&levels, &first, &queue, &last}) list->reserve(bodies + 2);
    for (auto* list : {&down, &place, &staged, &begin}) list->reserve(contacts + 2);
    least.reserve(contacts);
    neighbours.reserve(2 * contacts);
    counts.reserve(std::max(2 * bodies + 4, contacts + 2));
}

/// Breadth first over the contacts that touch, from what nothing moves.
void ContactOrder::find_levels(std::span<const Contact> contacts, const SolverBodies& bodies) {
    const std::size_t count = bodies.body.size();
    first.assign(count + 1, 0);
    least.resize(contacts.size());
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        const Contact& c = contacts[i];
        least[i] = least_separation(c);
        if (least[i] < touching) ++first[c.body_a], ++first[c.body_b];
    }
    sum_up(first);
    neighbours.resize(first[count]);
    queue.assign(first.begin(), first.end() - 1); // where the next neighbour of each body goes
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        if (least[i] >= touching) continue;
        const Contact& c = contacts[i];
        neighbours[queue[c.body_a]++] = c.body_b;
        neighbours[queue[c.body_b]++] = c.body_a;
    }
    levels.assign(count, no_level);
    queue.clear();
    for (std::uint32_t b = 0; b < count; ++b)
        if (!bodies.step[b].movable && first[b] != first[b + 1]) {
            levels[b] = 0;
            queue.push_back(b);
        }
    level_max = 0;
    for (std::size_t i = 0; i < queue.size(); ++i) { // each body enters once: no more than were reserved
        const std::uint32_t b = queue[i];
        level_max = levels[b];
        for (std::uint32_t n = first[b]; n < first[b + 1]; ++n) {
            if (levels[neighbours[n]] != no_level) continue;
            levels[neighbours[n]] = levels[b] + 1;
            queue.push_back(neighbours[n]);
        }
    }
}

/// Sorts contacts by the sum of their bodies' levels, the highest first; contacts of bodies that nothing holds come before those.
void ContactOrder::sort_down(std::span<const Contact> contacts) {
    const std::uint32_t above = level_max + 1;
    const auto key = [&](const Contact& c) {
        return 2 * above - std::min(levels[c.body_a], above) - std::min(levels[c.body_b], above);
    };
    counts.assign(std::size_t{2} * above + 1, 0);
    place.resize(contacts.size()); // of its key, until find_stages()
    for (std::size_t i = 0; i < contacts.size(); ++i) ++counts[place[i] = key(contacts[i])];
    sum_up(counts);
    down.resize(contacts.size());
    for (std::uint32_t i = 0; i < contacts.size(); ++i) down[counts[place[i]]++] = i;
}

void ContactOrder::find_stages(std::span<const Contact> contacts, const SolverBodies& bodies) {
    last.assign(bodies.body.size(), 0);
    place.resize(contacts.size());
    begin.assign(1, 0);
    for (const std::uint32_t i : down) {
        const std::uint32_t a = contacts[i].body_a, b = contacts[i].body_b;
        const bool a_moves = bodies.step[a].movable, b_moves = bodies.step[b].movable;
        const std::uint32_t stage = std::max(a_moves ? last[a] : 0, b_moves ? last[b] : 0);
        if (a_moves) last[a] = stage + 1;
        if (b_moves) last[b] = stage + 1;
        if (stage + 1 == begin.size()) begin.push_back(0); // at most one stage further than before
        ++begin[stage];
        place[i] = stage;
    }
    sum_up(begin);
    counts.assign(begin.begin(), begin.end());
    staged.resize(contacts.size());
    for (const std::uint32_t i : down) staged[counts[place[i]]++] = i;
}

void ContactOrder::find(std::span<const Contact> contacts, const SolverBodies& bodies) {
    if (down.capacity() < contacts.size() + 2 || levels.capacity() < bodies.body.size() + 2)
        reserve(base::room_for(contacts.size()), base::room_for(bodies.body.size()));
    if (contacts.empty()) { // no stages
        levels.assign(bodies.body.size(), no_level);
        begin.assign(1, 0);
        return;
    }
    find_levels(contacts, bodies);
    sort_down(contacts);
    find_stages(contacts, bodies);
}

void ContactOrder::poison(std::byte with) {
    base::poison(with, least, levels, first, neighbours, queue, down, place, last, staged, begin, counts);
}

} // namespace lockstone::solve
