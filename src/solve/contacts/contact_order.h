// The order in which contacts are solved.
//
// A pass over the contacts carries a change of load only as far as the order of the contacts lets it. Both passes, the
// soft one and the relaxing one, go from the top of a pile down, so each pass brings the whole load of the pile to the
// ground, and stacks stop swaying. In a random order, or in one that is reversed between the passes, the reaction of
// the ground comes some substeps late, and walls sway without a cause: a pyramid with a base of 10 by 6 mm at 3 Hz, for
// ever.
//
//   level    of a body: the number of contacts from it to the nearest body that impulses do not move
//
// contact_packs.h chooses which contacts are solved at once.
#pragma once

#include "solve/bodies/solver_body.h"
#include "solve/bodies/solving_order.h"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace lockstone::solve {

struct Contact;
struct ContactHead;

class ContactOrder {
  public:
    void reserve(std::size_t contacts, std::size_t bodies);
    /// Orders contacts from the top down, those of one level by index. The order depends only on which bodies touch and
    /// which bodies impulses move.
    void find(std::span<const ContactHead> contacts, const SolverBodies& bodies);

    /// Fills all data that find() computes in each tick with the byte `with`, and drops the cached order.
    void poison(std::byte with);

    /// Indices of the contacts in order, after `find`.
    std::span<const std::uint32_t> down_from_the_top() const { return down; }
    /// The position of each contact in that order.
    CheckVector<std::uint32_t> ranks() const;
    struct Link {
        /// The bodies of a contact.
        std::uint32_t a, b;
        bool operator==(const Link&) const = default;
    };
    const Link& link(std::uint32_t contact) const { return now.links[contact]; }
    std::size_t body_count() const { return now.movable.size(); }
    bool moves(std::uint32_t body) const { return now.movable[body] != 0; }
    /// Increases when find() finds other contacts, or another order. For bodies at rest it stays equal in most ticks.
    std::uint64_t version() const { return versions; }
    /// One of the bodies of a contact that impulses move: a, or b where they do not move a.
    std::uint32_t moved_body(std::uint32_t contact) const {
        return moves(link(contact).a) ? link(contact).a : link(contact).b;
    }

    enum Kind : std::uint8_t { carried = 1, several = 2, touches = 4, bounces = 8, rolls = 16, driven = 32 };
    /// The properties of a contact, as bits of Kind; any_kind() has the bits of all contacts. `driven`: one of the
    /// bodies moves, but impulses do not move it.
    std::uint8_t kind(std::uint32_t contact) const { return now.kinds[contact]; }
    std::uint8_t any_kind() const { return all_kinds; }
    /// The level of a body, after `find`; no_level when no chain of touching contacts joins it to a body that does not
    /// move.
    std::uint32_t level(std::uint32_t body) const { return levels[body]; }

    static constexpr std::uint32_t no_level = 0xffffffffu;

    base::Paths paths; ///< of the tick

  private:
    bool read(std::span<const ContactHead> contacts, const SolverBodies& bodies);
    void find_levels();
    void sort_down();

    struct Given {
        std::vector<Link> links;           ///< by contact
        std::vector<std::uint8_t> kinds;   ///< by contact: Kind
        std::vector<std::uint8_t> movable; ///< by body: not 0 where impulses move it
    };
    /// now: of the current find(); before: of the find() before it
    Given now, before;
    bool is_known = false; ///< `now` holds the result of a find()
    std::uint64_t versions = 0;
    std::uint8_t all_kinds = 0;
    std::uint32_t level_max = 0;       ///< of the bodies that have a level
    std::vector<std::uint32_t> levels; ///< by body
    /// Bodies that touch body b: neighbours[first[b] .. first[b + 1])
    std::vector<std::uint32_t> first, neighbours;
    std::vector<std::uint32_t> queue;
    std::vector<std::uint32_t> down, down_before; ///< contacts from the top down
    std::vector<std::uint32_t> place;             ///< by contact: its sort key
    std::vector<std::uint32_t> counts;            ///< of the counting sort
};

/// The head of a contact; all other members of the contact have to be set.
ContactHead head_of(const Contact& contact);

} // namespace lockstone::solve
