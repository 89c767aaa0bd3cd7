// Cuts the contacts into shares of about equal work. Each share is a strand, which one worker solves.
#pragma once

#include "lockstone/math/vec.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lockstone::solve {

class ContactOrder;

class ContactCut {
  public:
    void reserve(std::size_t contacts, std::size_t bodies);

    /// Each function cuts the contacts of an order into at most base::strands_max shares; a share's number is below
    /// `shares`.

    void make_one(const ContactOrder& order);
    /// Shares are regions of space: few bodies touch two regions, and all shares have work in each pass. `poses`: by
    /// body. A contact whose moved body has no pose, such as the still body, counts as at the origin.
    void cut_by_place(const ContactOrder& order, std::span<const Transform> poses, std::uint32_t shares);
    /// Shares are whole islands. Returns false where an island has more contacts than a quarter of a share.
    bool cut_by_island(const ContactOrder& order, std::uint32_t shares);
    /// Shares are consecutive parts of the order. Within one pass, a share depends on the shares before it. Where
    /// passes overlap, all shares have work at once. This also cuts chains of contacts that depend on each other within
    /// a pass.
    void cut_by_order(const ContactOrder& order, std::uint32_t shares);

    std::uint32_t of(std::uint32_t contact) const { return share_of[contact]; }

    void poison(std::byte with);

  private:
    /// by contact
    std::vector<std::uint8_t> share_of;
    /// by body: the parents in the trees of islands; and the number of contacts of an island, at its root
    std::vector<std::uint32_t> parent, contacts;
};

} // namespace lockstone::solve
