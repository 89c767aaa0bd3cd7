// Shrinks a failing world, and prints it as a test in C++.
#pragma once

#include "modes.h"

namespace worlds {

struct Shrunk {
    Story story; ///< with symbolic ids if possible
    Mode mode;
    std::uint64_t tick; ///< the first tick after which the mode differs
};
/// Removes steps, features of the mode and values of commands while the mode still differs from the reference.
Shrunk shrink(const Story& story, const Mode& mode);
/// Returns a doctest case that plays the story.
std::string program_of(const Shrunk& shrunk);

} // namespace worlds
