// Makes a failing world small, and writes it down as a test in C++.
#pragma once

#include "modes.h"

namespace worlds {

struct Shrunk {
    Story story; ///< with symbolic ids where that was possible
    Mode mode;
    std::uint64_t tick; ///< the first after which the mode differs
};
/// Removes steps, features of the mode and values of commands while the mode still differs from the reference.
Shrunk shrink(const Story& story, const Mode& mode);
/// A doctest case that plays the story, ready to be kept.
std::string program_of(const Shrunk& shrunk);

} // namespace worlds
