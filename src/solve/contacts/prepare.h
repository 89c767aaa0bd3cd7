// Fills the lane of a pack from a contact. See contact_solver.h for the symbols.
#pragma once

#include "solve/contacts/contact.h"
#include "solve/contacts/pack.h"

#include <array>

namespace lockstone::solve {

/// The inputs of preparing a contact.
struct PrepareInput {
    std::span<const solve::Contact> contacts;
    std::span<const solve::ContactMemory> memory;
    solve::MassView mass;
    const solve::StepConstants& step;
    const solve::SolverBodies& bodies;
};

using Raw3 = std::array<std::int64_t, 3>;

/// Clears a pack: no lane of it moves a body. `points`: the largest number of points of its contacts; it clears at
/// least one point. Later points stay as they are, and so do the members for several points where `points` is 1: no
/// pass reads them.
template <unsigned N> void clear_pack(ContactPack<N>& pack, std::uint32_t still_body, std::uint32_t points);
/// Puts the contacts of a pack into its lanes; null: the lane has no contact. The pack has to be clear. It gets the
/// data that a contact has once, and `source` gets the data from which ContactKernel::prepare() computes the rest.
template <unsigned N>
void fill_pack(ContactPack<N>& pack, PackSource& source, const solve::Contact* const (&contacts)[N],
               const PrepareInput& in);

/// Fills the entry of a contact with rolling resistance.
void fill_rolling(Rolling& rolling, const solve::Contact& contact, const PrepareInput& in);

} // namespace lockstone::solve
