// From a contact to its lane of a pack. See contact_solver.h for the symbols.
#pragma once

#include "dynamics/contact.h"
#include "solve/contacts/pack.h"

#include <array>

namespace lockstone::solve {

/// What preparing a contact reads.
struct PrepareInput {
    std::span<const dynamics::Contact> contacts;
    std::span<const dynamics::ContactMemory> memory;
    std::span<const dynamics::BodyMass> mass;
    const dynamics::StepConstants& step;
    const dynamics::SolverBodies& bodies;
};

using Raw3 = std::array<std::int64_t, 3>;

/// Where the points of a contact lie in its plane.
struct Layout {
    Raw3 centre_a, centre_b; ///< levers of the members' centre, Length
    Raw3 along[2];           ///< from the centre to the farthest point, in the plane; and that turned by a right angle
    std::int64_t arm[2][4];  ///< in units of `along`, Unit
    std::int64_t size;       ///< |along|, Length
    std::uint32_t members, count;
};

/// H H^T, fit_bits: of the level; of the tilts by rows of the lower triangle.
using Gram = std::array<std::int64_t, 4>;

/// A lane between the two halves of preparing it.
struct LaneWork {
    Layout layout;
    Gram gram;
    bool plane; ///< members lie about their centre, not on a line
    bool is_filled;
};

/// An empty pack: nothing in it moves anything.
template <unsigned N> void clear_pack(ContactPack<N>& pack, std::uint32_t still_body);
template <unsigned N> void clear_rows(RowInput<N>& rows);
/// All that rows are made of; ContactKernel::make_rows() makes them, for the lanes of a pack at once.
template <unsigned N>
void begin_lane(ContactPack<N>& pack, RowInput<N>& rows, LaneWork& work, unsigned lane, const dynamics::Contact& contact,
                const PrepareInput& in);
/// What follows from the rows: effective masses, inverses, impulses to start from.
template <unsigned N>
void end_lane(ContactPack<N>& pack, const RowInput<N>& rows, const LaneWork& work, unsigned lane,
              const dynamics::Contact& contact, const PrepareInput& in);

/// The entry of a contact that bounces; its lane is filled already.
template <unsigned N>
void fill_bounce(Bounce& bounce, const ContactPack<N>& pack, const dynamics::Contact& contact);
/// The entry of a contact with rolling resistance.
void fill_rolling(Rolling& rolling, const dynamics::Contact& contact, const PrepareInput& in);

/// m^-1 of a symmetric matrix, by rows of the lower triangle, response_bits to inverse_bits. What nothing answers to, or
/// depends on the rows before it, gets zero rows.
void invert3(const std::int64_t (&m)[6], std::int32_t (&out)[6]);

} // namespace lockstone::solve
