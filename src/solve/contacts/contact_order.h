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
