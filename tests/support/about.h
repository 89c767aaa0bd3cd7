// Comparison with a relative tolerance.
#pragma once

#include <doctest/doctest.h>

namespace lockstone::test {

/// `expected` with a tolerance of `relative` times the larger of the two numbers. doctest's Approx adds `relative`
/// times 1, which is a multiple of that for a number below 1. Only 0 is about 0: a bound near 0 must be in the unit of
/// the number.
inline doctest::Approx about(double expected, double relative = 1e-5) {
    return doctest::Approx(expected).epsilon(relative).scale(1e-30); // not 0, because 0 must be below it
}

} // namespace lockstone::test
