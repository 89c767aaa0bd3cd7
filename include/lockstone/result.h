// Errors that come from outside: files, packets, definitions, capacities. A programmer's error asserts instead.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace lockstone {

/// One sentence a user can act on: what was wrong, where, and what would have been right.
struct Error {
    std::string message;
};

namespace detail {
/// Ends the program with a sentence, in every build: the caller took the value of an error, or the error of a value.
[[noreturn]] void stop_without_value(const Error& error);
[[noreturn]] void stop_without_error();
} // namespace detail

/// A value or an Error. `if (!result) report(result.error().message);` To take the value of an error, or the error of a
/// value, ends the program with a sentence that holds the error.
template <class T> class [[nodiscard]] Result {
    std::variant<T, Error> content;

    template <class Self> static auto& value_of(Self& self) {
        if (const Error* error = std::get_if<1>(&self.content)) [[unlikely]]
            detail::stop_without_value(*error);
        return *std::get_if<0>(&self.content);
    }

  public:
    Result(T value) : content(std::in_place_index<0>, std::move(value)) {}
    Result(Error error) : content(std::in_place_index<1>, std::move(error)) {}

    explicit operator bool() const { return content.index() == 0; }
    bool ok() const { return content.index() == 0; }
    T& value() & { return value_of(*this); }
    const T& value() const& { return value_of(*this); }
    T value() && {
        return std::move(value_of(*this));
    } ///< a value: a range-for over a temporary result is sound
    T& operator*() & { return value(); }
    const T& operator*() const& { return value(); }
    T operator*() && { return std::move(*this).value(); }
    T* operator->() { return &value(); }
    const T* operator->() const { return &value(); }
    const Error& error() const {
        if (ok()) [[unlikely]]
            detail::stop_without_error();
        return *std::get_if<1>(&content);
    }
};

template <> class [[nodiscard]] Result<void> {
    std::variant<std::monostate, Error> content;

  public:
    Result() = default;
    Result(Error error) : content(std::move(error)) {}

    explicit operator bool() const { return content.index() == 0; }
    bool ok() const { return content.index() == 0; }
    /// Says that it went well, or ends the program with the error: `world.add_force(...).value();`
    void value() const {
        if (const Error* error = std::get_if<1>(&content)) [[unlikely]]
            detail::stop_without_value(*error);
    }
    const Error& error() const {
        if (ok()) [[unlikely]]
            detail::stop_without_error();
        return *std::get_if<1>(&content);
    }
};

using Status = Result<void>;

} // namespace lockstone
