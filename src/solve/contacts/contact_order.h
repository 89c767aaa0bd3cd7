// In what order contacts are solved, and which of them at once.
//
// A pass over the contacts carries a change of load only as far as the order of the contacts lets it. Both passes, the soft one and the
// relaxing one, go from the top of a pile down: so each pass brings the whole load of the pile to the ground, and stacks stop swaying. In a
// random order, or in one that is reversed between the passes, the answer of the ground comes some substeps late, and walls sway by
// themselves: a pyramid with a base of 10 by 6 mm at 3 Hz, for ever.
//
//   level    of a body: the number of contacts between it and something that nothing moves
//
// Which of them are solved at once is in contact_packs.h.
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
    /// Orders contacts from the top down, those of one level by index. The order depends on which bodies touch and can move, and on
    /// nothing else.
    void find(std::span<const ContactHead> contacts, const SolverBodies& bodies);

    /// Fills what find() makes anew with a byte.
    void poison(std::byte with);

    /// Indices of the contacts in order, after `find`.
    std::span<const std::uint32_t> down_from_the_top() const { return down; }
    /// The place of each contact in that order.
    CheckVector<std::uint32_t> ranks() const;
    struct Link {
        std::uint32_t a, b; ///< bodies
        bool operator==(const Link&) const = default;
    };
    const Link& link(std::uint32_t contact) const { return now.links[contact]; }
    std::size_t body_count() const { return now.movable.size(); }
    bool moves(std::uint32_t body) const { return now.movable[body] != 0; }
    /// Goes up whenever find() finds other contacts, or another order. Of what rests it finds the same in most ticks.
    std::uint64_t version() const { return versions; }
    /// One of the bodies of a contact that it moves: a, or b where nothing moves a.
    std::uint32_t moved_body(std::uint32_t contact) const {
        return moves(link(contact).a) ? link(contact).a : link(contact).b;
    }

    enum Kind : std::uint8_t { carried = 1, several = 2, touches = 4, bounces = 8, rolls = 16, driven = 32 };
    /// What a contact is, as bits, and what any of them is. Driven: one of the bodies moves, though impulses do not move it.
    std::uint8_t kind(std::uint32_t contact) const { return now.kinds[contact]; }
    std::uint8_t any_kind() const { return all_kinds; }
    /// Of a body, after `find`; no_level when nothing holds it.
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
    Given now, before;     ///< before: of the last find()
    bool is_known = false; ///< the last find() is
    std::uint64_t versions = 0;
    std::uint8_t all_kinds = 0;
    std::uint32_t level_max = 0;       ///< of the bodies that are held
    std::vector<std::uint32_t> levels; ///< by body
    /// Bodies that touch body b: neighbours[first[b] .. first[b + 1])
    std::vector<std::uint32_t> first, neighbours;
    std::vector<std::uint32_t> queue;
    std::vector<std::uint32_t> down, down_before; ///< contacts from the top down
    std::vector<std::uint32_t> place;             ///< by contact: its key
    std::vector<std::uint32_t> counts;            ///< of a counting sort
};

/// Of a contact whose other numbers are set.
ContactHead head_of(const Contact& contact);

} // namespace lockstone::solve
