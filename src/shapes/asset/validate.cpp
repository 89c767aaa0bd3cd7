// Checks a geometry: its sizes, its scale, and whether it names an asset. An error names the field, the value
// and the range.
#include "lockstone/shape.h"

#include <limits>
#include <string_view>
#include <utility>

namespace lockstone {
namespace {

constexpr Length scale_min = Length::from_raw(1 << (Length::fraction_bits - 7)); // 1/128
constexpr Length scale_max = Length(100);

/// The decimal text, rounded to the nearest millionth, without trailing zeros.
std::string decimal_of(Length v) {
    const std::uint64_t micro = (magnitude(v.raw) * 1'000'000u + (1u << 23)) >> Length::fraction_bits;
    std::string text = v.raw < 0 ? "-" : "";
    text += std::to_string(micro / 1'000'000u);
    std::string digits = std::to_string(1'000'000u + micro % 1'000'000u); // a leading 1 keeps the zeros
    digits.erase(digits.find_last_not_of('0') + 1);
    digits[0] = '.';
    if (digits.size() > 1) text += digits;
    return text;
}

/// The value as text. sphere() and similar functions clamp values beyond the range of Length: the text then
/// says "or more" or "or less".
std::string told(Length v, const char* unit) {
    if (v.raw == std::numeric_limits<Length::rep>::max()) return std::string("128") + unit + " or more";
    if (v.raw == std::numeric_limits<Length::rep>::min()) return std::string("-128") + unit + " or less";
    return decimal_of(v) + unit;
}

/// The first error about a geometry. Builds text only for an error, so that the usual case is cheap.
class Check {
  public:
    explicit Check(const Geometry& geometry) : g(geometry), name(name_of(geometry.kind)) {}

    void sizes();
    void scale();
    void asset();

    std::string fault; ///< empty: none so far

  private:
    void range(std::string_view field, Length v, Length low, Length high, const char* unit = " m") {
        if (fault.empty() && (v < low || v > high)) out_of_range(field, v, low, high, unit);
    }
    void size(std::string_view field, Length v) { range(field, v, shape_size_min, shape_size_max); }
    void out_of_range(std::string_view field, Length v, Length low, Length high, const char* unit);
    /// A rounding radius must not be negative, and the rounded shape must stay within 100 m.
    void rounded(Length widest) {
        range("radius", g.radius, Length{}, shape_size_max);
        range("half_extent + radius", widest + g.radius, Length{}, shape_size_max);
    }
    void round_core();

    const Geometry& g;
    std::string_view name;
};

void Check::out_of_range(std::string_view field, Length v, Length low, Length high, const char* unit) {
    fault = std::string(name) + " " + std::string(field) + " is " + told(v, unit) + ", it must be in " +
            decimal_of(low) + unit + " .. " + decimal_of(high) + unit;
    if (v > high && low == shape_size_min && high == shape_size_max)
        fault += "; on a static body scaled() makes a smaller one up to 8 times as large";
}

void Check::round_core() {
    const LengthVec3& half = g.half_extent;
    if (half.x != half.z) {
        fault = std::string(name) + " half_extent.x is " + decimal_of(half.x) + " m and half_extent.z is " +
                decimal_of(half.z) + " m, they must be equal";
        return;
    }
    size("half_extent.x", half.x);
    size("half_extent.y", half.y);
    rounded(max(half.x, half.y));
}

void Check::sizes() {
    const LengthVec3& half = g.half_extent;
    switch (g.kind) {
    case ShapeKind::sphere:
        return size("radius", g.radius);
    case ShapeKind::capsule:
        size("radius", g.radius);
        range("half_extent.y", half.y, Length{}, shape_size_max);
        return size("half_extent.y + radius", half.y + g.radius);
    case ShapeKind::cylinder:
    case ShapeKind::cone:
        return round_core();
    case ShapeKind::box:
        size("half_extent.x", half.x);
        size("half_extent.y", half.y);
        size("half_extent.z", half.z);
        return rounded(max(half.x, max(half.y, half.z)));
    case ShapeKind::hull:
        return range("radius", g.radius, Length{}, shape_size_max);
    default: // a plane has no size, and the other kinds have no radius
        return range("radius", g.radius, Length{}, Length{});
    }
}

void Check::scale() {
    const Length x = g.scale.x, y = g.scale.y, z = g.scale.z;
    if (g.kind == ShapeKind::hull || g.kind == ShapeKind::mesh || g.kind == ShapeKind::height_field) {
        range("scale.x", x, scale_min, scale_max, "");
        range("scale.y", y, scale_min, scale_max, "");
        range("scale.z", z, scale_min, scale_max, "");
        return;
    }
    const bool fixed = g.kind == ShapeKind::compound || g.kind == ShapeKind::plane;
    const auto allowed = [&](int factor) { return x == Length(factor) && (factor == 1 || !fixed); };
    if (!fault.empty() || (x == y && y == z && (allowed(1) || allowed(2) || allowed(4) || allowed(8))))
        return;
    fault = std::string(name) + " scale is (" + decimal_of(x) + ", " + decimal_of(y) + ", " + decimal_of(z) +
            "), it must be " + (fixed ? "(1, 1, 1)" : "1, 2, 4 or 8 on all axes");
}

void Check::asset() {
    const bool wanted = g.kind >= ShapeKind::hull && g.kind <= ShapeKind::mesh;
    if (!fault.empty() || wanted == static_cast<bool>(g.asset)) return;
    fault = std::string(name) + (wanted ? " names no asset" : " names an asset, it can have none");
}

} // namespace

const char* name_of(ShapeKind kind) {
    constexpr const char* names[] = {"sphere", "capsule",  "cylinder",     "cone", "box",
                                     "hull",   "compound", "height_field", "mesh", "plane"};
    const auto index = static_cast<std::uint32_t>(kind);
    return index < std::size(names) ? names[index] : "unknown";
}

std::string validate(const Geometry& g) {
    if (g.kind > ShapeKind::plane)
        return "shape kind is " + std::to_string(static_cast<std::uint32_t>(g.kind)) +
               ", it must be in 0 .. 9";
    Check check(g);
    check.sizes();
    check.scale();
    check.asset();
    return std::move(check.fault);
}

} // namespace lockstone
