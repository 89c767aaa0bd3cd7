// From a contact to its lane of a pack. See contact_solver.h for the symbols.
#pragma once

#include "solve/contacts/contact.h"
#include "solve/contacts/pack.h"

#include <array>

namespace lockstone::solve {

/// What preparing a contact reads.
struct PrepareInput {
    std::span<const solve::Contact> contacts;
    std::span<const solve::ContactMemory> memory;
    solve::MassView mass;
    const solve::StepConstants& step;
    const solve::SolverBodies& bodies;
};

using Raw3 = std::array<std::int64_t, 3>;

/// An empty pack: nothing in it moves anything. `points`: most that its contacts will have, at least 1. Those behind stay as they are, and
/// with one point what only several have: nobody looks at that.
template <unsigned N> void clear_pack(ContactPack<N>& pack, std::uint32_t still_body, std::uint32_t points);
/// The contacts of a pack, by lane, null: none. The pack, which is empty, gets what a contact has once, the source where
/// ContactKernel::prepare() finds the rest.
template <unsigned N>
void fill_pack(ContactPack<N>& pack, PackSource& source, const solve::Contact* const (&contacts)[N],
               const PrepareInput& in);

/// The entry of a contact that bounces; its lane is filled already.
void fill_bounce(Bounce& bounce, const solve::Contact& contact);
/// The entry of a contact with rolling resistance.
void fill_rolling(Rolling& rolling, const solve::Contact& contact, const PrepareInput& in);

} // namespace lockstone::solve
