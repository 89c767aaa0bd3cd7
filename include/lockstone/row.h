// Rows: the plain structs the state is made of, and how they name their fields.
//
//   struct Health {
//       std::int32_t points;
//       Real shield;
//   };
//   template <class Visit> constexpr void describe(Health& h, Visit&& visit) {
//       visit("points", h.points);
//       visit("shield", h.shield);
//   }
//
// From that one list come saving, hashing, byte order, comparison and text. A row with padding, a float, a
// pointer, or a field that the list forgets, repeats or moves, does not compile.
#pragma once

#include "lockstone/math/vec.h"

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

namespace lockstone {

template <FixedPoint T, class Visit> constexpr void describe(Vector3<T>& v, Visit&& visit) {
    visit("x", v.x);
    visit("y", v.y);
    visit("z", v.z);
}
template <FixedPoint T, class Visit> constexpr void describe(Matrix3<T>& m, Visit&& visit) {
    visit("x", m.x);
    visit("y", m.y);
    visit("z", m.z);
}
template <class Visit> constexpr void describe(Quat& q, Visit&& visit) {
    visit("x", q.x);
    visit("y", q.y);
    visit("z", q.z);
    visit("w", q.w);
}
template <class Visit> constexpr void describe(Transform& t, Visit&& visit) {
    visit("position", t.position);
    visit("rotation", t.rotation);
}

// ---- ranges: what a field of a definition may be, beside its name ----
//
//   template <class V> constexpr void describe(Ball& b, V&& v) {
//       field(v, "radius", b.radius, in(0.01_r, 10_r, " m"));
//   }
//
// A visitor that takes the range as a third argument gets it, any other is called as without. The range of an array is that
// of each entry.

template <class T> struct In {
    T low, high;
    const char* unit;
};
constexpr In<std::int64_t> in(std::int64_t low, std::int64_t high) { return {low, high, ""}; }
template <FixedPoint T> constexpr In<T> in(T low, T high, const char* unit = "") { return {low, high, unit}; }
inline constexpr In<std::int64_t> no_or_yes{0, 1, ""};
inline constexpr In<std::int64_t> always_zero{0, 0, ""}; ///< of a reserved field
/// From 0 to less than `end`; `text` is that as sentences say it.
struct Below {
    Real end;
    const char* text;
};
/// From low to high, or the negative of that.
struct EitherSign {
    Real low, high;
};
/// Bits of an enum, all of which together are `all`.
struct BitsOf {
    std::uint32_t all;
    const char* name;
};
/// Each component of a vector, to both sides.
struct EachIn {
    Real most;
    const char* unit;
};
/// The length of a vector; `text` is `most` as sentences say it.
struct LongAtMost {
    Real most;
    const char* text;
};
/// The position of a pose, on each axis [m]; its rotation is of unit length.
struct PoseIn {
    Real most;
};
/// A direction is of length 1, as `normalized` makes it.
struct UnitLong {};
/// A struct's or an array's own fields have ranges; a struct and an array are looked into without it.
struct OwnRanges {};
/// The range holds for the first `count` entries of an array; what stands behind them means nothing.
template <class R> struct First {
    std::uint32_t count;
    R range;
};
constexpr First<OwnRanges> first(std::uint32_t count) { return {count, {}}; }
template <class R> constexpr First<R> first(std::uint32_t count, const R& range) { return {count, range}; }

template <class V, class F, class R>
constexpr void field(V&& visit, const char* name, F& value, const R& range) {
    if constexpr (requires { visit(name, value, range); })
        visit(name, value, range);
    else
        visit(name, value);
}

/// An enum whose underlying type is written down; otherwise the compiler chooses its size and sign.
template <class T>
concept FixedEnum = std::is_enum_v<T> && requires {
    T{0};
} && !std::same_as<std::underlying_type_t<T>, bool>;

/// A value with no fields of its own: an integer, an enum or a fixed-point number. No bool, as two of its 256 byte
/// values are legal; no char or wchar_t, as their sign or size differs between platforms.
template <class T>
concept Leaf = FixedPoint<T> || FixedEnum<T> ||
    (std::integral<T> && sizeof(T) <= 8 && !std::same_as<T, bool> && !std::same_as<T, char> &&
     !std::same_as<T, wchar_t>);

template <class T> inline constexpr bool is_std_array = false;
template <class T, std::size_t N> inline constexpr bool is_std_array<std::array<T, N>> = true;

/// Visits every leaf of a row in declaration order: leaf(T& value). Nested rows and std::arrays are entered.
template <class T, class Visit> constexpr void for_each_leaf(T& value, Visit&& leaf) {
    if constexpr (Leaf<T>) {
        leaf(value);
    } else if constexpr (is_std_array<T>) {
        for (auto& element : value) for_each_leaf(element, leaf);
    } else {
        describe(value, [&](const char*, auto& field) { for_each_leaf(field, leaf); });
    }
}

namespace detail {
struct IgnoreField {
    template <class F> constexpr void operator()(const char*, F&) const {}
};

template <class T>
concept Described = requires(T& value) {
    describe(value, IgnoreField{});
};

/// Whether every value that T's field list reaches, however deep, is a leaf.
template <class T> consteval bool ends_in_leaves() {
    if constexpr (Leaf<T>) {
        return true;
    } else if constexpr (is_std_array<T>) {
        return std::tuple_size_v<T> > 0 && ends_in_leaves<typename T::value_type>();
    } else if constexpr (Described<T>) {
        T value{};
        bool all = true;
        describe(value, [&]<class F>(const char*, F&) { all = all && ends_in_leaves<F>(); });
        return all;
    } else {
        return false;
    }
}

/// Whether the field list names every byte of T once, in memory order: each leaf gets a mark of its own, and the
/// marks must then stand in the bytes as the leaves were visited.
template <class T> consteval bool names_every_byte() {
    if constexpr (!ends_in_leaves<T>()) {
        return false;
    } else {
        T value{};
        std::array<std::uint8_t, sizeof(T)> expected{};
        std::size_t size = 0;
        std::uint8_t mark = 0;
        for_each_leaf(value, [&]<class L>(L& leaf) {
            mark = static_cast<std::uint8_t>(mark % 251 + 1);
            std::array<std::uint8_t, sizeof(L)> marked{};
            marked.fill(mark);
            leaf = std::bit_cast<L>(marked);
            for (std::size_t i = 0; i < sizeof(L); ++i, ++size)
                if (size < sizeof(T)) expected[size] = mark;
        });
        return size == sizeof(T) && std::bit_cast<std::array<std::uint8_t, sizeof(T)>>(value) == expected;
    }
}
} // namespace detail

/// What may stand in the state: plain, no padding, no floats, no pointers, every byte named once and in order.
template <class T>
concept StateRow = std::is_trivially_copyable_v<T> && std::has_unique_object_representations_v<T> &&
                       alignof(T) <= 64 &&
                   detail::names_every_byte<T>();

enum class LeafKind : std::uint8_t { unsigned_integer, signed_integer, fixed_point };

/// One leaf of a row type: where it lies and how its bytes read.
struct LeafInfo {
    std::string name; ///< "rotation.w", "points[2].key"; "value" where the row is one number
    std::uint32_t offset;
    std::uint8_t size; ///< 1, 2, 4 or 8 bytes
    LeafKind kind;
    std::uint8_t fraction_bits;
};

namespace detail {
template <class T> consteval bool is_signed_leaf() {
    if constexpr (std::is_enum_v<T>)
        return std::is_signed_v<std::underlying_type_t<T>>;
    else
        return std::is_signed_v<T>;
}
template <class T>
void collect_leaves(T& value, const std::byte* base, const std::string& name, std::vector<LeafInfo>& out) {
    if constexpr (Leaf<T>) {
        LeafInfo info{name.empty() ? "value" : name,
                      static_cast<std::uint32_t>(reinterpret_cast<const std::byte*>(&value) - base),
                      static_cast<std::uint8_t>(sizeof(T)), LeafKind::unsigned_integer, 0};
        if constexpr (FixedPoint<T>) {
            info.kind = LeafKind::fixed_point;
            info.fraction_bits = static_cast<std::uint8_t>(T::fraction_bits);
        } else if constexpr (is_signed_leaf<T>()) {
            info.kind = LeafKind::signed_integer;
        }
        out.push_back(std::move(info));
    } else if constexpr (is_std_array<T>) {
        for (std::size_t i = 0; i < value.size(); ++i)
            collect_leaves(value[i], base, name + "[" + std::to_string(i) + "]", out);
    } else {
        describe(value, [&](const char* field_name, auto& field) {
            collect_leaves(field, base, name.empty() ? std::string(field_name) : name + "." + field_name,
                           out);
        });
    }
}
} // namespace detail

/// The leaves of a row type in memory order.
template <StateRow T> std::vector<LeafInfo> leaves_of() {
    T value{};
    std::vector<LeafInfo> out;
    detail::collect_leaves(value, reinterpret_cast<const std::byte*>(&value), "", out);
    return out;
}

} // namespace lockstone
