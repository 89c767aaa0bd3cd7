#include "lockstone/shape.h"

namespace lockstone {
namespace {

/// Six decimals, rounded towards zero: enough to tell a value from its limit.
std::string metres(Length v) {
    const std::uint64_t m = magnitude(v.raw);
    const std::uint64_t micro = ((m & 0xffffffu) * 1'000'000u) >> Length::fraction_bits;
    std::string digits = std::to_string(micro);
    digits.insert(0, 6 - digits.size(), '0');
    return (v.raw < 0 ? "-" : "") + std::to_string(m >> Length::fraction_bits) + "." + digits + " m";
}

std::string check(const char* field, Length v, Length low = shape_size_min, Length high = shape_size_max) {
    if (v >= low && v <= high) return {};
    return std::string(field) + " is " + metres(v) + ", it must be in " + metres(low) + " .. " + metres(high);
}

std::string first_of(std::string a, std::string b) { return a.empty() ? b : a; }

} // namespace

std::string validate(const Geometry& g) {
    switch (g.kind) {
    case ShapeKind::sphere: return check("sphere radius", g.radius);
    case ShapeKind::capsule:
        return first_of(first_of(check("capsule radius", g.radius),
                                 check("capsule half_extent.y", g.half_extent.y, Length{})),
                        check("capsule half_extent.y + radius", g.half_extent.y + g.radius));
    case ShapeKind::box:
        return first_of(
            first_of(check("box half_extent.x", g.half_extent.x), check("box half_extent.y", g.half_extent.y)),
            check("box half_extent.z", g.half_extent.z));
    case ShapeKind::plane: return {};
    }
    return "shape kind is " + std::to_string(static_cast<std::uint32_t>(g.kind)) + ", it must be in 0 .. 3";
}

} // namespace lockstone
