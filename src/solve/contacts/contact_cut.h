// Which worker solves a contact: contacts cut into shares of alike much work.
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

    /// Each makes at most base::strands_max shares of an order's contacts; share k is below the number that is asked for.

    void make_one(const ContactOrder& order);
    /// Parts of space: few bodies lie at borders, and all shares are at work in each pass. `poses`: by body that can move.
    void cut_by_place(const ContactOrder& order, std::span<const Transform> poses, std::uint32_t shares);
    /// Islands, of which no share has a part. False where one has so many contacts that shares would not be alike.
    bool cut_by_island(const ContactOrder& order, std::uint32_t shares);
    /// The first contacts in order, then those after them. Of a pass the second share can begin when the first one is done; where passes follow
    /// one another, all are at work. What follows one another within a pass is cut, too.
    void cut_by_order(const ContactOrder& order, std::uint32_t shares);

    std::uint32_t of(std::uint32_t contact) const { return share_of[contact]; }

    void poison(std::byte with);

  private:
    std::vector<std::uint8_t> share_of;          ///< by contact
    std::vector<std::uint32_t> parent, contacts; ///< by body: of the trees of islands; of an island, by root
};

} // namespace lockstone::solve
