// Equal but for a part of the number.
#pragma once

#include <doctest/doctest.h>

namespace lockstone::test {

/// `expected` and what is off by less than `relative` times the larger of the two. doctest's own Approx adds `relative` times 1: of a
/// number below 1 that is a multiple of what it says. Nothing but 0 is about 0: there a bound has to be in the unit of the number.
inline doctest::Approx about(double expected, double relative = 1e-5) {
    return doctest::Approx(expected).epsilon(relative).scale(1e-30); // not 0: 0 has to be below it
}

} // namespace lockstone::test
