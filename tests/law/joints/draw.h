// Random doubles for tests of the parts of joints.
#pragma once

#include "support/rigs/joint_rig.h"

#include <random>

namespace lockstone::test::rig {

struct Draw {
    std::mt19937_64 engine;
    double operator()(double low, double high) {
        return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53;
    }
    int below(int n) { return static_cast<int>(engine() % static_cast<std::uint64_t>(n)); }
    D3 vector(double size) { return {(*this)(-size, size), (*this)(-size, size), (*this)(-size, size)}; }
    Quat rotation(double most = 3) {
        D3 axis = vector(1);
        if (length(axis) < 0.1) axis = {1, 0, 0};
        return turn(axis, (*this)(-most, most));
    }
};

} // namespace lockstone::test::rig
