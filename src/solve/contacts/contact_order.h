// In what order contacts are solved, and which of them at once.
//
// A pass over the contacts carries a change of load as far as the order lets it. From the top of a pile down, in the soft
// pass and in the relaxing one, the ground takes in every pass what came to lie on it, and stacks stop swaying. In an
// order of chance, or in one that turns round between the passes, the answer of the ground comes some substeps late, and
// walls sway by themselves: a pyramid with a base of 10 by 6 mm at 3 Hz, for ever.
//
// What overlaps deeply comes after all that: the contact that is solved last keeps the speed that it asks for, and between bodies that
// are held from all sides only that one comes apart.
//
//   level    of a body: how many contacts away what nothing moves is
//   stage    the first stage after those of all earlier contacts that move the same body: solving stage after stage is
//            solving in order, and the contacts of a stage share nothing that is written
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
    /// From the top down, then what overlaps by centimetres, the deepest last; of equals by index. Pure: depends on the
    /// contacts and on who can move, on nothing else.
    void find(std::span<const Contact> contacts, const SolverBodies& bodies);

    /// Fills what find() makes anew with a byte.
    void poison(std::byte with);

    std::uint32_t stage_count() const { return static_cast<std::uint32_t>(begin.size() - 1); }
    /// Indices of the contacts of a stage, rising within a level.
    std::span<const std::uint32_t> stage(std::uint32_t s) const {
        return std::span(staged).subspan(begin[s], begin[s + 1] - begin[s]);
    }
    /// Of a body, after `find`; no_level when nothing holds it.
    std::uint32_t level(std::uint32_t body) const { return levels[body]; }

    static constexpr std::uint32_t no_level = 0xffffffffu;

  private:
    void find_levels(std::span<const Contact> contacts, const SolverBodies& bodies);
    void sort_down(std::span<const Contact> contacts);
    void find_stages(std::span<const Contact> contacts, const SolverBodies& bodies);

    std::vector<std::int32_t> least;   ///< by contact: its least separation, Separation
    std::uint32_t level_max = 0;       ///< of the bodies that are held
    std::vector<std::uint32_t> levels; ///< by body
    /// Bodies that touch body b: neighbours[first[b] .. first[b + 1])
    std::vector<std::uint32_t> first, neighbours;
    std::vector<std::uint32_t> queue;
    std::vector<std::uint32_t> down;     ///< contacts from the top down
    std::vector<std::uint32_t> place;    ///< by contact: its key, then its stage
    std::vector<std::uint32_t> last;     ///< by body: one more than the stage of its latest contact
    std::vector<std::uint32_t> staged;   ///< contacts by stage
    std::vector<std::uint32_t> begin{0}; ///< of each stage in `staged`, and the end
    std::vector<std::uint32_t> counts;   ///< of a counting sort
};

} // namespace lockstone::solve
