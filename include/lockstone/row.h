// Rows: the plain structs of the state, and the lists of their fields.
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
// Saving, hashing, byte order, comparison and text all use this list. A row does not compile if it has
// padding, a float or a pointer, or if the list omits, repeats or reorders a field.
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

/// Field list: calls visit(name, field) for each field, in memory order.
///@{
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
///@}

// ---- ranges of the fields of definitions ----
//
//   template <class V> constexpr void describe(Ball& b, V&& v) {
//       field(v, "radius", b.radius, in(0.01_r, 10_r, " m"));
//   }
//
// A visitor with a third parameter receives the range; others are called without it. The range of an array
// applies to each entry.

/// Range of a number: low..high.
template <class T> struct In {
    T low,            ///< smallest value
        high;         ///< largest value
    const char* unit; ///< for error sentences, with a leading space: " m"; or empty
};
/// The range low..high.
///@{
constexpr In<std::int64_t> in(std::int64_t low, std::int64_t high) { return {low, high, ""}; }
template <FixedPoint T> constexpr In<T> in(T low, T high, const char* unit = "") { return {low, high, unit}; }
///@}
inline constexpr In<std::int64_t> no_or_yes{0, 1, ""};   ///< a flag
inline constexpr In<std::int64_t> always_zero{0, 0, ""}; ///< a reserved field
/// Range of a number: from 0 to below `end`.
struct Below {
    Real end;         ///< excluded
    const char* text; ///< `end` in error sentences
};
/// Range of a number: low..high or -high..-low.
struct EitherSign {
    Real low, ///< smallest magnitude
        high; ///< largest magnitude
};
/// Range of bits of an enum.
struct BitsOf {
    std::uint32_t all; ///< all valid bits
    const char* name;  ///< of the enum, in error sentences
};
/// Range of each component of a vector: -most..most.
struct EachIn {
    Real most;        ///< largest magnitude
    const char* unit; ///< in error sentences
};
/// Range of the length of a vector: 0..most.
struct LongAtMost {
    Real most;        ///< largest length
    const char* text; ///< `most` with its unit, in error sentences
};
/// Range of a pose: each position component within -most..most [m], a rotation of unit length.
struct PoseIn {
    Real most; ///< largest magnitude [m]
};
/// Range of a direction: unit length.
struct UnitLong {};
/// The fields of a nested struct have their own ranges. The default for structs and arrays.
struct OwnRanges {};
/// The range applies to the first `count` entries of an array; the others are unused.
template <class R> struct First {
    std::uint32_t count; ///< used entries
    R range;             ///< range of a used entry
};
/// The first `count` entries of an array.
///@{
constexpr First<OwnRanges> first(std::uint32_t count) { return {count, {}}; }
template <class R> constexpr First<R> first(std::uint32_t count, const R& range) { return {count, range}; }
///@}

/// Calls visit(name, value, range), or visit(name, value) if the visitor takes no range.
template <class V, class F, class R>
constexpr void field(V&& visit, const char* name, F& value, const R& range) {
    if constexpr (requires { visit(name, value, range); })
        visit(name, value, range);
    else
        visit(name, value);
}

/// An enum with an explicit underlying type; otherwise the compiler chooses size and sign.
template <class T>
concept FixedEnum = std::is_enum_v<T> && requires {
    T{0};
} && !std::same_as<std::underlying_type_t<T>, bool>;

/// A number: an integer, an enum or a fixed-point number. Not bool, because only two of its 256 byte values
/// are valid. Not char and wchar_t, because their sign or size depends on the platform.
template <class T>
concept Leaf = FixedPoint<T> || FixedEnum<T> ||
    (std::integral<T> && sizeof(T) <= 8 && !std::same_as<T, bool> && !std::same_as<T, char> &&
     !std::same_as<T, wchar_t>);

/// True for each std::array.
///@{
template <class T> inline constexpr bool is_std_array = false;
template <class T, std::size_t N> inline constexpr bool is_std_array<std::array<T, N>> = true;
///@}

/// Calls leaf(T& value) for every number of a row in declaration order, also in nested rows and arrays.
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

/// True if every value that the field list of T reaches is a number.
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

/// True if the field list covers every byte of T once, in memory order. Writes a different mark to each
/// number, and compares the bytes with the marks in the order of the visit.
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

/// A type for the state: trivially copyable, without padding, floats and pointers; its field list covers
/// every byte once and in order.
template <class T>
concept StateRow = std::is_trivially_copyable_v<T> && std::has_unique_object_representations_v<T> &&
                       alignof(T) <= 64 &&
                   detail::names_every_byte<T>();

/// Type of a number.
enum class LeafKind : std::uint8_t {
    unsigned_integer, ///< unsigned integer or enum
    signed_integer,   ///< signed integer or enum
    fixed_point       ///< Fixed
};

/// A number of a row type.
struct LeafInfo {
    std::string name;           ///< "rotation.w", "points[2].key"; "value" for a row of one number
    std::uint32_t offset;       ///< in the row [bytes]
    std::uint8_t size;          ///< 1, 2, 4 or 8 bytes
    LeafKind kind;              ///< type
    std::uint8_t fraction_bits; ///< fixed_point: fraction bits; else 0
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

/// The numbers of a row type in memory order.
template <StateRow T> std::vector<LeafInfo> leaves_of() {
    T value{};
    std::vector<LeafInfo> out;
    detail::collect_leaves(value, reinterpret_cast<const std::byte*>(&value), "", out);
    return out;
}

} // namespace lockstone
