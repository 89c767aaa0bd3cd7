// In what order contacts are solved, and which of them at once.
//
// A pass over the contacts carries a change of load only as far as the order of the contacts lets it. Both passes, the soft one and the
// relaxing one, go from the top of a pile down: so each pass brings the whole load of the pile to the ground, and stacks stop swaying. In a
// random order, or in one that is reversed between the passes, the answer of the ground comes some substeps late, and walls sway by
// themselves: a pyramid with a base of 10 by 6 mm at 3 Hz, for ever.
//
//   level    of a body: the number of contacts between it and something that nothing moves
//   stage    the first stage after those of all earlier contacts that move the same body: solving stage after stage is
//            solving in order, and the contacts of a stage share nothing that is written
//   packs    contacts that are solved at once, in lanes. Workers take the packs of a stage in any order. Where there are none, a pack holds
//            contacts of several stages, as long as all that they wait for is in earlier packs: a pyramid of base 40 then has a
//            tenth fewer, and pack after pack it is solved in the same order
#pragma once

#include "solve/bodies/solver_body.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lockstone::solve {

struct Contact;

class ContactOrder {
  public:
    void reserve(std::size_t contacts, std::size_t bodies);
    /// Orders contacts from the top down, those of one level by index. The order depends on which bodies touch and can move, and on
    /// nothing else.
    void find(std::span<const Contact> contacts, const SolverBodies& bodies);

    /// Fills what find() makes anew with a byte.
    void poison(std::byte with);

    /// Sorts the contacts by stages, after `find`.
    void find_stages();
    std::uint32_t stage_count() const { return static_cast<std::uint32_t>((begin.size() - 1) / sorts); }
    /// Indices of the contacts of a stage: those of several points before single ones, of either those that carried something in
    /// the last tick before those that did not, and so from the top down and rising within a level.
    std::span<const std::uint32_t> stage(std::uint32_t s) const {
        return std::span(staged).subspan(begin[sorts * s], begin[sorts * (s + 1)] - begin[sorts * s]);
    }
    static constexpr std::uint32_t no_contact = 0xffffffffu;
    /// Contacts in packs of `lanes`, after `find`; lanes that are left over get `no_contact`. By stages, of which `stage_begin` gets the
    /// first pack of each, and the end; or as densely as their order allows.
    void pack_stages(std::uint32_t lanes, std::vector<std::uint32_t>& packed,
                     std::vector<std::uint32_t>& stage_begin);
    void pack_densely(std::uint32_t lanes, std::vector<std::uint32_t>& packed);

    enum Kind : std::uint8_t { carried = 1, several = 2, touches = 4, bounces = 8, rolls = 16 };
    /// What a contact is, as bits, and what any of them is.
    std::uint8_t kind(std::uint32_t contact) const { return kinds[contact]; }
    std::uint8_t any_kind() const { return all_kinds; }
    /// Of a body, after `find`; no_level when nothing holds it.
    std::uint32_t level(std::uint32_t body) const { return levels[body]; }

    static constexpr std::uint32_t no_level = 0xffffffffu;

  private:
    /// Of contacts, which are far apart in memory, all that is looked at again.
    struct Link {
        std::uint32_t a, b; ///< bodies
    };
    static constexpr std::uint32_t sorts = 4; ///< of contacts: several points or one, carried or did not
    std::uint32_t sort_of(std::uint32_t contact) const { return ~kinds[contact] & (carried | several); }
    /// The next contact that moves the same body, of either body; or `no_contact`.
    struct Followers {
        std::uint32_t of_a, of_b;
    };
    class Ready;

    void read(std::span<const Contact> contacts, const SolverBodies& bodies);
    void find_levels();
    void sort_down();
    void find_followers(Ready& ready);

    std::vector<Link> links;         ///< by contact
    std::vector<std::uint8_t> kinds; ///< by contact: Kind
    std::uint8_t all_kinds = 0;
    std::vector<std::uint32_t> moves;  ///< by body: all ones where impulses move it, or zero
    std::uint32_t level_max = 0;       ///< of the bodies that are held
    std::vector<std::uint32_t> levels; ///< by body
    /// Bodies that touch body b: neighbours[first[b] .. first[b + 1])
    std::vector<std::uint32_t> first, neighbours;
    std::vector<std::uint32_t> queue;
    std::vector<std::uint32_t> down; ///< contacts from the top down
    /// By contact: its key, then its stage and sort, or the next that is ready
    std::vector<std::uint32_t> place;
    /// By body: one more than its latest contact, or than its stage; 0: none
    std::vector<std::uint32_t> last;
    std::vector<Followers> followers; ///< by contact
    std::vector<std::uint8_t> waits;  ///< by contact: how many contacts it follows that are in no pack so far
    std::vector<std::uint32_t> staged;   ///< contacts by stage and sort
    std::vector<std::uint32_t> begin{0}; ///< of each sort of each stage in `staged`, and the end
    std::vector<std::uint32_t> counts;   ///< of a counting sort
};

} // namespace lockstone::solve
