// Bodies that a much heavier body presses against something that does not move.
//
// A pass gives a contact of two bodies the impulse that stops both. Of a light body between the ground and a body of M times its mass, the ground
// takes the impulse back in the same pass, so the heavy body loses 1 / (M + 1) of its speed in a pass: it sinks into the light one, and is
// thrown out again. Where the heavy body is no more than `pressed_ratio` times as heavy, a few passes are enough. So a body that is pressed
// counts as 1 / pressed_ratio of the mass of the heavy one, in their contacts alone. The ground takes up the difference in momentum: a light
// body with nothing behind it keeps its mass, and momentum is kept. The impulses of such contacts are those of the mass that they count with.
// source: Guendelman, Bridson, Fedkiw, Nonconvex Rigid Bodies with Stacking, SIGGRAPH 2003, for the idea that what is supported is heavier
#pragma once

#include "solve/bodies/solver_body.h"
#include "solve/contacts/contact.h"

#include <cstdint>
#include <span>
#include <vector>

namespace lockstone::solve {

inline constexpr std::int64_t pressed_ratio = 4;

/// A push that is no contact: of a wheel on what it stands on.
struct Load {
    std::uint32_t light, heavy; ///< rows of the body columns; the mass of the second pushes the first
    UnitVec3 push;
};

class PressedBodies {
  public:
    /// Sets BodyInertia::pressed of each body that is touched by one of more than pressed_ratio times its mass, and that other contacts support
    /// against its push: by something that does not move, or by way of other bodies. Call it when bodies are in solver form, before contacts are
    /// prepared. Returns true where there are any. The order of `contacts` is the same in every execution mode.
    bool find(std::span<const Contact> contacts, std::span<const Load> loads,
              std::span<const BodyTraits> traits, SolverBodies& bodies);
    void reserve(std::size_t bodies, std::size_t contacts);
    /// Fills with a byte the lists that find() makes in each tick.
    void poison(std::byte with);

  private:
    bool add(std::span<const Contact> contacts, const Load& load, SolverBodies& bodies);
    void list_contacts(std::span<const Contact> contacts, std::size_t bodies);
    bool is_supported(std::span<const Contact> contacts, const SolverBodies& bodies, const Load& load);

    /// The contacts that touch a body: first[body] .. first[body + 1] of of_body
    std::vector<std::uint32_t> first, of_body;
    bool is_listed;                    ///< in this tick
    std::vector<std::uint32_t> behind; ///< the bodies found by a search
};

} // namespace lockstone::solve
