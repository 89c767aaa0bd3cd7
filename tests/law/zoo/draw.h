// Numbers and directions that seeds draw, and the conversions for objects.
#pragma once

#include "lockstone/math/convert.h"
#include "lockstone/math/math.h"
#include "support/split_mix.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <string>

namespace lockstone::zoo {

using D3 = std::array<double, 3>;
using test::SplitMix;

inline constexpr double pi = 3.14159265358979323846;

/// A stream of numbers for each seed. SplitMix advances in equal steps, so neighbouring seeds without this mix would
/// overlap.
inline SplitMix stream(std::uint64_t seed, std::uint64_t kind) {
    return SplitMix(SplitMix(SplitMix(seed).next() ^ kind).next());
}
inline double unit(SplitMix& random) { return static_cast<double>(random.next() >> 11) * 0x1p-53; }
inline double between(SplitMix& random, double low, double high) { return low + (high - low) * unit(random); }
/// Logarithmic: each power of two is equally likely.
inline double log_between(SplitMix& random, double low, double high) {
    return low * std::pow(high / low, unit(random));
}
inline Real real(double x) { return quantize<Real>(x); }
inline Vec3 vec(double x, double y, double z) { return {real(x), real(y), real(z)}; }
inline Vec3 vec(const D3& v) { return vec(v[0], v[1], v[2]); }
inline LengthVec3 length_vec(const D3& p) {
    return {quantize<Length>(p[0]), quantize<Length>(p[1]), quantize<Length>(p[2])};
}
inline D3 to_double3(Vec3 v) { return {to_double(v.x), to_double(v.y), to_double(v.z)}; }
inline D3 direction(SplitMix& random) {
    const double y = between(random, -1, 1), turn = between(random, 0, 2 * pi), r = std::sqrt(1 - y * y);
    return {r * std::cos(turn), y, r * std::sin(turn)};
}
inline Quat any_turn(SplitMix& random) {
    const D3 axis = direction(random);
    const double half = between(random, 0, pi);
    return normalized(quantize_quat(
        {axis[0] * std::sin(half), axis[1] * std::sin(half), axis[2] * std::sin(half), std::cos(half)}));
}

inline std::string in_text(const char* format, double a, double b = 0, double c = 0) {
    char text[160];
    std::snprintf(text, sizeof text, format, a, b, c);
    return text;
}

inline double length(const D3& v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }
inline D3 plus(const D3& a, const D3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline D3 minus(const D3& a, const D3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline D3 times(double s, const D3& v) { return {s * v[0], s * v[1], s * v[2]}; }
inline double along(const D3& a, const D3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline D3 across(const D3& a, const D3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A pose in double precision, for laws.
struct Placed {
    D3 at, x, y, z;
    explicit Placed(const Transform& pose) : at(to_double3(pose.position)) {
        const Rotation turn = to_rotation(pose.rotation);
        x = {to_double(turn.x.x), to_double(turn.x.y), to_double(turn.x.z)};
        y = {to_double(turn.y.x), to_double(turn.y.y), to_double(turn.y.z)};
        z = {to_double(turn.z.x), to_double(turn.z.y), to_double(turn.z.z)};
    }
    D3 point(const D3& p) const {
        return plus(at, plus(times(p[0], x), plus(times(p[1], y), times(p[2], z))));
    }
};

} // namespace lockstone::zoo
