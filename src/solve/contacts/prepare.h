// From a contact to its lane of a pack. See contact_solver.h for the symbols.
#pragma once

#include "dynamics/contact.h"
#include "solve/contacts/pack.h"

namespace lockstone::solve {

/// What preparing a contact reads.
struct PrepareInput {
    std::span<const dynamics::Contact> contacts;
    std::span<const dynamics::ContactMemory> memory;
    std::span<const dynamics::BodyMass> mass;
    const dynamics::StepConstants& step;
    const dynamics::SolverBodies& bodies;
};

/// An empty pack: nothing in it moves anything.
template <unsigned N> void clear_pack(ContactPack<N>& pack, std::uint32_t still_body);
template <unsigned N>
void fill_lane(ContactPack<N>& pack, unsigned lane, const dynamics::Contact& contact, const PrepareInput& in);

/// The entry of a contact that bounces; its lane is filled already.
template <unsigned N>
void fill_bounce(Bounce& bounce, const ContactPack<N>& pack, const dynamics::Contact& contact);
/// The entry of a contact with rolling resistance.
void fill_rolling(Rolling& rolling, const dynamics::Contact& contact, const PrepareInput& in);

/// m^-1 of a symmetric matrix, by rows of the lower triangle, response_bits to inverse_bits. What nothing answers to, or
/// depends on the rows before it, gets zero rows.
void invert3(const std::int64_t (&m)[6], std::int32_t (&out)[6]);

} // namespace lockstone::solve
