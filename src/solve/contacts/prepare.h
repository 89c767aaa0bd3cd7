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

/// An empty pack: nothing in it moves anything.
template <unsigned N> void clear_pack(ContactPack<N>& pack, std::uint32_t still_body);
template <unsigned N> void clear_input(PackInput<N>& input);
/// One lane of both: the pack gets what a contact has once, the input what ContactKernel::prepare() makes the rest from.
template <unsigned N>
void fill_lane(ContactPack<N>& pack, PackInput<N>& input, unsigned lane, const solve::Contact& contact,
               const PrepareInput& in);

/// The entry of a contact that bounces; its lane is filled already.
template <unsigned N>
void fill_bounce(Bounce& bounce, const ContactPack<N>& pack, const solve::Contact& contact);
/// The entry of a contact with rolling resistance.
void fill_rolling(Rolling& rolling, const solve::Contact& contact, const PrepareInput& in);

} // namespace lockstone::solve
