#include "solve/contacts/contact_order.h"

#include "base/poison.h"
#include "base/room.h"
#include "solve/contacts/contact.h"

#include <algorithm>

namespace lockstone::solve {

namespace {

/// Points farther apart carry nothing soon [m].
constexpr std::int32_t touching = decimal<Separation>("0.0005").raw;

std::uint8_t kind_of(const Contact& contact) {
    std::int32_t least = Separation::max().raw, carried = 0;
    for (std::uint32_t k = 0; k < contact.count; ++k) {
        least = std::min(least, contact.points[k].separation.raw);
        carried |= contact.points[k].impulse.raw;
    }
    const auto bit = [](bool is, ContactOrder::Kind kind) { return is ? unsigned{kind} : 0u; };
    return static_cast<std::uint8_t>(bit(carried != 0, ContactOrder::carried) |
                                     bit(contact.count > 1, ContactOrder::several) |
                                     bit(least < touching, ContactOrder::touches) |
                                     bit(contact.restitution > Unit{}, ContactOrder::bounces) |
                                     bit(contact.rolling > Unit{}, ContactOrder::rolls));
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
    for (auto* list : {&moves, &levels, &first, &queue, &last}) list->reserve(bodies + 2);
    for (auto* list : {&down, &place, &staged}) list->reserve(contacts + 2);
    links.reserve(contacts), kinds.reserve(contacts), followers.reserve(contacts), waits.reserve(contacts);
    neighbours.reserve(2 * contacts);
    begin.reserve(sorts * contacts + 2);
    counts.reserve(std::max(2 * bodies + 4, sorts * contacts + 2));
}

/// Counts the neighbours of bodies, too.
void ContactOrder::read(std::span<const Contact> contacts, const SolverBodies& bodies) {
    const std::size_t count = bodies.body.size();
    moves.resize(count);
    for (std::size_t b = 0; b < count; ++b) moves[b] = bodies.step[b].movable ? 0xffffffffu : 0;
    first.assign(count + 1, 0);
    links.resize(contacts.size()), kinds.resize(contacts.size());
    all_kinds = 0;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        const Contact& c = contacts[i];
        links[i] = {c.body_a, c.body_b};
        kinds[i] = kind_of(c);
        all_kinds |= kinds[i];
        const std::uint32_t one = (kinds[i] & touches) != 0 ? 1 : 0;
        first[c.body_a] += one, first[c.body_b] += one;
    }
}

/// Breadth first over the contacts that touch, from what nothing moves.
void ContactOrder::find_levels() {
    const std::size_t count = moves.size();
    sum_up(first);
    neighbours.resize(first[count]);
    queue.assign(first.begin(), first.end() - 1); // where the next neighbour of each body goes
    for (std::size_t i = 0; i < links.size(); ++i) {
        if ((kinds[i] & touches) == 0) continue;
        const Link& link = links[i];
        neighbours[queue[link.a]++] = link.b;
        neighbours[queue[link.b]++] = link.a;
    }
    levels.assign(count, no_level);
    queue.clear();
    for (std::uint32_t b = 0; b < count; ++b)
        if (moves[b] == 0 && first[b] != first[b + 1]) {
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
void ContactOrder::sort_down() {
    const std::uint32_t above = level_max + 1;
    const auto key = [&](const Link& link) {
        return 2 * above - std::min(levels[link.a], above) - std::min(levels[link.b], above);
    };
    counts.assign(std::size_t{2} * above + 1, 0);
    place.resize(links.size()); // of its key, until find_stages()
    for (std::size_t i = 0; i < links.size(); ++i) ++counts[place[i] = key(links[i])];
    sum_up(counts);
    down.resize(links.size());
    for (std::uint32_t i = 0; i < links.size(); ++i) down[counts[place[i]]++] = i;
}

void ContactOrder::find_stages() {
    last.assign(moves.size(), 0);
    begin.clear();
    for (const std::uint32_t i : down) {
        const Link& link = links[i];
        const std::uint32_t stage = std::max(last[link.a], last[link.b]);
        last[link.a] = (stage + 1) & moves[link.a], last[link.b] = (stage + 1) & moves[link.b];
        if (sorts * stage == begin.size())
            begin.insert(begin.end(), sorts, 0); // at most one further than before
        place[i] = sorts * stage + sort_of(i);
        ++begin[place[i]];
    }
    begin.push_back(0);
    sum_up(begin);
    counts.assign(begin.begin(), begin.end());
    staged.resize(links.size());
    for (const std::uint32_t i : down) staged[counts[place[i]]++] = i;
}

void ContactOrder::find(std::span<const Contact> contacts, const SolverBodies& bodies) {
    if (down.capacity() < contacts.size() + 2 || levels.capacity() < bodies.body.size() + 2)
        reserve(base::room_for(contacts.size()), base::room_for(bodies.body.size()));
    if (contacts.empty()) {
        levels.assign(bodies.body.size(), no_level);
        down.clear();
        all_kinds = 0;
        return;
    }
    read(contacts, bodies);
    find_levels();
    sort_down();
}

void ContactOrder::pack_stages(std::uint32_t lanes, std::vector<std::uint32_t>& packed,
                               std::vector<std::uint32_t>& stage_begin) {
    find_stages();
    stage_begin.clear(), packed.clear();
    base::make_room(stage_begin, stage_count() + 1);
    base::make_room(packed, down.size() + std::size_t{lanes - 1} * stage_count());
    for (std::uint32_t s = 0; s < stage_count(); ++s) {
        stage_begin.push_back(static_cast<std::uint32_t>(packed.size()) / lanes);
        packed.insert(packed.end(), stage(s).begin(), stage(s).end());
        while (packed.size() % lanes != 0) packed.push_back(no_contact);
    }
    stage_begin.push_back(static_cast<std::uint32_t>(packed.size()) / lanes);
}

/// Contacts that wait for none, of each sort in the order in which they became so.
class ContactOrder::Ready {
  public:
    /// `next`: room by contact.
    explicit Ready(std::span<std::uint32_t> next) : next(next) {}

    void add(std::uint32_t contact, std::uint32_t sort) {
        Queue& line = queues[sort];
        (line.count != 0 ? next[line.back] : line.front) = contact;
        line.back = contact;
        ++line.count;
    }
    /// Of which sort the next pack is: the first that fills it, or the first that there is. `sorts`: none.
    std::uint32_t next_sort(std::uint32_t lanes) const {
        std::uint32_t some = sorts;
        for (std::uint32_t sort = 0; sort < sorts; ++sort) {
            if (queues[sort].count >= lanes) return sort;
            if (queues[sort].count != 0 && some == sorts) some = sort;
        }
        return some;
    }
    /// At most so many contacts that a pack of a sort takes: none costs it more by what its own lack. Returns how many.
    std::uint32_t take(std::uint32_t sort, std::uint32_t most, std::uint32_t* to) {
        std::uint32_t taken = 0;
        for (std::uint32_t from = sort; from < sorts; ++from) {
            if ((sort & ~from) != 0) continue;
            Queue& line = queues[from];
            for (; line.count != 0 && taken < most; --line.count) {
                to[taken++] = line.front;
                line.front = next[line.front];
            }
        }
        return taken;
    }

  private:
    struct Queue {
        std::uint32_t count = 0, front = 0, back = 0;
    };
    Queue queues[sorts];
    std::span<std::uint32_t> next;
};

void ContactOrder::find_followers(Ready& ready) {
    last.assign(moves.size(), 0);
    followers.resize(links.size()), waits.resize(links.size());
    const auto follow = [&](std::uint32_t i, std::uint32_t body) -> std::uint8_t {
        const std::uint32_t before = last[body];
        last[body] = (i + 1) & moves[body];
        if (before == 0) return 0;
        Followers& of = followers[before - 1];
        (links[before - 1].a == body ? of.of_a : of.of_b) = i;
        return 1;
    };
    for (const std::uint32_t i : down) {
        followers[i] = {no_contact, no_contact};
        waits[i] = static_cast<std::uint8_t>(follow(i, links[i].a) + follow(i, links[i].b));
        if (waits[i] == 0) ready.add(i, sort_of(i));
    }
}

void ContactOrder::pack_densely(std::uint32_t lanes, std::vector<std::uint32_t>& packed) {
    packed.clear();
    base::make_room(packed, down.size() + down.size() / 4 + lanes);
    Ready ready(place);
    find_followers(ready);
    const auto is_over = [&](std::uint32_t contact) {
        if (contact != no_contact && --waits[contact] == 0) ready.add(contact, sort_of(contact));
    };
    for (std::uint32_t sort; (sort = ready.next_sort(lanes)) != sorts;) {
        const std::size_t at = packed.size();
        packed.resize(at + lanes, no_contact);
        const std::uint32_t taken = ready.take(sort, lanes, &packed[at]);
        for (std::size_t i = at; i < at + taken; ++i) {
            const Followers& of = followers[packed[i]];
            is_over(of.of_a), is_over(of.of_b);
        }
    }
}

void ContactOrder::poison(std::byte with) {
    base::poison(with, links, kinds, all_kinds, moves, levels, first, neighbours, queue, down, place, last,
                 followers, waits, staged, begin, counts);
}

} // namespace lockstone::solve
