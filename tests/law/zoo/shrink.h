// The smallest case that still breaks a law, and a program that plays it.
#pragma once

#include "law/zoo/case.h"

#include <functional>

namespace lockstone::zoo {

/// Removes objects, spins, rotations, floors and odd numbers while the case still fails. `tries`: the most plays.
Case shrunk(Case c, const std::function<bool(const Case&)>& fails, int tries = 200);
/// A main function that plays the case and prints heights and speeds, for the headers of the zoo and its `floor.cpp`.
std::string program_of(const Case& c);

} // namespace lockstone::zoo
