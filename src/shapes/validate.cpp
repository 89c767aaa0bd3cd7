#include "lockstone/shape.h"

namespace lockstone {
namespace {

/// To the nearest micrometre, without trailing zeros.
std::string metres(Length v) {
    const std::uint64_t micro = (magnitude(v.raw) * 1'000'000u + (1u << 23)) >> Length::fraction_bits;
    std::string text = v.raw < 0 ? "-" : "";
    text += std::to_string(micro / 1'000'000u);
    std::string digits = std::to_string(1'000'000u + micro % 1'000'000u); // a leading 1 keeps the zeros
    digits.erase(digits.find_last_not_of('0') + 1);
    digits[0] = '.';
    if (digits.size() > 1) text += digits;
    return text += " m";
}

std::string check(const char* field, Length v, Length low = shape_size_min, Length high = shape_size_max) {
    if (v >= low && v <= high) return {};
    return std::string(field) + " is " + metres(v) + ", it must be in " + metres(low) + " .. " + metres(high);
}

std::string first_of(std::string a, std::string b) { return a.empty() ? b : a; }

} // namespace

std::string validate(const Geometry& g) {
    switch (g.kind) {
    case ShapeKind::sphere:
        return check("sphere radius", g.radius);
    case ShapeKind::capsule:
        return first_of(first_of(check("capsule radius", g.radius),
                                 check("capsule half_extent.y", g.half_extent.y, Length{})),
                        check("capsule half_extent.y + radius", g.half_extent.y + g.radius));
    case ShapeKind::box:
        return first_of(first_of(check("box half_extent.x", g.half_extent.x),
                                 check("box half_extent.y", g.half_extent.y)),
                        check("box half_extent.z", g.half_extent.z));
    case ShapeKind::plane:
        return {};
    }
    return "shape kind is " + std::to_string(static_cast<std::uint32_t>(g.kind)) + ", it must be in 0 .. 3";
}

} // namespace lockstone
