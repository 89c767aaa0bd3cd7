// Rotation matrices of quaternions in lanes.
#pragma once

#include <cstdint>

namespace lockstone::solve {

/// The matrix of a quaternion, with the bits of to_rotation(): r[k][i] is component i of column k. Returns true in the
/// lanes where q is no rotation.
template <class L, class V = typename L::V> V rotation_of(const V (&q)[4], V (&r)[3][3]) {
    const auto half_of = [](int bits) { return L::splat(std::int64_t{1} << (bits - 1)); };
    const V &x = q[0], &y = q[1], &z = q[2], &w = q[3];
    const V xx = L::mul(x, x), yy = L::mul(y, y), zz = L::mul(z, z), ww = L::mul(w, w);
    const auto once = [&](V sum) { return L::template shift_right<30>(L::add(sum, half_of(30))); };
    const auto twice = [&](V sum) { return L::template shift_right<29>(L::add(sum, half_of(29))); };
    const V xy = L::mul(x, y), xz = L::mul(x, z), yz = L::mul(y, z), wx = L::mul(w, x), wy = L::mul(w, y),
            wz = L::mul(w, z);
    const V plus = L::add(ww, xx), minus = L::sub(ww, xx), sum = L::add(yy, zz), less = L::sub(yy, zz);
    r[0][0] = once(L::sub(plus, sum)), r[0][1] = twice(L::add(xy, wz)), r[0][2] = twice(L::sub(xz, wy));
    r[1][0] = twice(L::sub(xy, wz)), r[1][1] = once(L::add(minus, less)), r[1][2] = twice(L::add(yz, wx));
    r[2][0] = twice(L::add(xz, wy)), r[2][1] = twice(L::sub(yz, wx)), r[2][2] = once(L::sub(minus, less));
    const V less_1 = L::sub(L::add(plus, sum), L::splat(1));
    return L::either(L::greater64(L::splat(0), less_1),
                     L::greater64(less_1, L::splat(3 * (std::int64_t{1} << 59) - 1)));
}

} // namespace lockstone::solve
