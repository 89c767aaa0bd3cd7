// Functions over the list of a definition's fields (describe): range checks, and copies between a definition, the row
// that holds it and the command that changes it.
#pragma once

#include "base/text.h"
#include "lockstone/command.h"
#include "lockstone/math/decimal.h"
#include "lockstone/math/math.h"
#include "model/checks.h"

#include <cstring>
#include <string>
#include <string_view>

namespace lockstone::sim {

/// Keeps the first error about fields that are out of range.
struct RangeCheck {
    std::string error;

    /// Checks a struct, whose fields have their own ranges.
    template <class F> void operator()(const char* name, F& value, OwnRanges = {}) {
        if constexpr (!Leaf<F>) {
            RangeCheck inner;
            describe(value, inner);
            if (error.empty() && !inner.error.empty()) error = base::join(name, ".", inner.error);
        }
    }
    template <class T, std::size_t N, class R = OwnRanges>
    void operator()(const char* name, std::array<T, N>& values, const R& range = {}) {
        (*this)(name, values, First<R>{N, range});
    }
    template <class T, std::size_t N, class R>
    void operator()(const char* name, std::array<T, N>& values, const First<R>& range) {
        for (std::size_t i = 0; i < N && i < range.count && error.empty(); ++i)
            (*this)(base::join(name, "[", i, "]").c_str(), values[i], range.range);
    }
    template <class F>
    requires std::is_enum_v<F> || std::is_integral_v<F>
    void operator()(const char* name, F& value, const In<std::int64_t>& range) {
        const auto number = static_cast<std::int64_t>(value);
        if (!error.empty() || (number >= range.low && number <= range.high)) return;
        error = base::join(name, " is ", number, ", must be ", range.low);
        if (range.high != range.low)
            error += base::join(range.low == 0 && range.high == 1 ? " or " : " to ", range.high);
    }
    void operator()(const char* name, Real& value, const In<Real>& range) {
        // An empty error, the usual case, is not assigned.
        if (error.empty() && (value < range.low || value > range.high))
            error = check_range(name, value, range.low, range.high, range.unit);
    }
    void operator()(const char* name, Real& value, const Below& range) {
        if (error.empty() && (value < Real{} || value >= range.end))
            error = base::join(name, " is ", to_string(value), ", must be 0 to less than ", range.text);
    }
    void operator()(const char* name, Real& value, const EitherSign& range) {
        if (error.empty() && (abs(value) < range.low || abs(value) > range.high))
            error = base::join(name, " is ", to_string(value), ", must be ", to_string(range.low), " to ",
                               to_string(range.high), " or the negative of that");
    }
    void operator()(const char* name, UnitVec3& value, UnitLong) {
        if (error.empty() && abs(length(value) - unit_one) > Unit::from_raw(1 << 20))
            error = base::join(name, " is not of length 1: use normalized");
    }
    void operator()(const char* name, std::uint32_t& value, const BitsOf& bits) {
        if (error.empty() && (value & ~bits.all) != 0)
            error = base::join(name, " is ", value, ", must be a sum of ", bits.name, " bits, at most ",
                               bits.all);
    }
    void operator()(const char* name, Vec3& value, const EachIn& range) {
        for (int i = 0; i < 3; ++i)
            if (error.empty() && abs(value[i]) > range.most)
                error = base::join(name, ".", std::string_view("xyz").substr(static_cast<std::size_t>(i), 1),
                                   " is ", to_string(value[i]), ", must be within ", to_string(range.most),
                                   " ", range.unit);
    }
    void operator()(const char* name, Vec3& value, const LongAtMost& range) {
        if (error.empty() && length(value) > range.most)
            error = base::join(name, " must be at most ", range.text, " long");
    }
    void operator()(const char* name, Transform& value, const PoseIn& range) {
        if (error.empty()) error = check_pose(name, value, range.most);
    }
};

/// Returns an empty text if every field is in its range, else the error.
template <class Def> std::string check_ranges(Def def) {
    RangeCheck check;
    describe(def, check);
    return check.error;
}

/// Calls visit(field) for the field with this name, if there is one. Compilers compare two constant names with strcmp
/// at compile time, but not two string views.
template <class T, class Visit> void visit_named(T& in, const char* name, Visit&& visit) {
    describe(in, [&](const char* other, auto& field) {
        if (std::strcmp(name, other) == 0) visit(field);
    });
}

/// Copies every field of `from` to the field of `to` with the same name. Skips pairs of different types, except pairs
/// of integers. Flattened, so that the compiler compares the names.
template <class From, class To> [[gnu::flatten]] void copy_named(From from, To& to) {
    describe(from, [&]<class F>(const char* name, F& value) {
        visit_named(to, name, [&]<class T>(T& target) {
            if constexpr (std::is_same_v<F, T>)
                target = value;
            else if constexpr (std::is_integral_v<F> && std::is_integral_v<T>)
                target = static_cast<T>(value);
        });
    });
}

/// Copies the fields that a command gives (Change) to the fields with the same names.
template <class Command, class To> void apply_changes(Command command, To& to) {
    describe(command, [&]<class F>(const char* name, F& change) {
        if constexpr (requires { change.given; })
            if (change.given != 0)
                visit_named(to, name, [&]<class T>(T& target) {
                    if constexpr (std::is_same_v<decltype(F::value), T>) target = change.value;
                });
    });
}

} // namespace lockstone::sim
