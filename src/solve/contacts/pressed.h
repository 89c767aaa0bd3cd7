// Bodies that a much heavier body presses against a body that does not move.
//
// A pass gives a contact of two bodies the impulse that stops both. Where a light body lies between the ground and a
// body of M times its mass, the ground takes the impulse back in the same pass. So the heavy body loses only 1 / (M +
// 1) of its speed in a pass: it sinks into the light body and is thrown out again. Where the heavy body is at most
// `pressed_ratio` times as heavy, a few passes are enough. So a pressed body counts as 1 / pressed_ratio of the mass of
// the heavy one, in their contacts alone. The ground takes up the difference in momentum. A light body without support
// keeps its mass, and momentum is kept. The impulses of such contacts are those of the mass that they count with.
// source: Guendelman, Bridson, Fedkiw, Nonconvex Rigid Bodies with Stacking, SIGGRAPH 2003 (supported bodies count as
// heavier)
#pragma once

#include "solve/bodies/solver_body.h"
#include "solve/contacts/contact.h"

#include <cstdint>
#include <span>
#include <vector>

namespace lockstone::solve {

inline constexpr std::int64_t pressed_ratio = 4;

/// A push that is no contact: of a wheel on the body under it.
struct Load {
    std::uint32_t light, heavy; ///< rows of the body columns; the heavy one pushes the light one
    UnitVec3 push;
};

class PressedBodies {
  public:
    /// Sets BodyInertia::pressed of each body that a body of more than pressed_ratio times its mass touches, and that
    /// other contacts support against this push: contacts with a body that does not move, directly or through other
    /// bodies. Call it when bodies are in solver form, before contacts are prepared. Returns true where there are such
    /// bodies. The order of `contacts` is the same in every execution mode.
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
