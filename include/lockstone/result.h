// Results of functions that can fail by data from outside: files, packets, definitions, capacities. A
// programming error ends the program instead.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace lockstone {

/// An error: a sentence that a user can act on.
struct Error {
    std::string message; ///< the wrong value, its place, and what is expected
};

namespace detail {
/// End the program with a message, in every build: value() of an error, or error() of a value.
[[noreturn]] void stop_without_value(const Error& error);
[[noreturn]] void stop_without_error();
} // namespace detail

/// A value or an Error: `if (!result) report(result.error().message);`. value() of an error, and error() of a
/// value, end the program with a message, in every build.
template <class T> class [[nodiscard]] Result {
    std::variant<T, Error> content;

    template <class Self> static auto& value_of(Self& self) {
        if (const Error* error = std::get_if<1>(&self.content)) [[unlikely]]
            detail::stop_without_value(*error);
        return *std::get_if<0>(&self.content);
    }

  public:
    Result(T value) : content(std::in_place_index<0>, std::move(value)) {}     ///< Success.
    Result(Error error) : content(std::in_place_index<1>, std::move(error)) {} ///< Failure.

    explicit operator bool() const { return content.index() == 0; } ///< True for a value.
    bool ok() const { return content.index() == 0; }                ///< True for a value.
    /// The value. A reference is valid as long as the result; a temporary result returns a value.
    ///@{
    T& value() & { return value_of(*this); }
    const T& value() const& { return value_of(*this); }
    T value() && { return std::move(value_of(*this)); }
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T operator*() && { return std::move(*this).value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }
    ///@}
    /// The error. Valid as long as the result.
    const Error& error() const {
        if (ok()) [[unlikely]]
            detail::stop_without_error();
        return *std::get_if<1>(&content);
    }
};

/// Success or an Error.
template <> class [[nodiscard]] Result<void> {
    std::variant<std::monostate, Error> content;

  public:
    Result() = default;                                ///< Success.
    Result(Error error) : content(std::move(error)) {} ///< Failure.

    explicit operator bool() const { return content.index() == 0; } ///< True for success.
    bool ok() const { return content.index() == 0; }                ///< True for success.
    /// Ends the program with the message of an error: `world.add_force(...).value();`.
    void value() const {
        if (const Error* error = std::get_if<1>(&content)) [[unlikely]]
            detail::stop_without_value(*error);
    }
    /// The error. Valid as long as the result.
    const Error& error() const {
        if (ok()) [[unlikely]]
            detail::stop_without_error();
        return *std::get_if<1>(&content);
    }
};

/// Result of a function without a value.
using Status = Result<void>;

} // namespace lockstone
