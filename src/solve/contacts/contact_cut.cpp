#include "solve/contacts/contact_cut.h"

#include "base/joined.h"
#include "base/poison.h"
#include "solve/bodies/sides.h"
#include "solve/contacts/contact_order.h"

#include <algorithm>
#include <array>

namespace lockstone::solve {

void ContactCut::reserve(std::size_t count, std::size_t bodies) {
    share_of.reserve(count), parent.reserve(bodies + 1), contacts.reserve(bodies + 1);
}

void ContactCut::make_one(const ContactOrder& order) { share_of.assign(order.down_from_the_top().size(), 0); }

void ContactCut::cut_by_place(const ContactOrder& order, std::span<const Transform> poses,
                              std::uint32_t shares) {
    const auto place_of = [&](std::uint32_t contact) { // a contact that moves no body counts as at the origin
        const std::uint32_t body = order.moved_body(contact);
        return body < poses.size() ? poses[body].position : Vec3{};
    };
    std::array<Vec3, Sides::samples_max> sample;
    std::size_t samples = 0;
    const std::span<const std::uint32_t> down = order.down_from_the_top();
    for (std::size_t i = 0; i < down.size(); i += Sides::stride_of(down.size()))
        sample[samples++] = place_of(down[i]);
    const Sides sides{std::span<const Vec3>(sample).first(samples), shares};
    share_of.resize(down.size());
    for (std::uint32_t i = 0; i < share_of.size(); ++i)
        share_of[i] = static_cast<std::uint8_t>(sides.side_of(place_of(i)));
}

bool ContactCut::cut_by_island(const ContactOrder& order, std::uint32_t shares) {
    const std::uint32_t count = static_cast<std::uint32_t>(order.down_from_the_top().size());
    base::start_sets(parent, order.body_count());
    const auto island_of = [&](std::uint32_t contact) {
        return base::root_of(parent, order.moved_body(contact));
    };
    for (std::uint32_t i = 0; i < count; ++i) {
        const ContactOrder::Link link = order.link(i);
        if (order.moves(link.a) && order.moves(link.b)) base::join(parent, link.a, link.b);
    }
    contacts.assign(order.body_count(), 0);
    std::uint32_t most = 0;
    for (std::uint32_t i = 0; i < count; ++i) most = std::max(most, ++contacts[island_of(i)]);
    if (std::uint64_t{most} * shares * 4 > std::uint64_t{count}) return false;
    // An island joins the share that is being filled when its first contact comes.
    share_of.resize(count);
    std::uint32_t placed = 0, full = count / shares + 1, share = 0;
    for (std::uint32_t i = 0; i < count; ++i) {
        std::uint32_t& of_island = contacts[island_of(i)];
        constexpr std::uint32_t is_placed = 1u << 31;
        if ((of_island & is_placed) == 0) {
            if (placed >= (share + 1) * full) ++share;
            placed += of_island;
            of_island = is_placed | share;
        }
        share_of[i] = static_cast<std::uint8_t>(of_island);
    }
    return true;
}

void ContactCut::cut_by_order(const ContactOrder& order, std::uint32_t shares) {
    const std::span<const std::uint32_t> down = order.down_from_the_top();
    const auto cost_of = [&](std::uint32_t i) -> std::uint64_t {
        static_assert(ContactOrder::carried == 1 && ContactOrder::several == 2);
        constexpr std::uint8_t costs[] = {3, 4, 4, 7}; // about the nanoseconds of a pass in lanes of 64 bytes
        return costs[order.kind(i) & (ContactOrder::carried | ContactOrder::several)];
    };
    std::uint64_t all = 0, so_far = 0;
    for (const std::uint32_t i : down) all += cost_of(i);
    share_of.resize(down.size());
    for (const std::uint32_t i : down) {
        share_of[i] = static_cast<std::uint8_t>(so_far * shares / all);
        so_far += cost_of(i);
    }
}

void ContactCut::poison(std::byte with) { base::poison(with, share_of, parent, contacts); }

} // namespace lockstone::solve
