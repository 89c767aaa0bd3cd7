// Random numbers for tests, equal on every machine.
#pragma once

#include "support/sim_scenes.h"

#include <cstdlib>
#include <random>

namespace lockstone::test::scene {

struct RandomPoint {
    std::mt19937_64 engine;
    explicit RandomPoint(std::uint64_t seed) : engine(seed) {}

    double operator()(double low, double high) {
        return low + (high - low) * static_cast<double>(engine() >> 11) * 0x1p-53;
    }
    /// A point within x of the y axis along x and z, between two heights.
    D3 point(double x, double low, double high) {
        return {(*this)(-x, x), (*this)(low, high), (*this)(-x, x)};
    }
    D3 direction() {
        for (;;) {
            const D3 v = point(1, -1, 1);
            if (length(v) > 0.05 && length(v) < 1) return (1 / length(v)) * v;
        }
    }
    Quat rotation() {
        const D3 a = direction();
        return from_axis_angle({quantize<Unit>(a[0]), quantize<Unit>(a[1]), quantize<Unit>(a[2])},
                               real((*this)(-3.1, 3.1)));
    }
};
inline Vec3 vec3(D3 v) { return vec(v[0], v[1], v[2]); }

/// The number of samples: more with LOCKSTONE_LONG=1 in the environment.
inline int samples(int quick, int thorough) {
    return std::getenv("LOCKSTONE_LONG") != nullptr ? thorough : quick;
}

} // namespace lockstone::test::scene
