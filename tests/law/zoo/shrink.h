// The smallest case that still breaks a law, and the program that plays it.
#pragma once

#include "law/zoo/case.h"

#include <functional>

namespace lockstone::zoo {

/// Takes away objects, spins, turns, floors and odd numbers while the case still fails. `tries`: plays at most.
Case shrunk(Case c, const std::function<bool(const Case&)>& fails, int tries = 200);
/// A main function that plays the case and prints heights and speeds, for the headers of the zoo and its `floor.cpp`.
std::string program_of(const Case& c);

} // namespace lockstone::zoo
